//! A single value of a document, and the types that it can be converted to.

use std::time::Duration;

use serde_json::{Value, json};

use super::log::Log;
use super::node::{Kind, Node};
use super::{Table, key};
use crate::{Problem, Span, Spanned};

/// A value of a document whose type is not yet determined.
#[derive(Clone, Debug)]
pub struct Item<'d> {
    node: &'d Node,
    /// The name of the value in problems: "`origin`", "item 2 of `origin`".
    name: String,
    log: &'d Log,
    /// Its number among the declared keys.
    declared: Option<usize>,
}

impl<'d> Item<'d> {
    pub(super) fn new(node: &'d Node, name: String, log: &'d Log) -> Self {
        Self { node, name, log, declared: None }
    }

    pub(super) fn of(self, declared: Option<usize>) -> Self {
        Self { declared, ..self }
    }

    /// The location of the value; the header for a table that has one.
    #[must_use]
    pub fn span(&self) -> &'d Span {
        &self.node.span
    }

    /// The number, if the value is one (integers included). May be infinite or NaN.
    #[must_use]
    pub fn as_number(&self) -> Option<f64> {
        match self.node.kind {
            Kind::Real(number) => Some(number),
            Kind::Integer(number) => Some(number as f64),
            _ => None,
        }
    }

    /// The integer, if the value is one that fits into 64 bits.
    #[must_use]
    pub fn as_integer(&self) -> Option<i64> {
        if let Kind::Integer(number) = self.node.kind { number.try_into().ok() } else { None }
    }

    /// The boolean, if the value is one.
    #[must_use]
    pub fn as_boolean(&self) -> Option<bool> {
        if let Kind::Boolean(value) = self.node.kind { Some(value) } else { None }
    }

    /// The text, if the value is one.
    #[must_use]
    pub fn as_text(&self) -> Option<&'d str> {
        if let Kind::Text(text) = &self.node.kind { Some(text) } else { None }
    }

    /// The items, if the value is an array.
    #[must_use]
    pub fn as_array(&self) -> Option<Vec<Self>> {
        let Kind::Array(nodes) = &self.node.kind else { return None };
        let item = |(place, node)| {
            let item = Self::new(node, format!("item {} of {}", place + 1, self.name), self.log);
            item.of(self.log.declare_item(self.declared, place))
        };
        Some(nodes.iter().enumerate().map(item).collect())
    }

    /// The table, if the value is one. Once one of its keys has been asked for, all others must be asked for too.
    #[must_use]
    pub fn as_table(&self) -> Option<Table<'d>> {
        let Kind::Table(entries) = &self.node.kind else { return None };
        Some(Table::open(entries, self.span(), self.log, self.declared))
    }

    /// The problem that the value is not what it must be (such as "a number"), with what it is instead.
    #[must_use]
    pub fn wrong(&self, wanted: &str) -> Problem {
        let problem = self.span().problem(format!("{} must be {wanted}", self.name));
        problem.with_label(format!("this is {}", self.node.kind.name()))
    }

    /// Converts the value to a `T`.
    ///
    /// # Errors
    /// The reasons why it is not a `T`.
    pub fn get<T: FromItem<'d>>(&self) -> Result<T, Vec<Problem>> {
        T::from_item(self)
    }
}

/// A type that a value of a document can be converted to.
pub trait FromItem<'d>: Sized {
    /// The accepted values, as a phrase that follows "must be": "a number".
    fn wanted() -> String;

    /// The accepted values, as JSON Schema; `title` has them in words, unless the type is enough.
    #[must_use]
    fn takes() -> Value {
        json!({ "title": Self::wanted() })
    }

    /// The value where keys are declared without a file: `table`, if this is a table or contains one.
    #[must_use]
    fn declaring(_table: Table<'d>) -> Option<Self> {
        None
    }

    /// Converts `item`.
    ///
    /// # Errors
    /// Everything that is wrong with it.
    fn from_item(item: &Item<'d>) -> Result<Self, Vec<Problem>>;
}

