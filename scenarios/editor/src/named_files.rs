//! Files named on the command line: on disk, or among those that come with the program.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use bags::{Described, Mapping};
use bt::{Loader, Tree};
use channels::Symbol;
use diagnostics::{Disk, Problem};
use interfaces::Interface;
use maps::{OccupancyGrid, PlacesFile};
use scenarios::Error;
use scenarios::files::{Files, Kind};
use skills::{Chart, Strictness};

/// Where they are looked up by their paths: in the current folder of this disk, then among the shipped files.
fn files(disk: &Disk) -> Files {
    Files::beside("").on(disk)
}

/// Where an argument and what it names are looked up: a name means the shipped file, whatever the current folder has.
fn files_of(disk: &Disk, kind: Kind, argument: &Path) -> Files {
    if kind.named(argument, disk).is_some() { Files::shipped() } else { files(disk) }
}

/// The text of a file, or nothing if it cannot be read.
pub(crate) fn text(disk: &Disk, path: &Path) -> Option<String> {
    files(disk).read_text(path).ok()
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

/// The same; leaves with these IDs need not be declared in it, and its scripts know these names for numbers.
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

/// Loads a map, with the warnings about it.
///
/// # Errors
/// Everything that is wrong with it.
pub fn map(disk: &Disk, argument: &Path) -> Result<(OccupancyGrid, Vec<Problem>), Error> {
    let (path, _) = read(disk, Kind::Map, argument)?;
    let files = files_of(disk, Kind::Map, argument);
    maps::load_map_with_concerns(&path, &|path: &Path| files.read(path)).map_err(Error::bad_input)
}

/// Loads places.
///
/// # Errors
/// Everything that is wrong with them.
pub fn places(disk: &Disk, argument: &Path) -> Result<PlacesFile, Error> {
    let (path, _) = read(disk, Kind::Places, argument)?;
    let files = files_of(disk, Kind::Places, argument);
    PlacesFile::load(&path, &|path: &Path| files.read(path)).map_err(Error::bad_input)
}

/// Loads a mapping, and what is known of it without a bag or a robot.
///
/// # Errors
/// Everything that is wrong with it.
pub fn mapping(disk: &Disk, path: &Path) -> Result<(Mapping, Described), Error> {
    let read = |path: &Path| files(disk).read(path);
    let mapping = Mapping::load(path, &read).map_err(Error::bad_input)?;
    let described = mapping.describe(&read).map_err(Error::bad_input)?;
    Ok((mapping, described))
}

/// Loads an interface, in which fields of the kind `place` take these places.
///
/// # Errors
/// Everything that is wrong with it.
pub fn interface(disk: &Disk, path: &Path, places: &[Symbol]) -> Result<Interface, Error> {
    Interface::load(path, places, &|path: &Path| files(disk).read(path)).map_err(Error::bad_input)
}
