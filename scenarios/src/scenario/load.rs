//! Loads a scenario: its file, everything that the file names, and checks that it all fits together.

use std::collections::BTreeMap;
use std::convert::Infallible;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use bt::Tree;
use components::NAVIGATION;
use diagnostics::{Same, Spanned};
use maps::{OccupancyGrid, Places, PlacesFile, Zone};
use monitors::{WORLD, syntax};
use nav::Reach;
use recording::{InputFile, Origin};
use roaml::Model;
use skills::Chart;

use super::file_reader::{FileReader, FileRole, LoadedMap};
use super::stand_in::{Listeners, Samples};
use super::stop::SomeProperties;
use super::{
    Behavior, BehaviorFiles, Component, Found, FoundKind, Monitoring, Premises, PremisesEntry, ReadyMade,
    ReadyMadeKind, Scenario, ScenarioFile, Skill, WatchingMachine, declaration, elsewhere, model, places, robot, world,
};
use crate::error::{Complaints, Error, Recorded};
use crate::faults::Effect;
use crate::files::{Kind, hash_of};
use crate::names::unknown;
use crate::processes::BUILTIN;

impl Scenario {
    /// Loads a scenario; `overrides` are assignments as for `--set`. What was made of a file before, through clones of
    /// `found`, is shared if the file has not changed since, with all that was computed from the map.
    ///
    /// # Errors
    /// [`Error::BadInput`] with everything that is wrong with the scenario and its files.
    pub fn load(found: &Found, overrides: &[String]) -> Result<Self, Error> {
        Self::load_with(found, overrides, |_| Ok(()))
    }

    /// Loads a scenario like [`load`](Self::load), with the machines that replace components in its
    /// `[prove.components]`.
    ///
    /// # Errors
    /// As for [`load`](Self::load).
    pub fn load_for_proof(found: &Found, overrides: &[String]) -> Result<Self, Error> {
        Self::load_with(found, overrides, |file| file.prove.put_stand_ins(&mut file.components))
    }

    /// Loads a scenario as far as that is possible: one with problems may lack machines and properties, and is good for
    /// its names only.
    ///
    /// # Errors
    /// As for [`load`](Self::load), if nothing could be loaded.
    pub fn load_partly(found: &Found) -> Result<(Self, Result<(), Error>), Error> {
        let (loaded, mut complaints) = Self::attempt(found, &[], |_| Ok(()))?;
        match loaded {
            Some(loaded) => Ok((loaded, complaints.check())),
            None => Err(complaints.check().expect_err("a file that could not be loaded was reported")),
        }
    }

    fn load_with(
        found: &Found,
        overrides: &[String],
        change: impl FnOnce(&mut ScenarioFile) -> Result<(), Error>,
    ) -> Result<Self, Error> {
        let (loaded, mut complaints) = Self::attempt(found, overrides, change)?;
        complaints.check()?;
        Ok(loaded.expect("a file that could not be loaded was reported"))
    }

    fn attempt(
        found: &Found,
        overrides: &[String],
        change: impl FnOnce(&mut ScenarioFile) -> Result<(), Error>,
    ) -> Result<(Option<Self>, Complaints), Error> {
        let found = &Found { files: found.files.clone().listing(), ..found.clone() };
        let assignments = overrides.iter().map(String::as_str);
        let mut file =
            ScenarioFile::parse(&found.path, &found.text, &found.files, assignments).map_err(Error::bad_input)?;
        change(&mut file)?;
        let mut found = Found { files: found.files.with_bases(&file.base_folders), ..found.clone() };
        let mut complaints = Complaints::default();
        let schedule = file.execution.schedule.clone().and_then(|path| {
            // A run with a schedule is one of a proof.
            complaints.take(file.prove.put_stand_ins(&mut file.components));
            FileReader { files: &found.files, complaints: &mut complaints }.schedule(&path)
        });
        complaints.check()?;
        if let Some(folder) = &file.folder {
            found.files = found.files.in_named_folder(folder);
            let main = &file.behavior.main_file().value;
            if found.files.read(main).is_err() {
                let problem = folder.span.problem(format!("there is no {} in this folder", main.display()));
                let help = "set the folder that contains the scenario's files with `--set folder=DIR`";
                return Err(Error::bad_input(problem.with_label("this folder").with_help(help)));
            }
        }
        let found = &found;
        let mut complaints = Complaints::default();
        let reader = FileReader { files: &found.files, complaints: &mut complaints };
        let loaded = Loader { found, overrides, reader }.load(file);
        Ok((loaded.map(|loaded| Self { schedule: schedule.map(Arc::new), ..loaded }), complaints))
    }