/// Implements [`FromItem`] for a type with a simple conversion.
macro_rules! plain {
    ($type:ty, $takes:tt, $wanted:literal, $convert:expr) => {
        impl<'d> FromItem<'d> for $type {
            fn wanted() -> String {
                $wanted.into()
            }

            fn takes() -> Value {
                json!($takes)
            }

            fn from_item(item: &Item<'d>) -> Result<Self, Vec<Problem>> {
                let convert: fn(&Item<'d>) -> Option<Self> = $convert;
                convert(item).ok_or_else(|| vec![item.wrong($wanted)])
            }
        }
    };
}

plain!(f64, { "type": "number" }, "a number", |item| item.as_number().filter(|number| number.is_finite()));
plain!(i64, { "type": "integer" }, "an integer", Item::as_integer);
plain!(u64, { "type": "integer", "minimum": 0 }, "an integer of at least 0", |item| {
    if let Kind::Integer(number) = item.node.kind { number.try_into().ok() } else { None }
});
plain!(bool, { "type": "boolean" }, "true or false", Item::as_boolean);
plain!(String, { "type": "string" }, "a string", |item| item.as_text().map(str::to_owned));
plain!(Duration, { "type": "number", "minimum": 0, "maximum": 1_000_000_000 }, "a number of seconds from 0 to 1e9", |item| {
    let seconds = item.as_number().filter(|seconds| (0.0..=1e9).contains(seconds))?;
    Duration::try_from_secs_f64(seconds).ok()
});
plain!(Item<'d>, {}, "a value", |item| Some(item.clone()));

impl<'d> FromItem<'d> for Table<'d> {
    fn wanted() -> String {
        "a table".into()
    }

    fn takes() -> Value {
        key::table()
    }

    fn declaring(table: Table<'d>) -> Option<Self> {
        Some(table)
    }

    fn from_item(item: &Item<'d>) -> Result<Self, Vec<Problem>> {
        item.as_table().ok_or_else(|| vec![item.wrong(&Self::wanted())])
    }
}

impl<'d, T: FromItem<'d>> FromItem<'d> for Spanned<T> {
    fn wanted() -> String {
        T::wanted()
    }

    fn takes() -> Value {
        T::takes()
    }

    fn declaring(table: Table<'d>) -> Option<Self> {
        Some(Self { value: T::declaring(table)?, span: table.span().clone() })
    }

    fn from_item(item: &Item<'d>) -> Result<Self, Vec<Problem>> {
        Ok(Self { value: item.get()?, span: item.span().clone() })
    }
}

impl<'d, T: FromItem<'d>> FromItem<'d> for Vec<T> {
    fn wanted() -> String {
        format!("an array, each item {}", T::wanted())
    }

    fn takes() -> Value {
        json!({ "type": "array", "items": T::takes() })
    }

    fn declaring(table: Table<'d>) -> Option<Self> {
        if table.log.is_without_file() { Some(vec![T::declaring(table)?]) } else { None }
    }

    fn from_item(item: &Item<'d>) -> Result<Self, Vec<Problem>> {
        let Some(items) = item.as_array() else { return Err(vec![item.wrong(&Self::wanted())]) };
        let (mut values, mut problems) = (Vec::with_capacity(items.len()), Vec::new());
        for item in &items {
            match item.get() {
                Ok(value) => values.push(value),
                Err(more) => problems.extend(more),
            }
        }
        if problems.is_empty() { Ok(values) } else { Err(problems) }
    }
}

impl<'d, T: FromItem<'d>, const N: usize> FromItem<'d> for [T; N] {
    fn wanted() -> String {
        format!("an array of {N} items, each {}", T::wanted())
    }

    fn takes() -> Value {
        json!({ "type": "array", "items": T::takes(), "minItems": N, "maxItems": N })
    }

    fn from_item(item: &Item<'d>) -> Result<Self, Vec<Problem>> {
        if item.as_array().is_none() {
            return Err(vec![item.wrong(&Self::wanted())]);
        }
        let values: Vec<T> = item.get()?;
        let count = values.len();
        values.try_into().map_err(|_| vec![item.wrong(&Self::wanted()).with_label(format!("this has {count}"))])
    }
}
