//! An inner node as a separate process.

mod halting;
mod stage;
mod ticking;

use std::time::Duration;

use channels::{
    Action, ChannelId, Envelope, Message, NoNormalForm, NormalForm, Offer, Pattern, Process, Shared, TransitionId, Use,
    Value,
};

use stage::Stage;

use super::board::BoardAnswer;
use super::protocol::{ChannelPair, own_status_name};
use crate::program::Flags;
use crate::semantics::{Memory, PortReading};
use crate::status::Mark;
use crate::{Fault, Kind, NodeId, NodeState, Outcome, Request, Status};

/// An inner node of a tree whose nodes are processes.
///
/// It waits for its parent's `[<tick>, n, <status>]` or `[<halt>, …]`, asks its children one at a time, and reports its
/// answer, its status afterwards, and whether the whole tree must be ticked again at once. A node keeps the statuses of
/// its children, because the parent resets them. It asks the [`BlackboardProcess`](super::BlackboardProcess) for values
/// of the blackboard. A leaf with scripts has such a process in front of it.
///
/// One more such process, which is not a node, is above the root: it receives the ticks of the tick generator.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct NodeProcess {
    wiring: Shared<NodeWiring>,
    records: Box<[Record]>,
    memory: Memory,
    /// The child with which the next tick begins.
    resume: usize,
    /// The status of this node, within a tick.
    mark: Mark,
    stage: Stage,
    /// Whether a node has asked for another tick of the whole tree.
    again: bool,
    /// The number of such repetitions in this tick; only above the root.
    repeats: u32,
    /// The number of the tree's tick in which this node was last asked.
    tick: Option<i64>,
    /// The last fault here, except on the blackboard.
    fault: Option<&'static str>,
}

#[derive(Debug, PartialEq, Eq)]
pub(super) struct NodeWiring {
    pub(super) role: Role,
    pub(super) children: Vec<Child>,
}

/// The client of a node, and the node's relation to its children.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Role {
    /// Receives ticks from this channel; the root is its only child.
    Root(ChannelId),
    Node(InnerNode),
}

#[derive(Debug, PartialEq, Eq)]
pub(super) struct InnerNode {
    pub(super) id: NodeId,
    pub(super) kind: Kind,
    pub(super) flags: Flags,
    /// Values that it reads without asking the blackboard.
    pub(super) reading: PortReading,
    pub(super) parent: ChannelPair,
    pub(super) board: Option<ChannelPair>,
}

/// What a node needs of a child.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Child {
    pub(super) node: NodeId,
    pub(super) kind: Kind,
    /// Whether it is a leaf with scripts: then its parent sends its requests to the process that runs them.
    pub(super) is_guarded: bool,
    pub(super) channels: ChannelPair,
}

/// The status of a child.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Default)]
struct Record {
    mark: Mark,
    outcome: Option<Outcome>,
    /// The tick to which the outcome belongs.
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
            wiring: Shared::new(NodeWiring { role, children }),
            memory,
            resume: 0,
            mark: Mark::Idle,
            stage: Stage::Idle,
            again: false,
            repeats: 0,
            tick: None,
            fault: None,
        }
    }

    /// The last fault here, except on the blackboard.
    pub(super) fn fault(&self) -> Option<Fault> {
        let node = self.node().map_or(NodeId(0), |node| node.id);
        self.fault.map(|why| Fault { node, message: why.to_owned() })
    }

    /// Writes the statuses of the children, as seen in this tick.
    pub(super) fn show(&self, tick: Option<i64>, states: &mut [NodeState]) {
        if self.node().is_some_and(|node| node.kind.is_leaf()) {
            // It is in front of the leaf: the parent has the leaf's status.
            return;
        }
        for (child, record) in self.wiring.children.iter().zip(&self.records) {
            let outcome = record.outcome.filter(|_| record.tick == tick);
            states[child.node.index()] = NodeState { status: record.mark.status(), outcome };
        }
    }

    /// The status of the children. The one that is being ticked counts as running.
    pub(super) fn outcomes(&self) -> Vec<(NodeId, Outcome)> {
        let children = self.wiring.children.iter();
        let known = children.zip(&self.records).filter_map(|(child, record)| Some((child.node, record.outcome?)));
        let ticked = match self.stage {
            Stage::Waiting(child, Request::Tick, _) => Some(child),
            _ => None,
        };
        let running = |child: usize| (self.wiring.children[child].node, Outcome::Answered(Status::Running));
        known.chain(ticked.map(running)).collect()
    }

    /// The number of the tick, if this is the process above the root.
    pub(super) fn tree_tick(&self) -> Option<i64> {
        matches!(self.wiring.role, Role::Root(_)).then_some(self.tick).flatten()
    }

    fn node(&self) -> Option<&InnerNode> {
        match &self.wiring.role {
            Role::Root(_) => None,
            Role::Node(node) => Some(node),
        }
    }

    /// The kind of the node; the process above the root only passes on its child's answer.
    fn kind(&self) -> Kind {
        self.node().map_or(Kind::SubTree, |node| node.kind)
    }

    fn has(&self, flag: Flags) -> bool {
        self.node().is_some_and(|node| node.flags.has(flag))
    }

    /// `[<tick>, n, <status of the child>]` or `[<halt>, …]`.
    fn question(&self, child: usize, request: Request) -> Message {
        let head = match request {
            Request::Tick => "tick",
            Request::Halt => "halt",
        };
        // The child is already marked as being asked; send its status before that.
        let own_status = self.records[child].mark.before();
        let tick = Value::Int(self.tick.unwrap_or_default());
        Message::new([Value::symbol(head), tick, Value::symbol(own_status_name(own_status))])
    }
}

