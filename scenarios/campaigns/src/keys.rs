//! The keys of a campaign file.

use scenarios::schema::{Key, flag, json_schema, list, number, one_of, or, plain, scalar, table, text, whole, with};
use serde_json::{Value, json};

use super::Measure;
use super::file::{MAX_RUNS, MAX_STEPS, MAX_VALUES};

/// The JSON schema of a campaign file.
#[must_use]
pub fn schema() -> Value {
    let sampling = |name: &str| json!({ "properties": { "sampling": { "const": name } }, "required": ["sampling"] });
    let not = |key: &str| json!({ "not": { "required": [key] } });
    let estimate = json!({ "properties": { "goal": { "required": ["estimate"] } }, "required": ["goal"] });
    let rules = json!({
        "dependentRequired": { "parameters": ["sampling"] },
        "if": sampling("grid"),
        "then": not("runs"),
        "else": { "allOf": [not("repeats"), { "anyOf": [{ "required": ["runs"] }, estimate] }] },
        "allOf": [{ "if": sampling("latin_hypercube"), "then": not("goal") }],
    });
    json_schema("A campaign of steward", rules, &keys())
}

/// All keys of a campaign file.
#[must_use]
pub fn keys() -> Vec<Key> {
    let mut keys = design();
    keys.extend(parameters());
    keys.extend(goal_and_model());
    keys
}

/// The keys that decide which runs there are, apart from the parameters.
fn design() -> Vec<Key> {
    let count = || with(whole(1), json!({ "maximum": MAX_RUNS }));
    let measures = one_of(&Measure::ALL.map(Measure::name));
    vec![
        Key::new("scenario", "The scenario to run: a file beside this one, or a name.", text()).required(),
        Key::new("about", "The question that the campaign answers, in one line.", or(text(), "")),
        Key::new(
            "sampling",
            "How runs are distributed over the parameters: all combinations (`grid`), independent random values \
             (`random`), one run in each of equal parts of every range (`latin_hypercube`), or an even sequence \
             (`sobol`). Required with parameters.",
            or(one_of(&["grid", "random", "latin_hypercube", "sobol"]), "random"),
        ),
        Key::new(
            "runs",
            "The number of runs; with a goal, the maximum. Not for a grid; otherwise required, unless the goal is an \
             estimate.",
            count(),
        ),
        Key::new("repeats", "How many times each combination of a grid is run.", or(count(), 1)),
        Key::new("seed", "The seed of all randomness in the campaign.", or(whole(0), 1)),
        Key::new(
            "seeds",
            "The root seeds of the runs: run k has `seed` + k (`each`), or all runs have `seed` (`same`), so that \
             only the parameters differ.",
            or(one_of(&["each", "same"]), "each"),
        ),
        Key::new(
            "set",
            "Settings of every run, in the syntax of `--set`.",
            or(list("an array of strings `KEY=VALUE`", &text()), json!([])),
        ),
        Key::new(
            "measures",
            "What the page plots against the parameters, besides the properties.",
            or(list(&format!("an array of {}", Measure::ALL.map(Measure::name).join(", ")), &measures), json!([])),
        ),
    ]
}

fn any_number() -> Value {
    json!({ "type": "number" })
}

fn positive() -> Value {
    json!({ "type": "number", "exclusiveMinimum": 0 })
}

/// The numbers between two others, exclusive.
fn between(least: f64, most: f64) -> Value {
    json!({ "type": "number", "exclusiveMinimum": plain(least), "exclusiveMaximum": plain(most) })
}

/// How the keys of a parameter may be combined.
fn parameter_rules() -> Value {
    let one = ["values", "from", "normal", "exponential"].map(|key| json!({ "required": [key] }));
    json!({
        "oneOf": one,
        "dependentRequired": {
            "from": ["to"], "to": ["from"], "steps": ["from"], "scale": ["from"], "whole": ["from"],
        },
        "allOf": [
            {
                "if": { "properties": { "whole": { "const": true } }, "required": ["whole"] },
                "then": {
                    "properties": { "from": { "type": "integer" }, "to": { "type": "integer" } },
                    "not": { "anyOf": [{ "required": ["steps"] }, { "required": ["scale"] }] },
                },
            },
            {
                "if": { "properties": { "scale": { "const": "log" } }, "required": ["scale"] },
                "then": { "properties": { "from": { "exclusiveMinimum": 0 } } },
            },
        ],
    })
}

