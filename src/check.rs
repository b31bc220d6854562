//! `steward check`: everything short of a run.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;

use bt::Tree;
use campaigns::{Error, Plan};
use channels::Symbol;
use clap::Args;
use interfaces::Interface;
use maps::Cell;
use miette::Diagnostic;
use runs::{Run, topology};
use scenarios::files::shipped_campaigns;
use scenarios::processes::HEARERS;
use scenarios::scenario::{Scenario, find};
use serde_json::json;
use skills::{Chart, Strictness};

use crate::counted::counted;
use crate::monitor::System;
use crate::named_files;
use crate::output::{complain, print_json, print_wrapped, warn};
use crate::render::{Finding, count, findings};
use crate::run::select;
use crate::toml_subject::Toml;

/// Help for a machine that sends to a process that no shipped system has.
const ELSEWHERE: &str =
    "a scenario defines its components; the shipped scenarios have BatteryReader, Localization and Navigation";

/// What to check.
#[derive(Debug, Args)]
pub(crate) struct CheckArgs {
    /// Scenarios, campaigns, maps, places, trees, skills, interfaces and properties: files, or names (see `steward
    /// list`)
    #[arg(value_name = "NAME|FILE", required = true)]
    files: Vec<String>,
    /// The scenario with the processes of machines, the processes and channels of property files and the places of
    /// interfaces [default: nominal]
    #[arg(long, value_name = "NAME|FILE")]
    scenario: Option<String>,
    /// Prints the findings as JSON
    #[arg(long)]
    json: bool,
}

/// The findings in a usable file.
pub(crate) struct Checked {
    /// Its kind, in a few words.
    pub(crate) summary: String,
    /// Its warnings.
    pub(crate) concerns: Vec<Box<dyn Diagnostic + Send + Sync>>,
    /// The programs that a run of it starts, each in a sentence.
    pub(crate) programs: Vec<String>,
}

impl Checked {
    /// A file without programs.
    fn of(summary: String, concerns: Vec<Box<dyn Diagnostic + Send + Sync>>) -> Self {
        Self { summary, concerns, programs: Vec::new() }
    }

    /// The summary, and whether anything looks wrong.
    pub(crate) fn words(&self) -> String {
        let found = match self.concerns.iter().map(|concern| count(concern.as_ref())).sum() {
            0 => "no problems found".to_owned(),
            count => counted(count, "warning"),
        };
        format!("{}; {found}", self.summary)
    }
}

/// Checks every file according to its kind.
pub(crate) fn check(args: &CheckArgs) -> Result<ExitCode, Error> {
    let files: Vec<Vec<String>> = args.files.iter().map(|file| meant(file)).collect::<Result<_, _>>()?;
    each(&files.concat(), args.json, |file| examine(file, args.scenario.as_deref()))
}

/// The files to which an argument refers: several for a folder or a pattern of scenarios, as in `steward run`.
fn meant(file: &str) -> Result<Vec<String>, Error> {
    let path = Path::new(file);
    let is_campaign = || find::shipped(file).is_none() && shipped_campaigns().any(|(name, _)| name == file);
    if !path.is_dir() && (path.extension().is_some() || is_campaign()) {
        return Ok(vec![file.to_owned()]);
    }
    match select::meant(file) {
        Ok(found) => Ok(found.into_iter().map(|one| one.argument).collect()),
        Err(error) if path.is_dir() => Err(error),
        // It is reported with the other files.
        Err(_) => Ok(vec![file.to_owned()]),
    }
}

