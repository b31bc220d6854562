//! The channels of a process, and the messages it may send on them.

use std::collections::BTreeSet;
use std::hash::{Hash, Hasher};
use std::sync::Arc;

use channels::{Capacity, ChannelId, Domain, Message, ProcessId, Role, Shape, Symbol, Topology};

use super::translate::{self, Unsendable};
use crate::Datum;

/// The process that makes requests to skills: messages from it are requests, and messages to it are answers.
pub const CLIENT: &str = "BT";

/// The sender at the other end of a channel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Incoming {
    pub(super) channel: ChannelId,
    pub(super) peer: Arc<str>,
    /// The channel to the same process, if there is one.
    pub(super) back: Option<usize>,
    pub(super) is_client: bool,
    pub(super) domain: Domain,
    /// The names of the events that messages become, and their roles, by their first symbol; each once, however many
    /// shapes there are.
    pub(super) events: Vec<(Symbol, Arc<str>, Role)>,
}

/// The receiver at the other end of a channel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Outgoing {
    pub(super) channel: ChannelId,
    pub(super) peer: Arc<str>,
    pub(super) domain: Domain,
    /// Whether the receiver takes each message as it is sent: then a newer one on a topic replaces no older one.
    pub(super) takes_all: bool,
}

/// A process's channels, in the order of their declaration, the topics that it publishes and the requests that it
/// understands.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Wiring {
    pub(super) name: Arc<str>,
    pub(super) incoming: Vec<Incoming>,
    pub(super) outgoing: Vec<Outgoing>,
    pub(super) topics: Domain,
    pub(super) understood: Domain,
    /// The answers that it may give to these.
    pub(super) answers: Domain,
}

impl Hash for Wiring {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.name.hash(state);
    }
}

impl Wiring {
    pub(super) fn new(topology: &Topology, process: ProcessId) -> Self {
        let domain = |channel| topology.get(channel).domain.clone();
        let peer = |process| {
            let name: Arc<str> = topology.name(topology.whole(process)).into();
            (&*name == CLIENT, name)
        };
        let mut outgoing: Vec<Outgoing> = Vec::new();
        for channel in topology.channels().filter(|channel| topology.get(*channel).source == process) {
            let (_, peer) = peer(topology.get(channel).target);
            let takes_all = topology.get(channel).capacity == Capacity::Zero;
            outgoing.push(Outgoing { channel, peer, domain: domain(channel), takes_all });
        }
        let mut incoming = Vec::new();
        for channel in topology.channels().filter(|channel| topology.get(*channel).target == process) {
            let (is_client, peer) = peer(topology.get(channel).source);
            let back = outgoing.iter().position(|out| out.peer == peer);
            let domain = domain(channel);
            let events = events(&peer, back.is_some() && !is_client, &domain);
            incoming.push(Incoming { channel, peer, back, is_client, domain, events });
        }
        let topics = Domain::new(topology.topics(process).cloned());
        let understood = Domain::new(topology.understood(process).cloned());
        let answers = Domain::new(topology.answers(process).cloned());
        Self { name: topology.name(process).into(), incoming, outgoing, topics, understood, answers }
    }

    /// The names of the fields of the client's requests: the values that the ports of a leaf read.
    pub(super) fn inputs(&self) -> impl Iterator<Item = &str> {
        let clients = self.incoming.iter().filter(|incoming| incoming.is_client);
        let fields =
            clients.flat_map(|incoming| incoming.domain.shapes()).flat_map(|shape| shape.fields().iter().skip(1));
        fields.map(|(name, _)| name.as_str())
    }

    /// The index of the channel to the process with this name.
    pub(super) fn outgoing_to(&self, peer: &str) -> Option<usize> {
        self.outgoing.iter().position(|out| &*out.peer == peer)
    }

    /// The channels to the subscribers of a topic.
    pub(super) fn subscribers(&self, topic: &str) -> impl Iterator<Item = usize> {
        let carries = move |out: &Outgoing| shapes_of(&out.domain, topic).any(|shape| shape.role() == Role::Topic);
        self.outgoing.iter().enumerate().filter(move |(_, out)| carries(out)).map(|(index, _)| index)
    }
}

