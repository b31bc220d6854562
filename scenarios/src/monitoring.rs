//! The monitors of a scenario: made once for the channels that there are, and shared by all runs on them. Most are made
//! from properties; the scenario may attach others as they stand.

mod machine;

use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};
use std::time::Duration;

use channels::{Monitor, Topology};
use diagnostics::Span;
use monitors::{Property, ScopeMonitor, Warnings, scope_monitor};
use recording::Graph;
use skills::Chart;

use crate::Error;
use crate::error::Complaints;
use crate::scenario::{ReadyMade, ReadyMadeKind, ScenarioFile};

pub(crate) use machine::MachineMonitor;

/// A property that is watched.
#[derive(Debug)]
pub(crate) struct Watched {
    /// The property's name.
    pub(crate) name: String,
    /// Its formula, as it is written.
    formula: String,
    /// What it asks for, in a few words.
    summary: String,
}

/// The monitors of a scenario as they are before a run.
#[derive(Debug)]
pub(crate) struct Monitoring {
    topology: Arc<Topology>,
    tick: Duration,
    monitors: Vec<(Watched, Box<dyn Monitor>)>,
    warnings: Vec<Warnings>,
    /// What records tell of them, once somebody has asked.
    told: OnceLock<Arc<[recording::Monitor]>>,
}

impl Monitoring {
    /// Makes the monitors of a scenario's `properties`, the names and texts of its property files, then those that it
    /// attaches as they stand; `watching` has the machines among these, by their places there.
    ///
    /// # Errors
    /// [`Error::BadInput`] with everything that is wrong with the files.
    pub(crate) fn new(
        file: &ScenarioFile,
        properties: &[(String, String)],
        watching: &BTreeMap<usize, Arc<Chart>>,
        topology: &Arc<Topology>,
    ) -> Result<Self, Error> {
        let tick = file.execution.tick;
        let mut complaints = Complaints::default();
        let mut made = Self {
            topology: Arc::clone(topology),
            tick,
            monitors: Vec::new(),
            warnings: Vec::new(),
            told: OnceLock::new(),
        };
        for ((name, text), place) in properties.iter().zip(&file.properties) {
            let Some(file) = complaints.note(monitors::load(name, text, topology, tick)) else { continue };
            for property in file.properties {
                made.add(property, &place.span, &mut complaints);
            }
            made.warnings.extend(Some(file.warnings).filter(|warnings| !warnings.is_empty()));
        }
        for (index, entry) in file.monitors.iter().enumerate() {
            if let Some(property) = ready_made(entry, watching.get(&index), topology, &mut complaints) {
                made.add(property, &entry.span, &mut complaints);
            }
        }
        complaints.check()?;
        Ok(made)
    }

    fn add(&mut self, property: Property, place: &Span, complaints: &mut Complaints) {
        let Property { name, formula, summary, monitor } = property;
        if self.monitors.iter().any(|(watched, _)| watched.name == name) {
            let problem = place.problem(format!("there is a property `{name}` already"));
            complaints.push(problem.with_label("this has another").with_help("give each a name of its own"));
        }
        self.monitors.push((Watched { name, formula, summary }, monitor));
    }

    /// Whether they are the monitors for systems of that topology with that time between ticks.
    pub(crate) fn fits(&self, topology: &Topology, tick: Duration) -> bool {
        self.tick == tick && *self.topology == *topology
    }

    /// What is watched, with a monitor for a new run each.
    pub(crate) fn monitors(&self) -> &[(Watched, Box<dyn Monitor>)] {
        &self.monitors
    }

    /// What records tell of them: worked out when it is asked for the first time, and shared by all runs from then on.
    pub(crate) fn told(&self) -> Arc<[recording::Monitor]> {
        let told = |(watched, monitor): &(Watched, Box<dyn Monitor>)| recording::Monitor {
            name: watched.name.clone(),
            property: watched.formula.clone(),
            summary: watched.summary.clone(),
            formula: scope_monitor(monitor.as_ref()).map(ScopeMonitor::formula).cloned(),
            graph: Graph::of(monitor.as_ref(), &self.topology),
        };
        Arc::clone(self.told.get_or_init(|| self.monitors.iter().map(told).collect()))
    }

    /// What looks wrong with the files, though they are accepted.
    pub(crate) fn warnings(&self) -> &[Warnings] {
        &self.warnings
    }
}

/// An entry of the scenario's `[[monitors]]`, with its machine if it is one and could be loaded.
fn ready_made(
    entry: &ReadyMade,
    machine: Option<&Arc<Chart>>,
    topology: &Topology,
    complaints: &mut Complaints,
) -> Option<Property> {
    let name = || entry.name.as_ref().map(|name| name.value.clone());
    match &entry.kind {
        ReadyMadeKind::Figure(figure) => {
            let made = figure.monitor(topology).map_err(|error| {
                let problem = entry.span.problem(format!("the paper's monitor does not fit this scenario: {error}"));
                problem.with_label("this monitor").with_help("it watches the channels of the paper's system")
            });
            let made = made.map_err(|problem| complaints.push(problem)).ok()?;
            let (formula, summary) = (format!("the monitor of {figure}"), made.summary);
            Some(Property { name: name().unwrap_or_else(|| figure.name().to_owned()), formula, summary, ..made })
        }
        ReadyMadeKind::Machine(file) => {
            let chart = machine?;
            let name = name().unwrap_or_else(|| chart.name().to_owned());
            let monitor = MachineMonitor::new(&name, chart, file, topology, complaints)?;
            let states: Vec<&str> = file.violated_in.iter().map(|state| state.value.as_str()).collect();
            let path = file.machine.value.display();
            Some(Property {
                formula: format!("{path}, violated in {}", states.join(", ")),
                summary: format!("its machine never enters {}", states.join(" or ")),
                monitor: Box::new(monitor),
                name,
            })
        }
    }
}
