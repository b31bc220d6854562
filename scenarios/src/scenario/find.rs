//! Turns a command-line argument into a scenario's text.

use std::path::{Path, PathBuf};

use diagnostics::Disk;

use super::schedule::quoted;
use crate::Error;
use crate::files::{Files, scenario_names, shipped_paths, shipped_scenarios};

/// A scenario's text, and where its other files are looked up.
#[derive(Clone, Debug)]
pub struct Found {
    /// The scenario's name: its file's name, without folder and extension.
    pub name: String,
    /// Its name on the command line: the name of a shipped scenario, or otherwise its path.
    pub argument: String,
    /// What it is.
    pub kind: FoundKind,
    /// The file's name in diagnostics.
    pub path: String,
    /// The text.
    pub text: String,
    /// Where the files that it names are looked up.
    pub files: Files,
}

/// What a command-line argument names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FoundKind {
    /// A scenario that comes with steward.
    Shipped,
    /// A scenario file on disk.
    OnDisk,
    /// The main file of a RoAML model, which has no scenario file.
    Model,
}

/// Finds a scenario by name or path.
///
/// # Errors
/// If there is no such scenario (with the nearest name), or its file cannot be read.
pub fn find(scenario: &str) -> Result<Found, Error> {
    find_on(&Disk::default(), scenario)
}

/// Finds a scenario by name, or by path on this disk.
///
/// # Errors
/// As for [`find`].
pub fn find_on(disk: &Disk, scenario: &str) -> Result<Found, Error> {
    let path = Path::new(scenario);
    let is_path = path.extension().is_some() || path.components().count() > 1 || disk.is_file(path);
    let name = name_of(scenario).filter(|_| !disk.exists(path)).unwrap_or(scenario);
    let found = if is_path && shipped(name).is_none() { by_path(disk, path) } else { by_name(name) }?;
    Ok(Found { files: found.files.on(disk), ..found })
}

/// The name of the shipped scenario with this path.
pub(super) fn name_of(path: &str) -> Option<&str> {
    path.strip_prefix("scenarios/")?.strip_suffix(".toml")
}

/// The path of the shipped scenario with this name, if there is one.
#[must_use]
pub fn shipped(name: &str) -> Option<&'static str> {
    let wanted = format!("scenarios/{name}.toml");
    shipped_paths().find(|path| *path == wanted)
}

/// Finds these files themselves, and those that they name, by their names in diagnostics: beside the file that names
/// them, or in the current folder; `None` for those that come with the program.
pub fn on_disk<S: AsRef<str>>(files: &[S]) -> impl Fn(&str) -> Option<String> + use<S> {
    let given: Vec<String> = files.iter().map(|file| file.as_ref().to_owned()).collect();
    move |name| {
        // So a path of `--set` is written, which is relative to the current folder.
        if name.starts_with("./") && Path::new(name).is_file() && !given.iter().any(|file| file == name) {
            return Some(name.to_owned());
        }
        let on_disk = || given.iter().filter(|file| shipped(file).is_none()).map(Path::new);
        let itself = on_disk().filter(|file| *file == Path::new(name)).map(Path::to_owned);
        let beside = on_disk().filter_map(|file| Some(file.parent()?.join(name)));
        let found = itself.chain(beside).find(|path| path.is_file()).map(|path| path.display().to_string());
        let here = || shipped_paths().all(|shipped| shipped != name) && Path::new(name).exists();
        found.or_else(|| here().then(|| name.to_owned()))
    }
}

fn by_name(name: &str) -> Result<Found, Error> {
    let path = shipped(name).ok_or_else(|| unknown(name))?;
    let files = Files::shipped();
    let text = files.read_text(Path::new(path)).map_err(|_| unknown(name))?;
    let kind = FoundKind::Shipped;
    Ok(Found { name: name.to_owned(), argument: name.to_owned(), kind, path: path.to_owned(), text, files })
}

fn by_path(disk: &Disk, path: &Path) -> Result<Found, Error> {
    let text = disk.read_text(path).map_err(|error| {
        let message = format!("cannot read the scenario {}: {error}", path.display());
        Error::refused(message, help(path, "a scenario is a TOML file, or one of", ""))
    })?;
    if is_model(path, &text) {
        return Ok(of_model(path));
    }
    let folder = path.parent().map_or_else(PathBuf::new, Path::to_owned);
    let folder = if folder.as_os_str().is_empty() { PathBuf::from(".") } else { folder };
    let name = path.file_stem().map_or_else(|| "scenario".into(), |stem| stem.to_string_lossy());
    let argument = path.display().to_string();
    let (name, kind, files) = (name.into_owned(), FoundKind::OnDisk, Files::beside(folder));
    Ok(Found { name, kind, path: argument.clone(), argument, text, files })
}

/// Whether a file with this text is the main file of a RoAML model, which can be used directly as a scenario.
#[must_use]
pub fn is_model(path: &Path, text: &str) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("xml")) && roaml::is_model(text)
}

/// The scenario that runs a RoAML model directly.
fn of_model(path: &Path) -> Found {
    let argument = path.display().to_string();
    let name = path.file_stem().map_or_else(|| "model".into(), |stem| stem.to_string_lossy()).into_owned();
    let about = quoted(&format!("The RoAML model {argument}."));
    let text = format!("about = {about}\nmodel = {}\n", quoted(&argument));
    Found { name, kind: FoundKind::Model, path: argument.clone(), argument, text, files: Files::beside(".") }
}

fn unknown(name: &str) -> Error {
    let help = help(Path::new(name), "the scenarios are", "; or give the path of a file");
    Error::refused(format!("unknown scenario `{name}`"), help)
}

/// The shipped scenario whose name or path is most similar, or otherwise all of them, between these words.
fn help(path: &Path, before: &str, after: &str) -> String {
    match path.to_str().and_then(|path| diagnostics::did_you_mean(path, scenario_names())) {
        Some(meant) => format!("{meant} `steward list` names all scenarios"),
        None => format!("{before} {}{after}", names()),
    }
}

fn names() -> String {
    let names: Vec<String> = shipped_scenarios().into_iter().map(|name| format!("`{name}`")).collect();
    format!(
        "{}, `guide/…` with something wrong, `nav2/…`, `faults/KIND` for each kind of fault (`steward faults`)",
        names.join(", ")
    )
}
