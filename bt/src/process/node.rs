//! An inner node as a process of its own.

use std::time::Duration;

use channels::{
    Action, ChannelId, Envelope, Message, Offer, Pattern, Process, RequestNumber, TransitionId, Use, Value,
};

use super::board::{Question, Told};
use super::protocol::{Line, Said, said_message, said_of, stands_name, status_of, symbol};
use super::whole::tick_number;
use crate::engine::MAX_REPEATS;
use crate::program::Flags;
use crate::semantics::{
    Answer, Beginning, Memory, Reaction, Reading, Reset, Resume, Then, Which, begin, needs_reading, react,
};
use crate::settings::Entrance;
use crate::shared::Shared;
use crate::status::Mark;
use crate::{Kind, NodeId, NodeState, Outcome, Request, Status};

/// An inner node of a tree whose nodes are processes.
///
/// It waits for its parent's `[<tick>, n, <how it stands>]` or `[<halt>, …]`, asks its children one at a time, and says
/// what it answers, how it stands then, and whether the whole tree is to be ticked again at once. A node keeps the
/// statuses of its children, for it is the parent that resets them. What it needs from the blackboard it asks the
/// [`BlackboardProcess`](super::BlackboardProcess). A leaf that has scripts has such a process before it.
///
/// One more such process, which is no node, is above the root: it takes the ticks of the tick generator.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct NodeProcess {
    wiring: Shared<Wiring>,
    records: Box<[Record]>,
    memory: Memory,
    /// The child that the next tick starts with.
    resume: usize,
    /// How this node stands, in the middle of a tick.
    mark: Mark,
    stage: Stage,
    /// Somebody wants the whole tree ticked again.
    again: bool,
    /// How often that has been done in this tick; above the root only.
    repeats: u32,
    /// How many requests the tree has made, as far as is known here.
    request: RequestNumber,
    /// The number of the tick of the tree that this node was last asked in.
    tick: Option<i64>,
}

#[derive(Debug, PartialEq, Eq)]
pub(super) struct Wiring {
    pub(super) role: Role,
    pub(super) children: Vec<Child>,
}

/// Who asks a node, and what it does with its children.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Role {
    /// Takes ticks from this channel, and has the root for its only child.
    Root(ChannelId),
    Node(Node),
}

/// A node as its process knows it.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Node {
    pub(super) id: NodeId,
    pub(super) kind: Kind,
    pub(super) flags: Flags,
    /// What it reads if it need not ask the blackboard.
    pub(super) reading: Reading,
    pub(super) parent: Line,
    pub(super) board: Option<Line>,
}

/// A child as its parent knows it.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Child {
    pub(super) node: NodeId,
    pub(super) kind: Kind,
    /// It is a leaf with scripts: what is asked is the process that runs them.
    pub(super) is_guarded: bool,
    pub(super) line: Line,
}

/// How a child stands.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Default)]
struct Record {
    mark: Mark,
    outcome: Option<Outcome>,
    /// The tick that the outcome is of.
    tick: Option<i64>,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
enum Stage {
    Idle,
    /// About to ask this child.
    Asking(usize, Request, After),
    /// Waiting for it.
    Waiting(usize, Request, After),
    /// About to ask the blackboard.
    Consulting(Question, Purpose),
    /// Waiting for it.
    Consulted(Question, Purpose),
    /// About to answer.
    Answering(Said),
}

/// What comes after a child has answered.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
enum After {
    /// The child was ticked: its answer is what comes.
    Tick,
    /// These children are to be reset as well, and then that is done.
    Reset(Vec<usize>, Goal),
}

/// What comes after children have been reset.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Goal {
    /// Because of that child.
    Do(usize, Then),
    /// This node is halted; it is skipped then, or says that it has halted.
    Halt { skips: bool },
    /// The last child is ticked, and then this node is halted.
    Catch,
}

/// Why the blackboard is asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Purpose {
    Tick,
    /// A child has failed that was idle or not, and the number of attempts is read again.
    Retry {
        child: usize,
        was_idle: bool,
    },
    /// To see whether the last child is ticked before this node is halted.
    Halt,
    /// This node has been halted.
    Halted {
        skips: bool,
    },
}

const ASKED: TransitionId = TransitionId(0);
const SEND: TransitionId = TransitionId(1);
const ANSWERED: TransitionId = TransitionId(2);

impl NodeProcess {
    pub(super) fn new(role: Role, children: Vec<Child>) -> Self {
        let memory = Memory::new(u32::try_from(children.len()).unwrap_or(u32::MAX));
        Self {
            records: vec![Record::default(); children.len()].into(),
            wiring: Shared::new(Wiring { role, children }),
            memory,
            resume: 0,
            mark: Mark::Idle,
            stage: Stage::Idle,
            again: false,
            repeats: 0,
            request: RequestNumber::default(),
            tick: None,
        }
    }

