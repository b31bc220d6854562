//! The messages of a machine, for its authors.

use channels::{Domain, FieldKind, ProcessId, Shape, Topology};

use super::check::fields;
use super::wiring::{Incoming, Wiring, heads, shapes_of};

/// A message as a machine sees it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MessageForm {
    /// The process at the other end; none if it is published.
    pub peer: Option<String>,
    /// The name of its event: for a `<transition>` if it is received, and for a `<send>` otherwise.
    pub event: String,
    /// The fields that `_event.data` or the `<param>` elements have.
    pub fields: Vec<(String, FieldKind)>,
}

/// The messages that the machine of a process may receive and send.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Vocabulary {
    /// Those that it may receive.
    pub received: Vec<MessageForm>,
    /// Those that it may send.
    pub sent: Vec<MessageForm>,
}

impl Vocabulary {
    /// The messages of a process of this system.
    #[must_use]
    pub fn of(topology: &Topology, process: ProcessId) -> Self {
        let wiring = Wiring::new(topology, process);
        let sent = wiring.outgoing.iter().flat_map(|out| forms(Some(&out.peer), &out.domain));
        Self {
            received: wiring.incoming.iter().flat_map(received).collect(),
            sent: sent.chain(forms(None, &wiring.topics)).collect(),
        }
    }
}

fn received(incoming: &Incoming) -> Vec<MessageForm> {
    let peer = Some(incoming.peer.to_string());
    let named = incoming.events.iter().map(|(head, event, _)| MessageForm {
        peer: peer.clone(),
        event: event.to_string(),
        fields: once(shapes_of(&incoming.domain, head.name()).flat_map(Shape::fields)),
    });
    let mut others = incoming.domain.shapes().iter().filter(|shape| shape.heads().is_empty()).peekable();
    let unnamed = others.peek().is_some().then(|| MessageForm {
        peer: peer.clone(),
        event: incoming.peer.to_string(),
        fields: once(others.flat_map(Shape::fields)),
    });
    named.chain(unnamed).collect()
}

fn forms(peer: Option<&str>, domain: &Domain) -> Vec<MessageForm> {
    let mut heads = heads(domain);
    heads.sort_unstable();
    heads.dedup();
    let form = |head: &str| MessageForm {
        peer: peer.map(str::to_owned),
        event: head.to_owned(),
        fields: once(fields(domain, head)),
    };
    heads.into_iter().map(form).collect()
}

/// The fields, each name once.
fn once<'s>(fields: impl Iterator<Item = &'s (String, FieldKind)>) -> Vec<(String, FieldKind)> {
    let mut known: Vec<(String, FieldKind)> = Vec::new();
    for (name, kind) in fields {
        if !known.iter().any(|(other, _)| other == name) {
            known.push((name.clone(), kind.clone()));
        }
    }
    known
}
