//! The messages between a tree and its skills.

use channels::{
    Capacity, ChannelId, Domain, FieldKind, Message, ProcessId, Role, Shape, TickGenerator, Topology, Use, Value,
    WiringError,
};

use crate::ports::Traffic;
use crate::{Kind, Node, NodeId, Reply, Request, Status, Tree};

/// The message from the tick generator to a tree: `[<tick>, n]`.
#[must_use]
pub fn tick_domain() -> Domain {
    Domain::new([TickGenerator::shape()])
}

/// The messages from a tree to the process of a leaf: `[<tick>, …]`, with the values that the leaf's ports read from
/// the blackboard in alphabetical order (`<none>` for an entry without a value), or `[<halt>]`. Each field has its
/// port's name and type.
#[must_use]
pub fn request_domain(tree: &Tree, leaf: NodeId) -> Domain {
    let traffic = Traffic::of(tree, leaf);
    if !traffic.reads() {
        return Domain::new([Shape::new([("request", FieldKind::symbols(["tick", "halt"]))])]);
    }
    let head = |name| ("request".to_owned(), FieldKind::symbols([name]));
    Domain::new([Shape::new(std::iter::once(head("tick")).chain(traffic.input_fields())), Shape::new([head("halt")])])
}

/// The answers of a leaf's process: `[<running>, …]`, `[<success>, …]` or `[<failure>, …]` to a tick, `[<halted>, …]`
/// to a halt, with the values that its ports write to the blackboard in alphabetical order (`<none>` for a port that is
/// not written).
#[must_use]
pub fn reply_domain(tree: &Tree, leaf: NodeId) -> Domain {
    let head = ("reply".to_owned(), FieldKind::symbols(["running", "success", "failure", "halted"]));
    let shape = Shape::new(std::iter::once(head).chain(Traffic::of(tree, leaf).output_fields()));
    Domain::new([shape.with_role(Role::Reply)])
}

/// Declares the channels of a tree, of capacity 1: from the tick generator, and to and from the
/// [process](crate::Node::process) of each leaf.
///
/// # Errors
/// [`WiringError::MissingChannel`] if there is no process for a leaf (check the [leaves](Tree::leaves) first:
/// [`Tree::problem_at`] reports the position of a leaf in the file); [`WiringError::DuplicateChannel`] if a channel
/// exists already.
pub fn declare_channels(
    tree: &Tree,
    topology: &mut Topology,
    bt: ProcessId,
    tick_generator: ProcessId,
) -> Result<(), WiringError> {
    topology.channel(tick_generator, bt, Capacity::One, tick_domain())?;
    for leaf in tree.leaves() {
        let skill = topology.find_process(leaf.process()).ok_or_else(|| {
            let process = topology.name(bt).to_owned();
            WiringError::MissingChannel { channel: format!("{process} → {}", leaf.process()), process }
        })?;
        topology.channel(bt, skill, Capacity::One, request_domain(tree, leaf.id()))?;
        topology.channel(skill, bt, Capacity::One, reply_domain(tree, leaf.id()))?;
    }
    Ok(())
}

/// A leaf outside the tree: its process, and its messages.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Skill {
    pub(super) leaf: NodeId,
    pub(super) process: String,
    pub(super) channels: ChannelPair,
    pub(super) traffic: Traffic,
    /// Whether it can be asked to halt.
    halts: bool,
}

impl Skill {
    /// The skill of a leaf of the tree that is the process with this name.
    pub(super) fn find(tree: &Tree, leaf: &Node, topology: &Topology, bt: &str) -> Result<Self, WiringError> {
        Ok(Self {
            leaf: leaf.id(),
            process: leaf.process().to_owned(),
            channels: ChannelPair::find(topology, bt, leaf.process())?,
            traffic: Traffic::of(tree, leaf.id()),
            halts: leaf.kind() == Kind::Action,
        })
    }

