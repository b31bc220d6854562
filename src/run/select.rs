//! Turns names, folders and patterns into scenarios.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use campaigns::Error;
use checks::Toml;
use glob::Pattern;
use scenarios::files::{Files, scenario_names};
use scenarios::scenario::{Found, RunsEntry, ScenarioFile, find};

use crate::output::note;

/// A requested scenario, under the name that was requested.
pub(crate) type Selected = (String, Result<Found, Error>);

/// The requested scenarios, each once, as far as they pass the filters; without names, all that come with the program.
/// One that is not found has an error in its place.
pub(crate) fn select(names: &[String], filters: &[String]) -> Result<Vec<Selected>, Error> {
    let known = |found: Vec<Found>| found.into_iter().map(|one| (one.argument.clone(), Ok(one))).collect();
    let of_name = |name: &String| meant(name).map_or_else(|error| vec![(name.clone(), Err(error))], known);
    let mut found: Vec<Selected> = match names {
        [] => known(shipped(|_| true)?),
        names => names.iter().flat_map(of_name).collect(),
    };
    found.retain(|(argument, one)| {
        one.is_err() || filters.is_empty() || filters.iter().any(|text| argument.contains(text.as_str()))
    });
    let mut seen = Vec::new();
    found.retain(|(argument, _)| {
        !seen.contains(argument) && {
            seen.push(argument.clone());
            true
        }
    });
    if found.is_empty() {
        let message = format!("no scenario has `{}` in its name", filters.join("` or `"));
        return Err(Error::refused(message, "`steward list` names the scenarios"));
    }
    Ok(found)
}

/// The scenarios to which one argument refers.
pub(crate) fn meant(name: &str) -> Result<Vec<Found>, Error> {
    let path = Path::new(name);
    let is_one = path.is_file() || find::shipped(name).is_some();
    if path.is_dir() && !is_one {
        return in_folder(path);
    }
    let folder = format!("{}/", name.trim_end_matches('/'));
    if !is_one && shipped_names().any(|shipped| shipped.starts_with(&folder)) {
        return shipped(|name| name.starts_with(&folder));
    }
    if is_one || !name.contains(['*', '?', '[']) {
        return Ok(vec![find::find(name)?]);
    }
    let help = "patterns match the names that `steward list` and `steward faults` print: 'faults/laser_*'";
    let pattern =
        Pattern::new(name).map_err(|error| Error::refused(format!("`{name}` is not a pattern: {error}"), help))?;
    let found = shipped(|name| pattern.matches(name))?;
    if found.is_empty() { Err(Error::refused(format!("no scenario matches `{name}`"), help)) } else { Ok(found) }
}

/// The names of the scenarios that come with the program, those in folders last.
fn shipped_names() -> impl Iterator<Item = &'static str> {
    let mut names: Vec<&str> = scenario_names().collect();
    names.sort_by_key(|name| (name.contains('/'), *name));
    names.into_iter()
}

/// The scenarios with these names that come with the program, except those whose other files do not, and those that
/// need a robot outside.
fn shipped(wanted: impl Fn(&str) -> bool) -> Result<Vec<Found>, Error> {
    let mut found = Vec::new();
    for name in shipped_names().filter(|name| wanted(name)) {
        let one = find::find(name)?;
        let file = ScenarioFile::parse(&one.path, &one.text, &Files::shipped(), []).map_err(Error::bad_input)?;
        if file.folder.is_some() {
            note(&format!("{name} is left out: it needs files that are not shipped"));
        } else if file.components.iter().any(|entry| matches!(entry.runs, RunsEntry::Remote { .. })) {
            note(&format!("{name} is left out: it needs a robot of ROS 2; name it to run it"));
        } else {
            found.push(one);
        }
    }
    Ok(found)
}

/// The scenarios in a folder on disk, by name.
fn in_folder(folder: &Path) -> Result<Vec<Found>, Error> {
    let unreadable = |source| diagnostics::Error::Read { path: folder.to_owned(), source };
    let entries =
        std::fs::read_dir(folder).and_then(Iterator::collect::<std::io::Result<Vec<_>>>).map_err(unreadable)?;
    let mut paths: Vec<PathBuf> = entries.iter().map(std::fs::DirEntry::path).collect();
    paths.retain(|path| path.extension().is_some_and(|ending| ending == "toml"));
    paths.sort();
    paths.retain(|path| {
        // One that cannot be read is reported as such.
        let Ok(text) = std::fs::read_to_string(path) else { return true };
        let kind = Toml::of(&text);
        if kind.is_none() {
            note(&format!("{} is left out: it has no key of a scenario", path.display()));
        }
        kind == Some(Toml::Scenario)
    });
    if paths.is_empty() {
        let message = format!("there is no scenario in the folder {}", folder.display());
        return Err(Error::refused(message, "a scenario is a TOML file with a tree, or a `base`"));
    }
    paths.iter().map(|path| Ok(find::find(&path.to_string_lossy())?)).collect()
}

/// Refuses scenarios, each named on the command line and with its folder, that would write to the same one.
pub(crate) fn check_folders<'a>(scenarios: impl IntoIterator<Item = (&'a str, PathBuf)>) -> Result<(), Error> {
    let mut taken: BTreeMap<PathBuf, &str> = BTreeMap::new();
    for (scenario, folder) in scenarios {
        if let Some(other) = taken.get(&folder) {
            let message = format!("{other} and {scenario} would both write to {}", folder.display());
            return Err(Error::refused(message, "name them in separate commands, each with a folder of its own"));
        }
        taken.insert(folder, scenario);
    }
    Ok(())
}
