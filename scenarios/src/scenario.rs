//! Scenarios: one file per experiment, loaded with everything that it names.

mod asking;
mod base;
mod component;
mod component_entry;
mod data;
mod declaration;
mod doubts;
mod elsewhere;
mod execution;
mod expectations;
mod faulty;
mod file;
mod file_reader;
pub mod find;
mod keys;
mod leaves;
mod load;
mod model;
mod model_entry;
mod monitoring;
mod offer;
mod offered;
mod places;
mod premises;
mod prove;
mod ready_made;
mod robot;
pub mod schedule;
mod scxml_text;
mod settings;
mod skill;
mod snapshots;
mod stand_in;
mod stop;
mod symbols;
mod truth;
mod world;

use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};

use bt::{Kind, Tree};
use channels::Topology;
use diagnostics::Spanned;
use miette::Diagnostic;
use programs::Program;
use recording::{Expected, Origin};
use roaml::Model;
use skills::{Chart, Concerns};

pub use asking::Asking;
pub use component::{Component, Runs};
pub use component_entry::{ComponentEntry, RunsEntry};
pub use declaration::{TreeIds, misfit};
pub use devices::{DeviceKind, DeviceSettings};
pub use elsewhere::Elsewhere;
pub use execution::{Execution, Order, Policy, TreeForm};
pub use expectations::Expectations;
pub use faulty::FaultyMachines;
pub use file::{BehaviorEntry, BehaviorFiles, ScenarioFile};
pub use find::{Found, FoundKind};
pub use leaves::LeafEntry;
pub use model_entry::ModelEntry;
pub use monitoring::{MachineMonitor, Monitoring, Watched, named_like_a_general_one};
pub use offer::{Offer, OfferMessage};
pub use offered::OfferedComponents;
pub use premises::{Premises, PremisesEntry, Sites, Start};
pub use prove::{
    ALL_REACHED, AllowedFault, BatteryAssumption, Conduct, Drained, FaultAssumption, GENERAL, MessageAssumption,
    PROGRESS, Passes, ProofOutcome, ProveEntry, StandIn, TripAssumption,
};
pub use ready_made::{Content, EventRule, Figure, ReadyMade, ReadyMadeKind, WatchingMachine};
pub use robot::STEP;
pub use skill::Skill;
pub use stand_in::{Carrier, Samples, literals};
pub use stop::{SomeProperties, Stop};
pub use truth::{Fact, Truths};
pub use world::WorldBody;

use self::schedule::Schedule;
use crate::Error;
use crate::faults::FaultKind;
use crate::processes::BUILTIN;

/// A scenario, ready to be run: its file and everything that the file names, loaded and checked.
#[derive(Clone, Debug)]
pub struct Scenario {
    /// The scenario's name.
    pub name: String,
    /// The contents of its file.
    pub file: ScenarioFile,
    /// Its origin.
    pub origin: Origin,
    /// The map on which its robot drives; without one, tree, skills and components run alone.
    pub premises: Option<Premises>,
    /// The tree, or the model that has one.
    pub behavior: Behavior,
    /// The skill of each leaf, by the name of the leaf's process.
    pub skills: BTreeMap<String, Skill>,
    /// The components from files, by the name of their process; for a model, everything that is not a leaf.
    pub components: BTreeMap<String, Component>,
    /// What a proof tries of the answers of components that may answer anything.
    pub samples: Samples,
    /// The machines that skills and components run while faults change them, by the name of the process.
    pub machines: BTreeMap<String, FaultyMachines>,
    /// The property files: their names and texts.
    pub properties: Vec<(String, String)>,
    /// The machines that monitor the run, by their index among the monitors of the file.
    pub watching: BTreeMap<usize, Arc<Chart>>,
    /// The schedule that its runs follow; without one, a scheduler chooses, and drivers and physics do the rest.
    pub schedule: Option<Arc<Schedule>>,
    /// The files that it takes from elsewhere than the folders of its own files.
    pub elsewhere: Vec<Elsewhere>,
    /// The monitors of the properties, once requested.
    monitoring: Arc<OnceLock<Arc<Monitoring>>>,
}

/// The source of a scenario's processes.
#[derive(Clone, Debug)]
pub enum Behavior {
    /// A behavior tree, with skills and components from files of their own.
    Tree(Arc<Tree>),
    /// A RoAML model, with its tree if it has one, and with the machines of all its processes.
    Model(Arc<Model>),
}

