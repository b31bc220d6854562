//! The value of one key while it is being read: checked, then required or given a default.

use std::fmt;
use std::ops::RangeInclusive;
use std::time::Duration;

use serde_json::{Value, json};

use super::{Key, Referent, Table, Written};
use crate::{Problem, Span, Spanned};

/// The value of a table under one key. Checks skip a value that is missing or already refused, so one mistake is
/// reported once.
#[derive(Debug)]
#[must_use = "ends in `required`, `optional` or `or`"]
pub struct Field<'d, T> {
    table: Table<'d>,
    key: String,
    /// Its number among the declared keys, if no file is read.
    declared: Option<usize>,
    state: FieldState<T>,
}

#[derive(Debug)]
pub(super) enum FieldState<T> {
    Given(T, Span),
    /// The key is missing; this would be accepted.
    Missing(String),
    /// The problem has been recorded.
    Refused,
}

impl<'d, T> Field<'d, T> {
    pub(super) fn new(table: Table<'d>, key: &str, declared: Option<usize>, state: FieldState<T>) -> Self {
        Self { table, key: key.into(), declared, state }
    }

    pub(super) fn declare(self, change: impl FnOnce(&mut Key)) -> Self {
        self.table.log.amend(self.declared, change);
        self
    }

    /// The key's meaning, in a sentence or two, with its unit.
    pub fn about(self, meaning: &str) -> Self {
        self.declare(|key| meaning.clone_into(&mut key.about))
    }

    /// The accepted values in words: `[x, y] in meters`.
    pub fn words(self, words: &str) -> Self {
        self.rules(|| json!({ "title": words }))
    }

    /// Keywords of JSON Schema that restrict the accepted values more than their type does: what a later check
    /// refuses, or how the keys of a table are related. `null` removes a keyword.
    pub fn rules(self, keywords: impl FnOnce() -> Value) -> Self {
        self.declare(|key| key.extend(keywords()))
    }

    /// Sets what the advice about a missing key gives as accepted.
    pub(super) fn wanted(mut self, wanted: impl FnOnce() -> String) -> Self {
        if let FieldState::Missing(accepted) = &mut self.state {
            *accepted = wanted();
        }
        self
    }

    /// The key has no meaning without this one of the top level. The reader has to refuse it.
    pub fn needs(self, other: &str) -> Self {
        self.declare(|key| key.needs = Some(other.to_owned()))
    }

    /// What the text stands for.
    pub fn refers_to(self, what: Referent) -> Self {
        self.declare(|key| key.refers_to = Some(what))
    }

    /// What the key stands for, which the file chooses.
    pub fn named_after(self, what: Referent) -> Self {
        self.declare(|key| key.named_after = Some(what))
    }

    /// Refuses a value for which `holds` does not. `must` completes the sentence "`key` must …".
    pub fn check(self, holds: impl FnOnce(&T) -> bool, must: impl fmt::Display) -> Self {
        let message = format!("`{}` must {must}", self.key);
        self.try_map(
            |value, span| {
                if holds(&value) { Ok(value) } else { Err(span.problem(message).with_label("this value")) }
            },
        )
    }

