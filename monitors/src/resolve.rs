//! From the tree of a file to formulas: resolves names, checks types, converts durations to ticks.

mod channel;
mod condition;
mod duration;

use std::collections::BTreeMap;
use std::time::Duration;

use channels::Topology;
use diagnostics::{Problem, nearest_or_all};

use crate::formula::Formula;
use crate::syntax::{ByteRange, Constraint, ConstraintKind, File, Item, Literal, Name, PropertyItem};

/// A property of a file with resolved names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Definition {
    pub(crate) name: Name,
    pub(crate) constraint: Constraint,
    pub(crate) formula: Formula,
}

/// The properties of a file and everything that is wrong with it.
pub(crate) fn resolve(file: &File, topology: &Topology, tick_period: Duration) -> (Vec<Definition>, Vec<Problem>) {
    let mut resolver =
        Resolver { topology, tick_period, constants: BTreeMap::new(), unreadable: false, problems: Vec::new() };
    resolver.declare(file);
    let properties = file.items.iter().filter_map(|item| match item {
        Item::Property(property) => Some(property),
        Item::Constant(_) => None,
    });
    let definitions = properties.filter_map(|property| resolver.definition(property)).collect();
    (definitions, resolver.problems)
}

struct Resolver<'a> {
    topology: &'a Topology,
    tick_period: Duration,
    constants: BTreeMap<&'a str, &'a Literal>,
    /// Whether the current property has a part that could not be read.
    unreadable: bool,
    problems: Vec<Problem>,
}

impl<'a> Resolver<'a> {
    /// Collects the file's constants, and reports names that are defined twice.
    fn declare(&mut self, file: &'a File) {
        let mut known: BTreeMap<&str, ByteRange> = BTreeMap::new();
        for item in &file.items {
            let name = match item {
                Item::Constant(constant) => &constant.name,
                Item::Property(property) => &property.name,
            };
            if let Some(first) = known.insert(&name.text, name.span) {
                let problem = Problem::new(format!("`{}` is defined twice", name.text)).at(name.span, "defined again");
                self.problems.push(problem.at(first, "first defined here"));
            }
            if let Item::Constant(constant) = item {
                self.constants.insert(&constant.name.text, &constant.value);
            }
        }
    }

    fn definition(&mut self, property: &PropertyItem) -> Option<Definition> {
        let noted = self.problems.len();
        self.unreadable = false;
        let formula = self.formula(&property.constraint, false);
        let sound = !self.problems[noted..].iter().any(Problem::is_error) && !self.unreadable;
        let definition =
            |formula| Definition { name: property.name.clone(), constraint: property.constraint.clone(), formula };
        formula.filter(|_| sound).map(definition)
    }

    /// The formula of a constraint; `None` after its problems have been reported. All of its parts are checked.
    fn formula(&mut self, constraint: &Constraint, inside_temporal: bool) -> Option<Formula> {
        let mut temporal = |part: &Constraint| self.formula(part, true).map(Box::new);
        Some(match &constraint.kind {
            ConstraintKind::True => Formula::True,
            ConstraintKind::False => Formula::False,
            ConstraintKind::Unreadable => {
                self.unreadable = true;
                return None;
            }
            ConstraintKind::Next(part) => Formula::Next(temporal(part)?),
            ConstraintKind::Always(part) => Formula::Always(temporal(part)?),
            ConstraintKind::Eventually(part) => Formula::Eventually(temporal(part)?),
            ConstraintKind::Until(left, right) => {
                let (left, right) = (temporal(left), temporal(right));
                Formula::Until(left?, right?)
            }
            ConstraintKind::Not(part) => self.formula(part, inside_temporal)?.negated(),
            ConstraintKind::And(parts) => Formula::And(self.formulas(parts, inside_temporal)?),
            ConstraintKind::Or(parts) => Formula::Or(self.formulas(parts, inside_temporal)?),
            ConstraintKind::Implies(left, right) => {
                let (left, right) = (self.formula(left, inside_temporal), self.formula(right, inside_temporal));
                left?.implies(right?)
            }
            ConstraintKind::Event(event) => {
                if !inside_temporal {
                    let problem = Problem::new("this event is outside every temporal operator");
                    let problem = problem.at(event.span, "checked only in the first state, before any message");
                    self.problems.push(problem.with_help("did you mean `always`?"));
                }
                Formula::Event(self.event(event)?)
            }
            ConstraintKind::TimeUntil { event, relation, bound } => {
                let (event, ticks) = (self.event(event), self.ticks(*relation, bound));
                let (relation, ticks) = ticks?;
                Formula::TimeUntil { event: event?, relation, ticks }
            }
        })
    }

    fn formulas(&mut self, parts: &[Constraint], inside_temporal: bool) -> Option<Vec<Formula>> {
        let formulas: Vec<Option<Formula>> = parts.iter().map(|part| self.formula(part, inside_temporal)).collect();
        formulas.into_iter().collect()
    }

    /// The value of a constant; `None` after reporting that it is unknown.
    fn constant(&mut self, name: &Name) -> Option<&'a Literal> {
        let found = self.constants.get(name.text.as_str()).copied();
        if found.is_none() {
            let known: Vec<&str> = self.constants.keys().copied().collect();
            let problem = Problem::new(format!("unknown constant `{}`", name.text)).at(name.span, "not defined");
            self.problems.push(problem.with_help(nearest_or_all(&name.text, "constants", &known)));
        }
        found
    }
}
