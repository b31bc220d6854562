//! The process that takes copies of the messages that properties are about.

use std::time::Duration;

use channels::{Action, ChannelId, Envelope, NoNormalForm, NormalForm, Offer, Pattern, Process, TransitionId, Use};

/// Receives everything sent to it.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct Recorder {
    pub(super) incoming: Vec<ChannelId>,
}

impl Process for Recorder {
    fn offers(&self, offers: &mut Vec<Offer>) {
        for (index, channel) in self.incoming.iter().enumerate() {
            let action = Action::Receive(*channel, Pattern::Any);
            offers.push(Offer { transition: TransitionId(index as u32), action });
        }
    }

    fn take(&mut self, _: TransitionId, _: Option<Envelope>, _: Duration) {}

    fn uses(&self) -> Vec<Use> {
        self.incoming.iter().map(|channel| Use::Receives(*channel, None)).collect()
    }

    fn normalize(&mut self, _: &NormalForm<'_>) -> Result<(), NoNormalForm> {
        Ok(())
    }

    fn location(&self) -> String {
        "listening".to_owned()
    }
}
