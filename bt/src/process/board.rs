//! The blackboard as a separate process.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use channels::{
    Action, Domain, Envelope, FieldKind, Message, NoNormalForm, NormalForm, Offer, Pattern, Process, Shape,
    TransitionId, Use, Value,
};

use super::protocol::{Line, number, own_status_name, status_of, symbol};
use crate::blackboard::Blackboard;
use crate::hooks::Entrance;
use crate::ports::Traffic;
use crate::semantics::Reading;
use crate::shared::Shared;
use crate::{Fault, Node, NodeId, Status, Tree};

/// The blackboard of a tree whose nodes are processes: the paper calls it the shared variables of a composite process.
/// It is kept by an additional process, which evaluates the ports and scripts of the nodes.
///
/// A node sends `[<question>, node, <status>]` and waits for the answer; a leaf asks for the values that its ports
/// read, and reports those that they write. So the blackboard is a value like every other state, and nodes know it only
/// through messages.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct BlackboardProcess {
    wiring: Shared<Wiring>,
    board: Blackboard,
    faults: Vec<Fault>,
    /// The pending answer and its recipient.
    answer: Option<(usize, Message)>,
}

#[derive(Debug, PartialEq)]
struct Wiring {
    tree: Arc<Tree>,
    lines: Vec<Line>,
    /// For leaves with ports connected to entries.
    traffic: BTreeMap<u32, Traffic>,
}

impl Eq for Wiring {}

/// A question of a node to the blackboard.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Question {
    /// Run its scripts before its tick.
    Enter,
    /// Read its ports.
    Read,
    /// Read its ports after this answer of a child.
    ReadAfter(Status),
    /// Run the scripts for this answer.
    Leave(Status),
    /// Run the script for a halt.
    Halted,
}

/// The answer of the blackboard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Told {
    Entrance(Entrance),
    Reading(Reading),
    Done,
    /// An error occurred.
    Fault,
}

const ANSWER: TransitionId = TransitionId(0);
/// The transition of receiving a question from the first node.
const FIRST_NODE: u32 = 1;

impl BlackboardProcess {
    pub(super) fn new(tree: Arc<Tree>, lines: Vec<Line>) -> Self {
        let board = tree.program.blackboard();
        let with_entries = |leaf: &&Node| has_entries(&tree, leaf.id());
        let traffic = tree.leaves().filter(with_entries).map(|leaf| (leaf.id().0, Traffic::of(&tree, leaf.id())));
        let traffic = traffic.collect();
        Self { wiring: Shared::new(Wiring { tree, lines, traffic }), board, faults: Vec::new(), answer: None }
    }

    /// The blackboard.
    #[must_use]
    pub fn blackboard(&self) -> &Blackboard {
        &self.board
    }

    /// The blackboard, for writing while the system is quiet.
    pub fn blackboard_mut(&mut self) -> &mut Blackboard {
        &mut self.board
    }

    /// All faults so far in scripts and ports, each once.
    #[must_use]
    pub fn faults(&self) -> &[Fault] {
        &self.faults
    }

    fn tell(&mut self, message: &Message) -> Message {
        let wiring = Shared::clone(&self.wiring);
        let program = &wiring.tree.program;
        let node = number(message, 2).and_then(|node| u32::try_from(node).ok()).unwrap_or_default();
        let own_status = symbol(message, 3).and_then(status_of);
        let kind = wiring.tree.node(NodeId(node)).kind();
        let board = &mut self.board;
        let traffic = wiring.traffic.get(&node);
        let told = match message.head() {
            Some("inputs") => {
                let read = traffic.map_or(Ok(Vec::new()), |traffic| traffic.read(board));
                let inputs = |inputs| Message::new(std::iter::once(Value::symbol("inputs")).chain(inputs));
                return self.answered(node, read.map(inputs).map_err(|error| error.to_string()));
            }
            Some("outputs") => {
                let outputs = message.fields().get(2..).unwrap_or_default();
                let written = traffic.map_or(Ok(()), |traffic| traffic.write(outputs, board));
                written.map(|()| Told::Done).map_err(|error| error.to_string())
            }
            Some("enter") => {
                program.hooks(node).enter(own_status, board).map(Told::Entrance).map_err(|e| e.to_string())
            }
            Some("read") => {
                let read = program.setting(node).read(board, own_status.is_none(), kind);
                read.map(Told::Reading).map_err(|error| error.to_string())
            }
            Some("read_after") => {
                let read = program.setting(node).read_after(own_status.unwrap_or(Status::Skipped), board, kind);
                read.map(Told::Reading).map_err(|error| error.to_string())
            }
            Some("leave") => {
                let left = program.hooks(node).leave(own_status.unwrap_or(Status::Running), board);
                left.map(|()| Told::Done).map_err(|error| error.to_string())
            }
            _ => program.hooks(node).halted(board).map(|()| Told::Done).map_err(|error| error.to_string()),
        };
        self.answered(node, told.map(Told::message))
    }

    /// The answer to a node, or the fault in its place.
    fn answered(&mut self, node: u32, answer: Result<Message, String>) -> Message {
        answer.unwrap_or_else(|message| {
            let fault = Fault { node: NodeId(node), message };
            if !self.faults.contains(&fault) {
                self.faults.push(fault);
            }
            Told::Fault.message()
        })
    }
}

impl Process for BlackboardProcess {
    fn offers(&self, offers: &mut Vec<Offer>) {
        if let Some((node, message)) = &self.answer {
            let action = Action::Send(self.wiring.lines[*node].replies, message.clone().into());
            offers.push(Offer { transition: ANSWER, action });
            return;
        }
        offers.extend((FIRST_NODE..).zip(&self.wiring.lines).map(|(number, line)| Offer {
            transition: TransitionId(number),
            action: Action::Receive(line.requests, Pattern::Any),
        }));
    }