    /// The same with the machines of leaves that only an earlier state of the scenario has.
    #[must_use]
    pub fn with_machines_of(mut self, before: &Self) -> Self {
        let Behavior::Tree(tree) = &self.behavior else { return self };
        for leaf in tree.leaves() {
            if let Some(skill) = before.skills.get(leaf.process()) {
                self.skills.entry(leaf.process().to_owned()).or_insert_with(|| skill.clone());
            }
        }
        self
    }
}

/// The text of a property. The name is quoted if it is none in the language.
fn property(name: &str, formula: &str) -> String {
    let name = syntax::Name { text: name.to_owned(), span: syntax::ByteRange::default() };
    format!("property {name} := {formula}")
}

/// Leaves out the properties about the world, which a schedule replaces, and what is expected of them.
fn leave_out_world(file: &mut ScenarioFile, properties: &mut [(String, String)]) {
    let mut gone: Vec<String> = Vec::new();
    for (_, text) in properties {
        let parsed = syntax::parse_file(text);
        if parsed.problems.iter().any(diagnostics::Problem::is_error) {
            continue;
        }
        let (mut kept, before) = (parsed.file, gone.len());
        kept.items.retain(|item| match item {
            syntax::Item::Property(property) if is_about_world(&property.constraint) => {
                gone.push(property.name.text.clone());
                false
            }
            _ => true,
        });
        if gone.len() > before {
            *text = kept.to_string();
        }
    }
    file.monitors.retain(|entry| match &entry.kind {
        ReadyMadeKind::Zone(zone) => {
            gone.push(zone_property(entry, zone));
            false
        }
        _ => true,
    });
    file.expect.satisfied.retain(|(name, _)| !gone.contains(&name.value));
    file.expect.outcomes.retain(|(name, _)| !gone.contains(&name.value));
    for some in [&mut file.stop.on_violation, &mut file.stop.when_settled] {
        if let SomeProperties::Named(names) = some {
            names.retain(|name| !gone.contains(&name.value));
        }
    }
}

fn is_about_world(constraint: &syntax::Constraint) -> bool {
    let mut speaks = false;
    constraint.events(&mut |event| speaks |= event.source.name().is_some_and(|name| name.text == WORLD));
    speaks
}

/// The name of the property that a zone is respected.
fn zone_property(entry: &ReadyMade, zone: &Spanned<String>) -> String {
    entry.name.as_ref().map_or_else(|| format!("respects_{}", zone.value), |name| name.value.clone())
}

/// What decides in a scenario, as far as it could be loaded.
#[derive(Default)]
struct Parts {
    behavior: Option<Behavior>,
    skills: Option<BTreeMap<String, Skill>>,
    components: Option<BTreeMap<String, Component>>,
    samples: Samples,
    /// The places to which skills always drive, each with one such skill.
    driven_to: BTreeMap<String, String>,
}

impl Parts {
    fn of_model(model: &Arc<Model>) -> Self {
        let (skills, components) = model::machines(model);
        Self {
            behavior: Some(Behavior::Model(Arc::clone(model))),
            skills: Some(skills),
            components: Some(components),
            ..Self::default()
        }
    }
}

/// Loads the files that a scenario names and records their problems.
struct Loader<'a> {
    found: &'a Found,
    overrides: &'a [String],
    reader: FileReader<'a>,
}

