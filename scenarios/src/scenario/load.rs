//! Loads a scenario: its file, everything that the file names, and the checks that it all fits together.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use bt::Tree;
use diagnostics::Spanned;
use maps::{OccupancyGrid, PlacesFile};
use nav::Reach;
use recording::Origin;
use skills::Chart;

use super::file_reader::FileReader;
use super::{Found, ReadyMadeKind, Scenario, ScenarioFile, Skill, WatchingMachine, leaves, places, world};
use crate::error::{Complaints, Error};
use crate::wiring;

impl Scenario {
    /// Loads a scenario; `overrides` are assignments as for `--set`.
    ///
    /// # Errors
    /// [`Error::BadInput`] with everything that is wrong with the scenario and its files.
    pub fn load(found: &Found, overrides: &[String]) -> Result<Self, Error> {
        Self::load_with(found, overrides, None)
    }

    /// Loads a scenario like [`load`](Self::load), but shares all common files, and the data computed from the map,
    /// with `like`, which was loaded from the same scenario with other overrides.
    ///
    /// # Errors
    /// As for [`load`](Self::load).
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
                let help = "set the folder that contains the scenario's files with `--set folder=DIR`";
                return Err(Error::bad_input(problem.with_label("this folder").with_help(help)));
            }
        }
        let found = &found;
        let mut complaints = Complaints::default();
        let reader = FileReader { files: &found.files, complaints: &mut complaints };
        let loaded = Loader { found, overrides, like, reader }.load(file);
        complaints.check()?;
        Ok(loaded.expect("what could not be loaded was complained about"))
    }
}

/// Loads the files that a scenario names and records their problems.
struct Loader<'a> {
    found: &'a Found,
    overrides: &'a [String],
    /// The same scenario with other overrides.
    like: Option<&'a Scenario>,
    reader: FileReader<'a>,
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
                wiring::check_skills(tree, skills, places.places(), self.reader.complaints)
            }
            _ => BTreeMap::new(),
        };
        let poses =
            places.as_ref().and_then(|places| places::check_places(&file, places.places(), self.reader.complaints));
        let reach = map.as_ref().and_then(|map| self.reach(&file, map));
        if let (Some(map), Some(places), Some(reach), Some((start, _))) = (&map, &places, &reach, &poses) {
            places::check_reach(&file, &driven_to, places, map, reach, start, self.reader.complaints);
        }
        let machines = skills.as_ref().map(|skills| self.reader.faulty_machines(&file, skills));
        let wrong_map = self.reader.wrong_map(&file);
        let properties = self.properties(&file);
        let watching = self.watching(&file);
        if let Some(map) = &map {
            world::check_world(&file.world, map, self.reader.complaints);
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
        let map = maps::load_map(&file.map.value, &|path: &Path| self.reader.files.read(path));
        self.reader.loaded(&file.map, "map", map).map(Arc::new)
    }

    fn places(&mut self, file: &ScenarioFile) -> Option<Arc<PlacesFile>> {
        if let Some(like) = self.like.filter(|_| self.shares(file, |file| &file.places)) {
            return Some(Arc::clone(&like.written));
        }
        let places = PlacesFile::load(&file.places.value, &|path: &Path| self.reader.files.read(path));
        self.reader.loaded(&file.places, "places", places).map(Arc::new)
    }

    /// The part of the map that the robot can reach.
    fn reach(&mut self, file: &ScenarioFile, map: &OccupancyGrid) -> Option<Arc<Reach>> {
        let shared =
            self.like.filter(|like| self.shares(file, |file| &file.map) && like.file.sim.model == file.sim.model);
        if let Some(like) = shared {
            return Some(Arc::clone(&like.reach));
        }
        let reach = Reach::new(map, &file.sim.model);
        let refused = |error: nav::Error| file.map.span.problem(error.to_string()).with_label("this map");
        reach.map_err(|error| self.reader.complaints.push(refused(error))).ok().map(Arc::new)
    }

    fn tree(&mut self, file: &ScenarioFile) -> Option<Arc<Tree>> {
        if let Some(like) = self.like.filter(|_| self.shares(file, |file| &file.tree)) {
            return Some(Arc::clone(&like.tree));
        }
        let text = self.reader.text(&file.tree.span, "tree", &file.tree.value)?;
        self.reader.complaints.note(Tree::from_xml(&file.tree.value, &text)).map(Arc::new)
    }

    /// Whether the scenario to share with has the same skills.
    fn shares_skills(&self, file: &ScenarioFile) -> bool {
        let same_files = self.shares(file, |file| &file.tree) && self.shares(file, |file| &file.skills);
        same_files && self.like.is_some_and(|like| leaves::same_entries(&like.file.leaves, &file.leaves))
    }

    fn skills_of(&mut self, file: &ScenarioFile, tree: &Tree) -> BTreeMap<String, Skill> {
        match self.like.filter(|_| self.shares_skills(file)) {
            Some(like) => like.skills.clone(),
            None => self.reader.skills(file, tree),
        }
    }

    fn properties(&mut self, file: &ScenarioFile) -> Vec<(String, String)> {
        let names = |file: &ScenarioFile| file.properties.iter().map(|path| path.value.clone()).collect::<Vec<_>>();
        if let Some(like) = self.like.filter(|like| names(&like.file) == names(file)) {
            return like.properties.clone();
        }
        let read = |path: &Spanned<PathBuf>| {
            let text = self.reader.text(&path.span, "property file", &path.value)?;
            Some((path.value.display().to_string(), text))
        };
        file.properties.iter().filter_map(read).collect()
    }

    /// The machines among the ready-made monitors.
    fn watching(&mut self, file: &ScenarioFile) -> BTreeMap<usize, Arc<Chart>> {
        let mut charts = BTreeMap::new();
        for (index, entry) in file.monitors.iter().enumerate() {
            let ReadyMadeKind::Machine(WatchingMachine { machine, .. }) = &entry.kind else { continue };
            let Some(text) = self.reader.text(&machine.span, "machine", &machine.value) else { continue };
            let chart = self.reader.complaints.note(Chart::load(&machine.value.display().to_string(), &text));
            charts.extend(chart.map(|chart| (index, chart)));
        }
        charts
    }
}
