//! Scenarios: one file per experiment, loaded with everything that it names.

mod faulty;
mod file;
mod file_reader;
pub mod find;
pub mod keys;
mod leaves;
mod load;
mod places;
mod ready_made;
pub(crate) mod settings;
mod skill;
mod stop;
mod world;

use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};

use bt::Tree;
use channels::Topology;
use maps::{OccupancyGrid, Places, PlacesFile, Pose};
use nav::{Atlas, LocalizationParameters, Reach};
use recording::Origin;
use robot::RobotModel;
use sim::Building;
use skills::Chart;

pub use faulty::FaultyMachines;
pub use file::{Execution, Expectations, Order, Policy, ScenarioFile, Sites, Start, TreeForm};
pub use find::Found;
pub use leaves::LeafEntry;
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
    /// The map.
    pub map: Arc<OccupancyGrid>,
    /// The places on the map.
    pub places: Places,
    /// The behavior tree.
    pub tree: Arc<Tree>,
    /// The skill of each leaf, by the name of the leaf's process.
    pub skills: BTreeMap<String, Skill>,
    /// The machines that skills run while faults change them, by skill.
    pub machines: BTreeMap<String, FaultyMachines>,
    /// The software's map, if a fault gives it another one than the world's.
    pub wrong_map: Option<Arc<OccupancyGrid>>,
    /// The property files: their names and texts.
    pub properties: Vec<(String, String)>,
    /// The machines that monitor the run, by their index among the monitors of the file.
    pub watching: BTreeMap<usize, Arc<Chart>>,
    /// The start pose of the robot, in the `map` frame.
    pub start: Pose,
    /// The pose of a robot docked at the charging station, in the `map` frame, if there is a station.
    pub station: Option<Pose>,
    /// The places that skills always drive to, each with one such skill.
    driven_to: BTreeMap<String, String>,
    /// The places file.
    written: Arc<PlacesFile>,
    /// The part of the map that the robot can reach.
    reach: Arc<Reach>,
    /// The data that localization and navigation compute from the map, once requested.
    atlas: OnceLock<Result<Arc<Atlas>, nav::Error>>,
    /// The data that the simulation computes from the map, once requested.
    building: OnceLock<Building>,
    /// The monitors of the properties, once requested.
    monitoring: OnceLock<Arc<Monitoring>>,
}

impl Scenario {
    /// The data of the map for localization and navigation of the scenario's robot: computed on first use, and then
    /// shared by all runs.
    ///
    /// # Errors
    /// [`nav::Error`] if localization is impossible on the map.
    pub fn atlas(&self, model: &RobotModel) -> Result<Arc<Atlas>, nav::Error> {
        let map = self.wrong_map.as_ref().unwrap_or(&self.map);
        let atlas = || Atlas::new(Arc::clone(map), model, LocalizationParameters::default()).map(Arc::new);
        match self.atlas.get_or_init(atlas) {
            // Shared with a scenario that has another robot.
            Ok(shared) if shared.model() != model => atlas(),
            result => result.clone(),
        }
    }

    /// The walls of the simulated world: computed on first use, and then shared by all runs.
    #[must_use]
    pub fn building(&self) -> &Building {
        self.building.get_or_init(|| Building::new(&self.map))
    }

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