/// Examines every file, and reports errors and warnings. Exit status 2 if anything is wrong.
pub(crate) fn each<F: AsRef<Path>>(
    files: &[F],
    json: bool,
    examine: impl Fn(&F) -> Result<Checked, Error>,
) -> Result<ExitCode, Error> {
    let (mut refused, mut report) = (0, Vec::new());
    for file in files {
        let checked = examine(file);
        let file = file.as_ref().display();
        refused += usize::from(checked.is_err());
        if json {
            report.push(as_json(&file.to_string(), &checked));
            continue;
        }
        let words = match &checked {
            Ok(checked) => {
                checked.concerns.iter().for_each(|concern| warn(concern.as_ref()));
                checked.words()
            }
            Err(error) => {
                complain(error);
                counted(error.diagnostics().into_iter().map(count).sum::<usize>().max(1), "problem")
            }
        };
        print_wrapped(format!("{file}: {words}\n"))?;
        for program in checked.iter().flat_map(|checked| &checked.programs) {
            print_wrapped(format!("  {program}\n"))?;
        }
    }
    if json {
        print_json(&report)?;
    } else if files.len() > 1 {
        print_wrapped(format!("{} checked, {refused} with problems\n", counted(files.len(), "file")))?;
    }
    Ok(ExitCode::from(if refused > 0 { 2 } else { 0 }))
}

fn as_json(file: &str, checked: &Result<Checked, Error>) -> serde_json::Value {
    let (summary, warnings, problems) = match checked {
        Ok(checked) => {
            let warnings: Vec<Finding> =
                checked.concerns.iter().flat_map(|concern| findings(concern.as_ref())).collect();
            (Some(&checked.summary), warnings, Vec::new())
        }
        Err(error) => (None, Vec::new(), problems(error)),
    };
    let programs = checked.as_ref().map_or(&[][..], |checked| &checked.programs);
    json!({
        "file": file, "ok": checked.is_ok(), "summary": summary, "programs": programs, "warnings": warnings,
        "problems": problems
    })
}

/// Everything that an error says.
fn problems(error: &Error) -> Vec<Finding> {
    match error.diagnostics() {
        none if none.is_empty() => vec![Finding::of_message(error.to_string())],
        diagnostics => diagnostics.into_iter().flat_map(findings).collect(),
    }
}

/// Checks a file according to its kind.
fn examine(file: &str, of: Option<&str>) -> Result<Checked, Error> {
    let path = Path::new(file);
    let scenario = of.unwrap_or("nominal");
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
    match ending.as_deref() {
        Some("xml") if find::is_model(path) => of_scenario(file),
        Some("xml") => tree(path).map(|(_, checked)| checked),
        Some("scxml") => machine(path, of).map(|(_, checked)| checked),
        Some("scope") => properties(path, scenario),
        Some("yaml" | "yml") => map(path),
        Some("ini") => places(path),
        Some("toml") => match Toml::of_file(path) {
            Toml::Campaign => campaign(path),
            Toml::Interface => interface(path, scenario),
            Toml::Places => places(path),
            Toml::Scenario => of_scenario(file),
        },
        None if find::shipped(file).is_none() && shipped_campaigns().any(|(name, _)| name == file) => campaign(path),
        None => of_scenario(file),
        Some(_) => Err(Error::refused(
            format!("{file} is not a kind of file that can be checked"),
            "scenarios, campaigns, interfaces and places (also .ini) end in .toml, maps in .yaml, trees in .xml, skills \
             in .scxml, and properties in .scope",
        )),
    }
}

