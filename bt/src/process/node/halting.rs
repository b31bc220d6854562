//! Resetting children, and halting a node.

use super::stage::{After, Goal, Purpose, Stage};
use super::{Child, NodeProcess, Record};
use crate::process::board::Question;
use crate::process::protocol::NodeReply;
use crate::program::Flags;
use crate::semantics::PortReading;
use crate::status::Mark;
use crate::{Kind, Outcome, Request, Status};

impl NodeProcess {
    pub(super) fn start_halt(&mut self) -> Stage {
        if self.memory.catches_halts(self.kind()) {
            if self.has(Flags::READS) {
                return Stage::Consulting(Question::Read, Purpose::Halt);
            }
            if self.node().is_some_and(|node| node.reading == PortReading::Numbers([1, 0])) {
                return self.start_catch();
            }
        }
        self.reset_all(Goal::Halt { skips: false })
    }

    pub(super) fn start_catch(&mut self) -> Stage {
        self.memory.catches = true;
        self.reset((0..self.records.len() - 1).collect(), Goal::Catch)
    }

    pub(super) fn reset_all(&mut self, goal: Goal) -> Stage {
        self.reset((0..self.records.len()).collect(), goal)
    }

    /// Resets children in order, up to the first that must be asked to halt; the stage keeps the others.
    pub(super) fn reset(&mut self, children: Vec<usize>, goal: Goal) -> Stage {
        let mut children = children.into_iter();
        while let Some(child) = children.next() {
            let record = &mut self.records[child];
            let Child { kind, is_guarded, .. } = self.wiring.children[child];
            if !record.mark.is_running() {
                record.mark = Mark::Idle;
            } else if kind == Kind::Condition && !is_guarded {
                // A condition is not asked to stop; a process that runs its scripts is, for the script of a halt.
                self.record_halt(child);
            } else {
                return Stage::Asking(child, Request::Halt, After::Reset(children.collect(), goal));
            }
        }
        match goal {
            Goal::Do(here, then) => self.do_then(here, then),
            Goal::Catch => self.tick_child(self.records.len() - 1),
            Goal::Halt { skips } => {
                self.forget();
                if self.has(Flags::HALTED) {
                    return Stage::Consulting(Question::Halted, Purpose::Halted { skips });
                }
                Stage::Answering(self.reply_when_halted(skips))
            }
        }
    }

    pub(super) fn reply_when_halted(&mut self, skips: bool) -> NodeReply {
        let again = std::mem::take(&mut self.again);
        NodeReply { status: skips.then_some(Status::Skipped), own_status: None, again }
    }

    pub(super) fn forget(&mut self) {
        let kind = self.kind();
        self.memory.forget(kind);
        if kind.forgets() {
            self.resume = 0;
        }
    }

    pub(super) fn record_halt(&mut self, child: usize) {
        let skipped = Some(Outcome::Answered(Status::Skipped));
        let Record { mark, outcome, tick } = self.records[child];
        let was_skipped = mark == Mark::Lingering && outcome == skipped && tick == self.tick;
        let outcome = if was_skipped { skipped } else { Some(Outcome::Halted) };
        self.records[child] = Record { mark: Mark::Idle, outcome, tick: self.tick };
    }
}
