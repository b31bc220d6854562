//! Files named on the command line: on disk, or among those that come with the program. How each kind is read, and
//! then checked.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use bt::{Loader, Tree};
use channels::Symbol;
use diagnostics::{Disk, Problem, counted};
use interfaces::Interface;
use maps::{Cell, OccupancyGrid, PlacesFile};
use runs::topology;
use scenarios::Error;
use scenarios::files::{Files, Kind};
use scenarios::processes::RECEIVERS;
use scenarios::scenario::{Scenario, find};
use skills::{Chart, Strictness};

use crate::checked::Checked;

/// Help for a machine that sends to a process that no shipped system has.
const ELSEWHERE: &str =
    "a scenario defines its components; the shipped scenarios have BatteryReader, Localization and Navigation";

/// Where they are looked up by their paths: in the current folder of this disk, then among the shipped files.
pub(crate) fn files(disk: &Disk) -> Files {
    Files::beside("").on(disk)
}

/// Where an argument and what it names are looked up: a name means the shipped file, whatever the current folder has.
fn files_of(disk: &Disk, kind: Kind, argument: &Path) -> Files {
    if kind.named(argument, disk).is_some() { Files::shipped() } else { files(disk) }
}

/// The path to which an argument refers, and the text of the file.
///
/// # Errors
/// If it cannot be read, with the names of the shipped files.
pub fn read(disk: &Disk, kind: Kind, argument: &Path) -> Result<(PathBuf, String), Error> {
    let path = kind.path(argument, disk);
    let text = files_of(disk, kind, argument).read_text(&path).map_err(|error| {
        let name = argument.display().to_string();
        let meant = diagnostics::did_you_mean(&name, kind.names()).map_or_else(String::new, |meant| meant + " Or ");
        let names: Vec<&str> = kind.names().filter(|name| !name.contains('/')).collect();
        let help = format!("{meant}give the path of a file, or the name of a shipped one: {}", names.join(", "));
        Error::refused(format!("cannot read {} {name}: {error}", what(kind)), help)
    })?;
    Ok((path, text))
}

fn what(kind: Kind) -> &'static str {
    match kind {
        Kind::Tree => "the tree",
        Kind::Skill => "the machine",
        Kind::Properties => "the properties",
        Kind::Map => "the map",
        Kind::Places => "the places",
    }
}

/// Loads a tree with the files that it includes.
///
/// # Errors
/// Everything that is wrong with it.
pub fn tree(disk: &Disk, argument: &Path) -> Result<Tree, Error> {
    tree_with(disk, argument, [], [])
}

/// The same; leaves with these IDs need not be declared in it, and its scripts may use these names for numbers.
///
/// # Errors
/// The same.
pub fn tree_with(
    disk: &Disk,
    argument: &Path,
    leaves: impl IntoIterator<Item = String>,
    constants: impl IntoIterator<Item = (String, i64)>,
) -> Result<Tree, Error> {
    let (path, text) = read(disk, Kind::Tree, argument)?;
    let loader = Loader::default().leaves(leaves).constants(constants);
    let files = files_of(disk, Kind::Tree, argument);
    loader.load_with(path, &text, |path| files.read_text(path)).map_err(Error::bad_input)
}

pub(crate) fn check_tree(disk: &Disk, file: &Path) -> Result<Checked, Error> {
    let tree = tree(disk, file)?;
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
    Ok(Checked::of(summary, tree.concerns().into_iter().cloned()))
}

/// Loads a machine.
///
/// # Errors
/// Everything that is wrong with it.
pub fn machine(disk: &Disk, argument: &Path, strictness: Strictness) -> Result<Arc<Chart>, Error> {
    let (path, text) = read(disk, Kind::Skill, argument)?;
    let chart = match files_of(disk, Kind::Skill, argument).on_disk(&path) {
        // It may name files beside it.
        Some(path) => Chart::open_on(disk, &path, strictness),
        None => Chart::load_with(&path.to_string_lossy(), &text, strictness),
    };
    chart.map_err(Error::bad_input)
}

