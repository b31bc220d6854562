//! The blackboard as a separate process.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use channels::{
    Action, Domain, Envelope, FieldKind, Message, NoNormalForm, NormalForm, Offer, Pattern, Process, Shape, Shared,
    TransitionId, Use, Value,
};

use super::protocol::{ChannelPair, number, own_status_name, status_of, symbol};
use crate::blackboard::Blackboard;
use crate::hooks::Entrance;
use crate::ports::Traffic;
use crate::semantics::PortReading;
use crate::settings::ReadError;
use crate::{Fault, Node, NodeId, Status, Tree};

/// The blackboard of a tree whose nodes are processes: the paper calls it the shared variables of a composite process.
/// It is kept by an additional process, which evaluates the ports and scripts of the nodes.
///
/// A node sends `[<question>, node, <status>]` and waits for the answer; a leaf asks for the values that its ports
/// read, and reports those that they write. So the blackboard is a value like every other state, and nodes know it only
/// through messages.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct BlackboardProcess {
    wiring: Shared<BoardWiring>,
    board: Blackboard,
    faults: Vec<Fault>,
    /// The pending answer and its recipient.
    answer: Option<(usize, Message)>,
}

#[derive(Debug, PartialEq)]
struct BoardWiring {
    tree: Arc<Tree>,
    pairs: Vec<ChannelPair>,
    /// For leaves with ports connected to entries.
    traffic: BTreeMap<u32, Traffic>,
}

impl Eq for BoardWiring {}

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

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum BoardAnswer {
    Entrance(Entrance),
    Reading(PortReading),
    Done,
    /// An error occurred.
    Fault,
}

const ANSWER: TransitionId = TransitionId(0);
/// The transition of receiving a question from the first node.
const FIRST_NODE: u32 = 1;

impl BlackboardProcess {
    pub(super) fn new(tree: Arc<Tree>, pairs: Vec<ChannelPair>) -> Self {
        let board = tree.program.blackboard();
        let with_entries = |leaf: &&Node| has_entries(&tree, leaf.id());
        let traffic = tree.leaves().filter(with_entries).map(|leaf| (leaf.id().0, Traffic::of(&tree, leaf.id())));
        let traffic = traffic.collect();
        Self { wiring: Shared::new(BoardWiring { tree, pairs, traffic }), board, faults: Vec::new(), answer: None }
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

    fn reply_to(&mut self, message: &Message) -> Message {
        let wiring = Shared::clone(&self.wiring);
        let node = number(message, 2).and_then(|node| u32::try_from(node).ok()).unwrap_or_default();
        let (traffic, board) = (wiring.traffic.get(&node), &mut self.board);
        let answer = match message.head() {
            Some("inputs") => {
                let read = traffic.map_or(Ok(Vec::new()), |traffic| traffic.read(board));
                let inputs = |inputs| Message::new(std::iter::once(Value::symbol("inputs")).chain(inputs));
                read.map(inputs).map_err(|error| error.to_string())
            }
            Some("outputs") => {
                let outputs = message.fields().get(2..).unwrap_or_default();
                let written = traffic.map_or(Ok(()), |traffic| traffic.write(outputs, board));
                written.map(|()| BoardAnswer::Done.message()).map_err(|error| error.to_string())
            }
            _ => evaluate(&wiring.tree, node, message, board)
                .map(BoardAnswer::message)
                .map_err(|error| error.to_string()),
        };
        // A node with a question at every tick would add the same fault each time, and the list would grow forever.
        answer.unwrap_or_else(|message| {
            let fault = Fault { node: NodeId(node), message };
            if !self.faults.contains(&fault) {
                self.faults.push(fault);
            }
            BoardAnswer::Fault.message()
        })
    }
}

/// Reads a node's ports or runs its scripts, as its question requires.
fn evaluate(tree: &Tree, node: u32, question: &Message, board: &mut Blackboard) -> Result<BoardAnswer, ReadError> {
    let (program, kind) = (&tree.program, tree.node(NodeId(node)).kind());
    let status = symbol(question, 3).and_then(status_of);
    Ok(match question.head() {
        Some("enter") => BoardAnswer::Entrance(program.hooks(node).enter(status, board)?),
        Some("read") => BoardAnswer::Reading(program.setting(node).read(board, status.is_none(), kind)?),
        Some("read_after") => {
            let status = status.unwrap_or(Status::Skipped);
            BoardAnswer::Reading(program.setting(node).read_after(status, board, kind)?)
        }
        Some("leave") => {
            program.hooks(node).leave(status.unwrap_or(Status::Running), board)?;
            BoardAnswer::Done
        }
        _ => {
            program.hooks(node).halted(board)?;
            BoardAnswer::Done
        }
    })
}

impl Process for BlackboardProcess {
    fn offers(&self, offers: &mut Vec<Offer>) {
        if let Some((node, message)) = &self.answer {
            let action = Action::Send(self.wiring.pairs[*node].replies, message.clone().into());
            offers.push(Offer { transition: ANSWER, action });
            return;
        }
        offers.extend((FIRST_NODE..).zip(&self.wiring.pairs).map(|(number, pair)| Offer {
            transition: TransitionId(number),
            action: Action::Receive(pair.requests, Pattern::Any),
        }));
    }

