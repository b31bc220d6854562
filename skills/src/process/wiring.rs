//! The channels of a skill, and the messages it may send on them.

use std::collections::BTreeSet;
use std::hash::{Hash, Hasher};
use std::sync::Arc;

use channels::{ChannelId, Domain, Message, ProcessId, Shape, Symbol, Topology};

use super::translate::{self, Unsendable};
use crate::Datum;

/// The process that makes requests to skills: messages from it are requests, and messages to it are answers.
pub const CLIENT: &str = "BT";

/// The sender at the other end of a channel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Incoming {
    pub(super) channel: ChannelId,
    pub(super) peer: Arc<str>,
    /// The channel for requests to the same process; `None` for the client, and for processes that cannot be asked.
    pub(super) asked_on: Option<usize>,
    pub(super) is_client: bool,
    domain: Domain,
    /// The names of the events that messages become, by their first symbol; each once, however many shapes there are.
    events: Vec<(Symbol, Arc<str>)>,
}

/// The receiver at the other end of a channel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Outgoing {
    pub(super) channel: ChannelId,
    pub(super) peer: Arc<str>,
    pub(super) is_client: bool,
    pub(super) domain: Domain,
}

/// A skill's channels, in the order of their declaration.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Wiring {
    pub(super) name: Arc<str>,
    pub(super) incoming: Vec<Incoming>,
    pub(super) outgoing: Vec<Outgoing>,
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
            let (is_client, peer) = peer(topology.get(channel).target);
            outgoing.push(Outgoing { channel, peer, is_client, domain: domain(channel) });
        }
        let mut incoming = Vec::new();
        for channel in topology.channels().filter(|channel| topology.get(*channel).target == process) {
            let (is_client, peer) = peer(topology.get(channel).source);
            let asked_on = outgoing.iter().position(|out| out.peer == peer && !is_client);
            let domain = domain(channel);
            let events = event_names(&peer, &domain);
            incoming.push(Incoming { channel, peer, asked_on, is_client, domain, events });
        }
        Self { name: topology.name(process).into(), incoming, outgoing }
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
}

impl Incoming {
    /// The name of the event that a message becomes: `Navigation.ok`, or `Navigation` if it does not begin with a
    /// symbol.
    pub(super) fn event_name(&self, message: &Message) -> Arc<str> {
        let known = self.events.iter().find(|(head, _)| Some(head.name()) == message.head());
        Arc::clone(known.map_or(&self.peer, |(_, name)| name))
    }

    /// The names of the events that messages on this channel become.
    pub(super) fn event_names(&self) -> impl Iterator<Item = &str> {
        let begins_otherwise = self.domain.shapes().iter().any(|shape| translate::heads(shape).is_empty());
        self.events.iter().map(|(_, name)| &**name).chain(begins_otherwise.then_some(&*self.peer))
    }

    /// The fields of a message by name.
    pub(super) fn data(&self, message: &Message) -> Datum {
        translate::data(message, self.domain.shape_of(message))
    }
}

fn event_names(peer: &str, domain: &Domain) -> Vec<(Symbol, Arc<str>)> {
    let heads = domain.shapes().iter().flat_map(translate::heads);
    let mut seen = BTreeSet::new();
    let new = heads.filter(|head| seen.insert(*head));
    new.map(|head| (head.clone(), format!("{peer}.{}", head.name()).into())).collect()
}

impl Outgoing {
    /// The symbols that messages on this channel may begin with.
    pub(super) fn heads(&self) -> Vec<&str> {
        self.domain.shapes().iter().flat_map(translate::heads).map(Symbol::name).collect()
    }

    /// The shapes of messages that begin with this symbol.
    pub(super) fn shapes_of<'a>(&'a self, head: &'a str) -> impl Iterator<Item = &'a Shape> {
        let begins = move |shape: &&Shape| translate::heads(shape).iter().any(|symbol| symbol.name() == head);
        self.domain.shapes().iter().filter(begins)
    }

    /// The message that begins with this symbol and has these fields by name.
    pub(super) fn message(&self, head: &str, fields: &Datum) -> Result<Message, Unsendable> {
        let mut problem = Unsendable::Head { head: head.to_owned() };
        for shape in self.shapes_of(head) {
            match translate::message(head, shape, fields) {
                Ok(values) => return Ok(Message::new(values)),
                Err(unfit) => problem = unfit,
            }
        }
        Err(problem)
    }

    /// Whether a message that begins with this symbol can have this value in the field with this name.
    pub(super) fn takes(&self, head: &str, field: &str, value: &Datum) -> bool {
        let mut kinds = self.shapes_of(head).flat_map(Shape::fields).filter(|(name, _)| name == field);
        kinds.any(|(_, kind)| translate::value(value, kind).is_some())
    }
}
