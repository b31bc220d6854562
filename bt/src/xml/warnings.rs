//! Warnings about what BehaviorTree.CPP throws or loses when an assembled tree runs.

use std::collections::{BTreeMap, BTreeSet};

use diagnostics::Problem;

use super::problems::{Written, assigned_condition, copy_refused, large_integer, string_refused};
use super::source_file::SourceFile;
use crate::blackboard::{Declared, Scopes, Slot, Type};
use crate::program::{Flags, Program};
use crate::script::Script;
use crate::settings::{Input, Setting};
use crate::{Direction, Kind, Node};

pub(super) struct Assembled<'a> {
    pub(super) nodes: &'a [Node],
    pub(super) program: &'a Program,
    pub(super) scopes: &'a Scopes,
    pub(super) declared: &'a Declared,
}

/// What scripts do with an entry.
#[derive(Clone, Copy)]
struct Scripted {
    /// Whether one can assign a string to it.
    text: bool,
    /// The first and the last node whose scripts assign to it.
    first: u32,
    last: u32,
}

impl Assembled<'_> {
    pub(super) fn warn(&self, files: &mut [SourceFile]) {
        let scripted = self.scripted();
        let mut report = |node: &Node, problem: Problem| files[node.file].problems.push(problem.at(node.span, "here"));
        self.warn_of_copies(&scripted, &mut report);
        self.warn_of_strings(&scripted, &mut report);
        self.warn_of_large_integers(&mut report);
        self.warn_of_assignments(&mut report);
    }

    /// Warns of each condition that assigns where it seems to compare.
    fn warn_of_assignments(&self, report: &mut impl FnMut(&Node, Problem)) {
        let assigns = |node: &&Node| self.program.conditions_of(node.number.0).any(Script::only_assigns);
        self.nodes.iter().filter(assigns).for_each(|node| report(node, assigned_condition()));
    }

    /// The entries that scripts assign to.
    fn scripted(&self) -> BTreeMap<Slot, Scripted> {
        let mut scripted = BTreeMap::<Slot, Scripted>::new();
        for node in 0..self.count() {
            for script in self.program.scripts_of(node) {
                let mut assigned = BTreeMap::new();
                script.assigned(&mut assigned, |slot| {
                    self.declared.type_of(slot) == Type::Text || scripted.get(&slot).is_some_and(|found| found.text)
                });
                for (slot, text) in assigned {
                    let found = scripted.entry(slot).or_insert(Scripted { text, first: node, last: node });
                    (found.text, found.last) = (found.text || text, node);
                }
            }
        }
        scripted
    }

    /// Warns of each SetBlackboard that BehaviorTree.CPP refuses to carry out, or that empties its entry.
    fn warn_of_copies(&self, scripted: &BTreeMap<Slot, Scripted>, report: &mut impl FnMut(&Node, Problem)) {
        for node in self.nodes.iter().filter(|node| node.kind == Kind::SetBlackboard) {
            let setting = self.program.setting(node.number.0);
            let Setting::SetBlackboard { key: Input::Constant(key), value, scope } = setting else { continue };
            let key = key.to_text();
            let source = match value {
                Input::Constant(text) => Written::Constant(text.to_text()),
                Input::Entry(slot, _) => match (self.declared.type_of(*slot), scripted.get(slot)) {
                    (Type::Any, Some(Scripted { text: true, .. })) => Written::ScriptedString,
                    (Type::Any, Some(_)) => Written::ScriptedNumber,
                    (of, _) => Written::Copy(of),
                },
            };
            let slot = self.scopes.find(*scope, &key);
            let is_declared = slot.is_some_and(|slot| self.declared.exists(slot));
            let by_script = slot.and_then(|slot| scripted.get(&slot));
            let is_made = is_declared || by_script.is_some_and(|by| !self.comes_first(node.number.0, *by));
            let of = slot.map_or(Type::Any, |slot| self.declared.type_of(slot));
            let is_any = slot.is_some_and(|slot| self.declared.is_any(slot));
            if slot.is_some_and(|slot| self.declared.is_unknown(slot)) {
                continue;
            }
            if let Some(problem) = copy_refused(&key, of, (is_any, is_made), &source) {
                report(node, problem);
            }
        }
    }

    /// Whether a node is certainly ticked before the scripts that assign to an entry. It is if all of them follow it
    /// in a sequence, and nothing above it in that sequence can pass over it. If entries can be unset, nothing about
    /// later follows from what was first.
    fn comes_first(&self, node: u32, by: Scripted) -> bool {
        let ops = &self.program.ops;
        let mut top = node;
        while top > 0 && !ops[top as usize].flags.has(Flags::ENTRANCE) {
            let parent = ops[top as usize].parent;
            if !ticks_all_in_order(ops[parent as usize].kind) {
                break;
            }
            top = parent;
        }
        !self.program.can_unset() && by.first >= node && by.last < ops[top as usize].end
    }

    /// Warns of each script that assigns a string to an entry whose type cannot be read from a string.
    fn warn_of_strings(&self, scripted: &BTreeMap<Slot, Scripted>, report: &mut impl FnMut(&Node, Problem)) {
        let refuses = |slot: Slot| self.declared.is_any(slot) || self.declared.type_of(slot) == Type::Status;
        if !scripted.iter().any(|(slot, by)| by.text && refuses(*slot)) {
            return;
        }
        for node in self.nodes {
            let mut assigned = BTreeMap::new();
            for script in self.program.scripts_of(node.number.0) {
                script.assigned(&mut assigned, |slot| scripted.get(&slot).is_some_and(|by| by.text));
            }
            for slot in assigned.into_iter().filter_map(|(slot, text)| (text && refuses(slot)).then_some(slot)) {
                let of = Some(self.declared.type_of(slot)).filter(|_| !self.declared.is_any(slot));
                report(node, string_refused(self.scopes.name(slot), of));
            }
        }
    }

    /// Warns of integers in the file that are calculated with, or read as real numbers, though they are too large.
    fn warn_of_large_integers(&self, report: &mut impl FnMut(&Node, Problem)) {
        let mut large: BTreeSet<Slot> = self.declared.large_integers().collect();
        let mut calculates = Vec::new();
        // An entry can be read before the script that assigns to it, so the scripts are searched twice.
        for _ in 0..2 {
            calculates.clear();
            for node in 0..self.count() {
                for script in self.program.scripts_of(node) {
                    if script.calculates_with_large(&mut large) {
                        calculates.push(node);
                    }
                }
            }
            if large.is_empty() && calculates.is_empty() {
                return;
            }
        }
        calculates.dedup();
        for node in calculates {
            report(&self.nodes[node as usize], large_integer("a script calculates with an integer"));
        }
        for node in self.nodes.iter().filter(|node| node.kind.is_leaf()) {
            let mut ports = self.program.leaf_ports(node.number).values();
            if ports.any(|port| {
                let is_input = port.direction != Direction::Output && port.of.is_real();
                is_input && port.entry().is_some_and(|slot| large.contains(&slot))
            }) {
                report(node, large_integer("a port reads as a real number an integer"));
            }
        }
    }

    fn count(&self) -> u32 {
        u32::try_from(self.nodes.len()).expect("a tree has less than 2^32 nodes")
    }
}

/// Whether a node of this kind succeeds only after it has ticked all its children, one after another.
fn ticks_all_in_order(kind: Kind) -> bool {
    match kind {
        Kind::Sequence | Kind::ReactiveSequence | Kind::SequenceWithMemory | Kind::AsyncSequence => true,
        kind => matches!(kind, Kind::SubTree | Kind::ForceSuccess | Kind::RunOnce),
    }
}
