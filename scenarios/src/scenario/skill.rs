//! Skills: the machine of each leaf of the tree, and the initial values of its data.

use std::collections::{BTreeMap, BTreeSet};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::ptr;
use std::sync::Arc;

use bt::{Direction, Node, Source, Tree, Type};
use diagnostics::{Problem, Span};
use skills::{Chart, Datum};

use super::data::Data;
use super::file_reader::{FileReader, FileRole, unreadable};
use super::leaves::entry_of;
use super::{LeafEntry, ScenarioFile};
use crate::files::Kind;
use crate::names::unknown;
use crate::processes::RESERVED;

/// The skill of a leaf: a machine, and the initial values of its data.
#[derive(Clone, Debug)]
pub struct Skill {
    /// The machine's file.
    pub path: PathBuf,
    /// The machine.
    pub machine: Arc<Chart>,
    /// Where the scenario describes a machine that is generated.
    pub(super) place: Option<Span>,
    /// By datum id: the values of the leaf's ports, or those that the scenario sets instead.
    pub(super) data: BTreeMap<String, Datum>,
}

/// Machines are the same if they were made only once.
impl PartialEq for Skill {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.machine, &other.machine) && self.path == other.path && self.data == other.data
    }
}

impl Skill {
    /// The initial values of this machine's data, unless the machine sets them itself: for the skill's own machine, or
    /// for a replacement by a fault. Data that the machine does not have are left out.
    pub fn data_of<'a>(&'a self, machine: &'a Chart) -> impl Iterator<Item = (&'a str, Datum)> {
        let has = |id: &str| machine.parameters().any(|known| known == id);
        self.data.iter().filter(move |(id, _)| has(id)).map(|(id, value)| (id.as_str(), value.clone()))
    }

    /// A problem of the machine, where its author can mend it.
    pub(super) fn at_its_place(&self, problem: Problem) -> Problem {
        let Some(place) = &self.place else { return problem };
        let moved = place.problem(problem.message()).with_label(problem.label_text().unwrap_or("here"));
        moved.with_help_if(problem.help_text().map(str::to_owned))
    }

    /// Gives the machine its initial values. Returns a problem of each datum that it does not have.
    pub(super) fn set_data(&mut self, data: &Data) -> Vec<Problem> {
        let mut problems = Vec::new();
        for (id, value) in data {
            if self.machine.parameters().any(|known| known == id.value) {
                self.data.insert(id.value.clone(), value.clone());
            } else {
                problems.push(unknown(&format!("datum of {}", self.path.display()), id, self.machine.parameters()));
            }
        }
        problems
    }

    /// The constants with which the machine of this process compares a quantity that messages carry in this field.
    ///
    /// # Errors
    /// Everything else that it does with it.
    pub fn thresholds(&self, process: &str, tree: Option<&Tree>, field: &str) -> Result<Vec<f64>, Vec<Problem>> {
        let given: Vec<(&str, Datum)> = self.data_of(&self.machine).collect();
        // Ports that read the blackboard.
        let leaf = tree.and_then(|tree| Some((tree, tree.leaves().find(|leaf| leaf.process() == process)?)));
        let ports = leaf.into_iter().flat_map(|(tree, leaf)| tree.ports(leaf.id()));
        let open: Vec<&str> =
            ports.filter(|port| matches!(port.source, Source::Entry(_))).map(|port| port.name).collect();
        self.machine.thresholds(field, &given, &open)
    }
}

/// Where a leaf's machine is looked up: the file that the scenario names, or otherwise those with the leaf's name and
/// ID. Only this function determines it.
fn candidates(folder: &Path, leaf: &Node, entry: Option<&LeafEntry>) -> Vec<PathBuf> {
    if let Some(machine) = entry.and_then(|entry| entry.machine.as_ref()) {
        return vec![folder.join(&machine.value)];
    }
    // A name with a slash is not a file name in this folder.
    let is_file_name = |name: &&str| Path::new(name).file_name().is_some_and(|file| file == *name);
    let mut names: Vec<&str> = [leaf.label(), leaf.type_id()].into_iter().filter(is_file_name).collect();
    names.dedup();
    names.into_iter().map(|name| folder.join(format!("{name}.scxml"))).collect()
}