    fn take(&mut self, transition: TransitionId, received: Option<Envelope>, _now: Duration) {
        self.answer = received.map(|envelope| {
            let answer = self.reply_to(&envelope.message);
            ((transition.0 - FIRST_NODE) as usize, answer)
        });
    }

    fn uses(&self) -> Vec<Use> {
        let pairs = self.wiring.pairs.iter();
        pairs.flat_map(|pair| [Use::Receives(pair.requests, None), Use::Sends(pair.replies, None)]).collect()
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
    [Domain::new([inputs, outputs]), Domain::new([read, board_answer_shape()])]
}

pub(super) fn board_question_domain() -> Domain {
    Domain::new([Shape::new([
        ("question", FieldKind::symbols(["enter", "read", "read_after", "leave", "halted"])),
        ("node", FieldKind::Int),
        ("own_status", FieldKind::symbols(["idle", "running", "success", "failure", "skipped"])),
    ])])
}

pub(super) fn board_answer_domain() -> Domain {
    Domain::new([board_answer_shape()])
}

/// All answers have the same shape: a word and two numbers, which only some of them use.
fn board_answer_shape() -> Shape {
    let words =
        ["open", "left", "done", "fault", "nothing", "proceed", "numbers", "running", "success", "failure", "skipped"];
    Shape::new([("answer", FieldKind::symbols(words)), ("first", FieldKind::Int), ("second", FieldKind::Int)])
}

impl BoardAnswer {
    fn message(self) -> Message {
        let (word, [first, second]) = match self {
            Self::Done => ("done", [0, 0]),
            Self::Fault => ("fault", [0, 0]),
            Self::Entrance(Entrance::Open) => ("open", [0, 0]),
            Self::Entrance(Entrance::Left) => ("left", [0, 0]),
            Self::Entrance(Entrance::Closed(status)) | Self::Reading(PortReading::Status(status)) => {
                (status.name(), [0, 0])
            }
            Self::Reading(PortReading::Nothing) => ("nothing", [0, 0]),
            Self::Reading(PortReading::Proceed) => ("proceed", [0, 0]),
            Self::Reading(PortReading::Numbers(numbers)) => ("numbers", numbers),
        };
        Message::new([Value::symbol(word), Value::Int(first), Value::Int(second)])
    }

    pub(super) fn of(message: &Message, question: Question) -> Self {
        let numbers = [2, 3].map(|field| number(message, field).unwrap_or_default());
        let word = message.head().unwrap_or("fault");
        match (word, status_of(word)) {
            (_, Some(status)) if question == Question::Enter => Self::Entrance(Entrance::Closed(status)),
            (_, Some(status)) => Self::Reading(PortReading::Status(status)),
            ("open", _) => Self::Entrance(Entrance::Open),
            ("left", _) => Self::Entrance(Entrance::Left),
            ("done", _) => Self::Done,
            ("nothing", _) => Self::Reading(PortReading::Nothing),
            ("proceed", _) => Self::Reading(PortReading::Proceed),
            ("numbers", _) => Self::Reading(PortReading::Numbers(numbers)),
            _ => Self::Fault,
        }
    }
}