impl Loader<'_> {
    fn load(&mut self, mut file: ScenarioFile) -> Option<Scenario> {
        // The model comes first: it sets what the scenario does not.
        let model = self.model(&mut file).ok()?;
        let floor = file.premises.as_ref().map(|entry| (self.reader.map(&entry.map), self.places(entry)));
        let places = floor.as_ref().and_then(|(_, places)| Some(places.as_ref()?.places()));
        let mut properties = self.properties(&file);
        let Parts { behavior, skills, components, samples, driven_to } = match (&model, file.behavior.files()) {
            (None, Some(files)) => self.parts(&file, files, places, &properties),
            (Some(model), _) => Parts::of_model(model),
            (None, None) => Parts::default(),
        };
        // Only now: what answers anything answers what all of them distinguish, as in the proof.
        if file.execution.schedule.is_some() {
            leave_out_world(&mut file, &mut properties);
        }
        let premises = floor.map(|(map, places)| self.premises(&file, map, places, driven_to).ok_or(Recorded));
        let machines = skills.as_ref().zip(components.as_ref());
        let machines = machines
            .map(|(skills, components)| self.reader.faulty_machines(&file, model.as_deref(), skills, components));
        self.check_fault_components(&file, components.as_ref());
        if let Some(Ok(premises)) = &premises {
            properties.extend(self.zones_respected(&file, premises));
        }
        let watching = self.watching(&file);
        let monitoring = self.monitoring(&file, model.as_ref(), &properties);
        let elsewhere = skills.as_ref().map(|skills| elsewhere::of(&file, skills, self.reader.files));
        Some(Scenario {
            name: self.found.name.clone(),
            premises: premises.transpose().ok()?,
            behavior: behavior?,
            skills: skills?,
            components: components?,
            samples,
            machines: machines?,
            properties,
            watching,
            schedule: None,
            elsewhere: elsewhere.unwrap_or_default(),
            monitoring,
            origin: self.origin(),
            file,
        })
    }

    fn origin(&self) -> Origin {
        let Found { argument, text, path, .. } = self.found.clone();
        let shipped = self.found.kind == FoundKind::Shipped;
        let own = InputFile { path: path.clone(), blake3: hash_of(text.as_bytes()), shipped };
        let taken = self.reader.files.taken().into_iter().map(|(path, taken)| {
            let path = path.display().to_string();
            (path.clone(), InputFile { path, shipped: taken.on_disk.is_none(), blake3: taken.hash })
        });
        let inputs: BTreeMap<String, InputFile> = taken.chain([(path, own)]).collect();
        let inputs = inputs.into_values().collect();
        Origin { argument, text, overrides: self.overrides.to_vec(), inputs, ..Origin::default() }
    }

    fn model(&mut self, file: &mut ScenarioFile) -> Result<Option<Arc<Model>>, Recorded> {
        let Some(entry) = file.behavior.model().cloned() else { return Ok(None) };
        self.reader.model(&entry, &mut file.execution).map(Some).ok_or(Recorded)
    }

    /// The cell for the monitors, which scenarios with the same properties share. Ready-made ones are not compared.
    fn monitoring(
        &self,
        file: &ScenarioFile,
        model: Option<&Arc<Model>>,
        properties: &[(String, String)],
    ) -> Arc<OnceLock<Arc<Monitoring>>> {
        if !file.monitors.is_empty() {
            return Arc::default();
        }
        let inputs = (model.cloned().map(Same), properties.to_vec(), file.prove.is_used());
        let make = || Ok::<_, Infallible>(Arc::default());
        let Ok(made) = self.reader.files.memo().get(Path::new(&self.found.path), inputs, make);
        made
    }

    /// Tree, skills and components from files of the scenario's own.
    fn parts(
        &mut self,
        file: &ScenarioFile,
        files: &BehaviorFiles,
        places: Option<&Places>,
        properties: &[(String, String)],
    ) -> Parts {
        let tree = self.tree(file, files);
        let skills = tree.as_ref().map(|tree| self.reader.skills(file, &files.skills.value, tree));
        let listeners = Listeners {
            tree: tree.as_deref(),
            skills: skills.as_ref(),
            properties,
            places,
            repeated: file.prove.messages.repeat.into(),
        };
        let none = Places::default();
        let (components, samples) = self.reader.components(file, places.unwrap_or(&none), &listeners).unzip();
        let are_complete = places.is_some() == file.premises.is_some();
        let driven_to = match (&tree, &skills, &components) {
            (Some(tree), Some(skills), Some(components)) if are_complete => {
                self.check_machines(tree, declaration::Parts { tree, leaves: &file.leaves, skills, components }, places)
            }
            _ => BTreeMap::new(),
        };
        let samples = samples.unwrap_or_default();
        Parts { behavior: tree.map(Behavior::Tree), skills, components, samples, driven_to }
    }

    /// Checks that skills and components fit together. Returns the places to which skills always drive, each with one
    /// such skill.
    fn check_machines(
        &mut self,
        tree: &Arc<Tree>,
        parts: declaration::Parts<'_>,
        places: Option<&Places>,
    ) -> BTreeMap<String, String> {
        let declaration::Parts { leaves, skills, components, .. } = parts;
        let tree = Same(Arc::clone(tree));
        let inputs = (tree, leaves.to_vec(), skills.clone(), components.clone(), places.cloned());
        let driven_to = self.reader.files.memo().get(Path::new(&self.found.path), inputs, || {
            let mut misfits = Complaints::default();
            let driven_to = declaration::check_machines(&parts, places, &mut misfits);
            misfits.check().map_err(|misfits| (misfits, driven_to.clone())).map(|()| driven_to)
        });
        driven_to.unwrap_or_else(|(misfits, driven_to)| {
            self.reader.complaints.take::<()>(Err(misfits));
            driven_to
        })
    }

    fn premises(
        &mut self,
        file: &ScenarioFile,
        map: Option<LoadedMap>,
        places: Option<Arc<PlacesFile>>,
        driven_to: BTreeMap<String, String>,
    ) -> Option<Premises> {
        let entry = file.premises.as_ref()?;
        // Everything is checked before the first `?`, so that all problems are reported at once.
        let poses = places
            .as_ref()
            .and_then(|places| places::check_places(file, entry, places.places(), self.reader.complaints));
        let zones = places.as_ref().map_or_else(Vec::new, |places| places.places().zones().to_vec());
        let reach = map.as_ref().and_then(|(map, _)| self.reach(entry, map, &zones));
        robot::check_lasers(&file.faults, &entry.sim.model, self.reader.complaints);
        world::check_doors(&file.faults, &entry.world, self.reader.complaints);
        let (wrong_map, wrong_concerns) = self.reader.wrong_map(file).unzip();
        if let Some((map, _)) = &map {
            world::check_world(&entry.world, map, self.reader.complaints);
        }
        let (start, station) = poses?;
        let places = places?;
        let (map, mut map_concerns) = map?;
        map_concerns.extend(wrong_concerns.into_iter().flatten());
        let premises = Premises {
            entry: entry.clone(),
            map,
            map_concerns,
            places: places.places().clone(),
            driven_to,
            written: places,
            reach: reach?,
            start,
            station,
            wrong_map,
            memo: Arc::clone(self.reader.files.memo()),
        };
        places::check_reach(file, &premises, self.reader.complaints);
        Some(premises)
    }

    fn places(&mut self, entry: &PremisesEntry) -> Option<Arc<PlacesFile>> {
        let Some(path) = &entry.places else { return Some(Arc::default()) };
        let places = self.reader.files.load(&path.value, (), |read| PlacesFile::load(&path.value, read).map(Arc::new));
        self.reader.loaded(path, FileRole::Of(Kind::Places), places)
    }

    /// The part of the map that the robot can reach without entering an area to keep out of.
    fn reach(&mut self, entry: &PremisesEntry, map: &Arc<OccupancyGrid>, zones: &[Zone]) -> Option<Arc<Reach>> {
        let model = &entry.sim.model;
        let inputs = (Same(Arc::clone(map)), model.clone(), zones.to_vec());
        let reach = self.reader.files.memo().get(&entry.map.value, inputs, || {
            let mut kept_out = zones.iter().filter(|zone| zone.keep_out).peekable();
            let closed = kept_out.peek().is_some().then(|| nav::closed_map(map, kept_out));
            Reach::new(closed.as_ref().unwrap_or(map), model).map(Arc::new)
        });
        let refused = |error: nav::Error| entry.map.span.problem(error.to_string()).with_label("this map");
        reach.map_err(|error| self.reader.complaints.push(refused(error))).ok()
    }

    fn tree(&mut self, file: &ScenarioFile, files: &BehaviorFiles) -> Option<Arc<Tree>> {
        let Spanned { value: path, span } = &files.tree;
        let text = self.reader.text(span, FileRole::Of(Kind::Tree), path)?;
        let inputs = (text.clone(), file.constants.clone());
        let loader = bt::Loader::default().constants(file.constants.iter().cloned());
        let tree = self.reader.files.memo().get(path, inputs, || loader.load(path, &text).map(Arc::new));
        self.reader.complaints.note(tree)
    }

    /// Reports faults of components that are unknown or cannot have such faults.
    fn check_fault_components<'c>(
        &mut self,
        file: &'c ScenarioFile,
        components: Option<&'c BTreeMap<String, Component>>,
    ) {
        let written = || file.components.iter().map(|component| component.name.value.as_str()).collect();
        let loaded = |components: &'c BTreeMap<_, _>| components.keys().map(String::as_str).collect();
        let own: Vec<&str> = components.map_or_else(written, loaded);
        let known = || BUILTIN.into_iter().filter(|_| file.premises.is_some()).chain(own.iter().copied());
        for fault in &file.faults {
            let effect = fault.effect();
            if let Effect::Goal(to) = &effect
                && own.contains(&NAVIGATION)
            {
                // Only the driver of the built-in component takes goals that are not messages.
                let problem = to.span.problem(format!("{NAVIGATION} is a component of this scenario"));
                let problem = problem.with_label("a goal for the built-in one");
                self.reader.complaints.push(problem.with_help("send it one of the messages that it understands"));
            }
            let Some(component) = effect.component() else { continue };
            if !known().any(|name| name == component.value) {
                self.reader.complaints.push(unknown("component", component, known()));
            } else if let Effect::Device { trouble, .. } = effect
                && !file.components.iter().any(|entry| {
                    entry.name.value == component.value && entry.device().is_some_and(|kind| trouble.can_befall(kind))
                })
            {
                let problem = format!("`{}` cannot have the fault `{}`", component.value, fault.kind().name);
                let problem = component.span.problem(problem).with_label("this component");
                self.reader.complaints.push(problem.with_help(format!("only {} can", trouble.befalls())));
            }
        }
    }

    /// The names and texts of the property files, then of the properties that the scenario itself contains.
    fn properties(&mut self, file: &ScenarioFile) -> Vec<(String, String)> {
        let read = |path: &Spanned<PathBuf>| {
            let text = self.reader.text(&path.span, FileRole::Of(Kind::Properties), &path.value)?;
            let parsed = || Ok::<_, Infallible>(Arc::new(syntax::parse_file(&text)));
            let Ok(parsed) = self.reader.files.memo().get(&path.value, text.clone(), parsed);
            let is_property = |item: &syntax::Item| matches!(item, syntax::Item::Property(_));
            // One with mistakes is reported when its properties are loaded.
            if parsed.problems.is_empty() && !parsed.file.items.iter().any(is_property) {
                let message = format!("there is no property in {}", path.value.display());
                let help = "write `property NAME := …`, or leave the file out";
                let problem = path.span.problem(message).with_label("nothing is monitored");
                self.reader.complaints.push(problem.with_help(help));
            }
            Some((path.value.display().to_string(), text))
        };
        let mut properties: Vec<(String, String)> = file.properties.iter().filter_map(read).collect();
        for (name, formula) in &file.expect.satisfied {
            let text = property(&name.value, formula);
            // Another one would be monitored, but not expected.
            if syntax::parse_file(&text).file.items.len() > 1 {
                let problem = name.span.problem(format!("`{}` is more than one formula", name.value));
                self.reader.complaints.push(problem.with_label("this property"));
            }
            properties.push((format!("expect.satisfied.{}", name.value), text));
        }
        properties
    }

    /// Properties that zones are respected: names and texts.
    fn zones_respected(&mut self, file: &ScenarioFile, premises: &Premises) -> Vec<(String, String)> {
        let mut properties = Vec::new();
        for (entry, zone) in file.monitors.iter().filter_map(|entry| Some((entry, entry.zone()?))) {
            let Some((about, formula)) = premises.respects(&zone.value) else {
                let names = premises.places.zones().iter().map(|zone| zone.name.as_str());
                self.reader.complaints.push(unknown("zone", zone, names));
                continue;
            };
            let name = zone_property(entry, zone);
            let text = format!("// {about}\n{}", property(&name, &formula));
            properties.push((format!("monitors.{name}"), text));
        }
        properties
    }

    /// The machines among the ready-made monitors.
    fn watching(&mut self, file: &ScenarioFile) -> BTreeMap<usize, Arc<Chart>> {
        let mut charts = BTreeMap::new();
        for (index, entry) in file.monitors.iter().enumerate() {
            let ReadyMadeKind::Machine(WatchingMachine { machine, .. }) = &entry.kind else { continue };
            let role = FileRole::Of(Kind::Skill);
            let Some(text) = self.reader.text(&machine.span, role, &machine.value) else { continue };
            let chart = self.reader.chart(&machine.value, &text);
            charts.extend(chart.map(|chart| (index, chart)));
        }
        charts
    }
}
