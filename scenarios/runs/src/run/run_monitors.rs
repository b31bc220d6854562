//! The monitors of a run.

use std::sync::Arc;

use channels::{ChannelSystem, Event, Monitor};
use recording::{Evidence, Grounds};
use scenarios::names::unknown;
use scenarios::scenario::{GENERAL, Monitoring, Scenario};
use scenarios::{Complaints, Error};

use super::judged::Judged;

/// The monitors of a run, and what it vouches for.
pub(super) struct RunMonitors {
    /// `None` in a run without monitors.
    pub(super) monitoring: Option<Arc<Monitoring>>,
    /// The monitors of a run beside nodes of ROS 2, which take losses into account.
    pub(super) judged: Option<Judged>,
    grounds: Grounds,
}

impl RunMonitors {
    /// Attaches the monitors to the system, unless it is beside nodes of ROS 2, whose messages may be missing. Without
    /// `watch`, there are none.
    ///
    /// # Errors
    /// [`Error::BadInput`] if the scenario's properties do not fit the system.
    pub(super) fn attach(scenario: &Scenario, system: &mut ChannelSystem, watch: bool) -> Result<Self, Error> {
        let monitoring = watch.then(|| monitoring(scenario, system)).transpose()?;
        let nodes: Vec<String> = scenario.remote_components().map(|(name, _)| name.to_owned()).collect();
        let mut judged = None;
        match &monitoring {
            Some(monitoring) if nodes.is_empty() => {
                monitoring.monitors().iter().for_each(|(_, monitor)| system.attach(monitor.clone()));
            }
            Some(monitoring) => {
                let tick = scenario.file.execution.tick;
                judged = Some(Judged::begin(monitoring, system.topology(), tick, &nodes));
            }
            None => {}
        }
        Ok(Self { monitoring, judged, grounds: Grounds::computed(system.topology()) })
    }

    pub(super) fn count(&self) -> usize {
        self.monitoring.as_ref().map_or(0, |monitoring| monitoring.monitors().len())
    }

    pub(super) fn records(&self) -> Arc<[recording::Monitor]> {
        self.monitoring.as_ref().map_or_else(|| Arc::from([]), |monitoring| monitoring.records())
    }

    pub(super) fn observe(&mut self, events: &[Event]) {
        for event in events {
            self.grounds.observe(event);
            self.judged.iter_mut().for_each(|judged| judged.observe(event));
        }
    }

    /// The monitors, each with what its verdict rests on.
    pub(super) fn evidence<'m>(&'m self, system: &'m ChannelSystem) -> Vec<(&'m dyn Monitor, Evidence)> {
        let attached = system.monitors().iter().map(|attached| attached.monitor.as_ref());
        let attached = attached.map(|monitor| (monitor, self.grounds.evidence(monitor)));
        let judged = self.judged.iter().flat_map(Judged::evidence);
        attached.chain(judged.map(|(property, evidence)| (property.monitor.as_ref(), evidence))).collect()
    }
}

fn monitoring(scenario: &Scenario, system: &ChannelSystem) -> Result<Arc<Monitoring>, Error> {
    let monitoring = scenario.monitoring(system.topology())?;
    let mut complaints = Complaints::default();
    let known = || monitoring.monitors().iter().map(|(watched, _)| watched.name.as_str());
    let expected = scenario.file.expect.outcomes.iter().map(|(name, _)| name);
    let stop = &scenario.file.stop;
    let prove = &scenario.file.prove;
    let proved = prove.properties.iter().chain(prove.expect.iter().map(|(name, _)| name));
    let proved = proved.filter(|name| !GENERAL.contains(&name.value.as_str()));
    let named =
        expected.chain(stop.on_violation.names()).chain(stop.when_settled.names()).chain(stop.final_for.names());
    let named = named.chain(proved);
    let is_missing =
        |name: &&diagnostics::Spanned<String>| !known().any(|other| other == name.value) && scenario.file.means(name);
    for name in named.filter(is_missing) {
        complaints.push(unknown("property", name, known()));
    }
    complaints.check()?;
    Ok(monitoring)
}
