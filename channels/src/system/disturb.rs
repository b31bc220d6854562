//! How disturbances act on the channels of a system.

use std::time::Duration;

use super::disturbances::{ActiveDisturbance, Armed, DisturbanceId, Passage};
use super::{ChannelSystem, Enabled, EnabledKind};
use crate::{ChannelId, Disturbance, Effect, Envelope, Message, RunError, Topology, TransitionId};

impl ChannelSystem {
    /// Starts a disturbance: it may act on messages that are sent from now on.
    ///
    /// # Panics
    /// If the disturbance is not possible in this system, which [`Disturbance::check`] finds in advance.
    pub fn disturb(&mut self, disturbance: Disturbance) -> DisturbanceId {
        let checked = disturbance.check(&self.topology);
        assert!(checked.is_ok(), "a disturbance is checked before it begins: {checked:?}");
        let id = DisturbanceId(self.disturbances.begun);
        self.disturbances.begun += 1;
        self.disturbances.entries.push(ActiveDisturbance { id, disturbance, hits: 0 });
        id
    }

    /// Ends the disturbance. Returns how many messages it has acted on, or `None` if it is already over. Messages that
    /// it has not acted on yet are spared. Messages that it delays still arrive when they are due, and messages that it
    /// repeats are still repeated.
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

    /// How many messages the disturbance has acted on since it began, for reports; `None` once it is over.
    #[must_use]
    pub fn hits(&self, id: DisturbanceId) -> Option<u64> {
        self.disturbances.position(id).map(|position| self.disturbances.entries[position].hits)
    }

    /// Whether a disturbance may act on the messages of a channel.
    #[must_use]
    pub fn is_disturbed(&self, channel: ChannelId) -> bool {
        self.disturbances.entries.iter().any(|entry| entry.disturbance.channel == channel)
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

    /// The channel's own transition: the disturbance acts on the message in it.
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

    /// The effect of the disturbance at this index on the message, if anything is left.
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

/// The channel for the answers to the requests on `channel`.
fn opposite(topology: &Topology, channel: ChannelId) -> ChannelId {
    topology.opposite(channel).expect("a disturbance that answers was checked to have a channel for the answer")
}