    fn take(&mut self, transition: TransitionId, received: Option<Envelope>, _now: Duration) {
        self.answer = received.map(|envelope| {
            let told = self.tell(&envelope.message);
            ((transition.0 - FIRST_NODE) as usize, told)
        });
    }

    fn uses(&self) -> Vec<Use> {
        let lines = self.wiring.lines.iter();
        lines.flat_map(|line| [Use::Receives(line.requests, None), Use::Sends(line.replies, None)]).collect()
    }

    /// Faults are only reported.
    fn normalize(&mut self, _: &NormalForm<'_>) -> Result<(), NoNormalForm> {
        self.faults.clear();
        self.board.normalize(self.wiring.tree.program.can_unset());
        Ok(())
    }

    fn location(&self) -> String {
        if self.answer.is_some() { "answering" } else { "idle" }.to_owned()
    }
}

impl Question {
    /// The question of a node with this status.
    pub(super) fn message(self, node: NodeId, own_status: Option<Status>) -> Message {
        let (question, own_status) = match self {
            Self::Enter => ("enter", own_status),
            Self::Read => ("read", own_status),
            Self::ReadAfter(status) => ("read_after", Some(status)),
            Self::Leave(status) => ("leave", Some(status)),
            Self::Halted => ("halted", own_status),
        };
        Message::new([Value::symbol(question), Value::Int(node.0.into()), Value::symbol(own_status_name(own_status))])
    }
}

/// The request of a leaf for its inputs: `[<inputs>, node]`.
pub(super) fn inputs_question(leaf: NodeId) -> Message {
    Message::new([Value::symbol("inputs"), Value::Int(leaf.0.into())])
}

/// The request of a leaf to write its outputs: `[<outputs>, node, …]`, with the fields of the skill's answer.
pub(super) fn outputs_question(leaf: NodeId, answer: &Message) -> Message {
    let outputs = answer.fields().get(1..).unwrap_or_default().iter().cloned();
    Message::new([Value::symbol("outputs"), Value::Int(leaf.0.into())].into_iter().chain(outputs))
}

/// Whether a leaf has ports connected to entries.
pub(super) fn has_entries(tree: &Tree, leaf: NodeId) -> bool {
    tree.program.leaf_ports(leaf).values().any(|port| port.entry().is_some())
}

/// The domains of the channels between a leaf and the blackboard.
pub(super) fn leaf_domains(tree: &Tree, leaf: NodeId) -> [Domain; 2] {
    let traffic = Traffic::of(tree, leaf);
    let head = |field: &str, name| (field.to_owned(), FieldKind::symbols([name]));
    let node = || ("node".to_owned(), FieldKind::Int);
    let inputs = Shape::new([head("question", "inputs"), node()]);
    let outputs = Shape::new([head("question", "outputs"), node()].into_iter().chain(traffic.output_fields()));
    let read = Shape::new(std::iter::once(head("answer", "inputs")).chain(traffic.input_fields()));
    [Domain::new([inputs, outputs]), Domain::new([read, told_shape()])]
}

pub(super) fn asked_domain() -> Domain {
    Domain::new([Shape::new([
        ("question", FieldKind::symbols(["enter", "read", "read_after", "leave", "halted"])),
        ("node", FieldKind::Int),
        ("own_status", FieldKind::symbols(["idle", "running", "success", "failure", "skipped"])),
    ])])
}

pub(super) fn told_domain() -> Domain {
    Domain::new([told_shape()])
}

/// All answers have the same shape: a word and two numbers, which only some of them use.
fn told_shape() -> Shape {
    let words =
        ["open", "left", "done", "fault", "nothing", "proceed", "numbers", "running", "success", "failure", "skipped"];
    Shape::new([("answer", FieldKind::symbols(words)), ("first", FieldKind::Int), ("second", FieldKind::Int)])
}

impl Told {
    fn message(self) -> Message {
        let (word, [first, second]) = match self {
            Self::Done => ("done", [0, 0]),
            Self::Fault => ("fault", [0, 0]),
            Self::Entrance(Entrance::Open) => ("open", [0, 0]),
            Self::Entrance(Entrance::Left) => ("left", [0, 0]),
            Self::Entrance(Entrance::Closed(status)) | Self::Reading(Reading::Status(status)) => {
                (status.name(), [0, 0])
            }
            Self::Reading(Reading::Nothing) => ("nothing", [0, 0]),
            Self::Reading(Reading::Proceed) => ("proceed", [0, 0]),
            Self::Reading(Reading::Numbers(numbers)) => ("numbers", numbers),
        };
        Message::new([Value::symbol(word), Value::Int(first), Value::Int(second)])
    }

    /// The answer to this question.
    pub(super) fn of(message: &Message, question: Question) -> Self {
        let numbers = [2, 3].map(|field| number(message, field).unwrap_or_default());
        let word = message.head().unwrap_or("fault");
        match (word, status_of(word)) {
            (_, Some(status)) if question == Question::Enter => Self::Entrance(Entrance::Closed(status)),
            (_, Some(status)) => Self::Reading(Reading::Status(status)),
            ("open", _) => Self::Entrance(Entrance::Open),
            ("left", _) => Self::Entrance(Entrance::Left),
            ("done", _) => Self::Done,
            ("nothing", _) => Self::Reading(Reading::Nothing),
            ("proceed", _) => Self::Reading(Reading::Proceed),
            ("numbers", _) => Self::Reading(Reading::Numbers(numbers)),
            _ => Self::Fault,
        }
    }
}
