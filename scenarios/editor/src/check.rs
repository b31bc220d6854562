//! What is wrong with a file, and everything else short of a run.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;

use bags::Described;
use bt::Tree;
use campaigns::{Error, Plan};
use channels::Symbol;
use diagnostics::{Disk, counted, parts};
use interfaces::Interface;
use maps::Cell;
use miette::Diagnostic;
use runs::{Run, topology};
use scenarios::processes::HEARERS;
use scenarios::scenario::{Conduct, Found, Scenario, find};
use skills::{Chart, Strictness};

use crate::file_kind::FileKind;
use crate::named_files;
use crate::system::System;
use crate::toml_subject::Toml;

/// Help for a machine that sends to a process that no shipped system has.
const ELSEWHERE: &str =
    "a scenario defines its components; the shipped scenarios have BatteryReader, Localization and Navigation";

/// The findings in a usable file.
#[derive(Debug)]
pub struct Checked {
    /// Its kind, in a few words.
    pub summary: String,
    /// Its warnings.
    pub concerns: Vec<Box<dyn Diagnostic + Send + Sync>>,
    /// The programs that a run of it starts, each in a sentence.
    pub programs: Vec<String>,
    /// The files that it takes from elsewhere, in sentences.
    pub elsewhere: Vec<String>,
    /// The scenario, if it is one or needs one.
    pub scenario: Option<Arc<Scenario>>,
}

impl Checked {
    /// A file without programs.
    fn of(summary: String, concerns: Vec<Box<dyn Diagnostic + Send + Sync>>) -> Self {
        Self { summary, concerns, programs: Vec::new(), elsewhere: Vec::new(), scenario: None }
    }

    /// The summary, and whether anything looks wrong.
    #[must_use]
    pub fn words(&self) -> String {
        let found = match self.concerns.iter().map(|concern| parts(concern.as_ref()).len()).sum() {
            0 => "no problems found".to_owned(),
            count => counted(count, "warning"),
        };
        format!("{}; {found}", self.summary)
    }
}

/// Checks a file on this disk according to its kind. `of` is the scenario to which a machine, properties or an
/// interface belong; properties may belong to a mapping.
///
/// # Errors
/// Everything that is wrong with it.
pub fn examine(disk: &Disk, file: &str, of: Option<&str>) -> Result<Checked, Error> {
    let path = Path::new(file);
    let scenario = of.unwrap_or("nominal");
    match FileKind::of(disk, path) {
        Some(FileKind::Tree) => tree(disk, path).map(|(_, checked)| checked),
        Some(FileKind::Machine) => machine(disk, path, of).map(|(_, checked)| checked),
        Some(FileKind::Properties) => properties(disk, path, scenario),
        Some(FileKind::Map) => map(disk, path),
        Some(FileKind::PlacesIni | FileKind::Toml(Toml::Places)) => places(disk, path),
        Some(FileKind::Toml(Toml::Campaign)) => campaign(disk, path),
        Some(FileKind::Toml(Toml::Mapping)) => mapping(disk, path),
        Some(FileKind::Toml(Toml::Interface)) => interface(disk, path, scenario),
        Some(FileKind::Model | FileKind::Toml(Toml::Scenario)) => examine_scenario(disk, file).0,
        None => Err(Error::refused(
            format!("{file} is not a kind of file that can be checked"),
            "scenarios, campaigns, interfaces, mappings and places (also .ini) end in .toml, maps in .yaml, trees in .xml, \
             skills in .scxml, and properties in .scope",
        )),
    }
}

/// Checks a file whose meaning depends on a scenario, without one.
///
/// # Errors
/// Everything that is wrong with it in any scenario.
pub(crate) fn examine_text(disk: &Disk, path: &Path) -> Result<Checked, Error> {
    match FileKind::of(disk, path) {
        Some(FileKind::Machine) => drop(named_files::machine(disk, path, Strictness::Strict)?),
        Some(FileKind::Properties) => {
            let text = disk.read_text(path).unwrap_or_default();
            monitors::check(&path.display().to_string(), &text).map_err(Error::bad_input)?;
        }
        // There may be any place.
        Some(FileKind::Toml(Toml::Interface)) => drop(named_files::interface(disk, path, &[Symbol::new("place")])?),
        _ => {}
    }
    Ok(Checked::of(String::new(), Vec::new()))
}

