//! What looks like a typing error in the names of entries: arguments that a subtree does not use, and entries that are
//! read although nothing writes them.

use std::collections::{BTreeMap, BTreeSet};

use diagnostics::{MAX_HINTS, Problem, did_you_mean, nearest};

use super::ports::is_port_name;
use crate::blackboard::{ScopeId, Scopes, Slot};
use crate::settings::{Input, Setting};
use crate::{Category, Direction, Kind, Node, Tree};

/// The entries of the main tree that Nav2's `bt_navigator` writes before it ticks a tree.
const OF_NAVIGATOR: [&str; 3] = ["goal", "goals", "node"];

/// The entries of the main tree that a simulated robot writes.
const OF_ROBOT: [&str; 2] = ["robot_pose", "robot_speed"];

/// Names of entries are compared with each other if there are at most this many. Chosen, not measured.
const MAX_COMPARED: usize = 1000;

#[derive(Clone, Debug)]
struct Reading<'t> {
    node: &'t Node,
    slot: Slot,
    /// The key, as the node names it.
    key: String,
    /// The port that reads it; none if a script does.
    port: Option<&'t str>,
}

impl Reading<'_> {
    /// What reads it, in the file: a tree that is used twice has the node once.
    fn place(&self) -> (usize, usize, &str, Option<&str>) {
        (self.node.file, self.node.span.offset(), &self.key, self.port)
    }
}