impl Scenario {
    /// The behavior tree; only a model may have none.
    #[must_use]
    pub fn tree(&self) -> Option<&Arc<Tree>> {
        match &self.behavior {
            Behavior::Tree(tree) => Some(tree),
            Behavior::Model(model) => model.tree.as_ref(),
        }
    }

    /// What its runs are expected to do. The properties of a model may be true or false.
    #[must_use]
    pub fn expected(&self) -> Expected {
        Expected { others_are_open: self.model().is_some(), ..self.file.expect.record() }
    }

    /// The model, if it is one.
    #[must_use]
    pub fn model(&self) -> Option<&Arc<Model>> {
        match &self.behavior {
            Behavior::Tree(_) => None,
            Behavior::Model(model) => Some(model),
        }
    }

    /// The doors or devices on which a kind of fault can act; `None` if it acts on neither.
    #[must_use]
    pub fn devices_for(&self, kind: &FaultKind) -> Option<Vec<String>> {
        if kind.is_of_doors() {
            let doors = self.premises.iter().flat_map(|premises| world::doors(&premises.entry.world));
            return Some(doors.map(str::to_owned).collect());
        }
        let trouble = kind.trouble()?;
        let suffers = |component: &Component| matches!(&component.runs, Runs::Device(settings) if trouble.can_befall(settings.kind()));
        let devices = self.components.iter().filter(|(_, component)| suffers(component));
        Some(devices.map(|(name, _)| name.clone()).collect())
    }

    /// The machines of its skills, components and monitors, and those that faults put in their place.
    pub fn charts(&self) -> impl Iterator<Item = &Arc<Chart>> {
        let skills = self.skills.values().map(|skill| &skill.machine);
        let components = self.components.values().filter_map(|component| Some(&component.machine()?.machine));
        let replaced = self.machines.values().flat_map(BTreeMap::values);
        skills.chain(components).chain(self.watching.values()).chain(replaced)
    }

    /// The files that it takes from elsewhere, in sentences: those that come with the program together, and each that
    /// an assignment names.
    #[must_use]
    pub fn elsewhere_in_words(&self) -> Vec<String> {
        let (on_disk, shipped): (Vec<&Elsewhere>, Vec<_>) = self.elsewhere.iter().partition(|it| it.on_disk.is_some());
        let names: Vec<String> = shipped.iter().map(|it| it.path.display().to_string()).collect();
        let come = if names.len() == 1 { "comes" } else { "come" };
        let of_shipped = format!("{} {come} with steward: there is no such file beside the scenario", names.join(", "));
        let of_disk = on_disk.into_iter().filter_map(|Elsewhere { path, on_disk }| {
            Some(format!("{} is {}, not beside the scenario", path.display(), on_disk.as_ref()?.display()))
        });
        Some(of_shipped).filter(|_| !names.is_empty()).into_iter().chain(of_disk).collect()
    }

    /// The warnings about its machines, to be rendered: those of each file once, and whether it can be halted only if a
    /// leaf that uses it can. A model has already reported its own.
    #[must_use]
    pub fn machine_concerns(&self) -> Vec<Concerns> {
        let Behavior::Tree(tree) = &self.behavior else { return Vec::new() };
        let written = self.machine_processes().map(|(_, skill)| &skill.machine).chain(self.watching.values());
        let mut machines: BTreeMap<&str, (&Arc<Chart>, Option<bool>)> =
            written.map(|chart| (chart.file().name(), (chart, None))).collect();
        for leaf in tree.leaves() {
            if let Some((_, can_halt)) =
                self.skills.get(leaf.process()).and_then(|skill| machines.get_mut(skill.machine.file().name()))
            {
                *can_halt = Some(can_halt.unwrap_or(false) || leaf.kind() == Kind::Action);
            }
        }
        let of = |(chart, can_halt): (&Arc<Chart>, Option<bool>)| {
            [chart.concerns(), can_halt.and_then(|can_halt| chart.answer_concerns(can_halt))]
        };
        machines.into_values().flat_map(of).flatten().collect()
    }

