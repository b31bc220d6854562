//! Scenarios: one file an experiment, loaded with everything that it names.

mod faulty;
mod file;
pub mod find;
mod places;
mod ready_made;
pub(crate) mod settings;
mod skill;
mod stop;
mod world;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use bt::Tree;
use channels::Topology;
use diagnostics::{Problem, Spanned};
use maps::{OccupancyGrid, Places, PlacesFile, Pose};
use nav::{Atlas, LocalizationParameters, Reach};
use recording::Origin;
use robot::RobotModel;
use sim::Building;
use skills::Chart;

pub use faulty::FaultyMachines;
pub use file::{Execution, Expectations, Order, Policy, ScenarioFile, Sites, Start, TreeForm};
pub use find::Found;
pub use ready_made::{Content, EventRule, Figure, ReadyMade, ReadyMadeKind, WatchingMachine};
pub use skill::{LeafEntry, Skill};
pub use stop::{Stop, StopOnViolation};
pub use world::WorldBody;

use crate::error::Complaints;
use crate::monitoring::Monitoring;
use crate::{Error, wiring};

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
    /// Loads a scenario; `overrides` are assignments as `--set` takes them.
    ///
    /// # Errors
    /// [`Error::BadInput`] with everything that is wrong with the scenario and its files.
    pub fn load(found: &Found, overrides: &[String]) -> Result<Self, Error> {
        Self::load_with(found, overrides, None)
    }

    /// Loads a scenario as [`load`](Self::load) does, but shares with `like`, which was loaded from the same scenario with
    /// other overrides, all files that both name, and what is worked out of the map.
    ///
    /// # Errors
    /// As [`load`](Self::load).
    pub fn load_like(like: &Self, found: &Found, overrides: &[String]) -> Result<Self, Error> {
        Self::load_with(found, overrides, Some(like))
    }

    fn load_with(found: &Found, overrides: &[String], like: Option<&Self>) -> Result<Self, Error> {
        let assignments = overrides.iter().map(String::as_str);
        let file =
            ScenarioFile::parse(&found.path, &found.text, &found.files, assignments).map_err(Error::bad_input)?;
        let mut found = found.clone();
        if let Some(folder) = &file.folder {
            found.files = found.files.in_folder(&folder.value);
            if found.files.on_disk(&file.tree.value).is_none() {
                let problem = folder.span.problem(format!("there is no {} in this folder", file.tree.value.display()));
                let help = "`--set folder=DIR` names the folder that the scenario's files are in";
                return Err(Error::bad_input(problem.with_label("this folder").with_help(help)));
            }
        }
        let found = &found;
        let mut complaints = Complaints::default();
        let loaded = Loader { found, overrides, like, complaints: &mut complaints }.load(file);
        complaints.check()?;
        Ok(loaded.expect("what could not be loaded was complained about"))
    }

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
        let made = Arc::new(Monitoring::new(self, topology)?);
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

/// Loads the files that a scenario names and notes what is wrong with them.
struct Loader<'a> {
    found: &'a Found,
    overrides: &'a [String],
    /// The same scenario with other overrides.
    like: Option<&'a Scenario>,
    complaints: &'a mut Complaints,
}

