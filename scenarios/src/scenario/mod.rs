//! Scenarios: one file an experiment, loaded with everything that it names.

mod faulty;
mod file;
pub mod find;
mod stop;
mod world;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use bt::Tree;
use channels::Topology;
use maps::{OccupancyGrid, Place, Places, PlacesFile, Pose, Problem, Spanned};
use nav::{Atlas, LocalizationParameters};
use robot::RobotModel;
use sim::Building;
use skills::Chart;

pub use faulty::FaultyMachines;
pub use file::{Execution, Expectations, Moment, Moments, Order, Policy, ScenarioFile, Sites, Start, TreeForm};
pub use find::Found;
pub use stop::{Stop, StopOnViolation};
pub use world::WorldBody;

use crate::error::Complaints;
use crate::monitoring::Monitoring;
use crate::{Error, wiring};

/// Where a scenario comes from, for running it again.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Origin {
    /// How the command line calls it.
    pub argument: String,
    /// The text of its file.
    pub text: String,
    /// What the command line changed, as `--set` takes it.
    pub overrides: Vec<String>,
}

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
    /// The machine of each leaf, by the leaf's ID.
    pub charts: BTreeMap<String, Arc<Chart>>,
    /// The machines that skills run while faults hold that change them, by skill.
    pub machines: BTreeMap<String, FaultyMachines>,
    /// The map that the software has, where a fault gives it another one than the world's.
    pub wrong_map: Option<Arc<OccupancyGrid>>,
    /// The property files: their names and texts.
    pub properties: Vec<(String, String)>,
    /// Where the robot starts, in the `map` frame.
    pub start: Pose,
    /// Where the charging station stands and how a docked robot faces, in the `map` frame.
    pub station: Pose,
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
        let made = Arc::new(Monitoring::new(&self.properties, &self.file.properties, topology, tick)?);
        // Shared with a scenario whose channels are others, there is one already: that one stays.
        let _ = self.monitoring.set(Arc::clone(&made));
        Ok(made)
    }

    /// The machines that a skill may run: its own, and those that faults put in its place.
    pub(crate) fn machines_of(&self, skill: &str) -> impl Iterator<Item = &Arc<Chart>> {
        self.charts.get(skill).into_iter().chain(self.machines.get(skill).into_iter().flat_map(FaultyMachines::values))
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
        let charts = tree.as_ref().map(|tree| self.charts(&file, tree));
        let shared = self.shares(&file, |file| &file.places) && self.shares(&file, |file| &file.tree);
        let checked = shared && self.shares(&file, |file| &file.skills);
        if let (Some(tree), Some(charts), Some(places), false) = (&tree, &charts, &places, checked) {
            wiring::check_skills(tree, charts, places, self.complaints);
        }
        let poses = places.as_ref().and_then(|places| self.check_places(&file, places));
        let machines = charts.as_ref().map(|charts| self.faulty_machines(&file, charts));
        let wrong_map = self.wrong_map(&file);
        let properties = self.properties(&file);
        if let Some(map) = &map {
            self.check_world(&file.world, map);
        }
        let same_map = wrong_map.is_none() && self.shares(&file, |file| &file.map);
        let atlas = self.like.filter(|like| same_map && like.wrong_map.is_none()).map(|like| like.atlas.clone());
        let same_world = self.shares(&file, |file| &file.map);
        let building = self.like.filter(|_| same_world).map(|like| like.building.clone());
        let monitoring = self.like.filter(|like| like.properties == properties).map(|like| like.monitoring.clone());
        let (start, station) = poses?;
        Some(Scenario {
            name: self.found.name.clone(),
            map: map?,
            places: places?,
            tree: tree?,
            charts: charts?,
            machines: machines?,
            wrong_map: wrong_map.map(Arc::new),
            properties,
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
        self.like.is_some_and(|like| path(&like.file).value == path(file).value)
    }

    fn map(&mut self, file: &ScenarioFile) -> Option<Arc<OccupancyGrid>> {
        if let Some(like) = self.like.filter(|_| self.shares(file, |file| &file.map)) {
            return Some(Arc::clone(&like.map));
        }
        let map = maps::load_map(&file.map.value, &|path: &Path| self.found.files.read(path));
        self.loaded(&file.map, "map", map).map(Arc::new)
    }

    fn places(&mut self, file: &ScenarioFile) -> Option<Places> {
        if let Some(like) = self.like.filter(|_| self.shares(file, |file| &file.places)) {
            return Some(like.places.clone());
        }
        let places = PlacesFile::load(&file.places.value, &|path: &Path| self.found.files.read(path));
        self.loaded(&file.places, "places", places).map(PlacesFile::into_places)
    }

    /// What a loader of `maps` gave; a file that cannot be read is a problem of the line that names it.
    fn loaded<T>(&mut self, path: &Spanned<PathBuf>, what: &str, result: Result<T, maps::Error>) -> Option<T> {
        match result {
            Err(maps::Error::Read { path: file, source }) => {
                self.complaints.push(unreadable(&path.span, what, &file, &source));
                None
            }
            result => self.complaints.note(result),
        }
    }

    fn text(&mut self, span: &maps::Span, what: &str, path: &Path) -> Option<String> {
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

    /// The machine of each leaf: the file of its name in the folder of the skills.
    fn charts(&mut self, file: &ScenarioFile, tree: &Tree) -> BTreeMap<String, Arc<Chart>> {
        let shared = self.shares(file, |file| &file.tree) && self.shares(file, |file| &file.skills);
        if let Some(like) = self.like.filter(|_| shared) {
            return like.charts.clone();
        }
        let mut charts = BTreeMap::new();
        let mut missing = Vec::new();
        for leaf in tree.leaves() {
            let id = leaf.type_id();
            let path = file.skills.value.join(format!("{id}.scxml"));
            if charts.contains_key(id) {
                continue;
            }
            match self.found.files.read_text(&path) {
                Ok(text) => {
                    let chart = self.complaints.note(Chart::load(&path.display().to_string(), &text));
                    charts.extend(chart.map(|chart| (id.to_owned(), chart)));
                }
                Err(error) => missing.push(tree.problem_at(
                    leaf.id(),
                    format!("the leaf `{id}` has no skill: cannot read {}: {error}", path.display()),
                    "no skill for this leaf",
                    "a leaf needs an SCXML machine of its own name in the folder that the scenario's `skills` names",
                )),
            }
        }
        if !missing.is_empty() {
            self.complaints.push(tree.error(missing));
        }
        charts
    }

    /// Checks every place that the scenario names; the poses of start and station.
    fn check_places(&mut self, file: &ScenarioFile, places: &Places) -> Option<(Pose, Pose)> {
        for name in file
            .expect
            .reached
            .iter()
            .chain(&file.expect.not_reached)
            .chain(&file.stop.at)
            .chain([&file.sites.destination])
        {
            let _ = self.place(name, places);
        }
        let start = match &file.sites.start {
            Spanned { value: Start::Named(name), span } => {
                self.point(&Spanned { value: name.clone(), span: span.clone() }, places)
            }
            Spanned { value: Start::At(pose), .. } => Some(*pose),
        };
        let station = self.point(&file.sites.station, places);
        Some((start?, station?))
    }

    fn place<'p>(&mut self, name: &Spanned<String>, places: &'p Places) -> Option<&'p Place> {
        let place = places.get(&name.value);
        if place.is_none() {
            let names = places.iter().map(|(name, _)| name);
            self.complaints.push(unknown("place", name, names));
        }
        place
    }

    fn point(&mut self, name: &Spanned<String>, places: &Places) -> Option<Pose> {
        match self.place(name, places)? {
            Place::Point { pose, .. } => Some(*pose),
            Place::Area { .. } => {
                let problem = name.span.problem(format!("`{}` is an area, and a point is needed", name.value));
                self.complaints
                    .push(problem.with_label("this place").with_help("a point has a position and a heading"));
                None
            }
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
}

/// A problem with a name that is none of those there are.
pub(crate) fn unknown<'n>(what: &str, name: &Spanned<String>, known: impl IntoIterator<Item = &'n str>) -> Problem {
    let known: Vec<&str> = known.into_iter().collect();
    let list = || known.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
    let help = match maps::nearest(&name.value, known.iter().copied()) {
        Some(nearest) => format!("did you mean `{nearest}`?"),
        None if known.is_empty() => "there is none".to_owned(),
        None => format!("there are {}", list()),
    };
    let problem = name.span.problem(format!("unknown {what} `{}`", name.value));
    problem.with_label(format!("no such {what}")).with_help(help)
}

fn unreadable(span: &maps::Span, what: &str, path: &Path, error: &std::io::Error) -> Problem {
    let problem = span.problem(format!("cannot read the {what} {}: {error}", path.display()));
    let help = "a path is looked up beside the scenario's file, and then among the files that come with the program";
    problem.with_label(format!("this {what}")).with_help(help)
}
