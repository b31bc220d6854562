//! The disturbances of a system, and what has come of them.

use std::hash::{Hash, Hasher};
use std::time::Duration;

use crate::{Chance, ChannelId, Disturbance, Message};

/// A disturbance of a [`ChannelSystem`](crate::ChannelSystem), as
/// [`ChannelSystem::disturb`](crate::ChannelSystem::disturb) numbers them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct DisturbanceId(pub(super) usize);

impl DisturbanceId {
    /// Position among all disturbances that the system has had, in the order in which they began. No other takes it once
    /// the disturbance is over.
    #[must_use]
    pub fn index(self) -> usize {
        self.0
    }
}

/// A disturbance that is in force and what has come of it.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    pub(super) id: DisturbanceId,
    pub(super) disturbance: Disturbance,
    pub(super) hits: u64,
}

/// How the message in a channel gets on; of an empty channel, and wherever nothing disturbs, the default.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct Passage {
    /// The disturbance that is to act on it next.
    pub(super) armed: Option<Armed>,
    /// Before this time it cannot be received.
    pub(super) held_until: Option<Duration>,
    /// How many deliveries leave it in the channel.
    pub(super) repeats: u32,
}

/// A disturbance that is to act on a message, and when the message was sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Armed {
    pub(super) by: DisturbanceId,
    pub(super) sent: Duration,
}

/// The disturbances of a system and what they are at.
#[derive(Clone, Debug)]
pub(super) struct Disturbances {
    /// Those in force, in the order in which they began; so in the order of their ids.
    pub(super) entries: Vec<Entry>,
    /// How many have begun.
    pub(super) begun: usize,
    /// By channel.
    pub(super) passages: Vec<Passage>,
}

impl Disturbances {
    /// None, on that many channels.
    pub(super) fn none(channels: usize) -> Self {
        Self { entries: Vec::new(), begun: 0, passages: vec![Passage::default(); channels] }
    }

    /// Whether the message in the channel may be received, as far as disturbances go.
    pub(super) fn let_pass(&self, channel: ChannelId) -> bool {
        let Passage { armed, held_until, .. } = self.passages[channel.0];
        armed.is_none() && held_until.is_none()
    }

    /// The place of a disturbance among those in force; none if it is over.
    pub(super) fn position(&self, id: DisturbanceId) -> Option<usize> {
        self.entries.binary_search_by_key(&id, |entry| entry.id).ok()
    }

    /// The place of the disturbance that is to act on a message among those in force.
    pub(super) fn armed(&self, by: DisturbanceId) -> usize {
        self.position(by).expect("a message is armed only with what is in force")
    }

    /// A message has been sent into the channel.
    pub(super) fn enter(&mut self, channel: ChannelId, message: &Message, now: Duration) {
        self.arm(channel, 0, message, now);
    }

    /// The first of the disturbances from that position on that hits the message is to act on it.
    pub(super) fn arm(&mut self, channel: ChannelId, first: usize, message: &Message, sent: Duration) {
        let hit = self.entries[first..].iter_mut().find_map(|Entry { id, disturbance, .. }| {
            (disturbance.channel == channel && disturbance.hits(message)).then_some(*id)
        });
        self.passages[channel.0].armed = hit.map(|by| Armed { by, sent });
    }

    /// A message has been received; whether it stays in the channel all the same.
    pub(super) fn leave(&mut self, channel: ChannelId) -> bool {
        let repeats = std::mem::take(&mut self.passages[channel.0]).repeats;
        self.passages[channel.0].repeats = repeats.saturating_sub(1);
        repeats > 0
    }

    /// Lets go what is held until `now` or earlier.
    pub(super) fn release(&mut self, now: Duration) {
        if self.begun > 0 {
            for passage in &mut self.passages {
                passage.held_until = passage.held_until.filter(|&due| due > now);
            }
        }
    }

    /// The parts that decide how the system goes on: what is under way, and what disturbs with which stream.
    pub(super) fn state(&self) -> (&[Passage], impl Iterator<Item = (DisturbanceId, &Option<Chance>)>) {
        (&self.passages, self.entries.iter().map(|entry| (entry.id, &entry.disturbance.probability)))
    }
}

impl PartialEq for Disturbances {
    fn eq(&self, other: &Self) -> bool {
        let ((passages, in_force), (other_passages, other_in_force)) = (self.state(), other.state());
        passages == other_passages && in_force.eq(other_in_force)
    }
}

impl Hash for Disturbances {
    fn hash<H: Hasher>(&self, hasher: &mut H) {
        let (passages, in_force) = self.state();
        passages.hash(hasher);
        for (id, probability) in in_force {
            id.hash(hasher);
            probability.as_ref().map(|chance| chance.stream.get_word_pos()).hash(hasher);
        }
    }
}
