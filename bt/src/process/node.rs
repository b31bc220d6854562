//! An inner node as a process of its own.

mod halting;
mod stage;
mod ticking;

use std::time::Duration;

use channels::{
    Action, ChannelId, Envelope, Message, Offer, Pattern, Process, RequestNumber, TransitionId, Use, Value,
};

use stage::Stage;

use super::board::Told;
use super::protocol::{Line, said_message, stands_name};
use crate::program::Flags;
use crate::semantics::{Memory, Reading};
use crate::shared::Shared;
use crate::status::Mark;
use crate::{Fault, Kind, NodeId, NodeState, Outcome, Request};

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
    /// What went wrong here last, other than on the blackboard.
    fault: Option<&'static str>,
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
            fault: None,
        }
    }

    /// What went wrong here last, other than on the blackboard.
    pub(super) fn fault(&self) -> Option<Fault> {
        let node = self.node().map_or(NodeId(0), |node| node.id);
        self.fault.map(|why| Fault { node, message: why.to_owned() })
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