    /// The tree's use of the channels to the skill.
    pub(super) fn uses(&self) -> impl Iterator<Item = Use> {
        let ChannelPair { requests, replies } = self.channels;
        let tick = (!self.traffic.reads()).then(|| request_message(Request::Tick, Vec::new()));
        let halt = self.halts.then(|| Use::Sends(requests, Some(request_message(Request::Halt, Vec::new()))));
        [Use::Sends(requests, tick)].into_iter().chain(halt).chain([Use::Receives(replies, None)])
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ChannelPair {
    pub(super) requests: ChannelId,
    pub(super) replies: ChannelId,
}

impl ChannelPair {
    /// The channels between two processes of these names.
    pub(super) fn find(topology: &Topology, asking: &str, answering: &str) -> Result<Self, WiringError> {
        let requests = find_channel(topology, asking, asking, answering)?;
        let replies = find_channel(topology, asking, answering, asking)?;
        Ok(Self { requests, replies })
    }
}

/// The channel between the processes with these names, which `user` needs.
pub(super) fn find_channel(
    topology: &Topology,
    user: &str,
    source: &str,
    target: &str,
) -> Result<ChannelId, WiringError> {
    let missing =
        || WiringError::MissingChannel { process: user.to_owned(), channel: format!("{source} → {target}") };
    topology.find_channel(source, target).ok_or_else(missing)
}

/// A node's answer to its parent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct NodeReply {
    /// Its answer to a tick; `None` if it has been halted.
    pub(super) status: Option<Status>,
    /// Its status now; `None` is idle.
    pub(super) own_status: Option<Status>,
    /// Whether the whole tree must be ticked again at once.
    pub(super) again: bool,
}

/// The requests of a node to another: `[<tick>, n, <idle>]` or `[<halt>, n, <running>]`, where n is the number of the
/// tree's tick, and the last field is the status of the asked node.
pub(super) fn node_request_domain() -> Domain {
    Domain::new([Shape::new([
        ("request", FieldKind::symbols(["tick", "halt"])),
        ("tick", FieldKind::Int),
        ("own_status", FieldKind::symbols(["idle", "running", "success", "failure"])),
    ])])
}

pub(super) fn node_reply_domain() -> Domain {
    Domain::new([Shape::new([
        ("reply", FieldKind::symbols(["running", "success", "failure", "skipped", "halted"])),
        ("own_status", FieldKind::symbols(["idle", "running", "success", "failure", "skipped"])),
        ("again", FieldKind::Bool),
    ])])
}

impl NodeReply {
    pub(super) fn message(self) -> Message {
        let reply = self.status.map_or("halted", Status::name);
        Message::new([Value::symbol(reply), Value::symbol(own_status_name(self.own_status)), Value::Bool(self.again)])
    }

    pub(super) fn of(message: &Message) -> Self {
        Self {
            status: message.head().and_then(status_of),
            own_status: symbol(message, 2).and_then(status_of),
            again: message.field(3) == Some(&Value::Bool(true)),
        }
    }
}

/// The name of a node's status.
pub(super) fn own_status_name(status: Option<Status>) -> &'static str {
    status.map_or("idle", Status::name)
}

pub(super) fn status_of(name: &str) -> Option<Status> {
    [Status::Running, Status::Success, Status::Failure, Status::Skipped]
        .into_iter()
        .find(|status| status.name() == name)
}

pub(super) fn symbol(message: &Message, field: usize) -> Option<&str> {
    match message.field(field) {
        Some(Value::Symbol(symbol)) => Some(symbol.name()),
        _ => None,
    }
}

pub(super) fn number(message: &Message, field: usize) -> Option<i64> {
    match message.field(field) {
        Some(Value::Int(number)) => Some(*number),
        _ => None,
    }
}

/// The message of a request, with the values that the leaf's ports read.
pub(super) fn request_message(request: Request, inputs: Vec<Value>) -> Message {
    let head = match request {
        Request::Tick => "tick",
        Request::Halt => "halt",
    };
    Message::new(std::iter::once(Value::symbol(head)).chain(inputs))
}

pub(super) fn reply_of(message: &Message) -> Option<Reply> {
    match message.head()? {
        "halted" => Some(Reply::Halted),
        // Only nodes inside the tree skip themselves.
        name => status_of(name).filter(|status| *status != Status::Skipped).map(Reply::Status),
    }
}

pub(super) fn answers(reply: Reply, request: Request) -> bool {
    matches!((reply, request), (Reply::Status(_), Request::Tick) | (Reply::Halted, Request::Halt))
}
