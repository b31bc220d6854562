//! A process that only receives.

use std::time::Duration;

use crate::{
    Action, ChannelId, Envelope, NoNormalForm, NormalForm, Offer, Pattern, Process, ProcessId, Topology, TransitionId,
    Use,
};

/// Takes every message of its channels, and does nothing with it. Properties see messages when they are received; with
/// this process, they can be about what no other process reads.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Subscriber {
    channels: Vec<ChannelId>,
}

impl Subscriber {
    /// The process, with all channels that lead to it.
    #[must_use]
    pub fn new(topology: &Topology, process: ProcessId) -> Self {
        let leads_here = |channel: &ChannelId| topology.get(*channel).target == process;
        Self { channels: topology.channels().filter(leads_here).collect() }
    }
}

impl Process for Subscriber {
    fn offers(&self, offers: &mut Vec<Offer>) {
        let receive = |(number, channel): (u32, &ChannelId)| Offer {
            transition: TransitionId(number),
            action: Action::Receive(*channel, Pattern::Any),
        };
        offers.extend((0..).zip(&self.channels).map(receive));
    }

    fn take(&mut self, _: TransitionId, _: Option<Envelope>, _: Duration) {}

    fn uses(&self) -> Vec<Use> {
        self.channels.iter().map(|channel| Use::Receives(*channel, None)).collect()
    }

    fn normalize(&mut self, _: &NormalForm<'_>) -> Result<(), NoNormalForm> {
        Ok(())
    }

    fn location(&self) -> String {
        "listening".to_owned()
    }
}