impl Process for NodeProcess {
    fn offers(&self, offers: &mut Vec<Offer>) {
        let receive = |transition, channel| Offer { transition, action: Action::Receive(channel, Pattern::Any) };
        let send =
            |channel, message: Message| Offer { transition: SEND, action: Action::Send(channel, message.into()) };
        let children = &self.wiring.children;
        let board = || self.node().and_then(|node| node.board);
        offers.extend(match (&self.stage, &self.wiring.role) {
            (Stage::Idle, Role::Root(ticks)) => Some(receive(ASKED, *ticks)),
            (Stage::Idle, Role::Node(node)) => Some(receive(ASKED, node.parent.requests)),
            (Stage::Asking(child, request, _), _) => {
                Some(send(children[*child].channels.requests, self.question(*child, *request)))
            }
            (Stage::Waiting(child, ..), _) => Some(receive(ANSWERED, children[*child].channels.replies)),
            (Stage::Consulting(question, _), Role::Node(node)) => {
                board().map(|pair| send(pair.requests, question.message(node.id, self.mark.status())))
            }
            (Stage::Consulted(..), _) => board().map(|pair| receive(ANSWERED, pair.replies)),
            (Stage::Answering(reply), Role::Node(node)) => Some(send(node.parent.replies, reply.message())),
            (Stage::Answering(_) | Stage::Consulting(..), Role::Root(_)) => None,
        });
    }

    fn take(&mut self, transition: TransitionId, received: Option<Envelope>, now: Duration) {
        let stage = std::mem::replace(&mut self.stage, Stage::Idle);
        self.stage = match (transition, stage, received) {
            (ASKED, _, Some(envelope)) => self.take_request(&envelope, now),
            (ANSWERED, Stage::Waiting(child, _, after), Some(envelope)) => {
                self.take_reply(child, after, &envelope, now)
            }
            (ANSWERED, Stage::Consulted(question, purpose), Some(envelope)) => {
                self.take_board_answer(question, purpose, BoardAnswer::of(&envelope.message, question), now)
            }
            (SEND, Stage::Asking(child, request, after), _) => Stage::Waiting(child, request, after),
            (SEND, Stage::Consulting(question, purpose), _) => Stage::Consulted(question, purpose),
            _ => Stage::Idle,
        };
    }

    fn uses(&self) -> Vec<Use> {
        let both_ways = |pair: ChannelPair| [Use::Sends(pair.requests, None), Use::Receives(pair.replies, None)];
        let asked = match &self.wiring.role {
            Role::Root(ticks) => vec![Use::Receives(*ticks, None)],
            Role::Node(InnerNode { parent, .. }) => {
                vec![Use::Receives(parent.requests, None), Use::Sends(parent.replies, None)]
            }
        };
        let board = self.node().and_then(|node| node.board);
        let pairs = self.wiring.children.iter().map(|child| child.channels).chain(board);
        asked.into_iter().chain(pairs.flat_map(both_ways)).collect()
    }

    /// The status of the children, faults and the number of a tick are only reported. Between ticks, the parent knows
    /// the status of the node.
    fn normalize(&mut self, form: &NormalForm<'_>) -> Result<(), NoNormalForm> {
        for record in &mut self.records {
            (record.outcome, record.tick) = (None, None);
        }
        (self.tick, self.fault) = (None, None);
        if self.stage == Stage::Idle {
            (self.mark, self.repeats) = (Mark::Idle, 0);
        }
        let (kind, reading) = (self.kind(), self.node().map(|node| node.reading));
        self.memory.normalize(form, kind, reading);
        Ok(())
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
