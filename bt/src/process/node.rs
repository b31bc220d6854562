//! An inner node as a process of its own.

use std::time::Duration;

use channels::{
    Action, ChannelId, Envelope, Message, Offer, Pattern, Process, RequestNumber, TransitionId, Use, Value,
};

use super::protocol::Line;
use super::whole::tick_number;
use crate::reaction::{Answer, Reaction, Reset, Resume, react};
use crate::shared::Shared;
use crate::status::Mark;
use crate::{Kind, NodeId, NodeState, Outcome, Request, Status};

/// An inner node of a tree whose nodes are processes.
///
/// It waits for its parent's `[<tick>, n]` or `[<halt>, n]`, asks its children one at a time, and answers
/// `[<running>]`, `[<success>]`, `[<failure>]`, `[<halted>]`, or `[<again>]`: running, and the whole tree is to be
/// ticked again at once. A node keeps the statuses of its children, for it is the parent that resets them.
///
/// One more such process, which is no node, is above the root: it takes the ticks of the tick generator.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct NodeProcess {
    wiring: Shared<Wiring>,
    records: Box<[Record]>,
    /// The child that the next tick starts with.
    resume: usize,
    stage: Stage,
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
    /// Is a node of that kind.
    Node(Kind, Line),
}

/// A child as its parent knows it.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Child {
    pub(super) node: NodeId,
    pub(super) kind: Kind,
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
    /// About to answer.
    Answering(Said),
}

/// What comes after a child has halted.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
enum After {
    /// The child was ticked: its answer is what comes.
    Tick,
    /// These children are to be reset as well, and then this is the answer.
    Reset(Vec<usize>, Said),
}

/// What a node says to its parent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Said {
    Status(Status),
    Again,
    Halted,
}

const ASKED: TransitionId = TransitionId(0);
const SEND: TransitionId = TransitionId(1);
const ANSWERED: TransitionId = TransitionId(2);

impl NodeProcess {
    pub(super) fn new(role: Role, children: Vec<Child>) -> Self {
        Self {
            records: vec![Record::default(); children.len()].into(),
            wiring: Shared::new(Wiring { role, children }),
            resume: 0,
            stage: Stage::Idle,
            request: RequestNumber::default(),
            tick: None,
        }
    }

    /// Writes down how the children stand, as seen in that tick.
    pub(super) fn show(&self, tick: Option<i64>, states: &mut [NodeState]) {
        for (child, record) in self.wiring.children.iter().zip(&self.records) {
            let outcome = record.outcome.filter(|_| record.tick == tick);
            states[child.node.index()] = NodeState { status: record.mark.status(), outcome };
        }
    }

    /// The number of the tick, if this is the process above the root.
    pub(super) fn tree_tick(&self) -> Option<i64> {
        matches!(self.wiring.role, Role::Root(_)).then_some(self.tick).flatten()
    }

    fn kind(&self) -> Option<Kind> {
        match self.wiring.role {
            Role::Root(_) => None,
            Role::Node(kind, _) => Some(kind),
        }
    }

    fn take_request(&mut self, envelope: &Envelope) {
        self.request = self.request.max(envelope.request);
        self.tick = tick_number(&envelope.message);
        self.stage = match (self.kind(), envelope.message.head()) {
            (Some(Kind::AlwaysSuccess), _) => Stage::Answering(Said::Status(Status::Success)),
            (Some(Kind::AlwaysFailure), _) => Stage::Answering(Said::Status(Status::Failure)),
            (kind, Some("halt")) => {
                if kind.is_some_and(Kind::forgets) {
                    self.resume = 0;
                }
                self.reset(&mut (0..self.records.len()), Said::Halted)
            }
            _ => self.ask_to_tick(self.resume),
        };
    }

    fn ask_to_tick(&mut self, child: usize) -> Stage {
        let record = &mut self.records[child];
        let mark = record.mark.entered();
        *record = Record { mark, outcome: Some(Outcome::Answered(Status::Running)), tick: self.tick };
        Stage::Asking(child, Request::Tick, After::Tick)
    }

    fn take_reply(&mut self, child: usize, after: After, envelope: &Envelope) {
        self.request = envelope.request;
        self.stage = match (after, envelope.message.head()) {
            (After::Reset(rest, said), _) => {
                self.record_halt(child);
                self.reset(&mut rest.into_iter(), said)
            }
            (After::Tick, Some("success")) => self.answered(child, Status::Success, false),
            (After::Tick, Some("failure")) => self.answered(child, Status::Failure, false),
            (After::Tick, head) => self.answered(child, Status::Running, head == Some("again")),
        };
    }

