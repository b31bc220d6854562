//! Scenarios: one file per experiment, loaded with everything that it names.

mod faulty;
mod file;
mod file_reader;
pub mod find;
pub mod keys;
mod leaves;
mod load;
mod places;
mod premises;
mod ready_made;
mod robot;
pub(crate) mod settings;
mod skill;
mod stop;
mod world;

use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};

use bt::Tree;
use channels::Topology;
use recording::Origin;
use skills::Chart;

pub use faulty::FaultyMachines;
pub use file::{Execution, Expectations, Order, Policy, STEP, ScenarioFile, TreeForm};
pub use find::Found;
pub use leaves::LeafEntry;
pub use premises::{Premises, PremisesEntry, Sites, Start};
pub use ready_made::{Content, EventRule, Figure, ReadyMade, ReadyMadeKind, WatchingMachine};
pub use skill::Skill;
pub use stop::{Stop, StopOnViolation};
pub use world::WorldBody;

use crate::Error;
use crate::monitoring::Monitoring;

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
    /// The behavior tree.
    pub tree: Arc<Tree>,
    /// The skill of each leaf, by the name of the leaf's process.
    pub skills: BTreeMap<String, Skill>,
    /// The machines that skills run while faults change them, by skill.
    pub machines: BTreeMap<String, FaultyMachines>,
    /// The property files: their names and texts.
    pub properties: Vec<(String, String)>,
    /// The machines that monitor the run, by their index among the monitors of the file.
    pub watching: BTreeMap<usize, Arc<Chart>>,
    /// The monitors of the properties, once requested.
    monitoring: OnceLock<Arc<Monitoring>>,
}

impl Scenario {
    /// The monitors of the properties, for a system with this topology: made on first use, and then shared by all runs
    /// on the same channels.
    ///
    /// # Errors
    /// [`Error::BadInput`] with everything that is wrong with the property files.
    pub(crate) fn monitoring(&self, topology: &Arc<Topology>) -> Result<Arc<Monitoring>, Error> {
        let tick = self.file.execution.tick;
        if let Some(made) = self.monitoring.get().filter(|made| made.fits(topology, tick)) {
            return Ok(Arc::clone(made));
        }
        let made = Arc::new(Monitoring::new(&self.file, &self.properties, &self.watching, topology)?);
        // If a scenario with other channels shares it, there is one already, which stays.
        let _ = self.monitoring.set(Arc::clone(&made));
        Ok(made)
    }

    /// The machines that a skill may run: its own, and those with which faults replace it.
    pub(crate) fn machines_of(&self, skill: &str) -> impl Iterator<Item = &Arc<Chart>> {
        let sound = self.skills.get(skill).map(|skill| &skill.machine);
        sound.into_iter().chain(self.machines.get(skill).into_iter().flat_map(FaultyMachines::values))
    }

    /// The warnings about the tree and its skills, to be rendered; `None` if there are none.
    #[must_use]
    pub fn leaf_concerns(&self) -> Option<bt::TreeError> {
        let concerns = skill::concerns(&self.tree, &self.skills);
        (!concerns.is_empty()).then(|| self.tree.error(&concerns))
    }
}