impl Loader<'_> {
    fn load(&mut self, file: ScenarioFile) -> Option<Scenario> {
        let map = self.map(&file);
        let places = self.places(&file);
        let tree = self.tree(&file);
        let skills = tree.as_ref().map(|tree| self.skills_of(&file, tree));
        let checked = self.shares(&file, |file| &file.places) && self.shares_skills(&file);
        let driven_to = match (&tree, &skills, &places, self.like) {
            (.., Some(like)) if checked => like.driven_to.clone(),
            (Some(tree), Some(skills), Some(places), _) => {
                wiring::check_skills(tree, skills, places.places(), self.complaints)
            }
            _ => BTreeMap::new(),
        };
        let poses = places.as_ref().and_then(|places| self.check_places(&file, places.places()));
        let reach = map.as_ref().and_then(|map| self.reach(&file, map));
        if let (Some(map), Some(places), Some(reach), Some((start, _))) = (&map, &places, &reach, &poses) {
            self.check_reach(&file, &driven_to, places, map, reach, start);
        }
        let machines = skills.as_ref().map(|skills| self.faulty_machines(&file, skills));
        let wrong_map = self.wrong_map(&file);
        let properties = self.properties(&file);
        let watching = self.watching(&file);
        if let Some(map) = &map {
            self.check_world(&file.world, map);
        }
        let same_map = wrong_map.is_none() && self.shares(&file, |file| &file.map);
        let atlas = self.like.filter(|like| same_map && like.wrong_map.is_none()).map(|like| like.atlas.clone());
        let same_world = self.shares(&file, |file| &file.map);
        let building = self.like.filter(|_| same_world).map(|like| like.building.clone());
        let same_monitors = |like: &&Scenario| {
            like.properties == properties && like.file.monitors.is_empty() && file.monitors.is_empty()
        };
        let monitoring = self.like.filter(same_monitors).map(|like| like.monitoring.clone());
        let (start, station) = poses?;
        Some(Scenario {
            name: self.found.name.clone(),
            map: map?,
            places: places.as_ref()?.places().clone(),
            driven_to,
            written: places?,
            reach: reach?,
            tree: tree?,
            skills: skills?,
            machines: machines?,
            wrong_map: wrong_map.map(Arc::new),
            properties,
            watching,
            start,
            station,
            atlas: atlas.unwrap_or_default(),
            building: building.unwrap_or_default(),
            monitoring: monitoring.unwrap_or_default(),
            origin: Origin {
                argument: self.found.argument.clone(),
                text: self.found.text.clone(),
                overrides: self.overrides.to_vec(),
            },
            file,
        })
    }

    /// Whether the scenario to share with names the same file.
    fn shares(&self, file: &ScenarioFile, path: impl Fn(&ScenarioFile) -> &Spanned<PathBuf>) -> bool {
        let folder = |file: &ScenarioFile| file.folder.as_ref().map(|folder| folder.value.clone());
        self.like.is_some_and(|like| path(&like.file).value == path(file).value && folder(&like.file) == folder(file))
    }

    fn map(&mut self, file: &ScenarioFile) -> Option<Arc<OccupancyGrid>> {
        if let Some(like) = self.like.filter(|_| self.shares(file, |file| &file.map)) {
            return Some(Arc::clone(&like.map));
        }
        let map = maps::load_map(&file.map.value, &|path: &Path| self.found.files.read(path));
        self.loaded(&file.map, "map", map).map(Arc::new)
    }

    fn places(&mut self, file: &ScenarioFile) -> Option<Arc<PlacesFile>> {
        if let Some(like) = self.like.filter(|_| self.shares(file, |file| &file.places)) {
            return Some(Arc::clone(&like.written));
        }
        let places = PlacesFile::load(&file.places.value, &|path: &Path| self.found.files.read(path));
        self.loaded(&file.places, "places", places).map(Arc::new)
    }

    /// What reading a file gave; a file that cannot be read is a problem of the line that names it.
    fn loaded<T>(&mut self, path: &Spanned<PathBuf>, what: &str, result: Result<T, diagnostics::Error>) -> Option<T> {
        match result {
            Err(diagnostics::Error::Read { path: file, source }) => {
                self.complaints.push(unreadable(&path.span, what, &file, &source));
                None
            }
            result => self.complaints.note(result),
        }
    }

    fn text(&mut self, span: &diagnostics::Span, what: &str, path: &Path) -> Option<String> {
        let text = self.found.files.read_text(path);
        text.map_err(|error| self.complaints.push(unreadable(span, what, path, &error))).ok()
    }

    fn tree(&mut self, file: &ScenarioFile) -> Option<Arc<Tree>> {
        if let Some(like) = self.like.filter(|_| self.shares(file, |file| &file.tree)) {
            return Some(Arc::clone(&like.tree));
        }
        let text = self.text(&file.tree.span, "tree", &file.tree.value)?;
        self.complaints.note(Tree::from_xml(&file.tree.value, &text)).map(Arc::new)
    }

    /// Whether the scenario to share with has the same skills.
    fn shares_skills(&self, file: &ScenarioFile) -> bool {
        let same_files = self.shares(file, |file| &file.tree) && self.shares(file, |file| &file.skills);
        same_files && self.like.is_some_and(|like| skill::same_entries(&like.file.leaves, &file.leaves))
    }

    fn skills_of(&mut self, file: &ScenarioFile, tree: &Tree) -> BTreeMap<String, Skill> {
        match self.like.filter(|_| self.shares_skills(file)) {
            Some(like) => like.skills.clone(),
            None => self.skills(file, tree),
        }
    }

    fn properties(&mut self, file: &ScenarioFile) -> Vec<(String, String)> {
        let names = |file: &ScenarioFile| file.properties.iter().map(|path| path.value.clone()).collect::<Vec<_>>();
        if let Some(like) = self.like.filter(|like| names(&like.file) == names(file)) {
            return like.properties.clone();
        }
        let read = |path: &Spanned<PathBuf>| {
            let text = self.text(&path.span, "property file", &path.value)?;
            Some((path.value.display().to_string(), text))
        };
        file.properties.iter().filter_map(read).collect()
    }

    /// The machines among the monitors that are attached as they stand.
    fn watching(&mut self, file: &ScenarioFile) -> BTreeMap<usize, Arc<Chart>> {
        let mut charts = BTreeMap::new();
        for (index, entry) in file.monitors.iter().enumerate() {
            let ReadyMadeKind::Machine(WatchingMachine { machine, .. }) = &entry.kind else { continue };
            let Some(text) = self.text(&machine.span, "machine", &machine.value) else { continue };
            let chart = self.complaints.note(Chart::load(&machine.value.display().to_string(), &text));
            charts.extend(chart.map(|chart| (index, chart)));
        }
        charts
    }
}

/// A problem with a name that is none of those there are.
pub fn unknown<'n>(what: &str, name: &Spanned<String>, known: impl IntoIterator<Item = &'n str>) -> Problem {
    let known: Vec<&str> = known.into_iter().collect();
    let list = || match known.as_slice() {
        [] => "there is none".to_owned(),
        known => format!("there are `{}`", known.join("`, `")),
    };
    let help = diagnostics::did_you_mean(&name.value, known.iter().copied()).unwrap_or_else(list);
    let problem = name.span.problem(format!("unknown {what} `{}`", name.value));
    problem.with_label(format!("no such {what}")).with_help(help)
}

fn unreadable(span: &diagnostics::Span, what: &str, path: &Path, error: &std::io::Error) -> Problem {
    let problem = span.problem(format!("cannot read the {what} {}: {error}", path.display()));
    let help = "a path is looked up beside the scenario's file, and then among the files that come with the program";
    problem.with_label(format!("this {what}")).with_help(help)
}