    /// The programs that a run starts, each with its component.
    pub fn programs(&self) -> impl Iterator<Item = (&str, &Program)> {
        self.components.iter().filter_map(|(name, component)| match &component.runs {
            Runs::Program { program, .. } => Some((name.as_str(), &**program)),
            Runs::Machine(_) | Runs::Remote(_) | Runs::Device(_) => None,
        })
    }

    /// The components that are nodes of ROS 2, each with their namespace.
    pub fn remote_components(&self) -> impl Iterator<Item = (&str, &Spanned<String>)> {
        self.file.components.iter().filter_map(|entry| match &entry.runs {
            RunsEntry::Remote { namespace } => Some((entry.name.value.as_str(), namespace)),
            _ => None,
        })
    }

    /// The monitors of the properties, for a system with this topology: built on first use, and then shared by all runs
    /// on the same channels.
    ///
    /// # Errors
    /// [`Error::BadInput`] with everything that is wrong with the property files.
    pub fn monitoring(&self, topology: &Arc<Topology>) -> Result<Arc<Monitoring>, Error> {
        let tick = self.file.execution.tick;
        if let Some(made) = self.monitoring.get().filter(|made| made.fits(topology, tick)) {
            return Ok(Arc::clone(made));
        }
        let Self { file, properties, watching, .. } = self;
        let model = self.model().map(Arc::as_ref);
        let made = Arc::new(Monitoring::new(file, model, properties, watching, topology)?);
        // If a scenario with other channels shares the cell, it is already set and stays so.
        let _ = self.monitoring.set(Arc::clone(&made));
        Ok(made)
    }

    /// The processes that run SCXML machines: first skills, then components from files, by the name of the process.
    pub fn machine_processes(&self) -> impl Iterator<Item = (&str, &Skill)> {
        let components =
            self.components.iter().filter_map(|(name, component)| Some((name.as_str(), component.machine()?)));
        self.skills.iter().map(|(name, skill)| (name.as_str(), skill)).chain(components)
    }

    /// The machines that a process may run: its own, and those with which faults replace it.
    pub fn machines_of<'a>(&'a self, name: &str, sound: &'a Skill) -> impl Iterator<Item = &'a Arc<Chart>> {
        let faulty = self.machines.get(name).into_iter().flat_map(FaultyMachines::values);
        std::iter::once(&sound.machine).chain(faulty)
    }

    /// The names of the components: first the built-in ones, then those from files.
    pub fn component_names(&self) -> impl Iterator<Item = &str> {
        let is_replaced = |name: &&str| self.components.contains_key(*name);
        let of_robot = BUILTIN.into_iter().filter(|_| self.premises.is_some());
        of_robot.filter(move |name| !is_replaced(name)).chain(self.components.keys().map(String::as_str))
    }

    /// The warnings about its model, tree, leaves and places, to be rendered.
    #[must_use]
    pub fn concerns(&self) -> Vec<Box<dyn Diagnostic + Send + Sync>> {
        let mut concerns: Vec<Box<dyn Diagnostic + Send + Sync>> = Vec::new();
        let of_model = self.model().into_iter().flat_map(|model| &model.warnings);
        concerns.extend(of_model.map(|concern| Box::new(concern.clone()) as _));
        if let Some(tree) = self.tree() {
            let of_tree = tree.concerns().cloned().into_iter().chain(self.leaf_concerns(tree));
            concerns.extend(of_tree.map(|of_tree| Box::new(of_tree) as _));
        }
        concerns.extend(self.place_concerns().into_iter().map(|concern| Box::new(concern) as _));
        concerns
    }

    /// The warnings about the tree's leaves and their skills; `None` if there are none.
    fn leaf_concerns(&self, tree: &Tree) -> Option<bt::TreeError> {
        let mut concerns = skill::concerns(tree, &self.skills);
        concerns.extend(symbols::never_equal(tree, &self.file.leaves, &self.components));
        // Only the tree writes to its blackboard, and a fault may replace the machine of a leaf.
        concerns.extend(tree.unwritten_entries(&|leaf, port| {
            let skill = self.skills.get(leaf.process());
            let mut machines = skill.into_iter().flat_map(|skill| self.machines_of(leaf.process(), skill));
            skill.is_none() || machines.any(|machine| machine.answers_with(port))
        }));
        (!concerns.is_empty()).then(|| tree.error(&concerns))
    }
}