/// A tree, and the findings about it.
pub(crate) fn tree(file: &Path) -> Result<(Tree, Checked), Error> {
    let tree = named_files::tree(file)?;
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
pub(crate) fn machine(file: &Path, scenario: Option<&str>) -> Result<(Arc<Chart>, Checked), Error> {
    let chart = named_files::machine(file, Strictness::Strict)?;
    let [states, transitions] = [chart.states().count(), chart.transitions().count()];
    let mut summary = format!("{}, {}", counted(states, "state"), counted(transitions, "transition"));
    let elsewhere = match scenario {
        Some(name) => {
            let scenario = Scenario::load(&find::find(name)?, &[])?;
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
        None => chart.sends_elsewhere(&HEARERS, ELSEWHERE),
    };
    let concerns = chart.concerns().into_iter().chain(elsewhere).map(|concerns| Box::new(concerns) as _).collect();
    Ok((chart, Checked::of(summary, concerns)))
}

fn properties(file: &Path, scenario: &str) -> Result<Checked, Error> {
    let properties = System::of(scenario)?.load(file)?;
    let warned = (!properties.warnings.is_empty()).then(|| Box::new(properties.warnings) as _);
    Ok(Checked::of(counted(properties.properties.len(), "property"), warned.into_iter().collect()))
}

fn map(file: &Path) -> Result<Checked, Error> {
    let map = named_files::map(file)?;
    let free = map.cells().iter().filter(|cell| **cell == Cell::Free).count();
    if free == 0 {
        let message = format!("{} contains no free cell", file.display());
        return Err(Error::refused(message, "light pixels are free floor, unless the map's `negate` says otherwise"));
    }
    let size = |cells: usize| cells as f64 * map.resolution_m();
    let share = 100.0 * free as f64 / map.cells().len() as f64;
    let summary = format!("a map of {:.1} m × {:.1} m, {share:.0} % free", size(map.width()), size(map.height()));
    Ok(Checked::of(summary, Vec::new()))
}

fn places(file: &Path) -> Result<Checked, Error> {
    let places = named_files::places(file)?;
    Ok(Checked::of(counted(places.places().iter().count(), "place"), Vec::new()))
}

fn interface(file: &Path, scenario: &str) -> Result<Checked, Error> {
    let scenario = Scenario::load(&find::find(scenario)?, &[])?;
    let places = scenario.premises.iter().flat_map(|premises| premises.places.iter());
    let places: Vec<Symbol> = places.map(|(name, _)| Symbol::new(name)).collect();
    let Interface { services, topics, actions } = named_files::interface(file, &places)?;
    let counts = [(services.len(), "service"), (topics.len(), "topic"), (actions.len(), "action")];
    let counts: Vec<String> =
        counts.into_iter().filter(|(count, _)| *count > 0).map(|(count, what)| counted(count, what)).collect();
    Ok(Checked::of(format!("an interface with {}", counts.join(", ")), Vec::new()))
}

fn campaign(file: &Path) -> Result<Checked, Error> {
    let plan = Plan::load(file)?;
    let mut checked = ready(plan.base())?;
    let runs = match plan.file().goal {
        Some(_) => format!("at most {}", counted(plan.runs(), "run")),
        None => counted(plan.runs(), "run"),
    };
    checked.summary = format!("a campaign of {runs} of a scenario with {}", checked.summary);
    Ok(checked)
}

fn of_scenario(name: &str) -> Result<Checked, Error> {
    let scenario = Arc::new(Scenario::load(&find::find(name)?, &[])?);
    let mut checked = ready(&scenario)?;
    checked.summary = format!("a scenario with {}", checked.summary);
    Ok(checked)
}

/// Sets a scenario up as for a run: the world, the processes and channels, the monitors, and the faults with their
/// triggers.
fn ready(scenario: &Arc<Scenario>) -> Result<Checked, Error> {
    let run = Run::prepare(Arc::clone(scenario), scenario.file.seed, true)?;
    let mut concerns: Vec<Box<dyn Diagnostic + Send + Sync>> = Vec::new();
    concerns.extend(scenario.model_concerns().iter().map(|concern| Box::new(concern.clone()) as _));
    let tree = scenario.tree();
    concerns.extend(tree.and_then(|tree| tree.concerns()).map(|concerns| Box::new(concerns.clone()) as _));
    concerns.extend(scenario.leaf_concerns().map(|concerns| Box::new(concerns) as _));
    // A model has already reported its own warnings.
    let own = scenario.model().is_none().then_some(());
    let machines: BTreeMap<&Path, &Arc<Chart>> =
        own.iter().flat_map(|_| scenario.skills.values()).map(|skill| (&*skill.path, &skill.machine)).collect();
    concerns.extend(machines.values().filter_map(|chart| chart.concerns()).map(|concerns| Box::new(concerns) as _));
    concerns.extend(scenario.place_concerns().into_iter().map(|concern| Box::new(concern) as _));
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
    Ok(Checked { summary: parts.join(", "), concerns, programs })
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
