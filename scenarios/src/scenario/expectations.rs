//! The expected outcome of a run: the `[expect]` of a scenario file.

use diagnostics::Spanned;
use diagnostics::document::{Referent, Table};
use monitors::Outcome;
use recording::Expected;

use super::world::MAP;

/// The keys of `[expect]` that are not the name of a property.
pub(super) const KEYS: [&str; 7] =
    ["errors", "max_collisions", "max_localization_m", "min_battery_pct", "not_reached", "reached", "satisfied"];

/// The expected results of a run.
#[derive(Clone, Debug, Default)]
pub struct Expectations {
    /// The expected outcome of each property; `None` if any is.
    pub outcomes: Vec<(Spanned<String>, Option<Outcome>)>,
    /// Properties that are written here, with their formulas. They must be satisfied unless `outcomes` has them.
    pub satisfied: Vec<(Spanned<String>, String)>,
    /// Places that must have been reached.
    pub reached: Vec<Spanned<String>>,
    /// Places that must not have been reached.
    pub not_reached: Vec<Spanned<String>>,
    /// Skills, components and nodes of the tree in which an error must occur; in no other may one.
    pub errors: Vec<Spanned<String>>,
    /// The maximum number of collisions.
    pub max_collisions: Option<u64>,
    /// The minimum charge of the battery, in percent.
    pub min_battery_pct: Option<f64>,
    /// The maximum error of localization, in meters.
    pub max_localization_m: Option<f64>,
}

impl Expectations {
    /// Their record, as that of a scenario whose properties are requirements.
    pub fn record(&self) -> Expected {
        let names = |names: &[Spanned<String>]| names.iter().map(|name| name.value.clone()).collect();
        let outcomes = self.outcomes.iter().filter_map(|(name, outcome)| Some((name.value.clone(), (*outcome)?)));
        let open = self.outcomes.iter().filter(|(_, outcome)| outcome.is_none());
        let is_other = |name: &str| self.outcomes.iter().any(|(other, _)| other.value == name);
        let satisfied = self.satisfied.iter().map(|(name, _)| &name.value).filter(|name| !is_other(name));
        let satisfied = satisfied.map(|name| (name.clone(), Outcome::Satisfied));
        Expected {
            outcomes: outcomes.chain(satisfied).collect(),
            open: open.map(|(name, _)| name.value.clone()).collect(),
            others_are_open: false,
            reached: names(&self.reached),
            not_reached: names(&self.not_reached),
            errors: names(&self.errors),
            max_collisions: self.max_collisions,
            min_battery_pct: self.min_battery_pct,
            max_localization_m: self.max_localization_m,
        }
    }

    pub(super) fn read(root: Table<'_>) -> Self {
        let about = "The expected outcome of the run. A run is *as expected* if it meets everything that stands here, if no other \
                     property is violated, if no verdict is unsure, and if no error occurs that `errors` does not name. The \
                     words mean the same in `run`, in a campaign with its dataset and its goal, and in every other result; the exit status of `run` \
                     depends on it.";
        let Some(table) = root.table("expect").about(about).optional() else { return Self::default() };
        let names = |key, about, what| table.get(key).about(about).words("an array of names").refers_to(what);
        let places = |key, about| names(key, about, Referent::Place).needs(MAP).or_empty();
        let mut expect = Self {
            reached: places(
                "reached",
                "Places where the robot must have come to rest. One where it stands from the start counts once it has \
                 left and come back to rest there.",
            ),
            not_reached: places(
                "not_reached",
                "Places where the robot must never have been, not even on its way: in no step was its true position \
                 within the area, or within the tolerance of the point (with any heading).",
            ),
            errors: names(
                "errors",
                "Skills, components and nodes of the tree in which an error must occur: a program that fails, an \
                 expression or script that cannot be evaluated, a leaf that does not answer in time. An error elsewhere \
                 makes the run not as expected.",
                Referent::Process,
            )
            .or_empty(),
            max_collisions: table
                .get("max_collisions")
                .about("The maximum number of collisions.")
                .needs(MAP)
                .optional(),
            min_battery_pct: table
                .number("min_battery_pct")
                .about("The minimum charge of the battery, in percent.")
                .within(0.0..=100.0)
                .needs(MAP)
                .optional(),
            max_localization_m: table
                .number("max_localization_m")
                .about("The maximum localization error, in meters.")
                .within(0.0..=1e6)
                .needs(MAP)
                .optional(),
            satisfied: read_satisfied(table),
            outcomes: Vec::new(),
        };
        let outcomes = Outcome::ALL.map(|outcome| (outcome.name(), Some(outcome)));
        let outcomes = [&outcomes[..], &[("any", None)]].concat();
        for (property, span) in table.names("PROPERTY") {
            let outcome = table.one_of(property, &outcomes).about(
                "The expected verdict of a property; `any` if the property is a question, and not a requirement.",
            );
            let outcome = outcome.named_after(Referent::Property).optional();
            let name = Spanned { value: property.to_owned(), span: span.clone() };
            expect.outcomes.extend(outcome.map(|outcome| (name, outcome)));
        }
        expect
    }
}

fn read_satisfied(expect: Table<'_>) -> Vec<(Spanned<String>, String)> {
    let about = "Properties that are written here instead of in a file. Each is monitored, and must be satisfied unless \
                 `expect.NAME` is another outcome.";
    let Some(table) = expect.table("satisfied").about(about).optional() else { return Vec::new() };
    let properties = table.names_as_written("NAME").into_iter().filter_map(|(name, span)| {
        let formula = table.text(name).about("The formula of the property `NAME` in the SCOPE language.").optional();
        Some((Spanned { value: name.to_owned(), span: span.clone() }, formula?))
    });
    properties.collect()
}

#[cfg(test)]
mod tests {
    use super::KEYS;
    use crate::scenario::ScenarioFile;

    #[test]
    fn no_property_has_the_name_of_another_expectation() {
        let schema = ScenarioFile::schema();
        let keys = schema["properties"]["expect"]["properties"].as_object().expect("a table");
        let keys: Vec<&str> = keys.keys().map(String::as_str).filter(|key| *key != "PROPERTY").collect();
        assert_eq!(keys, KEYS);
    }
}