    /// Converts the value. The span is its location.
    pub fn try_map<U>(self, convert: impl FnOnce(T, &Span) -> Result<U, Problem>) -> Field<'d, U> {
        let table = self.table;
        self.step(|value, span| convert(value, span).map_err(|problem| table.report(problem)).ok())
    }

    /// Continues reading inside the value, usually a table. If `read` returns `None`, it has recorded a problem.
    pub fn and_then<U>(self, read: impl FnOnce(T) -> Option<U>) -> Field<'d, U> {
        self.step(|value, _| read(value))
    }

    /// Converts the value with a conversion that cannot fail.
    pub fn map<U>(self, convert: impl FnOnce(T) -> U) -> Field<'d, U> {
        self.try_map(|value, _| Ok(convert(value)))
    }

    /// Keeps the value's location with the value.
    pub fn spanned(self) -> Field<'d, Spanned<T>> {
        self.try_map(|value, span| Ok(Spanned { value, span: span.clone() }))
    }

    /// The value. A missing key is a problem. `None` means that a problem has been recorded.
    #[must_use]
    pub fn required(self) -> Option<T> {
        let help = match &self.state {
            FieldState::Missing(wanted) => format!("add `{}`: {wanted}", self.key),
            _ => String::new(),
        };
        self.required_or(&help)
    }

    /// Like [`required`](Self::required), with advice in case the key is missing.
    #[must_use]
    pub fn required_or(self, help: &str) -> Option<T> {
        self.table.log.amend(self.declared, |key| key.required = !self.table.is_form);
        match self.state {
            FieldState::Given(value, _) => Some(value),
            FieldState::Refused => None,
            FieldState::Missing(_) => {
                let problem = self.table.span().problem(format!("`{}` is missing", self.key));
                let problem = problem.with_label("here").with_help(help);
                self.table.entries.missing.borrow_mut().push((self.key, problem));
                None
            }
        }
    }

    /// The value if it is there and valid.
    #[must_use]
    pub fn optional(self) -> Option<T> {
        if let FieldState::Given(value, _) = self.state { Some(value) } else { None }
    }

    /// The value, or `default` if the key is missing or its value invalid (which has been recorded).
    #[must_use]
    pub fn or(self, default: T) -> T {
        self.optional().unwrap_or(default)
    }

    /// Like [`or`](Self::or), with a default that is part of the key's declaration.
    #[must_use]
    pub fn default(self, default: T) -> T
    where
        T: Written,
    {
        self.rules(|| json!({ "default": default.written() })).or(default)
    }

    /// Like [`default`](Self::default), with the first of the `choices` that a [`one_of`](Table::one_of) offers.
    #[must_use]
    pub fn or_first(self, choices: &[(&str, T)]) -> T
    where
        T: Clone,
    {
        let (name, value) = &choices[0];
        self.rules(|| json!({ "default": name })).or(value.clone())
    }

    /// Processes a given value further. If `next` returns `None`, it has recorded a problem.
    fn step<U>(self, next: impl FnOnce(T, &Span) -> Option<U>) -> Field<'d, U> {
        let state = match self.state {
            FieldState::Given(value, span) => {
                next(value, &span).map_or(FieldState::Refused, |value| FieldState::Given(value, span))
            }
            FieldState::Missing(wanted) => FieldState::Missing(wanted),
            FieldState::Refused => FieldState::Refused,
        };
        Field { table: self.table, key: self.key, declared: self.declared, state }
    }
}

impl<'d, T> Field<'d, Vec<T>> {
    /// Reads every item, even if others fail. If `read` returns `None`, it has recorded a problem.
    pub fn each<U>(self, read: impl FnMut(T) -> Option<U>) -> Field<'d, Vec<U>> {
        // Collecting into an Option would stop at the first invalid item.
        self.and_then(|items| items.into_iter().map(read).collect::<Vec<_>>().into_iter().collect())
    }

    /// Like [`default`](Field::default), with no items.
    #[must_use]
    pub fn or_empty(self) -> Vec<T> {
        self.rules(|| json!({ "default": [] })).or(Vec::new())
    }
}

impl Field<'_, String> {
    /// Refuses an empty text.
    pub fn filled(self, must: impl fmt::Display) -> Self {
        self.rules(|| json!({ "minLength": 1 })).check(|text| !text.is_empty(), must)
    }
}

impl<T: PartialOrd + Written> Field<'_, T> {
    /// Refuses a value outside `range`.
    pub fn within(self, range: RangeInclusive<T>) -> Self {
        let (least, most) = (range.start().written(), range.end().written());
        let must = format!("lie between {least} and {most}");
        self.rules(|| json!({ "minimum": least, "maximum": most })).check(|value| range.contains(value), must)
    }

    /// Refuses a value below `least`.
    pub fn at_least(self, least: T) -> Self {
        let limit = least.written();
        let must = format!("be at least {limit}");
        self.rules(|| json!({ "minimum": limit })).check(|value| *value >= least, must)
    }

    /// Refuses a value that is not above `limit`.
    pub fn above(self, limit: T) -> Self {
        let must = format!("be greater than {}", limit.written());
        self.rules(|| json!({ "exclusiveMinimum": limit.written() })).check(|value| *value > limit, must)
    }
}

impl Field<'_, Duration> {
    /// Refuses no time at all.
    pub fn above_0(self) -> Self {
        let declared = self.rules(|| json!({ "minimum": null, "exclusiveMinimum": 0 }));
        declared.check(|time| !time.is_zero(), "be above 0")
    }
}
