//! The monitors of a run in which messages can be lost.

use std::sync::Arc;
use std::time::Duration;

use channels::{ChannelId, Event, Gap, Ground, Topology};
use monitors::Property;
use recording::{Doubts, Evidence, Happening, Judge, MonitorState, Origin};
use scenarios::scenario::Monitoring;

/// The monitors of a run beside nodes of ROS 2. They judge its events as those of a recording, in which messages may be
/// missing.
#[derive(Debug)]
pub(super) struct Judged {
    judge: Judge,
    properties: Vec<Property>,
    /// What has been found since it was last taken: verdicts, and the states that have changed.
    verdicts: Vec<Happening>,
    states: Vec<(usize, MonitorState)>,
}

impl Judged {
    /// The monitors at the start of a run beside these components, which are nodes of ROS 2.
    pub(super) fn begin(monitoring: &Monitoring, topology: &Arc<Topology>, tick: Duration, nodes: &[String]) -> Self {
        let properties = monitoring.monitors().iter().map(|(watched, monitor)| Property {
            name: watched.name.clone(),
            formula: String::new(),
            summary: String::new(),
            place: None,
            monitor: monitor.clone(),
        });
        let properties: Vec<Property> = properties.collect();
        let doubts = Doubts::of_run(&properties, topology, &Ground::Complete, nodes);
        // The run has a header of its own.
        let (judge, _, start) =
            Judge::begin(Default::default(), Origin::default(), topology, tick, &properties, doubts);
        let states = start.details.map_or_else(Vec::new, |details| details.monitors);
        Self { judge, properties, verdicts: Vec::new(), states }
    }

    pub(super) fn observe(&mut self, event: &Event) {
        let step = self.judge.step(event.clone(), &mut self.properties);
        self.verdicts.extend(step.happenings);
        self.states.extend(step.details.into_iter().flat_map(|details| details.monitors));
    }

    pub(super) fn miss(&mut self, gap: &Gap) {
        self.judge.miss(gap, &mut self.properties);
    }

    pub(super) fn resume(&mut self, channel: ChannelId) {
        self.judge.resume(channel, &self.properties);
    }

    pub(super) fn take_verdicts(&mut self) -> Vec<Happening> {
        std::mem::take(&mut self.verdicts)
    }

    pub(super) fn take_states(&mut self) -> Vec<(usize, MonitorState)> {
        std::mem::take(&mut self.states)
    }

    /// The properties, each with what its verdict rests on.
    pub(super) fn evidence(&self) -> impl Iterator<Item = (&Property, Evidence)> {
        let of = |(index, property)| (property, self.judge.doubts().evidence(index, property));
        self.properties.iter().enumerate().map(of)
    }
}