/// Checks a machine. It may send to the processes of the scenario or, without one, to those of the shipped scenarios.
pub(crate) fn check_machine(disk: &Disk, file: &Path, scenario: Option<&str>) -> Result<Checked, Error> {
    let chart = machine(disk, file, Strictness::Strict)?;
    let [states, transitions] = [chart.states().count(), chart.transitions().count()];
    let mut summary = format!("{}, {}", counted(states, "state"), counted(transitions, "transition"));
    let elsewhere = match scenario {
        Some(name) => {
            let scenario = Scenario::load(&find::find_on(disk, name)?, &[])?;
            let is_used = scenario.charts().any(|known| known.file().text() == chart.file().text());
            // The machines of a scenario fit together or not; one that is none of them has no part in that.
            let topology = match topology(&scenario) {
                Err(misfit) if is_used => return Err(misfit),
                topology => topology.ok(),
            };
            if !is_used {
                summary = format!("{summary}; {name} does not use it, so it was checked alone");
            }
            topology.and_then(|topology| {
                let receivers = topology.processes().filter(|process| !topology.is_outside(*process));
                let receivers: Vec<&str> = receivers.map(|process| topology.name(process)).collect();
                chart.sends_elsewhere(&receivers, &format!("{name} has {}", receivers.join(", ")))
            })
        }
        None => {
            summary += ", not compared with the messages of a scenario";
            chart.sends_elsewhere(&RECEIVERS, ELSEWHERE)
        }
    };
    Ok(Checked::of(summary, chart.concerns().into_iter().chain(chart.answer_concerns(true)).chain(elsewhere)))
}

/// Loads a map, with the warnings about it.
///
/// # Errors
/// Everything that is wrong with it.
pub fn map(disk: &Disk, argument: &Path) -> Result<(OccupancyGrid, Vec<Problem>), Error> {
    let (path, _) = read(disk, Kind::Map, argument)?;
    let files = files_of(disk, Kind::Map, argument);
    maps::load_map_with_concerns(&path, &|path: &Path| files.read(path)).map_err(Error::bad_input)
}

pub(crate) fn check_map(disk: &Disk, file: &Path) -> Result<Checked, Error> {
    let (map, concerns) = map(disk, file)?;
    let free = map.cells().iter().filter(|cell| **cell == Cell::Free).count();
    if free == 0 {
        let message = format!("{} contains no free cell", file.display());
        return Err(Error::refused(message, "light pixels are free floor, unless the map sets `negate`"));
    }
    let size = |cells: usize| cells as f64 * map.resolution_m();
    let share = 100.0 * free as f64 / map.cells().len() as f64;
    let summary = format!("a map of {:.1} m × {:.1} m, {share:.0} % free", size(map.width()), size(map.height()));
    Ok(Checked::of(summary, concerns))
}

pub(crate) fn check_places(disk: &Disk, argument: &Path) -> Result<Checked, Error> {
    let (path, _) = read(disk, Kind::Places, argument)?;
    let files = files_of(disk, Kind::Places, argument);
    let places = PlacesFile::load(&path, &|path: &Path| files.read(path)).map_err(Error::bad_input)?;
    Ok(Checked::of(counted(places.places().iter().count(), "place"), places.concerns().iter().cloned()))
}

/// Loads an interface, in which fields of the kind `place` take these places.
pub(crate) fn interface(disk: &Disk, path: &Path, places: &[Symbol]) -> Result<Interface, Error> {
    Interface::load(path, places, &|path: &Path| files(disk).read(path)).map_err(Error::bad_input)
}

pub(crate) fn check_interface(disk: &Disk, file: &Path, scenario: Option<&str>) -> Result<Checked, Error> {
    let scenario = Scenario::load(&find::find_on(disk, scenario.unwrap_or("nominal"))?, &[])?;
    let places = scenario.premises.iter().flat_map(|premises| premises.places.iter());
    let places: Vec<Symbol> = places.map(|(name, _)| Symbol::new(name)).collect();
    let Interface { services, topics, actions } = interface(disk, file, &places)?;
    let counts = [(services.len(), "service"), (topics.len(), "topic"), (actions.len(), "action")];
    let counts: Vec<String> =
        counts.into_iter().filter(|(count, _)| *count > 0).map(|(count, what)| counted(count, what)).collect();
    Ok(Checked { summary: format!("an interface with {}", counts.join(", ")), ..Checked::default() })
}
