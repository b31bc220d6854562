//! Verdicts that missing messages could change.

use std::sync::Arc;

use channels::{ChannelId, Monitor, Topology, Verdict};
use monitors::{Formula, Property, ScopeMonitor};

/// Why the verdicts of properties are unsure, by the index of the property.
#[derive(Debug)]
pub struct Doubts {
    why: Vec<Option<String>>,
    /// Why violations after the first are unsure, of properties that had been violated.
    later: Vec<Option<String>>,
    /// For each property, the monitor that tells whether missing messages could change its verdict; without one, the
    /// property's own does.
    judges: Vec<Option<ScopeMonitor>>,
}

impl Doubts {
    /// Nothing is missing for this many properties. What may be missing later is within the domains of the channels.
    #[must_use]
    pub fn none(properties: usize) -> Self {
        let nothing = vec![None; properties];
        Self {
            why: nothing.clone(),
            later: nothing,
            judges: std::iter::repeat_with(|| None).take(properties).collect(),
        }
    }

    /// Nothing is missing. What may be missing later can be any message, such as one that is missing because its
    /// channel could not carry it.
    ///
    /// A monitor foresees from the domains of the channels what may come, and may therefore know its verdict before any
    /// such message. So whether the verdict is settled is asked of a second monitor, which knows no domains, unless
    /// they make no difference: it costs a quarter of the time of a bag.
    #[must_use]
    pub fn about_any_messages(properties: &[Property], topology: &Topology) -> Self {
        let any = Arc::new(topology.without_shapes());
        let judge = |property: &Property| {
            let monitor = property.scope_monitor()?;
            let judge = ScopeMonitor::new(&property.name, monitor.formula().clone(), &any);
            let judge = judge.expect("whether a formula can be monitored does not depend on the domains");
            (!judge.foresees_as(monitor)).then_some(judge)
        };
        let nothing = vec![None; properties.len()];
        Self { why: nothing.clone(), later: nothing, judges: properties.iter().map(judge).collect() }
    }

    /// The monitors that must see every event, besides those of the properties.
    pub fn monitors(&mut self) -> impl Iterator<Item = &mut dyn Monitor> {
        self.judges.iter_mut().flatten().map(|judge| judge as &mut dyn Monitor)
    }

    /// From here on, messages may be missing: on this channel, or on any. They could change every verdict that is open,
    /// except that of a property which judges each message of another channel by itself. All others may depend on them
    /// even if they are about other channels: ticks are made from the times of messages.
    pub fn miss(&mut self, why: &str, channel: Option<ChannelId>, properties: &[Property]) {
        for (index, property) in properties.iter().enumerate() {
            let is_elsewhere = judged(property).zip(channel).is_some_and(|(judged, missing)| judged != missing);
            if self.verdict(index, property) == Verdict::Inconclusive && !is_elsewhere {
                self.why[index].get_or_insert_with(|| why.to_owned());
            }
            if self.verdict(index, property) == Verdict::False && judged(property).is_none() {
                self.later[index].get_or_insert_with(|| why.to_owned());
            }
        }
    }

    /// Why violations after the first are unsure, of properties that had been violated when messages went missing.
    #[must_use]
    pub fn later(&self) -> &[Option<String>] {
        &self.later
    }

    /// The verdict that no missing message can change, or else inconclusive.
    #[must_use]
    pub fn verdict(&self, index: usize, property: &Property) -> Verdict {
        self.judges[index].as_ref().map_or_else(|| property.monitor.verdict(), Monitor::verdict)
    }

    /// Call this after each event: a message that violates a property by itself does so whatever else is missing.
    pub fn settle(&mut self, properties: &[Property]) {
        for (index, property) in properties.iter().enumerate() {
            let is_doubted = self.why[index].is_some();
            if is_doubted && self.verdict(index, property) == Verdict::False && judged(property).is_some() {
                self.why[index] = None;
            }
        }
    }

    /// Why each verdict is unsure, if it is.
    #[must_use]
    pub fn all(&self) -> &[Option<String>] {
        &self.why
    }
}

fn judged(property: &Property) -> Option<ChannelId> {
    property.scope_monitor().map(|monitor| monitor.formula()).and_then(Formula::judges_each_message_on)
}
