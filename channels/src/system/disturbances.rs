//! The disturbances of a system and their effects.

use std::hash::{Hash, Hasher};
use std::time::Duration;

use crate::{Chance, ChannelId, Disturbance, Message, NormalForm};

/// The number of a disturbance of a [`ChannelSystem`](crate::ChannelSystem), assigned by
/// [`ChannelSystem::disturb`](crate::ChannelSystem::disturb).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct DisturbanceId(pub(super) usize);

impl DisturbanceId {
    /// Its index among all disturbances that the system has had, in the order in which they began. It is never reused.
    #[must_use]
    pub fn index(self) -> usize {
        self.0
    }
}

/// An active disturbance and its effects so far.
#[derive(Clone, Debug)]
pub(super) struct ActiveDisturbance {
    pub(super) id: DisturbanceId,
    pub(super) disturbance: Disturbance,
    pub(super) hits: u64,
}

/// The effect of disturbances on the message in a channel. The default is that of an empty channel or an undisturbed
/// message.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct Passage {
    /// The disturbance that will act on it next.
    pub(super) armed: Option<Armed>,
    /// The time before which it cannot be received.
    pub(super) held_until: Option<Duration>,
    /// The number of deliveries that leave it in the channel.
    pub(super) repeats: u32,
}

/// A disturbance that will act on a message, and when the message was sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Armed {
    pub(super) by: DisturbanceId,
    pub(super) sent: Duration,
}

/// The disturbances of a system and their work in progress.
#[derive(Clone, Debug)]
pub(super) struct Disturbances {
    /// The active ones, in the order in which they began, which is the order of their ids.
    pub(super) entries: Vec<ActiveDisturbance>,
    /// How many have begun.
    pub(super) begun: usize,
    /// By channel.
    pub(super) passages: Vec<Passage>,
}

impl Disturbances {
    /// No disturbances, on this number of channels.
    pub(super) fn none(channels: usize) -> Self {
        Self { entries: Vec::new(), begun: 0, passages: vec![Passage::default(); channels] }
    }

    /// Whether disturbances allow the message in the channel to be received.
    pub(super) fn let_pass(&self, channel: ChannelId) -> bool {
        let Passage { armed, held_until, .. } = self.passages[channel.0];
        armed.is_none() && held_until.is_none()
    }

    /// The index of a disturbance among the active ones; `None` if it is over.
    pub(super) fn position(&self, id: DisturbanceId) -> Option<usize> {
        self.entries.binary_search_by_key(&id, |entry| entry.id).ok()
    }

    /// The index, among the active ones, of the disturbance that will act on a message.
    pub(super) fn armed(&self, by: DisturbanceId) -> usize {
        self.position(by).expect("only an active disturbance arms a message")
    }

    /// Arms the message with the first disturbance from this index on that hits it.
    pub(super) fn arm(&mut self, channel: ChannelId, first: usize, message: &Message, sent: Duration) {
        let hit = self.entries[first..].iter_mut().find_map(|ActiveDisturbance { id, disturbance, .. }| {
            (disturbance.channel == channel && disturbance.hits(message)).then_some(*id)
        });
        self.passages[channel.0].armed = hit.map(|by| Armed { by, sent });
    }

    /// Records that a message was received. Returns whether it stays in the channel nevertheless.
    pub(super) fn leave(&mut self, channel: ChannelId) -> bool {
        let repeats = std::mem::take(&mut self.passages[channel.0]).repeats;
        self.passages[channel.0].repeats = repeats.saturating_sub(1);
        repeats > 0
    }

    /// Releases messages that are held until `now` or earlier.
    pub(super) fn release(&mut self, now: Duration) {
        if self.begun > 0 {
            for passage in &mut self.passages {
                passage.held_until = passage.held_until.filter(|&due| due > now);
            }
        }
    }

    /// Brings the times into normal form.
    pub(super) fn normalize(&mut self, form: &NormalForm<'_>) {
        for passage in &mut self.passages {
            passage.held_until.iter_mut().for_each(|due| form.time(due));
            passage.armed.iter_mut().for_each(|armed| form.time(&mut armed.sent));
        }
    }

    /// The parts that determine how the system continues: messages in transit, disturbances and their streams.
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