    /// A child has answered a tick.
    fn answered(&mut self, child: usize, status: Status, again: bool) -> Stage {
        let record = &mut self.records[child];
        let was_idle = record.mark == Mark::Started;
        *record = Record { mark: status.into(), outcome: Some(Outcome::Answered(status)), tick: self.tick };
        let Some(kind) = self.kind() else { return self.root_answered(status, again) };
        let count = self.records.len();
        match react(kind, Answer { status, was_idle, is_last: child + 1 == count }) {
            Reaction::Next => self.ask_to_tick(child + 1),
            Reaction::Again => {
                self.resume = child + 1;
                Stage::Answering(Said::Again)
            }
            Reaction::Answer { status, reset, resume } => {
                self.resume = match resume {
                    Resume::First => 0,
                    Resume::Here => child,
                };
                let said = if again { Said::Again } else { Said::Status(status) };
                match reset {
                    Reset::None => Stage::Answering(said),
                    Reset::All => self.reset(&mut (0..count), said),
                    Reset::Others => self.reset(&mut (0..count).filter(|&other| other != child), said),
                    Reset::FromHere => self.reset(&mut (child..count), said),
                }
            }
        }
    }

    /// The root has answered: the tick is over, unless a node wants another at once.
    fn root_answered(&mut self, status: Status, again: bool) -> Stage {
        if again {
            return self.ask_to_tick(0);
        }
        if status != Status::Running {
            self.records[0].mark = Mark::Idle;
        }
        Stage::Idle
    }

    /// Resets children in order, up to the first that has to be told; what the others wait for is kept in the stage.
    fn reset(&mut self, children: &mut dyn Iterator<Item = usize>, said: Said) -> Stage {
        while let Some(child) = children.next() {
            let record = &mut self.records[child];
            if !record.mark.is_running() {
                record.mark = Mark::Idle;
            } else if self.wiring.children[child].kind == Kind::Condition {
                self.record_halt(child);
            } else {
                return Stage::Asking(child, Request::Halt, After::Reset(children.collect(), said));
            }
        }
        Stage::Answering(said)
    }

    fn record_halt(&mut self, child: usize) {
        self.records[child] = Record { mark: Mark::Idle, outcome: Some(Outcome::Halted), tick: self.tick };
    }

    /// `[<tick>, n]` or `[<halt>, n]`.
    fn question(&self, request: Request) -> Message {
        let head = match request {
            Request::Tick => "tick",
            Request::Halt => "halt",
        };
        Message::new([Value::symbol(head), Value::Int(self.tick.unwrap_or_default())])
    }

    fn envelope(&self, message: Message) -> Envelope {
        Envelope { message, request: self.request }
    }
}

impl Process for NodeProcess {
    fn offers(&self, offers: &mut Vec<Offer>) {
        let receive = |transition, channel| Offer { transition, action: Action::Receive(channel, Pattern::Any) };
        let send = |channel, message| Offer { transition: SEND, action: Action::Send(channel, self.envelope(message)) };
        let children = &self.wiring.children;
        offers.push(match (&self.stage, &self.wiring.role) {
            (Stage::Idle, Role::Root(ticks)) => receive(ASKED, *ticks),
            (Stage::Idle, Role::Node(_, parent)) => receive(ASKED, parent.requests),
            (Stage::Asking(child, request, _), _) => send(children[*child].line.requests, self.question(*request)),
            (Stage::Waiting(child, ..), _) => receive(ANSWERED, children[*child].line.replies),
            (Stage::Answering(said), Role::Node(_, parent)) => send(parent.replies, Message::symbols([said.name()])),
            (Stage::Answering(_), Role::Root(_)) => return,
        });
    }

    fn take(&mut self, transition: TransitionId, received: Option<Envelope>, _now: Duration) {
        match (transition, std::mem::replace(&mut self.stage, Stage::Idle), received) {
            (ASKED, _, Some(envelope)) => self.take_request(&envelope),
            (ANSWERED, Stage::Waiting(child, _, after), Some(envelope)) => self.take_reply(child, after, &envelope),
            (SEND, Stage::Asking(child, request, after), _) => self.stage = Stage::Waiting(child, request, after),
            _ => {}
        }
    }

    fn uses(&self) -> Vec<Use> {
        let asked = match self.wiring.role {
            Role::Root(ticks) => vec![Use::Receives(ticks, None)],
            Role::Node(_, parent) => vec![Use::Receives(parent.requests, None), Use::Sends(parent.replies, None)],
        };
        let children = self.wiring.children.iter().map(|child| child.line);
        let asks = children.flat_map(|line| [Use::Sends(line.requests, None), Use::Receives(line.replies, None)]);
        asked.into_iter().chain(asks).collect()
    }

    fn location(&self) -> String {
        match &self.stage {
            Stage::Idle => "idle".to_owned(),
            Stage::Asking(child, request, _) | Stage::Waiting(child, request, _) => match request {
                Request::Tick => format!("waiting for node {}", self.wiring.children[*child].node),
                Request::Halt => format!("waiting for node {} to halt", self.wiring.children[*child].node),
            },
            Stage::Answering(_) => "answering".to_owned(),
        }
    }
}

impl Said {
    fn name(self) -> &'static str {
        match self {
            Self::Status(status) => status.name(),
            Self::Again => "again",
            Self::Halted => "halted",
        }
    }
}
