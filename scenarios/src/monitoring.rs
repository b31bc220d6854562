//! The monitors of a scenario's properties: made once for the channels that there are, and shared by all runs on them.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use channels::Topology;
use maps::Spanned;
use monitors::{Property, ScopeMonitor, Warnings};

use crate::Error;
use crate::error::Complaints;
use crate::live::Watched;

/// The monitors of a scenario's properties as they are before a run.
#[derive(Debug)]
pub(crate) struct Monitoring {
    topology: Arc<Topology>,
    tick: Duration,
    properties: Vec<(Watched, ScopeMonitor)>,
    warnings: Vec<Warnings>,
}

impl Monitoring {
    /// Makes the monitors of property files, given by name and text, and each by the place where the scenario names it.
    ///
    /// # Errors
    /// [`Error::BadInput`] with everything that is wrong with the files.
    pub(crate) fn new(
        files: &[(String, String)],
        places: &[Spanned<PathBuf>],
        topology: &Arc<Topology>,
        tick: Duration,
    ) -> Result<Self, Error> {
        let mut complaints = Complaints::default();
        let (mut properties, mut warnings): (Vec<(Watched, ScopeMonitor)>, _) = (Vec::new(), Vec::new());
        for ((name, text), place) in files.iter().zip(places) {
            let Some(file) = complaints.note(monitors::load(name, text, topology, tick)) else { continue };
            let is_known = |name: &str| properties.iter().any(|(watched, _)| watched.name == name);
            if let Some(again) = file.properties.iter().find(|property| is_known(&property.name)) {
                let problem = place.span.problem(format!("there is a property `{}` already", again.name));
                complaints.push(problem.with_label("this file has another").with_help("give each a name of its own"));
            }
            properties.extend(file.properties.into_iter().map(as_watched));
            warnings.extend(Some(file.warnings).filter(|warnings| !warnings.is_empty()));
        }
        complaints.check()?;
        Ok(Self { topology: Arc::clone(topology), tick, properties, warnings })
    }

    /// Whether they are the monitors for systems of that topology with that time between ticks.
    pub(crate) fn fits(&self, topology: &Topology, tick: Duration) -> bool {
        self.tick == tick && *self.topology == *topology
    }

    /// The properties, with a monitor for a new run each.
    pub(crate) fn properties(&self) -> &[(Watched, ScopeMonitor)] {
        &self.properties
    }

    /// What looks wrong with the files, though they are accepted.
    pub(crate) fn warnings(&self) -> &[Warnings] {
        &self.warnings
    }
}

fn as_watched(property: Property) -> (Watched, ScopeMonitor) {
    let monitor = property.scope_monitor().expect("a monitor that was made from a text is one of SCOPE").clone();
    let Property { name, formula, summary, .. } = property;
    (Watched { name, formula, summary, decided: None }, monitor)
}
