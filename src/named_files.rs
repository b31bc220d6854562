//! Files named on the command line: on disk, or among those that come with the program.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use bt::{Loader, Tree};
use channels::Symbol;
use interfaces::Interface;
use maps::{OccupancyGrid, PlacesFile};
use scenarios::Error;
use scenarios::files::{Files, Kind};
use skills::{Chart, Strictness};

/// Where they are all looked up: in the current folder, then among the shipped files.
fn files() -> Files {
    Files::beside("")
}

/// The text of a file, or nothing if it cannot be read.
pub(crate) fn text(path: &Path) -> Option<String> {
    files().read_text(path).ok()
}

/// The path to which an argument refers, and the text of the file.
pub(crate) fn read(kind: Kind, argument: &Path) -> Result<(PathBuf, String), Error> {
    let path = kind.path(argument);
    let text = files().read_text(&path).map_err(|error| {
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
pub(crate) fn tree(argument: &Path) -> Result<Tree, Error> {
    let (path, text) = read(Kind::Tree, argument)?;
    Loader::default().load_with(path, &text, |path| files().read_text(path)).map_err(Error::bad_input)
}

/// Loads a machine.
pub(crate) fn machine(argument: &Path, strictness: Strictness) -> Result<Arc<Chart>, Error> {
    let (path, text) = read(Kind::Skill, argument)?;
    let chart = match files().on_disk(&path) {
        // It may name files beside it.
        Some(path) => Chart::open(&path, strictness),
        None => Chart::load_with(&path.to_string_lossy(), &text, strictness),
    };
    chart.map_err(Error::bad_input)
}

/// Loads a map.
pub(crate) fn map(argument: &Path) -> Result<OccupancyGrid, Error> {
    let (path, _) = read(Kind::Map, argument)?;
    maps::load_map(&path, &|path: &Path| files().read(path)).map_err(Error::bad_input)
}

/// Loads places.
pub(crate) fn places(argument: &Path) -> Result<PlacesFile, Error> {
    let (path, _) = read(Kind::Places, argument)?;
    PlacesFile::load(&path, &|path: &Path| files().read(path)).map_err(Error::bad_input)
}

/// Loads an interface, in which fields of the kind `place` take these places.
pub(crate) fn interface(path: &Path, places: &[Symbol]) -> Result<Interface, Error> {
    Interface::load(path, places, &|path: &Path| files().read(path)).map_err(Error::bad_input)
}
