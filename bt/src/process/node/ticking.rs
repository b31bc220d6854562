//! The tick of a node: down to its children and back up.

use std::time::Duration;

use channels::Envelope;

use super::stage::{After, Goal, Purpose, Stage};
use super::{NodeProcess, Record};
use crate::engine::{MAX_REPEATS, TOO_MANY_REPEATS};
use crate::hooks::Entrance;
use crate::process::board::{BoardAnswer, Question};
use crate::process::protocol::{NodeReply, number, status_of, symbol};
use crate::program::Flags;
use crate::semantics::{
    Answer, Beginning, PortReading, Reaction, Reset, Resume, Then, Which, begin, needs_reading, needs_reading_after,
    react,
};
use crate::status::Mark;
use crate::{Category, Outcome, Request, Status};

impl NodeProcess {
    pub(super) fn take_request(&mut self, envelope: &Envelope, now: Duration) -> Stage {
        self.tick = number(&envelope.message, 2);
        if self.node().is_none() {
            self.repeats = 0;
            return self.tick_child(0);
        }
        self.mark = mark_of(symbol(&envelope.message, 3).and_then(status_of));
        if envelope.message.head() == Some("halt") {
            return self.start_halt();
        }
        if self.has(Flags::ENTRANCE) {
            return Stage::Consulting(Question::Enter, Purpose::Tick);
        }
        self.read(now)
    }

    /// Reads the ports if necessary, and begins.
    pub(super) fn read(&mut self, now: Duration) -> Stage {
        if self.has(Flags::READS) && needs_reading(self.kind(), &self.memory, self.mark.was_idle()) {
            return Stage::Consulting(Question::Read, Purpose::Tick);
        }
        let reading = self.node().map_or(PortReading::Nothing, |node| node.reading);
        self.begin(reading, now)
    }

    pub(super) fn begin(&mut self, reading: PortReading, now: Duration) -> Stage {
        let kind = self.kind();
        let child_runs = self.records.first().is_some_and(|record| record.mark.is_running());
        let beginning = Beginning { was: self.mark.status(), reading, now, child_runs };
        let reaction = begin(kind, &mut self.memory, beginning);
        self.mark = self.mark.entered();
        if kind.runs_when_begun(reaction) {
            self.mark = self.mark.begun(kind.keeps_answer());
        }
        self.carry_out(0, reaction)
    }

    /// Handles an answer of the blackboard.
    pub(super) fn take_board_answer(
        &mut self,
        question: Question,
        purpose: Purpose,
        answer: BoardAnswer,
        now: Duration,
    ) -> Stage {
        match purpose {
            Purpose::Tick => self.go_on_ticking(question, answer, now),
            Purpose::Answer { child, status, was_idle } => {
                // As in the engine, a node whose ports cannot be read fails.
                let reading = match answer {
                    BoardAnswer::Reading(reading) => reading,
                    _ => PortReading::Status(Status::Failure),
                };
                self.react(child, Answer { status: Some(status), was_idle, is_last: self.is_last(child), reading, now })
            }
            Purpose::Halt if answer == BoardAnswer::Reading(PortReading::Numbers([1, 0])) => self.start_catch(),
            Purpose::Halt => self.reset_all(Goal::Halt { skips: false }),
            Purpose::Halted { skips } => Stage::Answering(self.reply_when_halted(skips)),
        }
    }

    /// Continues a tick with an answer of the blackboard.
    fn go_on_ticking(&mut self, question: Question, answer: BoardAnswer, now: Duration) -> Stage {
        match (answer, question) {
            (BoardAnswer::Entrance(Entrance::Open), _) => self.read(now),
            (BoardAnswer::Entrance(Entrance::Closed(status)), _) => self.leave(status),
            (BoardAnswer::Entrance(Entrance::Left), _) => self.reset_all(Goal::Halt { skips: true }),
            (BoardAnswer::Reading(reading), _) => self.begin(reading, now),
            (BoardAnswer::Done, Question::Leave(status)) => self.answer(status),
            (BoardAnswer::Done, _) => Stage::Idle,
            // The scripts for an answer have been run already, so a fault in them does not run them again.
            (BoardAnswer::Fault, Question::Leave(_)) => self.answer(Status::Failure),
            (BoardAnswer::Fault, Question::Read) => {
                self.mark = self.mark.entered();
                self.forget();
                self.reset_all(Goal::Do(0, Then::Answer(Status::Failure)))
            }
            (BoardAnswer::Fault, _) => self.leave(Status::Failure),
        }
    }

    pub(super) fn tick_child(&mut self, mut child: usize) -> Stage {
        while self.kind().passes_over_completed() && self.records[child].mark.is_completed() {
            let (is_last, reading) = (self.is_last(child), PortReading::Nothing);
            let answer = Answer { status: None, was_idle: false, is_last, reading, now: Duration::ZERO };
            match react(self.kind(), &mut self.memory, answer) {
                Reaction::Next => child += 1,
                reaction => return self.carry_out(child, reaction),
            }
        }
        let record = &mut self.records[child];
        let mark = record.mark.entered();
        *record = Record { mark, outcome: Some(Outcome::Answered(Status::Running)), tick: self.tick };
        Stage::Asking(child, Request::Tick, After::Tick)
    }

