//! What looks like an enumerator in a switch, but is declared nowhere: its case is never chosen.

use std::collections::{BTreeMap, BTreeSet};

use diagnostics::{MAX_HINTS, Problem, did_you_mean};

use crate::blackboard::{Entry, Slot, Type, Value};
use crate::settings::{Input, Setting};
use crate::{Direction, Kind, Tree};

impl Tree {
    /// Warnings about words with which a switch compares an entry that always holds a number, each with the index of
    /// its file.
    pub(super) fn undeclared_cases(&self) -> Vec<(usize, Problem)> {
        let scripted = self.scripted_numbers();
        let mut reported = BTreeSet::new();
        let mut problems = Vec::new();
        for node in self.nodes.iter().filter(|node| matches!(node.kind, Kind::Switch(_))) {
            let Setting::Switch { variable: Some(Input::Entry(slot, key)), cases, constants } =
                self.program.setting(node.number.0)
            else {
                continue;
            };
            // A tree is refused in which a port gives the entry the type of a number.
            if !scripted.contains(slot) {
                continue;
            }
            for case in cases.iter().flatten() {
                let Input::Constant(Value::Text(word)) = case else { continue };
                let is_word = word.starts_with(|first: char| first.is_alphabetic() || first == '_');
                let is_number = constants.contains_key(&**word) || word.parse::<f64>().is_ok();
                // A tree that is used twice has the node twice.
                if !is_word || is_number || !reported.insert((node.file, node.span.offset(), word)) {
                    continue;
                }
                let message = format!("the case `{word}` is never chosen: the entry `{key}` is a number");
                let known = constants.keys().map(String::as_str);
                let meant = (problems.len() < MAX_HINTS).then(|| did_you_mean(word, known)).flatten();
                let help = meant.unwrap_or_else(|| {
                    format!(
                        "write the number; or, if it is an enumerator that the robot's program registers, declare its \
                         number in a table `constants`: `{word} = 1`"
                    )
                });
                let problem = Problem::new(message).as_warning().at(node.span, "takes its last child instead");
                problems.push((node.file, problem.with_help(help)));
            }
        }
        problems
    }

    fn type_of(&self, slot: Slot) -> &Type {
        self.program.entries.get(slot.0 as usize).map_or(&Type::Any, |entry| entry.initial().0)
    }

    /// The entries to which scripts, and nothing else in the tree, assign numbers. A port that only reads an entry may
    /// have given it the type of a string.
    fn scripted_numbers(&self) -> BTreeSet<Slot> {
        let mut scripted = BTreeMap::new();
        if self.computes_keys() {
            return BTreeSet::new();
        }
        let text = |entry: &Entry| matches!(entry.initial().1, Some(Value::Text(_) | Value::List(_)));
        let entries = (0..).map(Slot).zip(&self.program.entries);
        let mut others: BTreeSet<Slot> = entries.filter(|(_, entry)| text(entry)).map(|(slot, _)| slot).collect();
        for node in &self.nodes {
            for script in self.program.scripts_of(node.number.0) {
                script.assigned(&mut scripted, |slot| !self.type_of(slot).is_number());
            }
            if node.kind.is_leaf() {
                let ports = self.program.leaf_ports(node.number).values();
                others.extend(ports.filter(|port| port.direction != Direction::Input).filter_map(|port| port.entry()));
            } else {
                others.extend(self.program.setting(node.number.0).written(&self.program.scopes));
            }
        }
        let is_number = |(slot, is_text): (Slot, bool)| {
            let of = self.type_of(slot);
            (!is_text && !others.contains(&slot) && matches!(of, Type::Any | Type::Text)).then_some(slot)
        };
        scripted.into_iter().filter_map(is_number).collect()
    }
}
