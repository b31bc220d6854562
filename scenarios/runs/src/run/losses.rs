//! What is lost on its way to a run, as gaps in its channels.

use std::collections::BTreeMap;

use channels::{ChannelId, Gap};
use remote::{Loss, Lost};

#[derive(Debug, Default)]
pub(super) struct Losses {
    /// By what is lost, the channel of each gap.
    open: BTreeMap<Lost, Vec<ChannelId>>,
    /// The channels of the gaps that are over once everything that has come has been passed on.
    ending: Vec<ChannelId>,
}

impl Losses {
    /// The gaps that a loss leaves in these channels.
    pub(super) fn begin(&mut self, loss: &Loss, channels: &[ChannelId]) -> Vec<Gap> {
        self.open.entry(loss.what.clone()).or_default().extend(channels);
        let Loss { flaw, since, why, .. } = loss;
        let gap = |channel: &ChannelId| Gap {
            flaw: *flaw,
            why: why.clone(),
            channel: Some(*channel),
            since: Some(*since),
            ends: true,
        };
        channels.iter().map(gap).collect()
    }

    /// Nothing more of this is lost.
    pub(super) fn end(&mut self, lost: &Lost) {
        self.ending.extend(self.open.remove(lost).into_iter().flatten());
    }

    /// The channel of each gap that is over: a message that was lost in it would have been received by now, since
    /// nothing that has come waits for this channel.
    pub(super) fn take_over(&mut self, is_empty: impl Fn(ChannelId) -> bool) -> Vec<ChannelId> {
        self.ending.extract_if(.., |channel| is_empty(*channel)).collect()
    }
}