    /// Writes down how the children stand, as seen in that tick.
    pub(super) fn show(&self, tick: Option<i64>, states: &mut [NodeState]) {
        if self.node().is_some_and(|node| node.kind.is_leaf()) {
            // It stands before the leaf: the parent knows how the leaf stands.
            return;
        }
        for (child, record) in self.wiring.children.iter().zip(&self.records) {
            let outcome = record.outcome.filter(|_| record.tick == tick);
            states[child.node.index()] = NodeState { status: record.mark.status(), outcome };
        }
    }

    /// The number of the tick, if this is the process above the root.
    pub(super) fn tree_tick(&self) -> Option<i64> {
        matches!(self.wiring.role, Role::Root(_)).then_some(self.tick).flatten()
    }

    fn node(&self) -> Option<&Node> {
        match &self.wiring.role {
            Role::Root(_) => None,
            Role::Node(node) => Some(node),
        }
    }

    /// The kind of the node; what is above the root does nothing but pass on what its child says.
    fn kind(&self) -> Kind {
        self.node().map_or(Kind::SubTree, |node| node.kind)
    }

    fn has(&self, flag: Flags) -> bool {
        self.node().is_some_and(|node| node.flags.has(flag))
    }

    fn take_request(&mut self, envelope: &Envelope, now: Duration) -> Stage {
        self.request = self.request.max(envelope.request);
        self.tick = tick_number(&envelope.message);
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

    /// Reads what is to be read, and begins.
    fn read(&mut self, now: Duration) -> Stage {
        if self.has(Flags::READS) && needs_reading(self.kind(), &self.memory, self.mark.was_idle()) {
            return Stage::Consulting(Question::Read, Purpose::Tick);
        }
        let reading = self.node().map_or(Reading::Nothing, |node| node.reading);
        self.begin(reading, now)
    }

    fn begin(&mut self, reading: Reading, now: Duration) -> Stage {
        let kind = self.kind();
        let child_runs = self.records.first().is_some_and(|record| record.mark.is_running());
        let beginning = Beginning { was: self.mark.status(), reading, now, child_runs };
        let reaction = begin(kind, &mut self.memory, beginning);
        self.mark = self.mark.entered();
        if kind.runs_when_begun() && matches!(reaction, Reaction::Do { then: Then::Tick(_), .. }) {
            self.mark = self.mark.begun();
        }
        self.carry_out(0, reaction)
    }

    /// The blackboard has answered.
    fn take_told(&mut self, question: Question, purpose: Purpose, told: Told, now: Duration) -> Stage {
        match (purpose, told) {
            (Purpose::Tick, Told::Entrance(Entrance::Open)) => self.read(now),
            (Purpose::Tick, Told::Entrance(Entrance::Closed(status))) => self.leave(status),
            (Purpose::Tick, Told::Entrance(Entrance::Left)) => self.reset_all(Goal::Halt { skips: true }),
            (Purpose::Tick, Told::Reading(reading)) => self.begin(reading, now),
            (Purpose::Tick, Told::Done) => match question {
                Question::Leave(status) => self.answer(status),
                _ => Stage::Idle,
            },
            (Purpose::Tick, Told::Fault) => match question {
                Question::Leave(_) => self.answer(Status::Failure),
                Question::Read => {
                    self.mark = self.mark.entered();
                    self.forget();
                    self.reset_all(Goal::Do(0, Then::Answer(Status::Failure)))
                }
                _ => self.leave(Status::Failure),
            },
            (Purpose::Retry { child, was_idle }, told) => {
                if let Told::Reading(Reading::Numbers(limits)) = told {
                    self.memory.limits = limits;
                }
                self.react(child, Status::Failure, was_idle)
            }
            (Purpose::Halt, told) => {
                if told == Told::Reading(Reading::Numbers([1, 0])) {
                    return self.start_catch();
                }
                self.reset_all(Goal::Halt { skips: false })
            }
            (Purpose::Halted { skips }, _) => Stage::Answering(self.said_when_halted(skips)),
        }
    }

    fn tick_child(&mut self, mut child: usize) -> Stage {
        while self.kind().passes_over_completed() && self.records[child].mark.is_completed() {
            let answer = Answer { status: None, was_idle: false, is_last: child + 1 == self.records.len() };
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

    fn take_reply(&mut self, child: usize, after: After, envelope: &Envelope) -> Stage {
        self.request = envelope.request;
        let said = said_of(&envelope.message);
        self.again |= said.again;
        match (after, said.status) {
            (After::Reset(rest, goal), _) => {
                self.record_halt(child);
                self.reset(rest, goal)
            }
            (After::Tick, status) => self.answered(child, status.unwrap_or(Status::Failure), said.stands),
        }
    }

    /// A child has answered a tick.
    fn answered(&mut self, child: usize, status: Status, stands: Option<Status>) -> Stage {
        let record = &mut self.records[child];
        let was_idle = record.mark.was_idle();
        *record = Record { mark: mark_of(stands), outcome: Some(Outcome::Answered(status)), tick: self.tick };
        if self.node().is_none() {
            return self.root_answered(status);
        }
        if self.memory.catches {
            return self.reset_all(Goal::Halt { skips: false });
        }
        let is_retry = self.kind() == Kind::RetryUntilSuccessful && status == Status::Failure;
        if is_retry && self.has(Flags::READS) {
            return Stage::Consulting(Question::Read, Purpose::Retry { child, was_idle });
        }
        self.react(child, status, was_idle)
    }

    fn react(&mut self, child: usize, status: Status, was_idle: bool) -> Stage {
        let answer = Answer { status: Some(status), was_idle, is_last: child + 1 == self.records.len() };
        let reaction = react(self.kind(), &mut self.memory, answer);
        self.carry_out(child, reaction)
    }

    /// Does what the node wants done; `here` is the child that answered.
    fn carry_out(&mut self, here: usize, reaction: Reaction) -> Stage {
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

    fn do_then(&mut self, here: usize, then: Then) -> Stage {
        match then {
            Then::Tick(which) => self.tick_child(match which {
                Which::First => 0,
                Which::Resumed => self.resume,
                Which::Next => here + 1,
                Which::Nth(child) => child as usize,
                Which::Last => self.records.len() - 1,
            }),
            Then::Answer(status) => self.leave(status),
            Then::Again => {
                self.again = true;
                self.leave(Status::Running)
            }
            Then::Fault(_) => {
                self.forget();
                self.leave(Status::Failure)
            }
        }
    }

    /// Runs the scripts for an answer, and answers.
    fn leave(&mut self, status: Status) -> Stage {
        if self.has(Flags::EXIT) && status.is_completed() {
            return Stage::Consulting(Question::Leave(status), Purpose::Tick);
        }
        self.answer(status)
    }

    fn answer(&mut self, status: Status) -> Stage {
        let stands = self.mark.answered(status).status();
        Stage::Answering(Said { status: Some(status), stands, again: std::mem::take(&mut self.again) })
    }

    /// The root has answered: the tick is over, unless a node wants another at once.
    fn root_answered(&mut self, status: Status) -> Stage {
        if status.is_completed() {
            self.records[0].mark = Mark::Idle;
        }
        if status == Status::Running && std::mem::take(&mut self.again) && self.repeats < MAX_REPEATS {
            self.repeats += 1;
            return self.tick_child(0);
        }
        Stage::Idle
    }

    /// This node is to halt.
    fn start_halt(&mut self) -> Stage {
        if self.memory.catches_halts(self.kind()) {
            if self.has(Flags::READS) {
                return Stage::Consulting(Question::Read, Purpose::Halt);
            }
            if self.node().is_some_and(|node| node.reading == Reading::Numbers([1, 0])) {
                return self.start_catch();
            }
        }
        self.reset_all(Goal::Halt { skips: false })
    }

    fn start_catch(&mut self) -> Stage {
        self.memory.catches = true;
        self.reset((0..self.records.len() - 1).collect(), Goal::Catch)
    }

    fn reset_all(&mut self, goal: Goal) -> Stage {
        self.reset((0..self.records.len()).collect(), goal)
    }

    /// Resets children in order, up to the first that has to be told; what the others wait for is kept in the stage.
    fn reset(&mut self, children: Vec<usize>, goal: Goal) -> Stage {
        let mut children = children.into_iter();
        while let Some(child) = children.next() {
            let record = &mut self.records[child];
            let Child { kind, is_guarded, .. } = self.wiring.children[child];
            if !record.mark.is_running() {
                record.mark = Mark::Idle;
            } else if kind == Kind::Condition && !is_guarded {
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
                Stage::Answering(self.said_when_halted(skips))
            }
        }
    }

    fn said_when_halted(&mut self, skips: bool) -> Said {
        let again = std::mem::take(&mut self.again);
        Said { status: skips.then_some(Status::Skipped), stands: None, again }
    }

    fn forget(&mut self) {
        let kind = self.kind();
        self.memory.forget(kind);
        if kind.forgets() {
            self.resume = 0;
        }
    }

    fn record_halt(&mut self, child: usize) {
        self.records[child] = Record { mark: Mark::Idle, outcome: Some(Outcome::Halted), tick: self.tick };
    }

    /// `[<tick>, n, <how the child stands>]` or `[<halt>, …]`.
    fn question(&self, child: usize, request: Request) -> Message {
        let head = match request {
            Request::Tick => "tick",
            Request::Halt => "halt",
        };
        // That the child is being asked is noted already: it stands as before.
        let stands = self.records[child].mark.before();
        let tick = Value::Int(self.tick.unwrap_or_default());
        Message::new([Value::symbol(head), tick, Value::symbol(stands_name(stands))])
    }

    fn envelope(&self, message: Message) -> Envelope {
        Envelope { message, request: self.request }
    }
}

/// How a node stands, as another has said it.
fn mark_of(stands: Option<Status>) -> Mark {
    match stands {
        Some(Status::Running) => Mark::Running,
        Some(Status::Success) => Mark::Success,
        Some(Status::Failure) => Mark::Failure,
        Some(Status::Skipped) | None => Mark::Idle,
    }
}

impl Process for NodeProcess {
    fn offers(&self, offers: &mut Vec<Offer>) {
        let receive = |transition, channel| Offer { transition, action: Action::Receive(channel, Pattern::Any) };
        let send = |channel, message| Offer { transition: SEND, action: Action::Send(channel, self.envelope(message)) };
        let children = &self.wiring.children;
        let board = || self.node().and_then(|node| node.board);
        offers.extend(match (&self.stage, &self.wiring.role) {
            (Stage::Idle, Role::Root(ticks)) => Some(receive(ASKED, *ticks)),
            (Stage::Idle, Role::Node(node)) => Some(receive(ASKED, node.parent.requests)),
            (Stage::Asking(child, request, _), _) => {
                Some(send(children[*child].line.requests, self.question(*child, *request)))
            }
            (Stage::Waiting(child, ..), _) => Some(receive(ANSWERED, children[*child].line.replies)),
            (Stage::Consulting(question, _), Role::Node(node)) => {
                board().map(|line| send(line.requests, question.message(node.id, self.mark.status())))
            }
            (Stage::Consulted(..), _) => board().map(|line| receive(ANSWERED, line.replies)),
            (Stage::Answering(said), Role::Node(node)) => Some(send(node.parent.replies, said_message(*said))),
            (Stage::Answering(_) | Stage::Consulting(..), Role::Root(_)) => None,
        });
    }

    fn take(&mut self, transition: TransitionId, received: Option<Envelope>, now: Duration) {
        let stage = std::mem::replace(&mut self.stage, Stage::Idle);
        self.stage = match (transition, stage, received) {
            (ASKED, _, Some(envelope)) => self.take_request(&envelope, now),
            (ANSWERED, Stage::Waiting(child, _, after), Some(envelope)) => self.take_reply(child, after, &envelope),
            (ANSWERED, Stage::Consulted(question, purpose), Some(envelope)) => {
                self.take_told(question, purpose, Told::of(&envelope.message, question), now)
            }
            (SEND, Stage::Asking(child, request, after), _) => Stage::Waiting(child, request, after),
            (SEND, Stage::Consulting(question, purpose), _) => Stage::Consulted(question, purpose),
            _ => Stage::Idle,
        };
    }

    fn uses(&self) -> Vec<Use> {
        let both_ways = |line: Line| [Use::Sends(line.requests, None), Use::Receives(line.replies, None)];
        let asked = match &self.wiring.role {
            Role::Root(ticks) => vec![Use::Receives(*ticks, None)],
            Role::Node(Node { parent, .. }) => {
                vec![Use::Receives(parent.requests, None), Use::Sends(parent.replies, None)]
            }
        };
        let board = self.node().and_then(|node| node.board);
        let lines = self.wiring.children.iter().map(|child| child.line).chain(board);
        asked.into_iter().chain(lines.flat_map(both_ways)).collect()
    }

    fn location(&self) -> String {
        match &self.stage {
            Stage::Idle => "idle".to_owned(),
            Stage::Asking(child, request, _) | Stage::Waiting(child, request, _) => match request {
                Request::Tick => format!("waiting for node {}", self.wiring.children[*child].node),
                Request::Halt => format!("waiting for node {} to halt", self.wiring.children[*child].node),
            },
            Stage::Consulting(..) | Stage::Consulted(..) => "waiting for the blackboard".to_owned(),
            Stage::Answering(_) => "answering".to_owned(),
        }
    }
}
