//! What a tree and the skills say to each other.

use std::collections::BTreeMap;

use channels::{
    Capacity, ChannelId, Domain, FieldKind, Message, ProcessId, Shape, TickGenerator, Topology, Use, Value, WiringError,
};

use crate::{Kind, Reply, Request, Status, Tree};

/// What the tick generator sends to a tree: `[<tick>, n]`.
#[must_use]
pub fn tick_domain() -> Domain {
    Domain::new([TickGenerator::shape()])
}

/// What a tree sends to a skill: `[<tick>]` or `[<halt>]`.
#[must_use]
pub fn request_domain() -> Domain {
    Domain::new([Shape::new([("request", FieldKind::symbols(["tick", "halt"]))])])
}

/// What a skill answers: `[<running>]`, `[<success>]` or `[<failure>]` to a tick, `[<halted>]` to a halt.
#[must_use]
pub fn reply_domain() -> Domain {
    Domain::new([Shape::new([("reply", FieldKind::symbols(["running", "success", "failure", "halted"]))])])
}

/// Declares the channels of a tree, of capacity 1: from the tick generator, and to and from the process of each leaf,
/// which has the leaf's ID for its name.
///
/// # Errors
/// [`WiringError::MissingChannel`] if a channel can't be, since there is no process for a leaf (check the
/// [leaves](Tree::leaves) first: [`Tree::problem_at`] can say where in the file the leaf is);
/// [`WiringError::DuplicateChannel`] if a channel is there already.
pub fn declare_channels(
    tree: &Tree,
    topology: &mut Topology,
    bt: ProcessId,
    tick_generator: ProcessId,
) -> Result<(), WiringError> {
    topology.channel(tick_generator, bt, Capacity::One, tick_domain())?;
    for id in LeafIds::of(tree).ids() {
        let skill = topology.find_process(id).ok_or_else(|| {
            let process = topology.name(bt).to_owned();
            WiringError::MissingChannel { channel: format!("{process} → {id}"), process }
        })?;
        topology.channel(bt, skill, Capacity::One, request_domain())?;
        topology.channel(skill, bt, Capacity::One, reply_domain())?;
    }
    Ok(())
}

/// The IDs of a tree's leaves, each once, in the order in which they first occur.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct LeafIds {
    ids: Vec<String>,
    /// By node, the place of its ID; none for inner nodes.
    by_node: Vec<Option<usize>>,
    /// By ID, whether it is ever told to halt.
    halts: Vec<bool>,
}

impl LeafIds {
    pub(super) fn of(tree: &Tree) -> Self {
        let mut places: BTreeMap<&str, usize> = BTreeMap::new();
        let (mut ids, mut halts) = (Vec::new(), Vec::new());
        let mut by_node = vec![None; tree.nodes().len()];
        for leaf in tree.leaves() {
            let place = *places.entry(leaf.type_id()).or_insert(ids.len());
            if place == ids.len() {
                ids.push(leaf.type_id().to_owned());
                halts.push(leaf.kind() == Kind::Action);
            }
            by_node[leaf.id().index()] = Some(place);
        }
        Self { ids, by_node, halts }
    }

    pub(super) fn ids(&self) -> impl Iterator<Item = &str> {
        self.ids.iter().map(String::as_str)
    }

    /// The place of a leaf's ID.
    pub(super) fn place(&self, node: usize) -> Option<usize> {
        self.by_node[node]
    }

    pub(super) fn halts(&self, place: usize) -> bool {
        self.halts[place]
    }
}

/// The channels to a skill and back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Line {
    pub(super) requests: ChannelId,
    pub(super) replies: ChannelId,
}

impl Line {
    /// The channels between two processes of these names.
    pub(super) fn find(topology: &Topology, asking: &str, answering: &str) -> Result<Self, WiringError> {
        let requests = find_channel(topology, asking, asking, answering)?;
        let replies = find_channel(topology, asking, answering, asking)?;
        Ok(Self { requests, replies })
    }

    /// What a tree does on these channels; `halts` if it ever sends a halt.
    pub(super) fn uses(self, halts: bool) -> impl Iterator<Item = Use> {
        let sends = |request| Use::Sends(self.requests, Some(request_message(request)));
        [Some(sends(Request::Tick)), halts.then(|| sends(Request::Halt)), Some(Use::Receives(self.replies, None))]
            .into_iter()
            .flatten()
    }
}

/// The channel between the processes of these names, which `user` needs.
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

/// What a node says to its parent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Said {
    /// What it answers to a tick; none if it has been halted.
    pub(super) status: Option<Status>,
    /// How it stands now; none is idle.
    pub(super) stands: Option<Status>,
    /// The whole tree is to be ticked again at once.
    pub(super) again: bool,
}

/// What a node asks another: `[<tick>, n, <idle>]` or `[<halt>, n, <running>]`, n being the number of the tree's tick,
/// and the last how the node that is asked stands.
pub(super) fn question_domain() -> Domain {
    Domain::new([Shape::new([
        ("request", FieldKind::symbols(["tick", "halt"])),
        ("tick", FieldKind::Int),
        ("stands", FieldKind::symbols(["idle", "running", "success", "failure"])),
    ])])
}

/// What a node answers another.
pub(super) fn said_domain() -> Domain {
    Domain::new([Shape::new([
        ("reply", FieldKind::symbols(["running", "success", "failure", "skipped", "halted"])),
        ("stands", FieldKind::symbols(["idle", "running", "success", "failure", "skipped"])),
        ("again", FieldKind::Bool),
    ])])
}

pub(super) fn said_message(said: Said) -> Message {
    let reply = said.status.map_or("halted", Status::name);
    Message::new([Value::symbol(reply), Value::symbol(stands_name(said.stands)), Value::Bool(said.again)])
}

pub(super) fn said_of(message: &Message) -> Said {
    Said {
        status: message.head().and_then(status_of),
        stands: symbol(message, 2).and_then(status_of),
        again: message.field(3) == Some(&Value::Bool(true)),
    }
}

/// How a node stands, in a word.
pub(super) fn stands_name(status: Option<Status>) -> &'static str {
    status.map_or("idle", Status::name)
}

/// The status of that name.
pub(super) fn status_of(name: &str) -> Option<Status> {
    [Status::Running, Status::Success, Status::Failure, Status::Skipped]
        .into_iter()
        .find(|status| status.name() == name)
}

/// The symbol in a field of a message.
pub(super) fn symbol(message: &Message, field: usize) -> Option<&str> {
    match message.field(field) {
        Some(Value::Symbol(symbol)) => Some(symbol.name()),
        _ => None,
    }
}

/// The number in a field of a message.
pub(super) fn number(message: &Message, field: usize) -> Option<i64> {
    match message.field(field) {
        Some(Value::Int(number)) => Some(*number),
        _ => None,
    }
}

/// The message that makes a request.
pub(super) fn request_message(request: Request) -> Message {
    Message::symbols([match request {
        Request::Tick => "tick",
        Request::Halt => "halt",
    }])
}

/// The reply that a message is, if it is one.
pub(super) fn reply_of(message: &Message) -> Option<Reply> {
    Some(match message.head()? {
        "running" => Reply::Status(Status::Running),
        "success" => Reply::Status(Status::Success),
        "failure" => Reply::Status(Status::Failure),
        "halted" => Reply::Halted,
        _ => return None,
    })
}

/// Whether that is an answer to that request.
pub(super) fn answers(reply: Reply, request: Request) -> bool {
    matches!((reply, request), (Reply::Status(_), Request::Tick) | (Reply::Halted, Request::Halt))
}
