//! A table of a document, whose keys the reader requests.

use std::time::Duration;

use serde_json::json;

use super::field::FieldState;
use super::log::Log;
use super::node::{Entries, Kind};
use super::{Field, FromItem, Item};
use crate::{Problem, Span, did_you_mean};

/// A table of a document that is being read. Every requested key counts as known.
#[derive(Clone, Copy, Debug)]
pub struct Table<'d> {
    pub(super) entries: &'d Entries,
    span: &'d Span,
    pub(super) log: &'d Log,
    /// Its number among the declared keys. The top level has none.
    declared: Option<usize>,
    /// Whether its keys are those of one of its forms.
    pub(super) is_form: bool,
}

impl<'d> Table<'d> {
    pub(super) fn open(entries: &'d Entries, span: &'d Span, log: &'d Log, declared: Option<usize>) -> Self {
        Self { entries, span, log, declared, is_form: false }
    }

    /// The value of `key` as a `T`.
    pub fn get<T: FromItem<'d>>(&self, key: &str) -> Field<'d, T> {
        self.know(key);
        let entry = self.entries.by_key.get(key);
        let declared = self.log.declare(self.declared, key, T::takes, entry.map(|entry| &entry.value));
        let Some(entry) = entry else {
            let table = Self::open(&self.log.nothing, self.span, self.log, declared);
            let state = match declared.and_then(|_| T::declaring(table)) {
                Some(value) => FieldState::Given(value, self.span.clone()),
                None => FieldState::Missing(T::wanted()),
            };
            return Field::new(*self, key, declared, state);
        };
        let item = Item::new(&entry.value, format!("`{key}`"), self.log).of(declared);
        let state = match item.get() {
            Ok(value) => FieldState::Given(value, item.span().clone()),
            Err(problems) => {
                problems.into_iter().for_each(|problem| self.report(problem));
                FieldState::Refused
            }
        };
        Field::new(*self, key, declared, state)
    }

    /// The value of `key` as a finite number; integers are accepted, too.
    pub fn number(&self, key: &str) -> Field<'d, f64> {
        self.get(key)
    }

    /// The value of `key` as an integer.
    pub fn integer(&self, key: &str) -> Field<'d, i64> {
        self.get(key)
    }

    /// The value of `key` as a boolean.
    pub fn boolean(&self, key: &str) -> Field<'d, bool> {
        self.get(key)
    }

    /// The value of `key` as a text.
    pub fn text(&self, key: &str) -> Field<'d, String> {
        self.get(key)
    }

    /// The value of `key` as a number of seconds, at least 0, rounded to nanoseconds.
    pub fn seconds(&self, key: &str) -> Field<'d, Duration> {
        self.get(key)
    }

    /// The table under `key`.
    pub fn table(&self, key: &str) -> Field<'d, Table<'d>> {
        self.get(key)
    }

    /// The array of tables under `key`.
    pub fn tables(&self, key: &str) -> Field<'d, Vec<Table<'d>>> {
        self.get(key)
    }

    /// The choice that the text under `key` names. `choices` lists every name with its value.
    pub fn one_of<T: Clone>(&self, key: &str, choices: &[(&str, T)]) -> Field<'d, T> {
        let names = || choices.iter().map(|(name, _)| *name).collect::<Vec<_>>();
        let one_of_them = || {
            let names: Vec<_> = names().iter().map(|name| format!("`{name}`")).collect();
            format!("one of {}", names.join(", "))
        };
        let text = self.text(key).declare(|key| key.takes = json!({ "enum": names() }));
        text.wanted(one_of_them).try_map(|text, span| {
            if let Some((_, value)) = choices.iter().find(|(name, _)| *name == text) {
                return Ok(value.clone());
            }
            let problem = span.problem(format!("`{key}` cannot be `{text}`")).with_label("not one of the choices");
            Err(problem.with_help(did_you_mean(&text, names()).unwrap_or_else(one_of_them)))
        })
    }

    /// The keys of the table, in alphabetical order, each with its location. This does not make them known: ask for
    /// each.
    pub fn keys(&self) -> impl Iterator<Item = (&'d str, &'d Span)> + use<'d> {
        self.entries.by_key.iter().map(|(key, entry)| (key.as_str(), &entry.key))
    }

    /// Like [`keys`](Self::keys), in the order of the file.
    #[must_use]
    pub fn keys_as_written(&self) -> Vec<(&'d str, &'d Span)> {
        let mut keys: Vec<_> = self.keys().collect();
        keys.sort_by_key(|(_, span)| span.range().start);
        keys
    }

    /// The keys that the file chooses: all that have not been requested yet, in alphabetical order, each with its
    /// location. This does not make them known: request each. While keys are declared without a file, `placeholder`, in
    /// capitals, stands for all of them.
    pub fn names(&self, placeholder: &'static str) -> impl Iterator<Item = (&'d str, &'d Span)> + use<'d> {
        let placeholder = self.log.is_without_file().then_some((placeholder, self.span));
        let asked = self.entries.asked.borrow().clone();
        self.keys().filter(move |(key, _)| !asked.contains(*key)).chain(placeholder)
    }

    /// Like [`names`](Self::names), in the order of the file.
    #[must_use]
    pub fn names_as_written(&self, placeholder: &'static str) -> Vec<(&'d str, &'d Span)> {
        let mut names: Vec<_> = self.names(placeholder).collect();
        names.sort_by_key(|(_, span)| span.range().start);
        names
    }

    /// The table, to ask for the keys of one of its forms, if it has this form. While keys are declared without a file,
    /// it has all its forms, and does not require the keys that only one of them requires.
    #[must_use]
    pub fn form(&self, has_it: bool) -> Option<Self> {
        (has_it || self.log.is_without_file()).then_some(Self { is_form: true, ..*self })
    }

    /// The location of the key at a path such as `stop.at`, if the file has it. This does not make it known.
    #[must_use]
    pub fn find(&self, path: &str) -> Option<&'d Span> {
        let Some((table, rest)) = path.split_once('.') else {
            return self.entries.by_key.get(path).map(|entry| &entry.key);
        };
        let Kind::Table(entries) = &self.entries.by_key.get(table)?.value.kind else { return None };
        Self { entries, ..*self }.find(rest)
    }

    /// Whether the table has this key. This does not make the key known.
    #[must_use]
    pub fn has(&self, key: &str) -> bool {
        self.entries.by_key.contains_key(key)
    }

    /// Makes a key known without reading it.
    pub fn know(&self, key: &str) {
        self.entries.asked.borrow_mut().insert(key.to_owned());
    }

    /// Allows unknown keys, except those that look like a misspelling of a missing key. For formats that other programs
    /// extend.
    pub fn allow_other_keys(&self) {
        self.entries.lenient.set(true);
    }

    /// The location of the table: its header, or all of an inline table.
    #[must_use]
    pub fn span(&self) -> &'d Span {
        self.span
    }

    /// Records a problem; reading can continue.
    pub fn report(&self, problem: Problem) {
        self.log.problems.borrow_mut().push(problem);
    }

    /// Records the problem of a missing key that something else needs, unless the key turns out to be misspelled.
    pub fn report_missing(&self, key: impl Into<String>, problem: Problem) {
        self.entries.needed.borrow_mut().push((key.into(), problem));
    }
}