impl Incoming {
    /// The name of the event that a message becomes, and the message's role. The event of a client's request has the
    /// request's name, `say`, for any client; all others, including the tree's requests, also have the sender's:
    /// `Navigation.ok`, or `Navigation` if the message does not begin with a symbol.
    pub(super) fn event(&self, message: &Message) -> (Arc<str>, Role) {
        match self.events.iter().find(|(head, ..)| Some(head.name()) == message.head()) {
            Some((_, name, role)) => (Arc::clone(name), *role),
            None => (Arc::clone(&self.peer), Role::Topic),
        }
    }

    /// The names of the events that messages on this channel become.
    pub(super) fn event_names(&self) -> impl Iterator<Item = &str> {
        let begins_otherwise = self.domain.shapes().iter().any(|shape| shape.heads().is_empty());
        self.events.iter().map(|(_, name, _)| &**name).chain(begins_otherwise.then_some(&*self.peer))
    }

    /// The names of the events that this process is asked to handle.
    pub(super) fn asked(&self) -> impl Iterator<Item = &str> {
        let is_asked = |role| matches!(role, Role::Request | Role::Goal | Role::Cancel);
        let names = self.events.iter().filter(move |(.., role)| is_asked(*role)).map(|(_, name, _)| &**name);
        names.filter(|_| self.back.is_some())
    }

    /// The fields of a message by name.
    pub(super) fn data(&self, message: &Message) -> Datum {
        translate::data(message, self.domain.shape_of(message))
    }
}

fn events(peer: &str, may_ask: bool, domain: &Domain) -> Vec<(Symbol, Arc<str>, Role)> {
    let heads = domain.shapes().iter().flat_map(|shape| shape.heads().iter().map(|head| (head, shape.role())));
    let mut seen = BTreeSet::new();
    let new = heads.filter(|(head, _)| seen.insert(*head));
    let event = |(head, role): (&Symbol, Role)| {
        let is_asked = may_ask && matches!(role, Role::Request | Role::Goal | Role::Cancel);
        let name = if is_asked { head.name().into() } else { format!("{peer}.{}", head.name()).into() };
        (head.clone(), name, role)
    };
    new.map(event).collect()
}

pub(super) fn has_channel(topology: &Topology, source: ProcessId, target: ProcessId) -> bool {
    topology.channels().any(|channel| topology.get(channel).source == source && topology.get(channel).target == target)
}

/// The symbols that messages may begin with.
pub(super) fn heads(domain: &Domain) -> Vec<&str> {
    domain.shapes().iter().flat_map(Shape::heads).map(Symbol::name).collect()
}

/// The shapes of messages that begin with this symbol.
pub(super) fn shapes_of<'a>(domain: &'a Domain, head: &'a str) -> impl Iterator<Item = &'a Shape> {
    let begins = move |shape: &&Shape| shape.heads().iter().any(|symbol| symbol.name() == head);
    domain.shapes().iter().filter(begins)
}

/// Whether a message that begins with this symbol can have this value in the field with this name.
pub(super) fn takes(domain: &Domain, head: &str, field: &str, value: &Datum) -> bool {
    let mut kinds = shapes_of(domain, head).flat_map(Shape::fields).filter(|(name, _)| name == field);
    kinds.any(|(_, kind)| translate::field_value(value, kind).is_some())
}

/// The message that begins with this symbol and has these fields by name, and its role.
pub(super) fn message(domain: &Domain, head: &str, fields: &Datum) -> Result<(Message, Role), Unsendable> {
    let mut problem = Unsendable::Head { head: head.to_owned() };
    for shape in shapes_of(domain, head) {
        match translate::message(head, shape, fields) {
            Ok(values) => return Ok((Message::new(values), shape.role())),
            Err(unfit) => problem = unfit,
        }
    }
    Err(problem)
}