fn parameters() -> Vec<Key> {
    let mut keys = vec![
        Key::new(
            "parameters[]",
            "A key of the scenario that varies, with one of `values`, `from` and `to`, `normal` and `exponential`.",
            table(parameter_rules()),
        ),
        Key::new(
            "parameters[].key",
            "The key, in the syntax of `--set`.",
            with(text(), json!({ "title": "a dotted key such as `battery.initial_pct`" })),
        )
        .required(),
        Key::new(
            "parameters[].name",
            "Its name in `[model]` and reports.",
            with(text(), json!({ "title": "a name of letters, digits and `_`", "minLength": 1 })),
        ),
        Key::new(
            "parameters[].about",
            "A description with its unit, for reports.",
            with(text(), json!({ "minLength": 1 })),
        ),
    ];
    keys.extend(domains());
    keys
}

/// The values of a parameter.
fn domains() -> Vec<Key> {
    let values = with(
        list("an array of strings, numbers, true or false", &scalar()),
        json!({ "minItems": 1, "maxItems": MAX_VALUES }),
    );
    vec![
        Key::new("parameters[].values", "Its values.", values),
        Key::new("parameters[].from", "The lower end of a range.", any_number()),
        Key::new("parameters[].to", "The upper end of a range.", any_number()),
        Key::new(
            "parameters[].steps",
            "This many values, evenly spaced over the range. Required for a grid.",
            with(whole(2), json!({ "maximum": MAX_STEPS })),
        ),
        Key::new(
            "parameters[].scale",
            "What is evenly spaced: the values or their logarithms.",
            or(one_of(&["linear", "log"]), "linear"),
        ),
        Key::new("parameters[].whole", "Whether to use only the whole numbers in the range.", or(flag(), false)),
        Key::new("parameters[].normal", "A normal distribution.", table(json!({}))),
        Key::new("parameters[].normal.mean", "Its mean.", any_number()).required(),
        Key::new("parameters[].normal.sd", "Its standard deviation.", positive()).required(),
        Key::new("parameters[].normal.min", "The lower end at which the distribution is truncated.", any_number()),
        Key::new("parameters[].normal.max", "The upper end at which the distribution is truncated.", any_number()),
        Key::new("parameters[].exponential", "An exponential distribution.", table(json!({}))),
        Key::new("parameters[].exponential.mean", "Its mean.", positive()).required(),
    ]
}

fn goal_and_model() -> Vec<Key> {
    let goal = json!({
        "if": { "required": ["estimate"] },
        "then": {
            "required": ["half_width", "confidence"],
            "propertyNames": { "enum": ["estimate", "half_width", "confidence"] },
        },
        "else": {
            "required": ["test", "bound", "indifference", "error"],
            "propertyNames": { "enum": ["test", "bound", "indifference", "error"] },
        },
    });
    let of = "the name of a property, or `expectation` for a run that is not as the scenario expects";
    vec![
        Key::new("goal", "The campaign stops as soon as this is known: an estimate, or a test.", table(goal)),
        Key::new("goal.estimate", &format!("The event whose probability is estimated: {of}."), text()),
        Key::new("goal.half_width", "Half the width of an interval that is narrow enough.", number(0.0005, 0.25)),
        Key::new("goal.confidence", "The confidence of the interval.", between(0.5, 1.0)),
        Key::new("goal.test", &format!("The event whose probability is compared with `bound`: {of}."), text()),
        Key::new("goal.bound", "The probability to compare it with.", between(0.0, 1.0)),
        Key::new(
            "goal.indifference",
            "The distance from `bound` within which either answer is acceptable.",
            between(0.0, 0.5),
        ),
        Key::new("goal.error", "The acceptable probability of a wrong answer.", between(0.0, 0.5)),
        Key::new(
            "model",
            "A model to compare with the results: something happens as soon as a quantity exceeds a bound.",
            table(json!({})),
        ),
        Key::new("model.of", &format!("What happens: {of}."), text()).required(),
        Key::new("model.about", "The model, in words.", or(text(), "")),
        Key::new("model.quantity", "A formula of parameter names, numbers, `+ - * /` and parentheses.", text())
            .required(),
        Key::new("model.bound", "The event happens if the quantity is greater than this.", any_number()).required(),
    ]
}
