//! Scenarios: one file an experiment, loaded with everything that it names.

mod faulty;
mod file;
mod file_reader;
pub mod find;
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
    /// What its file says.
    pub file: ScenarioFile,
    /// Where it comes from.
    pub origin: Origin,
    /// The map.
    pub map: Arc<OccupancyGrid>,
    /// The places on the map.
    pub places: Places,
    /// The behavior tree.
    pub tree: Arc<Tree>,
    /// The skill of each leaf, by the name of the leaf's process.
    pub skills: BTreeMap<String, Skill>,
    /// The machines that skills run while faults hold that change them, by skill.
    pub machines: BTreeMap<String, FaultyMachines>,
    /// The map that the software has, where a fault gives it another one than the world's.
    pub wrong_map: Option<Arc<OccupancyGrid>>,
    /// The property files: their names and texts.
    pub properties: Vec<(String, String)>,
    /// The machines that watch the run, by their place among the monitors of the file.
    pub watching: BTreeMap<usize, Arc<Chart>>,
    /// Where the robot starts, in the `map` frame.
    pub start: Pose,
    /// Where the charging station stands and how a docked robot faces, in the `map` frame, if there is one.
    pub station: Option<Pose>,
    /// The places that skills always drive to, each with such a skill.
    driven_to: BTreeMap<String, String>,
    /// Where the places are written.
    written: Arc<PlacesFile>,
    /// Where the robot can drive on the map.
    reach: Arc<Reach>,
    /// What localization and navigation work out of the map, once somebody has asked.
    atlas: OnceLock<Result<Arc<Atlas>, nav::Error>>,
    /// What the simulation works out of the map, once somebody has asked.
    building: OnceLock<Building>,
    /// The monitors of the properties, once somebody has asked.
    monitoring: OnceLock<Arc<Monitoring>>,
}

impl Scenario {
    /// What localization and navigation of the scenario's robot need of the map: worked out when it is asked for the
    /// first time, and shared by all runs from then on.
    ///
    /// # Errors
    /// [`nav::Error`] if nobody can be localized on the map.
    pub fn atlas(&self, model: &RobotModel) -> Result<Arc<Atlas>, nav::Error> {
        let map = self.wrong_map.as_ref().unwrap_or(&self.map);
        let atlas = || Atlas::new(Arc::clone(map), model, LocalizationParameters::default()).map(Arc::new);
        match self.atlas.get_or_init(atlas) {
            // Shared with a scenario whose robot is another.
            Ok(shared) if shared.model() != model => atlas(),
            result => result.clone(),
        }
    }

    /// The walls of the simulated world: worked out when they are asked for the first time, and shared by all runs from
    /// then on.
    #[must_use]
    pub fn building(&self) -> &Building {
        self.building.get_or_init(|| Building::new(&self.map))
    }

    /// The monitors of the properties, for a system of that topology: made when they are asked for the first time, and
    /// shared by all runs on the same channels from then on.
    ///
    /// # Errors
    /// [`Error::BadInput`] with everything that is wrong with the property files.
    pub(crate) fn monitoring(&self, topology: &Arc<Topology>) -> Result<Arc<Monitoring>, Error> {
        let tick = self.file.execution.tick;
        if let Some(made) = self.monitoring.get().filter(|made| made.fits(topology, tick)) {
            return Ok(Arc::clone(made));
        }
        let made = Arc::new(Monitoring::new(&self.file, &self.properties, &self.watching, topology)?);
        // Shared with a scenario whose channels are others, there is one already: that one stays.
        let _ = self.monitoring.set(Arc::clone(&made));
        Ok(made)
    }

    /// The machines that a skill may run: its own, and those that faults put in its place.
    pub(crate) fn machines_of(&self, skill: &str) -> impl Iterator<Item = &Arc<Chart>> {
        let sound = self.skills.get(skill).map(|skill| &skill.machine);
        sound.into_iter().chain(self.machines.get(skill).into_iter().flat_map(FaultyMachines::values))
    }

    /// What looks odd about the tree and its skills, to be rendered; none if there is nothing.
    #[must_use]
    pub fn leaf_concerns(&self) -> Option<bt::TreeError> {
        let concerns = skill::concerns(&self.tree, &self.skills);
        (!concerns.is_empty()).then(|| self.tree.error(&concerns))
    }
}
