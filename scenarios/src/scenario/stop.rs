//! When a run ends: the `[stop]` of a scenario file.

use std::time::Duration;

use diagnostics::document::{FromItem, Item, Table};
use diagnostics::{Problem, Spanned};
use serde_json::{Value, json};

use super::world::MAP;

/// When a run ends before its time limit: as soon as the first of these conditions is met.
#[derive(Clone, Debug, Default)]
pub struct Stop {
    /// The robot has come to rest at one of these places.
    pub at: Vec<Spanned<String>>,
    /// A property is violated.
    pub on_violation: StopOnViolation,
    /// Every property has its final verdict.
    pub when_settled: bool,
    /// How long the run continues after that.
    pub after: Duration,
}

/// The properties whose violation ends a run.
#[derive(Clone, Debug, Default)]
pub enum StopOnViolation {
    /// None.
    #[default]
    Never,
    /// Any.
    OfAny,
    /// These.
    Of(Vec<Spanned<String>>),
}

impl Stop {
    pub(super) fn read(root: Table<'_>) -> Self {
        let about = "When the run ends before `execution.max_time_s`: at the first of these.";
        let Some(table) = root.table("stop").about(about).optional() else { return Self::default() };
        let at = table.get("at").about("When the robot has come to rest at this place, or at one of several.");
        let Names(at) = at.needs(MAP).or(Names(Vec::new()));
        let on_violation = table.get("on_violation").about(
            "When a property is violated: any (`true`), or one of those named. Without monitors, the run continues.",
        );
        let when_settled = table.boolean("when_settled").about("When every property has a final verdict.");
        let after =
            table.seconds("after_s").about("How long the run continues after that, in seconds; 0 if not given.");
        let ends = ["at", "on_violation", "when_settled"];
        let after = after.spanned().optional();
        if let Some(after) = &after
            && !ends.into_iter().any(|key| table.has(key))
        {
            let problem =
                after.span.problem("`stop.after_s` says how long to wait after something, but not after what");
            let help = format!("add one of {}; the whole run is limited by `execution.max_time_s`", ends.join(", "));
            table.report(problem.with_label("after what?").with_help(help));
        }
        Self {
            at,
            on_violation: on_violation.rules(|| json!({ "default": false })).or(StopOnViolation::Never),
            when_settled: when_settled.default(false),
            after: after.map_or(Duration::ZERO, |after| after.value),
        }
    }
}

impl StopOnViolation {
    /// Whether a violation of the property with this name ends a run.
    #[must_use]
    pub fn concerns(&self, property: &str) -> bool {
        match self {
            Self::Never => false,
            Self::OfAny => true,
            Self::Of(names) => names.iter().any(|name| name.value == property),
        }
    }

    /// The properties that the file names.
    pub fn names(&self) -> &[Spanned<String>] {
        if let Self::Of(names) = self { names } else { &[] }
    }
}

/// One or several names.
pub(super) struct Names(pub(super) Vec<Spanned<String>>);

impl FromItem<'_> for Names {
    fn wanted() -> String {
        "a name, or an array of names".into()
    }

    fn takes() -> Value {
        json!({ "title": Self::wanted(), "anyOf": [String::takes(), <Vec<String>>::takes()] })
    }

    fn from_item(item: &Item<'_>) -> Result<Self, Vec<Problem>> {
        if let Some(name) = item.as_text() {
            return Ok(Self(vec![Spanned { value: name.to_owned(), span: item.span().clone() }]));
        }
        if item.as_array().is_none() {
            return Err(vec![item.wrong(&Self::wanted())]);
        }
        item.get().map(Self)
    }
}

impl FromItem<'_> for StopOnViolation {
    fn wanted() -> String {
        "true, false, the name of a property, or an array of names".into()
    }

    fn takes() -> Value {
        json!({ "title": Self::wanted(), "anyOf": [bool::takes(), String::takes(), <Vec<String>>::takes()] })
    }

    fn from_item(item: &Item<'_>) -> Result<Self, Vec<Problem>> {
        match item.as_boolean() {
            Some(true) => Ok(Self::OfAny),
            Some(false) => Ok(Self::Never),
            None if item.as_text().is_none() && item.as_array().is_none() => Err(vec![item.wrong(&Self::wanted())]),
            None => item.get().map(|Names(names)| Self::Of(names)),
        }
    }
}
