//! Verdicts that missing messages could change.

use channels::{ChannelId, Verdict};
use monitors::{Formula, Property};

/// Why the verdicts of properties are unsure, by the index of the property.
#[derive(Debug)]
pub struct Doubts(Vec<Option<String>>);

impl Doubts {
    /// Nothing is missing for this many properties.
    #[must_use]
    pub fn none(properties: usize) -> Self {
        Self(vec![None; properties])
    }

    /// From here on, messages may be missing: on this channel, or on any. They could change every verdict that is open,
    /// except that of a property which judges each message of another channel by itself. All others may depend on them
    /// even if they are about other channels: ticks are made from the times of messages.
    pub fn miss(&mut self, why: &str, channel: Option<ChannelId>, properties: &[Property]) {
        for (doubt, property) in self.0.iter_mut().zip(properties) {
            let is_elsewhere = judged(property).zip(channel).is_some_and(|(judged, missing)| judged != missing);
            if property.monitor.verdict() == Verdict::Inconclusive && !is_elsewhere {
                doubt.get_or_insert_with(|| why.to_owned());
            }
        }
    }

    /// Call this after each event: a message that violates a property by itself does so whatever else is missing.
    pub fn settle(&mut self, properties: &[Property]) {
        for (doubt, property) in self.0.iter_mut().zip(properties).filter(|(doubt, _)| doubt.is_some()) {
            if property.monitor.verdict() == Verdict::False && judged(property).is_some() {
                *doubt = None;
            }
        }
    }

    /// Why each verdict is unsure, if it is.
    #[must_use]
    pub fn all(&self) -> &[Option<String>] {
        &self.0
    }
}

fn judged(property: &Property) -> Option<ChannelId> {
    property.scope_monitor().map(|monitor| monitor.formula()).and_then(Formula::judges_each_message_on)
}