/// A tree, and the findings about it.
///
/// # Errors
/// Everything that is wrong with it.
pub fn tree(disk: &Disk, file: &Path) -> Result<(Tree, Checked), Error> {
    let tree = named_files::tree(disk, file)?;
    let of_nav2 = match tree.leaves_of_nav2().count() {
        0 => String::new(),
        count => format!(" ({count} declared by Nav2's model)"),
    };
    let summary = format!(
        "{}, {} of them {}{of_nav2}",
        counted(tree.nodes().len(), "node"),
        tree.leaves().count(),
        if tree.leaves().count() == 1 { "a leaf" } else { "leaves" }
    );
    let concerns = tree.concerns().into_iter().map(|concerns| Box::new(concerns.clone()) as _).collect();
    Ok((tree, Checked::of(summary, concerns)))
}

/// A machine, and the findings about it. It may send to the processes of the scenario or, without one, to those of the
/// shipped scenarios.
///
/// # Errors
/// Everything that is wrong with it.
pub fn machine(disk: &Disk, file: &Path, scenario: Option<&str>) -> Result<(Arc<Chart>, Checked), Error> {
    let chart = named_files::machine(disk, file, Strictness::Strict)?;
    let [states, transitions] = [chart.states().count(), chart.transitions().count()];
    let mut summary = format!("{}, {}", counted(states, "state"), counted(transitions, "transition"));
    let elsewhere = match scenario {
        Some(name) => {
            let scenario = Scenario::load(&find::find_on(disk, name)?, &[])?;
            let is_used = scenario.charts().any(|known| known.file().text() == chart.file().text());
            // The machines of a scenario fit together or not; one that is none of them has no part in that.
            let topology = match topology(&scenario) {
                Err(misfit) if is_used => return Err(misfit.into()),
                topology => topology.ok(),
            };
            if !is_used {
                summary = format!("{summary}; {name} does not use it, so it was checked alone");
            }
            topology.and_then(|topology| {
                let hearers = topology.processes().filter(|process| !topology.is_outside(*process));
                let hearers: Vec<&str> = hearers.map(|process| topology.name(process)).collect();
                chart.sends_elsewhere(&hearers, &format!("{name} has {}", hearers.join(", ")))
            })
        }
        None => {
            summary += ", not compared with the messages of a scenario";
            chart.sends_elsewhere(&HEARERS, ELSEWHERE)
        }
    };
    let concerns = chart.concerns().into_iter().chain(chart.answer_concerns(true)).chain(elsewhere);
    let concerns = concerns.map(|concerns| Box::new(concerns) as _).collect();
    Ok((chart, Checked::of(summary, concerns)))
}

fn properties(disk: &Disk, file: &Path, subject: &str) -> Result<Checked, Error> {
    let properties = System::on(disk, subject)?.load(file)?;
    let warned = (!properties.warnings.is_empty()).then(|| Box::new(properties.warnings) as _);
    Ok(Checked::of(counted(properties.properties.len(), "property"), warned.into_iter().collect()))
}

fn map(disk: &Disk, file: &Path) -> Result<Checked, Error> {
    let (map, concerns) = named_files::map(disk, file)?;
    let free = map.cells().iter().filter(|cell| **cell == Cell::Free).count();
    if free == 0 {
        let message = format!("{} contains no free cell", file.display());
        return Err(Error::refused(message, "light pixels are free floor, unless the map's `negate` says otherwise"));
    }
    let size = |cells: usize| cells as f64 * map.resolution_m();
    let share = 100.0 * free as f64 / map.cells().len() as f64;
    let summary = format!("a map of {:.1} m × {:.1} m, {share:.0} % free", size(map.width()), size(map.height()));
    Ok(Checked::of(summary, concerns.into_iter().map(|concern| Box::new(concern) as _).collect()))
}

fn places(disk: &Disk, file: &Path) -> Result<Checked, Error> {
    let places = named_files::places(disk, file)?;
    let concerns = places.concerns().iter().map(|concern| Box::new(concern.clone()) as _);
    Ok(Checked::of(counted(places.places().iter().count(), "place"), concerns.collect()))
}

fn mapping(disk: &Disk, file: &Path) -> Result<Checked, Error> {
    let (mapping, Described { open, misspelled, .. }) = named_files::mapping(disk, file)?;
    let topics: BTreeSet<&str> = mapping.topics().collect();
    let mut summary = format!("a mapping of {}", counted(topics.len(), "topic"));
    if !open.is_empty() {
        let open = open.into_iter().collect::<Vec<_>>().join(" and ");
        summary += &format!(", without the types of {open}, which only a bag or a robot tells");
    }
    Ok(Checked::of(summary, misspelled.into_iter().map(|problem| Box::new(problem) as _).collect()))
}

