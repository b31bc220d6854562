//! The monitors of a scenario: built once for its channels, and shared by all runs on them. Most are built from
//! properties; the scenario may also attach ready-made ones.

mod machine;

use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};
use std::time::Duration;

use channels::{Monitor, Topology};
use diagnostics::{Problem, Span};
use monitors::{Property, ScopeMonitor, Warnings, scope_monitor};
use recording::Graph;
use roaml::Model;
use skills::Chart;

use super::expectations;
use super::file::ScenarioFile;
use super::prove::GENERAL;
use super::ready_made::{ReadyMade, ReadyMadeKind};
use crate::error::{Complaints, Error};

pub use machine::MachineMonitor;

/// A monitored property.
#[derive(Debug)]
pub struct Watched {
    /// The property's name.
    pub name: String,
    /// Its formula, as written.
    formula: String,
    /// Its requirement, in a few words.
    summary: String,
    /// Where it is written: in its file, or in the scenario.
    pub place: Span,
}

/// The monitors of a scenario in their initial state.
#[derive(Debug)]
pub struct Monitoring {
    topology: Arc<Topology>,
    tick: Duration,
    monitors: Vec<(Watched, Box<dyn Monitor>)>,
    warnings: Vec<Warnings>,
    /// Their records, once requested.
    records: OnceLock<Arc<[recording::Monitor]>>,
}

impl Monitoring {
    /// Builds the monitors of a model's properties, then those of the given names and texts: of the property files, and
    /// of the properties that the scenario itself contains, those of zones among them; then the ready-made ones;
    /// `watching` contains the machines among these, by index.
    ///
    /// # Errors
    /// [`Error::BadInput`] with everything that is wrong with the files.
    pub fn new(
        file: &ScenarioFile,
        model: Option<&Model>,
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
            records: OnceLock::new(),
        };
        if let (Some(model), Some(entry)) = (model, file.behavior.model()) {
            for (property, monitor) in model.properties.iter().zip(model.monitors(topology)) {
                // It has no description: its formula takes the place of one.
                let roaml::Property { name, formula, place, .. } = property.clone();
                let (summary, place, monitor) = (formula.clone(), Some(place), Box::new(monitor));
                made.add(Property { name, formula, summary, place, monitor }, &entry.path.span, &mut complaints);
            }
        }
        let files = file.properties.iter().map(|path| &path.span);
        let places = files.chain(file.expect.satisfied.iter().map(|(name, _)| &name.span));
        let places = places.chain(file.monitors.iter().filter(|entry| entry.zone().is_some()).map(|entry| &entry.span));
        for (index, ((name, text), place)) in properties.iter().zip(places).enumerate() {
            let Some(loaded) = complaints.note(monitors::load(name, text, topology, tick)) else { continue };
            for mut property in loaded.properties {
                // The text of one that is no file's was made from that part of the scenario.
                property.place = property.place.filter(|_| index < file.properties.len());
                check_name(&property, place, file, &mut complaints);
                made.add(property, place, &mut complaints);
            }
            made.warnings.extend(Some(loaded.warnings).filter(|warnings| !warnings.is_empty()));
        }
        for (index, entry) in file.monitors.iter().enumerate() {
            if let Some(property) = ready_made(entry, watching.get(&index), topology, &mut complaints) {
                check_name(&property, &entry.span, file, &mut complaints);
                made.add(property, &entry.span, &mut complaints);
            }
        }
        complaints.check()?;
        Ok(made)
    }

    fn add(&mut self, property: Property, place: &Span, complaints: &mut Complaints) {
        let Property { name, formula, summary, place: own, monitor } = property;
        if self.monitors.iter().any(|(watched, _)| watched.name == name) {
            let problem = place.problem(format!("there is already a property `{name}`"));
            complaints
                .push(problem.with_label("this one has the same name").with_help("give each property its own name"));
        }
        let place = own.unwrap_or_else(|| place.clone());
        self.monitors.push((Watched { name, formula, summary, place }, monitor));
    }

    /// Whether the monitors were built for systems with this topology and tick period.
    pub fn fits(&self, topology: &Topology, tick: Duration) -> bool {
        self.tick == tick && *self.topology == *topology
    }

    /// The monitored properties, each with a monitor for a new run.
    pub fn monitors(&self) -> &[(Watched, Box<dyn Monitor>)] {
        &self.monitors
    }

    /// Their records: computed on first use, and then shared by all runs.
    pub fn records(&self) -> Arc<[recording::Monitor]> {
        let record = |(watched, monitor): &(Watched, Box<dyn Monitor>)| recording::Monitor {
            name: watched.name.clone(),
            property: watched.formula.clone(),
            summary: watched.summary.clone(),
            formula: scope_monitor(monitor.as_ref()).map(ScopeMonitor::formula).cloned(),
            graph: Graph::of(monitor.as_ref(), &self.topology),
        };
        Arc::clone(self.records.get_or_init(|| self.monitors.iter().map(record).collect()))
    }

    /// The warnings about the files.
    pub fn warnings(&self) -> &[Warnings] {
        &self.warnings
    }
}

/// Reports a property whose outcome no scenario could expect: in `[expect]` or in a proof, its name means something
/// else.
fn check_name(property: &Property, place: &Span, file: &ScenarioFile, complaints: &mut Complaints) {
    let name = &property.name;
    let place = property.place.as_ref().unwrap_or(place);
    if file.prove.is_used() && GENERAL.contains(&name.as_str()) {
        complaints.push(named_like_a_general_one(name, place));
    }
    if expectations::KEYS.contains(&name.as_str()) {
        let problem = place.problem(format!("a property cannot be called `{name}`")).with_label("this property");
        complaints.push(problem.with_help(format!("`expect.{name}` means something else; choose another name")));
    }
}

/// The problem of a property with the name of one that every proof has.
#[must_use]
pub fn named_like_a_general_one(name: &str, place: &Span) -> Problem {
    let problem = place.problem(format!("a property to be proved cannot be called `{name}`"));
    let help = format!("every proof has a property `{name}`; choose another name for this one");
    problem.with_label("this property").with_help(help)
}

/// An entry of the scenario's `[[monitors]]`, with its machine if one could be loaded.
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
        // It is among the properties.
        ReadyMadeKind::Zone(_) => None,
        ReadyMadeKind::Machine(file) => {
            let chart = machine?;
            let name = name().unwrap_or_else(|| chart.name().to_owned());
            let monitor = MachineMonitor::new(&name, chart, file, topology, complaints)?;
            let states: Vec<&str> = file.violated_in.iter().map(|state| state.value.as_str()).collect();
            let path = file.machine.value.display();
            Some(Property {
                formula: format!("{path}, violated in {}", states.join(", ")),
                summary: format!("its machine never enters {}", states.join(" or ")),
                place: None,
                monitor: Box::new(monitor),
                name,
            })
        }
    }
}
