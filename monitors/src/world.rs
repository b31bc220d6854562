//! What a property sees of the world: changes of the fields that it mentions.

use channels::{ChannelId, EventKind, Message, Topology, Value};

use crate::formula::EventAtom;
use crate::{MONITORS, WORLD};

/// What a property, or a fault that waits for an event, sees of the [`WORLD`]: the messages in which a field that it
/// mentions has changed. The world's message has the fields that all properties and faults together mention, so without
/// this, what one of them mentions would decide when the others are checked.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct OwnWorld {
    channel: Option<ChannelId>,
    fields: Vec<usize>,
    /// The values of these fields in the last message.
    last: Option<Vec<Option<Value>>>,
}

impl OwnWorld {
    /// What is seen of the world if these fields of messages on these channels are mentioned.
    #[must_use]
    pub fn new(mentioned: impl IntoIterator<Item = (ChannelId, usize)>, topology: &Topology) -> Self {
        let channel = topology.find_channel(WORLD, MONITORS);
        let own = mentioned.into_iter().filter(|(of, _)| Some(*of) == channel);
        let mut fields: Vec<usize> = own.map(|(_, field)| field).collect();
        fields.sort_unstable();
        fields.dedup();
        Self { channel, fields, last: None }
    }

    /// What these events mention of the world.
    #[must_use]
    pub fn of_events<'a>(events: impl IntoIterator<Item = &'a EventAtom>, topology: &Topology) -> Self {
        let mut mentioned = Vec::new();
        for event in events {
            event.condition.fields(&mut |field| mentioned.push((event.channel, field.number)));
        }
        Self::new(mentioned, topology)
    }

    /// Whether it is to be seen: a tick, a message of another channel, or one in which a field has changed. The first
    /// message of the world is always seen.
    #[inline]
    pub fn sees(&mut self, kind: &EventKind) -> bool {
        match kind {
            EventKind::Received { channel, message } if Some(*channel) == self.channel => self.changes(message),
            _ => true,
        }
    }

    /// Whether a field has changed, or this is the first message.
    fn changes(&mut self, message: &Message) -> bool {
        let is_same = |last: &Vec<Option<Value>>| {
            self.fields.iter().zip(last).all(|(field, last)| message.field(*field) == last.as_ref())
        };
        if self.last.as_ref().is_some_and(is_same) {
            return false;
        }
        self.last = Some(self.fields.iter().map(|field| message.field(*field).cloned()).collect());
        true
    }
}
