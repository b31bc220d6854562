//! What messages have reported of the battery's level.

use std::time::Duration;

use channels::{ChannelId, Event, EventKind, Topology};

/// The levels in the messages of a channel so far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeardLevels {
    /// The lowest, in percent.
    pub lowest_pct: f64,
    /// When the last one was received.
    pub last: Duration,
}

/// The levels in the messages of all channels.
#[derive(Clone, Debug)]
pub(crate) struct Heard {
    by_channel: Vec<Option<HeardLevels>>,
    /// Whether every step that had messages recorded them.
    is_complete: bool,
}

impl Heard {
    pub(crate) fn new(topology: &Topology) -> Self {
        Self { by_channel: vec![None; topology.channels().count()], is_complete: true }
    }

    /// A step had messages and did not record them.
    pub(crate) fn miss(&mut self) {
        self.is_complete = false;
    }

    /// Takes note of a message; its channel is in the topology.
    pub(crate) fn note(&mut self, event: &Event, topology: &Topology) {
        let EventKind::Received { channel, message } = &event.kind else { return };
        let Some(shape) = topology.get(*channel).domain.shape_of(message) else { return };
        let Some(field) = shape.fields().iter().position(|(name, _)| name == LEVEL) else { return };
        let Some(level_pct) = message.fields().get(field).and_then(|level| level.as_number()) else { return };
        let heard = &mut self.by_channel[channel.index()];
        let lowest_pct = heard.map_or(level_pct, |heard| heard.lowest_pct.min(level_pct));
        *heard = Some(HeardLevels { lowest_pct, last: event.time });
    }

    /// The levels in the messages of a channel; `None` if not all messages are known.
    #[expect(clippy::option_option, reason = "there may be no messages, or unknown ones")]
    pub(crate) fn on(&self, channel: ChannelId) -> Option<Option<HeardLevels>> {
        self.is_complete.then(|| self.by_channel[channel.index()])
    }
}

/// The name of the field of a message that carries the battery's level.
pub const LEVEL: &str = "level";