fn interface(disk: &Disk, file: &Path, scenario: &str) -> Result<Checked, Error> {
    let scenario = Scenario::load(&find::find_on(disk, scenario)?, &[])?;
    let places = scenario.premises.iter().flat_map(|premises| premises.places.iter());
    let places: Vec<Symbol> = places.map(|(name, _)| Symbol::new(name)).collect();
    let Interface { services, topics, actions } = named_files::interface(disk, file, &places)?;
    let counts = [(services.len(), "service"), (topics.len(), "topic"), (actions.len(), "action")];
    let counts: Vec<String> =
        counts.into_iter().filter(|(count, _)| *count > 0).map(|(count, what)| counted(count, what)).collect();
    Ok(Checked::of(format!("an interface with {}", counts.join(", ")), Vec::new()))
}

fn campaign(disk: &Disk, file: &Path) -> Result<Checked, Error> {
    let plan = Plan::load_on(disk, file)?;
    let mut checked = ready(plan.base())?;
    let runs = match plan.file().goal {
        Some(_) => format!("at most {}", counted(plan.runs(), "run")),
        None => counted(plan.runs(), "run"),
    };
    checked.summary = format!("a campaign of {runs} of a scenario with {}", checked.summary);
    Ok(checked)
}

/// Checks a scenario. With the scenario, as far as it could be loaded.
pub(crate) fn examine_scenario(disk: &Disk, name: &str) -> (Result<Checked, Error>, Option<Arc<Scenario>>) {
    let loaded = find::find_on(disk, name).and_then(|found| Ok((Scenario::load_partly(&found)?, found)));
    let (scenario, result, found) = match loaded {
        Ok(((scenario, result), found)) => (Arc::new(scenario), result, found),
        Err(error) => return (Err(error.into()), None),
    };
    let checked = result.map_err(Error::from).and_then(|()| ready(&scenario));
    let checked = checked.and_then(|checked| with_stand_ins(checked, &scenario, &found));
    let with_kind = |checked: Checked| Checked { summary: format!("a scenario with {}", checked.summary), ..checked };
    (checked.map(with_kind), Some(scenario))
}

/// Adds the findings about the machines that take the place of components in a proof.
fn with_stand_ins(mut checked: Checked, scenario: &Scenario, found: &Found) -> Result<Checked, Error> {
    let stand_ins = &scenario.file.prove.components;
    if stand_ins.is_empty() {
        return Ok(checked);
    }
    let in_proof = Scenario::load_for_proof(found, &[])?;
    let named = stand_ins.iter().filter(|stand_in| matches!(stand_in.conduct, Conduct::Machine(_)));
    let machines = named.filter_map(|stand_in| in_proof.components.get(&stand_in.component.value)?.machine());
    let concerns = machines.filter_map(|skill| skill.machine.concerns());
    checked.concerns.extend(concerns.map(|concerns| Box::new(concerns) as _));
    Ok(checked)
}

/// Sets a scenario up as for a run: the world, the processes and channels, the monitors, and the faults with their
/// triggers.
fn ready(scenario: &Arc<Scenario>) -> Result<Checked, Error> {
    let run = Run::prepare(Arc::clone(scenario), scenario.file.seed, true)?;
    let mut concerns = scenario.concerns();
    let tree = scenario.tree();
    concerns.extend(scenario.machine_concerns().into_iter().map(|concerns| Box::new(concerns) as _));
    concerns.extend(scenario.doubts().into_iter().map(|doubt| Box::new(doubt) as _));
    concerns.extend(run.warnings().iter().map(|warnings| Box::new(warnings.clone()) as _));
    let mut parts = match scenario.model() {
        Some(_) => vec![format!("a RoAML model of {}", counted(scenario.machine_processes().count(), "machine"))],
        None => vec![counted(tree.map_or(0, |tree| tree.leaves().count()), "leaf")],
    };
    // A model's components are its machines; those of the robot are built in.
    let components = if scenario.model().is_some() { 0 } else { scenario.components.len() };
    parts.extend((components > 0).then(|| counted(components, "component")));
    parts.extend(scenario.premises.as_ref().map(|premises| counted(premises.places.iter().count(), "place")));
    parts.push(counted(run.properties().count(), "property"));
    parts.push(counted(scenario.file.faults.len(), "fault"));
    let programs = programs(scenario).map(|program| format!("a run starts {program}")).collect();
    let (summary, elsewhere) = (parts.join(", "), scenario.elsewhere_in_words());
    Ok(Checked { summary, concerns, programs, elsewhere, scenario: Some(Arc::clone(scenario)) })
}

/// The programs that a run of this scenario starts, in words.
fn programs(scenario: &Scenario) -> impl Iterator<Item = String> {
    scenario.programs().map(|(component, program)| {
        let place = match program.folder() {
            Some(folder) if folder == Path::new(".") => "in this folder".to_owned(),
            Some(folder) => format!("in {}", folder.display()),
            None => "in a temporary folder".to_owned(),
        };
        format!("`{program}` {place}, for {component}")
    })
}