impl Tree {
    /// Warnings about entries that are read although nothing writes them, if only this tree can: no program writes
    /// entries from outside. `writes` decides whether a leaf writes to a port that no model declares. Warnings that are
    /// among the [concerns](Self::concerns) are left out.
    #[must_use]
    pub fn unwritten_entries(&self, writes: &dyn Fn(&Node, &str) -> bool) -> Vec<Problem> {
        let written = self.written(writes);
        let anywhere = self.written(&|_, _| true);
        let is_new = |reading: &Reading<'_>| {
            let is_of_robot = self.is_of_main_tree(reading.slot, &OF_ROBOT);
            !is_of_robot && (anywhere.contains(&reading.slot) || !self.is_suspicious(reading, &anywhere))
        };
        let problems = self.problems_of_unwritten(&written, is_new);
        problems.into_iter().map(|(file, problem)| problem.of(&self.sources[file])).collect()
    }

    /// The warnings that hold whatever program ticks the tree, each with the index of its file.
    pub(super) fn entry_concerns(&self) -> Vec<(usize, Problem)> {
        let written = self.written(&|_, _| true);
        let mut concerns = self.unused_arguments();
        concerns.extend(self.undeclared_cases());
        concerns.extend(self.problems_of_unwritten(&written, |reading| self.is_suspicious(reading, &written)));
        concerns
    }

    /// Arguments that no node of a subtree names.
    fn unused_arguments(&self) -> Vec<(usize, Problem)> {
        if self.computes_keys() {
            return Vec::new();
        }
        let mut by_place: BTreeMap<(usize, usize, &str), (bool, ScopeId, &Node)> = BTreeMap::new();
        // The scopes of subtrees are made in the order of their nodes, after that of the main tree.
        let subtrees = self.nodes.iter().filter(|node| node.kind == Kind::SubTree);
        for (scope, subtree) in (1..).map(ScopeId).zip(subtrees) {
            let model = self.library.model(&subtree.type_id).filter(|model| model.category == Category::SubTree);
            for (name, _) in subtree.attributes.iter().filter(|(name, _)| is_port_name(name)) {
                let is_declared = model.is_some_and(|model| model.port(name).is_some());
                let is_used = is_declared || self.program.scopes.is_mentioned(scope, name);
                let place = (subtree.file, subtree.span.offset(), name.as_str());
                by_place.entry(place).and_modify(|found| found.0 |= is_used).or_insert((is_used, scope, subtree));
            }
        }
        let unused = by_place.into_iter().filter(|(_, (is_used, ..))| !is_used).enumerate();
        let problem = unused.map(|(count, ((file, _, name), (_, scope, subtree)))| {
            let problem = Problem::new(format!("nothing in the tree `{}` uses `{name}`", subtree.type_id));
            let own = self.program.scopes.own_keys(scope).filter(|key| subtree.attribute(key).is_none());
            let meant = (count < MAX_HINTS).then(|| did_you_mean(name, own)).flatten();
            let help = meant.unwrap_or_else(|| "remove it, or name it in that tree".to_owned());
            (file, problem.as_warning().at(subtree.span, "this argument has no effect").with_help(help))
        });
        problem.collect()
    }

    /// The problems of entries that are read, none of which is among those written; only those about which to `warn`.
    fn problems_of_unwritten(
        &self,
        written: &BTreeSet<Slot>,
        warn: impl Fn(&Reading<'_>) -> bool,
    ) -> Vec<(usize, Problem)> {
        if self.computes_keys() {
            return Vec::new();
        }
        let readings = self.readings();
        let (found, lost): (Vec<_>, Vec<_>) = readings.iter().partition(|reading| written.contains(&reading.slot));
        // Where another use of the same tree gets the entry, it is the use that lacks it.
        let elsewhere: BTreeSet<_> = found.into_iter().map(Reading::place).collect();
        let mut reported = BTreeSet::new();
        let mut problems = Vec::new();
        for reading in lost.into_iter().filter(|reading| warn(reading)) {
            let around = self.around(reading.node).map(|place| &self.nodes[place]);
            let lacking = around.filter(|_| elsewhere.contains(&reading.place()));
            let at = lacking.unwrap_or(reading.node);
            if reported.insert((at.file, at.span.offset(), reading.key.clone())) {
                let hints = problems.len() < MAX_HINTS;
                problems.push((at.file, self.unwritten(reading, written, lacking, hints)));
            }
        }
        problems
    }

    fn unwritten(
        &self,
        reading: &Reading<'_>,
        written: &BTreeSet<Slot>,
        lacking: Option<&Node>,
        hints: bool,
    ) -> Problem {
        let Reading { node, slot, key, port } = reading;
        let what = match port {
            Some(port) => format!("the port `{port}` of `{}`", node.label()),
            None => "a script".to_owned(),
        };
        let problem = Problem::new(format!("nothing writes the entry `{key}`, which {what} reads")).as_warning();
        if let Some(subtree) = lacking {
            let help = format!("write {key}=\"…\" here, as where `{}` is used elsewhere", subtree.type_id);
            return problem.at(subtree.span, format!("this one does not give it `{key}`")).with_help(help);
        }
        let meant = hints.then(|| self.meant(*slot, written)).flatten();
        let meant = meant.map(|meant| format!("did you mean `{meant}`?"));
        let help = meant.unwrap_or_else(|| match port {
            Some(_) => "write it before: with an output port, a script or <SetBlackboard>".to_owned(),
            None => "write it before; if it is an enumerator that the robot's program registers, declare its number \
                     in a table `constants`"
                .to_owned(),
        });
        problem.at(node.span, "never has a value").with_help(help)
    }

    /// Whether nothing writes an entry even if a program writes entries of the main tree: those of subtrees, names of
    /// enumerators in scripts, and what is nearly the name of another entry.
    fn is_suspicious(&self, reading: &Reading<'_>, written: &BTreeSet<Slot>) -> bool {
        let is_enumerator =
            || reading.port.is_none() && reading.key.len() > 1 && reading.key.starts_with(char::is_uppercase);
        let is_of_subtree = self.program.scopes.names()[reading.slot.0 as usize].0 != Scopes::ROOT;
        let is_of_navigator = || self.is_of_main_tree(reading.slot, &OF_NAVIGATOR);
        is_of_subtree || is_enumerator() || !is_of_navigator() && self.meant(reading.slot, written).is_some()
    }
    fn is_of_main_tree(&self, slot: Slot, keys: &[&str]) -> bool {
        let (scope, key) = &self.program.scopes.names()[slot.0 as usize];
        *scope == Scopes::ROOT && keys.contains(&&**key)
    }

    /// The entry of the same tree that was probably meant: one that is written, and differs in more than a number or a
    /// plural.
    fn meant(&self, slot: Slot, written: &BTreeSet<Slot>) -> Option<&str> {
        let names = self.program.scopes.names();
        let (scope, key) = &names[slot.0 as usize];
        let stem = |key: &str| key.trim_end_matches('s').replace(|c: char| c.is_ascii_digit(), "");
        if names.len() > MAX_COMPARED {
            return None;
        }
        let known = written.iter().map(|slot| &names[slot.0 as usize]).filter(|(of, _)| of == scope);
        let known = known.map(|(_, known)| &**known).filter(|known| stem(known) != stem(key) && known.len() > 2);
        nearest(key, known).filter(|_| key.len() > 2)
    }

    /// Whether a node computes the key of the entry that it writes: then nothing is known of any entry.
    pub(super) fn computes_keys(&self) -> bool {
        let computes = |setting: &Setting| matches!(setting, Setting::SetBlackboard { key: Input::Entry(..), .. });
        self.program.settings.iter().any(computes)
    }

    /// The entries that the file sets, or that nodes may write.
    fn written(&self, writes: &dyn Fn(&Node, &str) -> bool) -> BTreeSet<Slot> {
        let program = &self.program;
        let entries = (0..).map(Slot).zip(&program.entries);
        let mut written: BTreeSet<Slot> =
            entries.filter(|(_, entry)| entry.has_value()).map(|(slot, _)| slot).collect();
        let mut assigned = BTreeMap::new();
        for node in &self.nodes {
            program.scripts_of(node.number.0).for_each(|script| script.assigned(&mut assigned, |_| false));
            if !node.kind.is_leaf() {
                written.extend(program.setting(node.number.0).written(&program.scopes));
                continue;
            }
            for (name, port) in program.leaf_ports(node.number) {
                let is_written = match port.direction {
                    Direction::Input => false,
                    Direction::Output => true,
                    Direction::InOut => port.is_declared || writes(node, name),
                };
                written.extend(port.entry().filter(|_| is_written));
            }
        }
        written.extend(assigned.into_keys());
        written
    }

    /// The entries that nodes read, as far as the file names them.
    fn readings(&self) -> Vec<Reading<'_>> {
        let mut readings = Vec::new();
        for node in &self.nodes {
            if node.kind.is_leaf() {
                for (name, port) in self.program.leaf_ports(node.number) {
                    let is_read = port.direction != Direction::Output && node.attribute(name).is_some();
                    if let Some(Input::Entry(slot, key)) = port.input.as_ref().filter(|_| is_read) {
                        readings.push(Reading { node, slot: *slot, key: key.to_string(), port: Some(name) });
                    }
                }
            } else {
                for input in self.program.setting(node.number.0).inputs() {
                    let Input::Entry(slot, key) = input else { continue };
                    let port = node.attributes.iter().find(|(_, value)| value.contains(&**key));
                    let port = port.map(|(name, _)| name.as_str());
                    readings.push(Reading { node, slot: *slot, key: key.to_string(), port: port.or(Some("value")) });
                }
            }
            let mut names = BTreeMap::new();
            self.program.scripts_of(node.number.0).for_each(|script| script.read(&mut names));
            let of_scripts = names.into_iter();
            readings.extend(of_scripts.map(|(slot, key)| Reading { node, slot, key: key.to_string(), port: None }));
        }
        readings
    }
}
