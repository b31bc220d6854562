//! How disturbances act on the channels of a system.

use std::hash::{Hash, Hasher};
use std::time::Duration;

use super::{ChannelSystem, Enabled, EnabledKind};
use crate::{Chance, ChannelId, Disturbance, Effect, Envelope, Message, RunError, Topology, TransitionId};

/// A disturbance of a [`ChannelSystem`], as [`ChannelSystem::disturb`] numbers them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct DisturbanceId(usize);

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
struct Entry {
    id: DisturbanceId,
    disturbance: Disturbance,
    hits: u64,
}

/// How the message in a channel gets on; of an empty channel, and wherever nothing disturbs, the default.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
struct Passage {
    /// The disturbance that is to act on it next.
    armed: Option<Armed>,
    /// Before this time it cannot be received.
    held_until: Option<Duration>,
    /// How many deliveries leave it in the channel.
    repeats: u32,
}

/// A disturbance that is to act on a message, and when the message was sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Armed {
    by: DisturbanceId,
    sent: Duration,
}

/// The disturbances of a system and what they are at.
#[derive(Clone, Debug)]
pub(super) struct Disturbances {
    /// Those in force, in the order in which they began; so in the order of their ids.
    entries: Vec<Entry>,
    /// How many have begun.
    begun: usize,
    /// By channel.
    passages: Vec<Passage>,
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
    fn position(&self, id: DisturbanceId) -> Option<usize> {
        self.entries.binary_search_by_key(&id, |entry| entry.id).ok()
    }

    /// The place of the disturbance that is to act on a message among those in force.
    fn armed(&self, by: DisturbanceId) -> usize {
        self.position(by).expect("a message is armed only with what is in force")
    }

    /// A message has been sent into the channel.
    pub(super) fn enter(&mut self, channel: ChannelId, message: &Message, now: Duration) {
        self.arm(channel, 0, message, now);
    }

    /// The first of the disturbances from that position on that hits the message is to act on it.
    fn arm(&mut self, channel: ChannelId, first: usize, message: &Message, sent: Duration) {
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
    fn state(&self) -> (&[Passage], impl Iterator<Item = (DisturbanceId, &Option<Chance>)>) {
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

impl ChannelSystem {
    /// From now on, this may happen to messages that are sent.
    ///
    /// # Panics
    /// If the disturbance cannot take hold in this system: [`Disturbance::check`] says so first.
    pub fn disturb(&mut self, disturbance: Disturbance) -> DisturbanceId {
        let checked = disturbance.check(&self.topology);
        assert!(checked.is_ok(), "a disturbance is checked before it begins: {checked:?}");
        let id = DisturbanceId(self.disturbances.begun);
        self.disturbances.begun += 1;
        self.disturbances.entries.push(Entry { id, disturbance, hits: 0 });
        id
    }

    /// The disturbance is over, if it is not yet: how many messages it has acted on. It spares a message that it has not
    /// acted on yet; what it holds back already still comes when it is due, and what it is to repeat is repeated.
    pub fn calm(&mut self, id: DisturbanceId) -> Option<u64> {
        let position = self.disturbances.position(id)?;
        let over = self.disturbances.entries.remove(position);
        let channel = over.disturbance.channel;
        let armed = self.disturbances.passages[channel.0].armed.filter(|armed| armed.by == id);
        if let (Some(Armed { sent, .. }), Some(envelope)) = (armed, &self.contents[channel.0]) {
            self.disturbances.arm(channel, position, &envelope.message, sent);
        }
        Some(over.hits)
    }

    /// How many messages the disturbance has acted on since it began, for reports; nothing once it is over.
    #[must_use]
    pub fn hits(&self, id: DisturbanceId) -> Option<u64> {
        self.disturbances.position(id).map(|position| self.disturbances.entries[position].hits)
    }

    /// Lists the transitions that channels take by themselves.
    pub(super) fn push_disturbances(&self, enabled: &mut Vec<Enabled>) {
        if self.disturbances.entries.is_empty() {
            return;
        }
        for channel in self.topology.channels() {
            let Some(Armed { by, .. }) = self.disturbances.passages[channel.0].armed else { continue };
            let effect = &self.disturbances.entries[self.disturbances.armed(by)].disturbance.effect;
            if !matches!(effect, Effect::Answer(_)) || self.contents[opposite(&self.topology, channel).0].is_none() {
                let process = self.topology.get(channel).source;
                let transition = TransitionId(u32::try_from(by.0).unwrap_or(u32::MAX));
                enabled.push(Enabled { process, transition, kind: EnabledKind::Disturb(channel) });
            }
        }
    }

    /// The channel's own transition: what disturbs the message in it acts on it.
    pub(super) fn take_disturbance(&mut self, channel: ChannelId) -> Result<(), RunError> {
        let armed = self.disturbances.passages[channel.0].armed.take();
        let (Some(Armed { by, sent }), Some(envelope)) = (armed, self.contents[channel.0].take()) else {
            unreachable!("an enabled disturbance finds a message to act on");
        };
        let position = self.disturbances.armed(by);
        self.disturbances.entries[position].hits += 1;
        let Some(left) = self.affect(channel, position, sent, envelope)? else {
            self.disturbances.passages[channel.0] = Passage::default();
            return Ok(());
        };
        self.disturbances.arm(channel, position + 1, &left.message, sent);
        self.contents[channel.0] = Some(left);
        Ok(())
    }

    /// What the disturbance at that position leaves of the message, if anything.
    fn affect(
        &mut self,
        channel: ChannelId,
        position: usize,
        sent: Duration,
        mut envelope: Envelope,
    ) -> Result<Option<Envelope>, RunError> {
        let passage = &mut self.disturbances.passages[channel.0];
        match &self.disturbances.entries[position].disturbance.effect {
            Effect::Lose => return Ok(None),
            Effect::Hold(time) => {
                let due = Some(sent.saturating_add(*time)).filter(|&due| due > self.clock.time);
                passage.held_until = passage.held_until.max(due);
            }
            Effect::Repeat => passage.repeats += 1,
            Effect::Replace(corruption) => envelope.message = self.corrupted(channel, corruption(&envelope.message))?,
            Effect::Answer(answer) => {
                let answer = Envelope { message: answer.clone(), request: envelope.request };
                self.contents[opposite(&self.topology, channel).0] = Some(answer);
                return Ok(None);
            }
        }
        Ok(Some(envelope))
    }

    fn corrupted(&self, channel: ChannelId, message: Message) -> Result<Message, RunError> {
        if self.topology.carries(channel, &message) {
            return Ok(message);
        }
        let (domain, channel) = (self.topology.get(channel).domain.to_string(), self.topology.describe(channel));
        Err(RunError::Corrupted { message, channel, domain })
    }
}

/// The channel on which the answers to the requests on `channel` go.
fn opposite(topology: &Topology, channel: ChannelId) -> ChannelId {
    topology.opposite(channel).expect("a disturbance that answers was checked to have a channel for it")
}
