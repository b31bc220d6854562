//! The tree of a parsed file in either syntax, with the locations of all keys and values.

use std::cell::{Cell, RefCell};
use std::collections::{BTreeMap, BTreeSet};

use crate::{MAX_HINTS, Problem, Span, nearest};

/// Deeper nesting is refused, because the walks over the tree are recursive.
pub(super) const MAX_DEPTH: usize = 64;

/// A value and its location. The location of a table with a header is the header.
#[derive(Debug)]
pub(super) struct Node {
    pub(super) span: Span,
    pub(super) kind: Kind,
}

/// The kinds of values.
#[derive(Debug)]
pub(super) enum Kind {
    Text(String),
    Integer(i128),
    /// May be infinite or NaN.
    Real(f64),
    Boolean(bool),
    /// A date or a time of day, which no key accepts.
    Moment,
    /// A YAML key without a value.
    Nothing,
    /// A YAML value whose tag contradicts it.
    Unreadable,
    Array(Vec<Node>),
    Table(Entries),
}

/// The entries of a table, and the keys that its reader has requested so far.
#[derive(Debug, Default)]
pub(super) struct Entries {
    pub(super) by_key: BTreeMap<String, Entry>,
    /// Whether unknown keys are allowed unless they look like misspellings.
    pub(super) lenient: Cell<bool>,
    /// The known keys. A table is checked only if at least one of its keys was requested.
    pub(super) asked: RefCell<BTreeSet<String>>,
    /// Required keys that are missing, each with the problem to report.
    pub(super) missing: RefCell<Vec<(String, Problem)>>,
    /// Missing keys that something else needs, each with the problem to report, located where they are needed.
    pub(super) needed: RefCell<Vec<(String, Problem)>>,
}

/// A key's location and its value.
#[derive(Debug)]
pub(super) struct Entry {
    pub(super) key: Span,
    pub(super) value: Node,
}

impl Node {
    /// Takes entries that only the other table has, recursively. `{}` takes none: it is the empty table, as in an
    /// assignment. A header without keys, `[expect]`, is not a value, and changes nothing.
    pub(super) fn inherit(&mut self, base: Self) {
        let is_value = self.span.text().starts_with('{');
        if is_value && self.entries().is_some_and(|own| own.by_key.is_empty()) {
            return;
        }
        let (Kind::Table(own), Kind::Table(base)) = (&mut self.kind, base.kind) else { return };
        for (key, entry) in base.by_key {
            match own.by_key.get_mut(&key) {
                Some(own) => own.value.inherit(entry.value),
                None => drop(own.by_key.insert(key, entry)),
            }
        }
    }

    /// Removes those entries of a table from `base` that have one of the `forms` where this one's have another.
    pub(super) fn replace_other_forms(&self, base: &mut Self, table: &str, forms: &[&str]) {
        let Some(own) = self.entries().and_then(|root| root.by_key.get(table)?.value.entries()) else { return };
        let Kind::Table(base) = &mut base.kind else { return };
        let Some(Kind::Table(base)) = base.by_key.get_mut(table).map(|entry| &mut entry.value.kind) else { return };
        let form = |entry: &Entry| {
            let entries = entry.value.entries()?;
            forms.iter().find(|form| entries.by_key.contains_key(**form)).copied()
        };
        base.by_key.retain(|name, entry| {
            let own = own.by_key.get(name).and_then(form);
            own.is_none() || form(entry).is_none_or(|inherited| own == Some(inherited))
        });
    }

    fn entries(&self) -> Option<&Entries> {
        if let Kind::Table(entries) = &self.kind { Some(entries) } else { None }
    }

    /// Collects the problems that are known only once reading is over: unknown keys, and required keys that are missing
    /// rather than misspelled.
    pub(super) fn left_over(&self, problems: &mut Vec<Problem>) {
        match &self.kind {
            Kind::Array(items) => items.iter().for_each(|item| item.left_over(problems)),
            Kind::Table(entries) => entries.left_over(problems),
            _ => {}
        }
    }
}

impl Kind {
    /// The kind of value, for a label.
    pub(super) fn name(&self) -> &'static str {
        match self {
            Self::Text(_) => "a string",
            Self::Integer(number) if i64::try_from(*number).is_err() => "an integer of more than 64 bits",
            Self::Integer(_) => "an integer",
            Self::Real(number) if number.is_finite() => "a number",
            Self::Real(_) => "not a finite number",
            Self::Boolean(_) => "a boolean",
            Self::Moment => "a date or time",
            Self::Nothing => "empty",
            Self::Unreadable => "not a value of its tag",
            Self::Array(_) => "an array",
            Self::Table(_) => "a table",
        }
    }
}

impl Entries {
    fn left_over(&self, problems: &mut Vec<Problem>) {
        let asked = self.asked.borrow();
        if asked.is_empty() {
            return;
        }
        let mut misspelt = BTreeSet::new();
        for (key, entry) in &self.by_key {
            if asked.contains(key) {
                entry.value.left_over(problems);
                continue;
            }
            let hinted = problems.len() < MAX_HINTS;
            let known = |absent: bool| {
                let known =
                    asked.iter().map(String::as_str).filter(|known| !absent || !self.by_key.contains_key(*known));
                if hinted { nearest(key, known) } else { None }
            };
            let absent = known(true);
            misspelt.extend(absent);
            // The override may mean an existing key: `--set batery.initial_pct=3`, for example.
            let meant = absent.or_else(|| if self.lenient.get() { None } else { known(false) });
            if meant.is_some() || !self.lenient.get() {
                let problem = entry.key.problem(format!("unknown key `{key}`")).with_label("unknown key");
                problems.push(if hinted { problem.with_help(known_keys(meant, &asked)) } else { problem });
            }
        }
        let is_missing = |(key, _): &(String, Problem)| !misspelt.contains(key.as_str());
        problems.extend(together(self.missing.take().into_iter().filter(is_missing).collect()));
        problems.extend(self.needed.take().into_iter().filter(is_missing).map(|(_, problem)| problem));
    }
}

/// The missing keys of a table, as one problem.
fn together(missing: Vec<(String, Problem)>) -> Option<Problem> {
    let names: Vec<String> = missing.iter().map(|(key, _)| format!("`{key}`")).collect();
    let help: Vec<&str> = missing.iter().filter_map(|(_, problem)| problem.help_text()).collect();
    let help = help.join("\n");
    let first = missing.first().map(|(_, problem)| problem.clone())?;
    match names.split_last() {
        Some((last, others @ [_, ..])) => {
            Some(first.with_message(format!("{} and {last} are missing", others.join(", "))).with_help(help))
        }
        _ => Some(first),
    }
}

fn known_keys(meant: Option<&str>, known: &BTreeSet<String>) -> String {
    match meant {
        Some(meant) => format!("did you mean `{meant}`?"),
        None => {
            let known: Vec<_> = known.iter().map(|key| format!("`{key}`")).collect();
            format!("known here: {}", known.join(", "))
        }
    }
}