impl FileReader<'_> {
    /// The skill of each leaf, by the name of the leaf's process; `folder` contains the machines.
    pub(super) fn skills(&mut self, file: &ScenarioFile, folder: &Path, tree: &Tree) -> BTreeMap<String, Skill> {
        self.check_leaf_names(file, tree);
        let is_component = |name: &str| file.components.iter().any(|component| component.name.value == name);
        let mut machines: BTreeMap<PathBuf, Option<Arc<Chart>>> = BTreeMap::new();
        let mut skills = BTreeMap::new();
        let (mut problems, mut given) = (Vec::new(), BTreeSet::new());
        for leaf in tree.leaves() {
            if RESERVED.contains(&leaf.process()) || is_component(leaf.process()) {
                let message =
                    format!("a leaf cannot be named `{}`: that is the name of another process", leaf.process());
                problems.push(tree.problem_at(leaf.id(), message, "this leaf", "give the leaf another `name`"));
                continue;
            }
            let entry = entry_of(&file.leaves, leaf);
            let Some((path, machine)) = self.machine_of(folder, tree, leaf, entry, &mut machines, &mut problems) else {
                continue;
            };
            let place = entry.and_then(|entry| entry.asking.as_ref()).map(|asking| asking.place().clone());
            let mut skill = Skill { path, machine, place, data: constant_ports(tree, leaf) };
            if let Some(entry) = entry {
                let unknown = skill.set_data(&entry.data);
                // Reported once for all leaves with this entry and machine.
                if given.insert((&entry.leaf.value, skill.path.clone())) {
                    unknown.into_iter().for_each(|problem| self.complaints.push(problem));
                }
            }
            skills.insert(leaf.process().to_owned(), skill);
        }
        // One error for all leaves: it shows each of them in the tree's file.
        if !problems.is_empty() {
            self.complaints.push(tree.error(&problems));
        }
        skills
    }

    /// The machine of a leaf and its file; a file that several leaves share is loaded once.
    fn machine_of(
        &mut self,
        folder: &Path,
        tree: &Tree,
        leaf: &Node,
        entry: Option<&LeafEntry>,
        machines: &mut BTreeMap<PathBuf, Option<Arc<Chart>>>,
        problems: &mut Vec<Problem>,
    ) -> Option<(PathBuf, Arc<Chart>)> {
        if let Some(asking) = entry.and_then(|entry| entry.asking.as_ref()) {
            if let Some(why) = asking.misfit(leaf) {
                problems.push(tree.problem_at(leaf.id(), why.to_owned(), "this leaf", "make it an action of the tree"));
                return None;
            }
            let name = PathBuf::from(format!("leaves.{}", key(leaf.process())));
            let chart = self.chart(&name, &asking.scxml(leaf))?;
            return Some((name, chart));
        }
        let paths = candidates(folder, leaf, entry);
        let named = entry.and_then(|entry| entry.machine.as_ref());
        for path in &paths {
            if let Some(known) = machines.get(path) {
                return Some((path.clone(), Arc::clone(known.as_ref()?)));
            }
            match (self.files.read_text(path), named) {
                (Ok(text), named) => {
                    let chart = self.chart(path, &text);
                    // A file that the scenario names may be shared by leaves with other names.
                    let found = chart.as_ref().filter(|_| named.is_none());
                    problems.extend(found.and_then(|chart| misnamed(tree, leaf, path, chart)));
                    return Some((path.clone(), machines.entry(path.clone()).or_insert(chart).clone()?));
                }
                (Err(error), Some(named)) => {
                    self.complaints.push(unreadable(&named.span, FileRole::Of(Kind::Skill), path, &error));
                    machines.insert(path.clone(), None);
                    return None;
                }
                (Err(error), None) if error.kind() == ErrorKind::NotFound => {}
                (Err(error), None) => {
                    let message =
                        format!("the machine of `{}` cannot be read: {}: {error}", leaf.process(), path.display());
                    problems.push(tree.problem_at(leaf.id(), message, "this leaf", "a machine is an SCXML file"));
                    return None;
                }
            }
        }
        problems.push(without_machine(tree, leaf, &paths));
        None
    }

    /// Reports entries of the table `leaves` that are about no leaf.
    fn check_leaf_names(&mut self, file: &ScenarioFile, tree: &Tree) {
        for LeafEntry { leaf: name, .. } in &file.leaves {
            if tree.leaves().any(|leaf| entry_of(&file.leaves, leaf).is_some_and(|entry| ptr::eq(&entry.leaf, name))) {
                continue;
            }
            let problem = if tree.leaves().any(|leaf| leaf.type_id() == name.value) {
                let problem = name.span.problem(format!("no leaf uses the entry of the ID `{}`", name.value));
                problem.with_help("each leaf with this ID has an entry of its own, by its name: leave this one out")
            } else {
                let known: BTreeSet<&str> = tree.leaves().flat_map(|leaf| [leaf.process(), leaf.type_id()]).collect();
                unknown("leaf", name, known)
            };
            self.complaints.push(problem);
        }
    }
}