    pub(super) fn take_reply(&mut self, child: usize, after: After, envelope: &Envelope, now: Duration) -> Stage {
        let reply = NodeReply::of(&envelope.message);
        self.again |= reply.again;
        match (after, reply.status) {
            (After::Reset(rest, goal), _) => {
                self.record_halt(child);
                self.reset(rest, goal)
            }
            (After::Tick, status) => self.answered(child, status.unwrap_or(Status::Failure), reply.own_status, now),
        }
    }

    /// Handles a child's answer to a tick.
    fn answered(&mut self, child: usize, status: Status, own_status: Option<Status>, now: Duration) -> Stage {
        let record = &mut self.records[child];
        let was_idle = record.mark.was_idle();
        let mark = match mark_of(own_status) {
            Mark::Running if status == Status::Skipped && record.mark != Mark::Running => Mark::Lingering,
            mark => mark,
        };
        *record = Record { mark, outcome: Some(Outcome::Answered(status)), tick: self.tick };
        if self.node().is_none() {
            return self.root_answered(status);
        }
        if self.memory.catches {
            return self.reset_all(Goal::Halt { skips: false });
        }
        if self.has(Flags::READS) && needs_reading_after(self.kind(), status) {
            return Stage::Consulting(Question::ReadAfter(status), Purpose::Answer { child, status, was_idle });
        }
        let (is_last, reading) = (self.is_last(child), PortReading::Nothing);
        self.react(child, Answer { status: Some(status), was_idle, is_last, reading, now })
    }

    fn is_last(&self, child: usize) -> bool {
        child + 1 == self.records.len()
    }

    fn react(&mut self, child: usize, answer: Answer) -> Stage {
        let reaction = react(self.kind(), &mut self.memory, answer);
        self.carry_out(child, reaction)
    }

    /// Carries out the node's reaction; `here` is the child that answered.
    pub(super) fn carry_out(&mut self, here: usize, reaction: Reaction) -> Stage {
        let Reaction::Do { reset, resume, then } = reaction else { return self.tick_child(here + 1) };
        match resume {
            Resume::Same => {}
            Resume::First => self.resume = 0,
            Resume::Here => self.resume = here,
            Resume::Next => self.resume = here + 1,
        }
        let count = self.records.len();
        let children: Vec<usize> = match reset {
            Reset::None => Vec::new(),
            Reset::All => (0..count).collect(),
            Reset::Others => (0..count).filter(|child| *child != here).collect(),
            Reset::FromHere => (here..count).collect(),
            Reset::Here => vec![here],
            Reset::Nth(child) => (0..count).skip(child as usize).take(1).collect(),
        };
        self.reset(children, Goal::Do(here, then))
    }

    pub(super) fn do_then(&mut self, here: usize, then: Then) -> Stage {
        match then {
            Then::Tick(which) => self.tick_child(match which {
                Which::First => 0,
                Which::Resumed => self.resume,
                Which::Next => here + 1,
                Which::Nth(child) => child as usize,
                Which::Last => self.records.len() - 1,
            }),
            Then::Answer(status) => self.leave(status),
            Then::Finish(status) => self.carry_out(here, Reaction::finish(status)),
            Then::Skip => {
                self.mark = Mark::Started;
                self.leave(Status::Skipped)
            }
            Then::Again => {
                self.again = true;
                self.leave(Status::Running)
            }
            Then::Fault(why) => {
                self.fault = Some(why);
                self.forget();
                self.leave(Status::Failure)
            }
        }
    }

    /// Runs the scripts for an answer, then answers.
    pub(super) fn leave(&mut self, status: Status) -> Stage {
        if self.has(Flags::EXIT) && status.is_completed() {
            return Stage::Consulting(Question::Leave(status), Purpose::Tick);
        }
        self.answer(status)
    }

    pub(super) fn answer(&mut self, status: Status) -> Stage {
        let own_status = self.mark.answered(status).status();
        if self.kind().category() == Category::Decorator && self.records[0].mark.is_completed() {
            self.records[0].mark = Mark::Idle;
        }
        Stage::Answering(NodeReply { status: Some(status), own_status, again: std::mem::take(&mut self.again) })
    }

    /// The root has answered: the tick is finished, unless a node requests another at once.
    pub(super) fn root_answered(&mut self, status: Status) -> Stage {
        if status.is_completed() {
            self.records[0].mark = Mark::Idle;
        }
        if status == Status::Running && std::mem::take(&mut self.again) {
            if self.repeats < MAX_REPEATS {
                self.repeats += 1;
                return self.tick_child(0);
            }
            self.fault = Some(TOO_MANY_REPEATS);
        }
        Stage::Idle
    }
}

/// The status of a node, as another node reported it.
fn mark_of(own_status: Option<Status>) -> Mark {
    match own_status {
        Some(Status::Running) => Mark::Running,
        Some(Status::Success) => Mark::Success,
        Some(Status::Failure) => Mark::Failure,
        Some(Status::Skipped) | None => Mark::Idle,
    }
}
