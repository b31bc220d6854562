//! The files that a scenario of one's own takes from elsewhere.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use diagnostics::{Span, Spanned};

use super::{ReadyMadeKind, RunsEntry, ScenarioFile, Skill, WatchingMachine};
use crate::faults::{Effect, Fault};
use crate::files::{Files, is_assigned, shipped_paths, unmarked};

/// A file that is not beside the scenario that names it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Elsewhere {
    /// Its path, as it is named.
    pub path: PathBuf,
    /// Where it is; none if it comes with the program.
    pub on_disk: Option<PathBuf>,
}

/// The files that a scenario takes from elsewhere, in alphabetical order: those that come with the program because
/// there is none beside the scenario, and those that an assignment names elsewhere. What a shipped file names is where
/// it belongs, also if this scenario inherits or uses it.
pub(super) fn of(file: &ScenarioFile, skills: &BTreeMap<String, Skill>, files: &Files) -> Vec<Elsewhere> {
    if files.are_shipped() {
        return Vec::new();
    }
    let taken = files.taken();
    let of_shipped = |span: &Span| !span.is_assignment() && shipped_paths().any(|path| path == span.source().name());
    let mut found: Vec<Elsewhere> = Vec::new();
    let map = |fault: &Arc<Fault>| if let Effect::Map(path) = fault.effect() { Some(path) } else { None };
    let maps: Vec<Spanned<PathBuf>> = file.faults.iter().filter_map(map).collect();
    let of_faults = maps.iter().map(|map| (map.value.as_path(), &map.span));
    for path in named(file, skills).chain(of_faults).filter(|(_, span)| !of_shipped(span)).map(|(path, _)| path) {
        let Some(taken) = taken.get(path) else { continue };
        let beside = || files.on_disk(unmarked(path)).and_then(|path| path.canonicalize().ok());
        let is_beside = match &taken.on_disk {
            None => false,
            Some(file) => !is_assigned(path) || file.canonicalize().ok() == beside(),
        };
        if !is_beside {
            found.push(Elsewhere { path: unmarked(path).to_owned(), on_disk: taken.on_disk.clone() });
        }
    }
    // What a file on disk names in turn, such as the image of a map.
    for (path, missing) in taken.iter().filter(|(_, taken)| taken.on_disk.is_none()) {
        let is_on_disk = |by: &PathBuf| taken.get(by).is_some_and(|by| by.on_disk.is_some());
        if missing.named_by.iter().any(is_on_disk) {
            found.push(Elsewhere { path: unmarked(path).to_owned(), on_disk: None });
        }
    }
    found.sort_by(|one, other| one.path.cmp(&other.path));
    found.dedup();
    found
}

/// The files that a scenario names, and its skills, each with the place that names it.
fn named<'s>(
    file: &'s ScenarioFile,
    skills: &'s BTreeMap<String, Skill>,
) -> impl Iterator<Item = (&'s Path, &'s Span)> {
    let at = |path: &'s Spanned<PathBuf>| (path.value.as_path(), &path.span);
    let floor = file.premises.iter().flat_map(move |floor| std::iter::once(&floor.map).chain(&floor.places)).map(at);
    let behavior = file.behavior.files();
    let tree = behavior.into_iter().map(move |files| at(&files.tree));
    let of_skills = behavior
        .into_iter()
        .flat_map(move |files| skills.values().map(move |skill| (skill.path.as_path(), &files.skills.span)));
    let model = file.behavior.model().map(move |model| at(&model.path));
    let components = file.components.iter().flat_map(move |component| {
        let machine = if let RunsEntry::Machine(path) = &component.runs { Some(path) } else { None };
        machine.into_iter().chain(&component.interface).map(at)
    });
    let monitors = file.monitors.iter().filter_map(move |entry| match &entry.kind {
        ReadyMadeKind::Machine(WatchingMachine { machine, .. }) => Some(at(machine)),
        _ => None,
    });
    floor
        .chain(tree)
        .chain(of_skills)
        .chain(model)
        .chain(file.properties.iter().map(at))
        .chain(components)
        .chain(monitors)
}