fn misnamed(tree: &Tree, leaf: &Node, path: &Path, chart: &Chart) -> Option<Problem> {
    if path.file_stem().is_none_or(|stem| stem == chart.name()) {
        return None;
    }
    let message = format!("the machine of `{}`, {}, has the name `{}`", leaf.process(), path.display(), chart.name());
    let help = format!(
        "its `name` should be that of its file; if this is intended, add to the scenario: [leaves.{}] machine = \"{}\"",
        key(leaf.process()),
        path.file_name().unwrap_or_default().display()
    );
    Some(tree.problem_at(leaf.id(), message, "this leaf", help))
}

/// The problem of a leaf whose machine is in none of these files.
fn without_machine(tree: &Tree, leaf: &Node, paths: &[PathBuf]) -> Problem {
    let files: Vec<String> = paths.iter().map(|path| path.display().to_string()).collect();
    let message = match files.as_slice() {
        [] => format!("the leaf `{}` has no machine", leaf.process()),
        files => format!("the leaf `{}` has no machine: there is no {}", leaf.process(), files.join(" and no ")),
    };
    let help =
        format!("add the file, or name another one in the scenario: [leaves.{}] machine = \"…\"", key(leaf.process()));
    tree.problem_at(leaf.id(), message, "no machine for this leaf", help)
}

/// A name as a TOML key.
fn key(name: &str) -> String {
    let is_bare = name.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '_' | '-'));
    if is_bare { name.to_owned() } else { format!("{name:?}") }
}

/// The ports of a leaf with constant values in the tree's file.
fn constant_ports(tree: &Tree, leaf: &Node) -> BTreeMap<String, Datum> {
    let ports = tree.ports(leaf.id()).filter(|port| port.direction != Direction::Output);
    let constant = |port: bt::Port<'_>| {
        let Source::Constant(value) = port.source else { return None };
        let datum = match port.of {
            Type::Bool => value.to_bool().map(Datum::from).ok()?,
            Type::Int { .. } | Type::Real | Type::Float => value.to_real().map(Datum::from).ok()?,
            _ => Datum::from(value.to_text()),
        };
        Some((port.name.to_owned(), datum))
    };
    ports.filter_map(constant).collect()
}

/// Warnings about the leaves of a tree and their machines: ports that a machine does not read.
pub(super) fn concerns(tree: &Tree, skills: &BTreeMap<String, Skill>) -> Vec<Problem> {
    let mut concerns = Vec::new();
    for leaf in tree.leaves() {
        let Some(Skill { path, machine, .. }) = skills.get(leaf.process()) else { continue };
        for port in tree.ports(leaf.id()) {
            let is_read = match port.source {
                _ if port.direction == Direction::Output => true,
                Source::Nothing => true,
                _ if machine.parameters().any(|id| id == port.name) => true,
                Source::Constant(_) => false,
                Source::Entry(_) => machine.file().text().contains(&format!("_event.data.{}", port.name)),
            };
            if !is_read {
                let message = format!("the machine of `{}` does not read the port `{}`", leaf.process(), port.name);
                let help = format!("add <data id=\"{}\"/> to {} to get the port's value", port.name, path.display());
                concerns.push(tree.problem_at(leaf.id(), message, "this leaf", help).as_warning());
            }
        }
    }
    concerns
}
