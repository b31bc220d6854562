//! What is wrong with a file, and everything else short of a run: how each kind of file is checked.

use std::path::Path;
use std::sync::Arc;

use campaigns::{Error, Plan};
use channels::Symbol;
use diagnostics::{Disk, counted};
use runs::Run;
use scenarios::scenario::{Conduct, Found, Scenario, find};
use skills::Strictness;

use crate::checked::Checked;
use crate::file_kind::FileKind;
use crate::named_files;
use crate::system::{self, System};
use crate::toml_subject::Toml;

/// The result of a check.
#[derive(Debug)]
pub struct Examined {
    /// The findings, or everything that is wrong with the file.
    pub result: Result<Checked, Error>,
    /// The scenario, as far as it could be loaded; that of a campaign with which nothing is wrong.
    pub scenario: Option<Arc<Scenario>>,
    /// What a mapping describes, or the system that was named for properties.
    pub system: Option<System>,
}

impl<E: Into<Error>> From<Result<Checked, E>> for Examined {
    fn from(result: Result<Checked, E>) -> Self {
        Self { result: result.map_err(Into::into), scenario: None, system: None }
    }
}

impl<E: Into<Error>> From<(Result<Checked, E>, Option<System>)> for Examined {
    fn from((result, system): (Result<Checked, E>, Option<System>)) -> Self {
        Self { result: result.map_err(Into::into), scenario: None, system }
    }
}

impl FileKind {
    /// Checks a file of this kind. `of` is the scenario to which a machine, properties or an interface belong, or the
    /// mapping of properties. Without it, properties and interfaces belong to `nominal`.
    #[must_use]
    pub fn examine(self, disk: &Disk, file: &Path, of: Option<&str>) -> Examined {
        match self {
            Self::Tree => named_files::check_tree(disk, file).into(),
            Self::Machine => named_files::check_machine(disk, file, of).into(),
            Self::Properties => system::check_properties(disk, file, of).into(),
            Self::Map => named_files::check_map(disk, file).into(),
            Self::PlacesIni | Self::Toml(Toml::Places) => named_files::check_places(disk, file).into(),
            Self::Toml(Toml::Interface) => named_files::check_interface(disk, file, of).into(),
            Self::Toml(Toml::Mapping) => system::check_mapping(disk, file).into(),
            Self::Toml(Toml::Campaign) => check_campaign(disk, file),
            Self::Model | Self::Toml(Toml::Scenario) => check_scenario(disk, file),
        }
    }

    /// Checks a file that belongs to a scenario, without one.
    ///
    /// # Errors
    /// Everything that is wrong with it in any scenario.
    pub fn examine_alone(self, disk: &Disk, file: &Path) -> Result<Checked, Error> {
        match self {
            Self::Machine => drop(named_files::machine(disk, file, Strictness::Strict)?),
            Self::Properties => {
                let text = disk.read_text(file).unwrap_or_default();
                monitors::check(&file.display().to_string(), &text).map_err(Error::bad_input)?;
            }
            // There may be any place.
            Self::Toml(Toml::Interface) => drop(named_files::interface(disk, file, &[Symbol::new("place")])?),
            _ => {}
        }
        Ok(Checked::default())
    }
}

/// Checks a file on this disk according to its kind, as [`FileKind::examine`] does.
///
/// # Errors
/// Everything that is wrong with it.
pub fn examine(disk: &Disk, file: &str, of: Option<&str>) -> Result<Checked, Error> {
    let path = Path::new(file);
    match FileKind::of(disk, path) {
        Some(kind) => kind.examine(disk, path, of).result,
        None => Err(Error::refused(
            format!("{file} is not a kind of file that can be checked"),
            "scenarios, campaigns, interfaces, mappings and places (also .ini) end in .toml, maps in .yaml, trees in .xml, \
             skills in .scxml, and properties in .scope",
        )),
    }
}

fn check_campaign(disk: &Disk, file: &Path) -> Examined {
    let mut scenario = None;
    let result = Plan::load_on(disk, file).and_then(|plan| {
        let mut checked = ready(plan.base())?;
        let runs = match plan.file().goal {
            Some(_) => format!("at most {}", counted(plan.runs(), "run")),
            None => counted(plan.runs(), "run"),
        };
        checked.summary = format!("a campaign of {runs} of a scenario with {}", checked.summary);
        scenario = Some(Arc::clone(plan.base()));
        Ok(checked)
    });
    Examined { scenario, ..result.into() }
}

fn check_scenario(disk: &Disk, file: &Path) -> Examined {
    let loaded =
        find::find_on(disk, &file.to_string_lossy()).and_then(|found| Ok((Scenario::load_partly(&found)?, found)));
    let (scenario, result, found) = match loaded {
        Ok(((scenario, result), found)) => (Arc::new(scenario), result, found),
        Err(error) => return Err::<Checked, _>(error).into(),
    };
    let checked = result.map_err(Error::from).and_then(|()| ready(&scenario));
    let checked = checked.and_then(|checked| with_stand_ins(checked, &scenario, &found));
    let with_kind = |checked: Checked| Checked { summary: format!("a scenario with {}", checked.summary), ..checked };
    Examined { scenario: Some(scenario), ..checked.map(with_kind).into() }
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
    Ok(Checked { summary, concerns, programs, elsewhere })
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
