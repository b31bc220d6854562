//! When a run ends: the `[stop]` of a scenario file.

use std::time::Duration;

use diagnostics::document::{FromItem, Item, Referent, Table};
use diagnostics::{Problem, Spanned};
use serde_json::{Value, json};

use super::world::MAP;

/// When a run ends before its time limit: as soon as the first of these conditions is met.
#[derive(Clone, Debug, Default)]
pub struct Stop {
    /// The robot has come to rest at one of these places.
    pub at: Vec<Spanned<String>>,
    /// One of these properties is violated.
    pub on_violation: SomeProperties,
    /// All of these properties have their final verdicts.
    pub when_settled: SomeProperties,
    /// How long the run continues after that.
    pub after: Duration,
    /// For these properties, nothing comes after the end of the run, whatever ends it: what is still pending then and
    /// has no deadline is violated.
    pub final_for: SomeProperties,
}

/// Some of a scenario's properties.
#[derive(Clone, Debug, Default)]
pub enum SomeProperties {
    /// None.
    #[default]
    None,
    /// All.
    All,
    /// Those with these names.
    Named(Vec<Spanned<String>>),
}

impl Stop {
    pub(super) fn read(root: Table<'_>) -> Self {
        let about = "When the run ends before `execution.max_time_s`: at the first of these.";
        let Some(table) = root.table("stop").about(about).optional() else { return Self::default() };
        let at = table.get("at").about("When the robot has come to rest at this place, or at one of several.");
        let Names(at) = at.refers_to(Referent::Place).needs(MAP).or(Names(Vec::new()));
        let some = |key, about| {
            let some = table.get(key).about(about).refers_to(Referent::Property);
            some.rules(|| json!({ "default": false })).or(SomeProperties::None)
        };
        let on_violation = some(
            "on_violation",
            "When a property is violated: any (`true`), or one of those named. Without monitors, the run continues.",
        );
        let when_settled = some(
            "when_settled",
            "When properties have their final verdicts: all of them (`true`), or those named. Without monitors, the run \
             continues.",
        );
        let final_for = some(
            "final_for",
            "Properties for which nothing comes after the end of the run: all (`true`), or those named. What is still \
             pending then, such as an `eventually` that never came, is violated; what has a deadline after the end \
             stays inconclusive. An interrupted run has not come to its end.",
        );
        let after =
            table.seconds("after_s").about("How long the run continues after that, in seconds; 0 if not given.");
        let ends = ["at", "on_violation", "when_settled"];
        let after = after.spanned().optional();
        if let Some(after) = &after
            && !ends.into_iter().any(|key| table.has(key))
        {
            let problem = after.span.problem("`stop.after_s` is a time to wait after something that is not given");
            let help = format!("add one of {}; the whole run is limited by `execution.max_time_s`", ends.join(", "));
            table.report(problem.with_label("after what?").with_help(help));
        }
        Self { at, on_violation, when_settled, after: after.map_or(Duration::ZERO, |after| after.value), final_for }
    }
}

impl SomeProperties {
    /// Whether the property with this name is one of them.
    #[must_use]
    pub fn has(&self, property: &str) -> bool {
        match self {
            Self::None => false,
            Self::All => true,
            Self::Named(names) => names.iter().any(|name| name.value == property),
        }
    }

    /// The properties that the file names.
    pub fn names(&self) -> &[Spanned<String>] {
        if let Self::Named(names) = self { names } else { &[] }
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

impl FromItem<'_> for SomeProperties {
    fn wanted() -> String {
        "true, false, the name of a property, or an array of names".into()
    }

    fn takes() -> Value {
        json!({ "title": Self::wanted(), "anyOf": [bool::takes(), String::takes(), <Vec<String>>::takes()] })
    }

    fn from_item(item: &Item<'_>) -> Result<Self, Vec<Problem>> {
        match item.as_boolean() {
            Some(true) => Ok(Self::All),
            Some(false) => Ok(Self::None),
            None if item.as_text().is_none() && item.as_array().is_none() => Err(vec![item.wrong(&Self::wanted())]),
            None => item.get().map(|Names(names)| Self::Named(names)),
        }
    }
}
