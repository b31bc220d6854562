//! The campaign file: what a user writes, read and checked as far as possible without the scenario.

use diagnostics::document::{Document, Field, Key, Referent, Table, Written};
use diagnostics::{FileProblems, Problem, Span, Spanned};
use scenarios::names::unknown;
use serde_json::{Value, json};

use super::Measure;
use super::model::{EVENT, Model};
use super::parameter::{Parameter, ParameterDomain, normal_cdf};
use super::sampling::{MAX_SOBOL_DIMENSIONS, Sampling};
use super::statistics::{Confidence, Precision, Sprt, StatisticsError};

/// The greatest number of runs of a campaign.
pub const MAX_RUNS: u64 = 100_000_000;
/// The greatest length of a list of values: the scenario checks each of them before the first run.
const MAX_VALUES: u64 = 1000;
/// The greatest number of steps of a range.
const MAX_STEPS: u64 = 1_000_000;

/// A campaign file.
#[derive(Clone, Debug)]
pub struct CampaignFile {
    /// The question that the campaign answers, in one line.
    pub about: String,
    /// The scenario, by name or as a path relative to the file.
    pub scenario: Spanned<String>,
    /// The seed of all the campaign's randomness.
    pub seed: u64,
    /// The root seeds of the runs.
    pub seeds: Seeds,
    /// Settings of every run, in the syntax of `--set`.
    pub set: Vec<Spanned<String>>,
    /// How runs are distributed over the parameters.
    pub sampling: Sampling,
    /// What varies.
    pub parameters: Vec<Parameter>,
    /// The maximum number of runs.
    pub runs: u64,
    /// When fewer runs are enough.
    pub goal: Option<Goal>,
    /// The values plotted against the parameters.
    pub measures: Vec<Spanned<Measure>>,
    /// The model with which the results are compared.
    pub model: Option<Model>,
}

/// The root seeds of the runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Seeds {
    /// Run k has the campaign's seed plus k.
    Each,
    /// All runs have the campaign's seed: only the parameters differ.
    Same,
}

/// A statistical goal.
#[derive(Clone, Debug)]
pub struct Goal {
    /// The event whose probability is in question: a property's name stands for its violation, and `expectation` for a
    /// run that is not as the scenario expects.
    pub of: Spanned<String>,
    /// The question.
    pub question: Question,
}

/// A question about a probability.
#[derive(Clone, Debug)]
pub enum Question {
    /// Its value, to within a half width.
    Estimate(Precision),
    /// On which side of a bound it is.
    Test(Sprt),
}

impl CampaignFile {
    /// Reads a campaign; `name` is its name in diagnostics.
    ///
    /// # Errors
    /// Everything that is wrong with the text.
    pub fn parse(name: &str, text: &str) -> Result<Self, FileProblems> {
        Document::parse_toml(name, text)?.read(read)
    }

    /// All keys of a campaign file.
    #[must_use]
    pub fn keys() -> Vec<Key> {
        Key::all(read)
    }

    /// The JSON schema of a campaign file.
    #[must_use]
    pub fn schema() -> Value {
        let sampling =
            |name: &str| json!({ "properties": { "sampling": { "const": name } }, "required": ["sampling"] });
        let not = |key: &str| json!({ "not": { "required": [key] } });
        let estimate = json!({ "properties": { "goal": { "required": ["estimate"] } }, "required": ["goal"] });
        let rules = json!({
            "dependentRequired": { "parameters": ["sampling"] },
            "if": sampling("grid"),
            "then": not("runs"),
            "else": { "allOf": [not("repeats"), { "anyOf": [{ "required": ["runs"] }, estimate] }] },
            "allOf": [{ "if": sampling("latin_hypercube"), "then": not("goal") }],
        });
        Key::json_schema("A campaign of steward", rules, &Self::keys())
    }
}

fn read(root: Table<'_>) -> Option<CampaignFile> {
    let scenario = root.text("scenario").about("The scenario to run: a file beside this one, or a name.");
    let scenario = scenario.refers_to(Referent::Scenario);
    let scenario = scenario.spanned().required();
    let about = root.text("about").about("The question that the campaign answers, in one line.");
    let about = about.default(String::new());
    let sampling = read_sampling(root);
    // Whether it is required depends on the design.
    let runs = root.form(true)?.get::<u64>("runs").within(1..=MAX_RUNS).spanned().about(
        "The number of runs; with a goal, the maximum. Not for a grid; otherwise required, unless the goal is an \
         estimate.",
    );
    let repeats = root.get::<u64>("repeats").within(1..=MAX_RUNS).rules(|| json!({ "default": 1 })).spanned();
    let repeats = repeats.about("How many times each combination of a grid is run.");
    let seed = root.get::<u64>("seed").about("The seed of all randomness in the campaign.").default(1);
    let kinds = [("each", Seeds::Each), ("same", Seeds::Same)];
    let seeds = root.one_of("seeds", &kinds).about(
        "The root seeds of the runs: run k has `seed` + k (`each`), or all runs have `seed` (`same`), so that \
         only the parameters differ.",
    );
    let seeds = seeds.or_first(&kinds);
    let set = root.get("set").words("an array of strings `KEY=VALUE`").refers_to(Referent::Setting);
    let set = set.about("Settings of every run, in the syntax of `--set`.").or_empty();
    let measures = read_measures(root);
    let parameters = root
        .tables("parameters")
        .rules(relations_of_parameters)
        .about("A key of the scenario that varies, with one of `values`, `from` and `to`, `normal` and `exponential`.");
    let parameters = parameters.each(read_parameter);
    let parameters = if_given(root, "parameters", parameters, Vec::new());
    let goal = root.table("goal").rules(forms_of_goals);
    let goal = goal.about("The campaign stops as soon as this is known: an estimate, or a test.").and_then(read_goal);
    let goal = if_given(root, "goal", goal.map(Some), None);
    let model = root
        .table("model")
        .about("A model to compare with the results: something happens as soon as a quantity exceeds a bound.");
    let model = model.and_then(|table| Model::read(table));
    let model = if_given(root, "model", model.map(Some), None);
    // What follows relates keys to each other: it would only repeat what is wrong with one of them.
    let (sampling, parameters, goal, model) = (sampling?, parameters?, goal?, model?);
    check_parameters(root, &sampling, &parameters);
    model.iter().for_each(|model| model.check(root, &parameters));
    let runs = if sampling.value == Sampling::Grid {
        refuse_given(root, runs, "a grid has one run per combination: set `repeats` for more");
        grid_runs(root, &parameters, repeats)
    } else {
        refuse_given(root, repeats, "only a grid repeats its runs: set `runs`");
        settled_runs(root, sampling.value, goal.as_ref(), runs)
    };
    let (scenario, sampling, runs, measures) = (scenario?, sampling.value, runs?, measures?);
    Some(CampaignFile { about, scenario, seed, seeds, set, sampling, parameters, runs, goal, measures, model })
}

/// The value of a key, or `otherwise` if the key is missing. None if its value is invalid, which has been recorded.
fn if_given<T>(root: Table<'_>, key: &str, field: Field<'_, T>, otherwise: T) -> Option<T> {
    if root.has(key) { field.required() } else { Some(otherwise) }
}

/// The design, which must be given with parameters.
fn read_sampling(root: Table<'_>) -> Option<Spanned<Sampling>> {
    let samplings = [
        ("grid", Sampling::Grid),
        ("random", Sampling::Random),
        ("latin_hypercube", Sampling::LatinHypercube),
        ("sobol", Sampling::Sobol),
    ];
    let sampling = root.one_of("sampling", &samplings).rules(|| json!({ "default": "random" })).spanned().about(
        "How runs are distributed over the parameters: all combinations (`grid`), independent random values \
         (`random`), one run in each of equal parts of every range (`latin_hypercube`), or an even sequence \
         (`sobol`). Required with parameters.",
    );
    let random = Spanned { value: Sampling::Random, span: root.span().clone() };
    if root.has("parameters") { sampling.required() } else { Some(sampling.or(random)) }
}

fn read_measures(root: Table<'_>) -> Option<Vec<Spanned<Measure>>> {
    let names = Measure::ALL.map(Measure::name);
    let measures = root.get::<Vec<Spanned<String>>>("measures");
    let measures = measures.about("What the page plots against the parameters, besides the properties.");
    let measures = measures.words(&format!("an array of {}", names.join(", ")));
    let measures = measures.rules(|| json!({ "items": { "enum": names }, "default": [] })).try_map(|given, _| {
        let measure = |name: &Spanned<String>| {
            let found = Measure::ALL.into_iter().find(|measure| measure.name() == name.value);
            let found = found.map(|value| Spanned { value, span: name.span.clone() });
            found.ok_or_else(|| unknown("measure", name, names))
        };
        given.iter().map(measure).collect::<Result<Vec<_>, _>>()
    });
    if_given(root, "measures", measures, Vec::new())
}

fn refuse_given(root: Table<'_>, field: Field<'_, Spanned<u64>>, why: &str) {
    if let Some(given) = field.optional() {
        root.report(given.span.problem(why).with_label("not here"));
    }
}

/// The number of runs of a design other than a grid.
fn settled_runs(
    root: Table<'_>,
    sampling: Sampling,
    goal: Option<&Goal>,
    runs: Field<'_, Spanned<u64>>,
) -> Option<u64> {
    if let (Sampling::LatinHypercube, Some(goal)) = (sampling, goal) {
        let problem =
            goal.of.span.problem("a Latin hypercube cannot stop early").with_label("this would stop it early");
        root.report(problem.with_help("only all of its runs together form one: choose `sobol` or `random`"));
    }
    match goal.map(|goal| &goal.question) {
        Some(Question::Estimate(precision)) => {
            Some(runs.optional().map_or(u64::MAX, |runs| runs.value).min(precision.max_runs()))
        }
        Some(Question::Test(_)) => {
            let help = "a test may never decide: set `runs` to the maximum number of runs";
            runs.required_or(help).map(|runs| runs.value)
        }
        None => runs
            .required_or("set the number of runs with `runs`, or a statistical goal with `[goal]`")
            .map(|runs| runs.value),
    }
}

fn grid_runs(root: Table<'_>, parameters: &[Parameter], repeats: Field<'_, Spanned<u64>>) -> Option<u64> {
    let repeats = repeats.optional().map_or(1, |repeats| repeats.value);
    let counts: Vec<u64> = parameters.iter().filter_map(|parameter| parameter.domain.count()).collect();
    let runs = counts.iter().fold(u128::from(repeats), |runs, count| runs.saturating_mul(u128::from(*count)));
    if runs <= u128::from(MAX_RUNS) {
        return Some(runs as u64);
    }
    let factors: Vec<String> = counts.iter().chain([&repeats]).map(u64::to_string).collect();
    let message = format!("the grid has {} = {runs} runs", factors.join(" × "));
    let span = parameters.first().map_or(root.span(), |parameter| &parameter.key.span);
    let help = format!("the maximum is {MAX_RUNS}: use fewer values, or `sobol` with as many `runs` as you can afford");
    root.report(span.problem(message).with_label("of these parameters").with_help(help));
    None
}

/// Checks that the parameters are compatible with each other and with the design.
fn check_parameters(root: Table<'_>, sampling: &Spanned<Sampling>, parameters: &[Parameter]) {
    for (place, parameter) in parameters.iter().enumerate() {
        let Spanned { value: key, span } = &parameter.key;
        let before = &parameters[..place];
        // Values are set one after the other, so one of two overlapping keys would undo the other.
        let inside = |outer: &str, inner: &str| inner.strip_prefix(outer).is_some_and(|rest| rest.starts_with('.'));
        if before.iter().any(|other| other.key.value == *key) {
            root.report(span.problem(format!("`{key}` is varied twice")).with_label("again"));
        } else if let Some(other) =
            before.iter().find(|other| inside(&other.key.value, key) || inside(key, &other.key.value))
        {
            root.report(span.problem(format!("`{key}` and `{}` overlap", other.key.value)).with_label("this key"));
        }
        if sampling.value == Sampling::Grid && parameter.domain.count().is_none() {
            let problem = span.problem(format!("a grid cannot enumerate all values of `{key}`"));
            root.report(
                problem.with_label("of this key").with_help("set `values`, or `steps` between `from` and `to`"),
            );
        }
    }
    if sampling.value == Sampling::Sobol && parameters.len() > MAX_SOBOL_DIMENSIONS {
        let problem =
            sampling.span.problem(format!("a Sobol sequence can vary at most {MAX_SOBOL_DIMENSIONS} parameters"));
        let label = format!("with {} parameters", parameters.len());
        root.report(problem.with_label(label).with_help("`latin_hypercube` and `random` accept any number"));
    }
}

fn read_parameter(table: Table<'_>) -> Option<Parameter> {
    let text = |key, about| table.text(key).about(about);
    let key = text("key", "The key, in the syntax of `--set`.").words("a dotted key such as `battery.initial_pct`");
    let key = key.refers_to(Referent::Setting);
    let key = key.check(|key| is_key(key), "be a dotted key such as `battery.initial_pct`").spanned().required();
    let name = text("name", "Its name in `[model]` and reports.").words("a name of letters, digits and `_`");
    let name = name.rules(|| json!({ "minLength": 1 }));
    let name = name.check(|name| is_name(name), "be a name of letters, digits and `_`").optional();
    let about = text("about", "A description with its unit, for reports.").filled("not be empty").optional();
    let domain = read_domain(table);
    Some(Parameter { key: key?, domain: domain?, name, about })
}

/// How the keys of a parameter are related.
fn relations_of_parameters() -> Value {
    json!({
        "oneOf": DOMAINS.map(|key| json!({ "required": [key] })),
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

/// Whether a formula can refer to it.
fn is_name(name: &str) -> bool {
    name.starts_with(|first: char| first.is_alphabetic() || first == '_')
        && name.chars().all(|letter| letter.is_alphanumeric() || letter == '_')
}

/// Whether `--set` accepts it as a key.
fn is_key(key: &str) -> bool {
    key.split('.').all(|part| !part.trim().is_empty()) && !key.contains(['=', '\n'])
}

/// The keys that select the domain of a parameter, which has exactly one of them.
const DOMAINS: [&str; 4] = ["values", "from", "normal", "exponential"];

fn read_domain(table: Table<'_>) -> Option<ParameterDomain> {
    let given: Vec<&str> = DOMAINS.into_iter().filter(|kind| table.has(kind)).collect();
    // A wrong combination of keys is one problem: none of them is also reported as unknown.
    DOMAINS.into_iter().chain(["to", "steps", "scale", "whole"]).for_each(|key| table.know(key));
    let help = "set `values`, or `from` and `to`, or `normal`, or `exponential`";
    match given.as_slice() {
        [] => table.report(table.span().problem("the parameter has no values").with_help(help)),
        ["from"] => {}
        [_] => only_ranges(table),
        _ => {
            let message = format!("the parameter has both `{}`", given.join("` and `"));
            table.report(table.span().problem(message).with_help(help));
        }
    }
    let form = |key| table.form(given == [key]);
    let values = form("values").and_then(read_values);
    let range = form("from").and_then(read_range);
    let normal = form("normal")
        .and_then(|table| table.table("normal").about("A normal distribution.").and_then(read_normal).required());
    let exponential = form("exponential").and_then(|table| {
        let mean = |table: Table<'_>| table.number("mean").about("Its mean.").above(0.0).required();
        table.table("exponential").about("An exponential distribution.").and_then(mean).required()
    });
    let exponential = exponential.map(|mean| ParameterDomain::Exponential { mean });
    values.or(range).or(normal).or(exponential)
}

fn read_values(table: Table<'_>) -> Option<ParameterDomain> {
    let values = table.get::<Vec<_>>("values").about("Its values.");
    let values = values.words("an array of strings, numbers, true or false");
    let values = values.rules(|| json!({ "minItems": 1, "maxItems": MAX_VALUES }));
    let few = |values: &Vec<_>| (1..=MAX_VALUES).contains(&(values.len() as u64));
    values.check(few, format!("have 1 to {MAX_VALUES} items")).required().map(ParameterDomain::Values)
}

/// Rejects the keys of a range in other domains.
fn only_ranges(table: Table<'_>) {
    for (key, span) in table.keys().filter(|(key, _)| ["to", "steps", "scale", "whole"].contains(key)) {
        table.report(span.problem(format!("`{key}` requires `from`")).with_label("there is no `from`"));
    }
}

fn read_range(table: Table<'_>) -> Option<ParameterDomain> {
    let end = |key, about| table.number(key).about(about).spanned().required();
    let (from, to) = (end("from", "The lower end of a range."), end("to", "The upper end of a range."));
    let steps = table.get::<u64>("steps").within(2..=MAX_STEPS);
    let steps = steps.about("This many values, evenly spaced over the range. Required for a grid.").optional();
    let scales = [("linear", false), ("log", true)];
    let scale = table.one_of("scale", &scales).about("What is evenly spaced: the values or their logarithms.");
    let logarithmic = scale.or_first(&scales);
    let whole = table.boolean("whole").about("Whether to use only the whole numbers in the range.").default(false);
    if whole {
        for (key, span) in table.keys().filter(|(key, _)| ["steps", "scale"].contains(key)) {
            table.report(
                span.problem(format!("`{key}` cannot be combined with `whole`"))
                    .with_label("`whole` uses every whole number"),
            );
        }
        // As numbers, they have been checked to be there: what is missing is reported once.
        let (from, to) = (table.integer("from").optional(), table.integer("to").spanned().optional());
        let (from, to) = (from?, to?);
        check_order(table, from < to.value, &to.span)?;
        return Some(ParameterDomain::Whole { from, to: to.value });
    }
    let (from, to) = (from?, to?);
    check_order(table, from.value < to.value, &to.span)?;
    if logarithmic && from.value <= 0.0 {
        table.report(from.span.problem("a logarithmic scale must start above 0").with_label("this value"));
        return None;
    }
    Some(ParameterDomain::Range { from: from.value, to: to.value, logarithmic, steps })
}

fn check_order(table: Table<'_>, right: bool, to: &Span) -> Option<()> {
    if !right {
        table.report(to.problem("`to` must be greater than `from`").with_label("this value"));
    }
    right.then_some(())
}

fn read_normal(table: Table<'_>) -> Option<ParameterDomain> {
    let number = |key, about| table.number(key).about(about);
    let mean = number("mean", "Its mean.").required();
    let sd = number("sd", "Its standard deviation.").above(0.0).required();
    let min = number("min", "The lower end at which the distribution is truncated.").optional();
    let max = number("max", "The upper end at which the distribution is truncated.").optional();
    let (mean, sd) = (mean?, sd?);
    let share = |end: f64| normal_cdf((end - mean) / sd);
    let left = max.map_or(1.0, share) - min.map_or(0.0, share);
    if left < 1e-6 {
        let problem = table.span().problem("almost none of the distribution lies between `min` and `max`");
        table.report(problem.with_label("this distribution").with_help("at least a millionth must"));
        return None;
    }
    Some(ParameterDomain::Normal { mean, sd, min, max })
}

fn read_goal(table: Table<'_>) -> Option<Goal> {
    let (estimates, tests) = (table.has("estimate"), table.has("test"));
    ["estimate", "test"].into_iter().for_each(|key| table.know(key));
    if estimates == tests {
        let problem = table.span().problem("a goal either estimates or tests").with_label("this goal");
        table.report(problem.with_help("`estimate = \"phi1\"` with `half_width` and `confidence`, or `test = \"phi1\"` with `bound`, `indifference` and `error`"));
    }
    let estimate = table.form(estimates && !tests).and_then(read_estimate);
    let test = table.form(tests && !estimates).and_then(read_test);
    estimate.or(test)
}

/// The keys of a goal that estimates, and of one that tests.
fn forms_of_goals() -> Value {
    let form = |read: fn(Table<'_>) -> Option<Goal>| {
        let names: Vec<String> = Key::all(read).into_iter().map(|key| key.path).collect();
        json!({ "required": names, "propertyNames": { "enum": names } })
    };
    let mut estimate = form(read_estimate);
    estimate["required"].as_array_mut().expect("it is one").remove(0);
    json!({ "if": { "required": ["estimate"] }, "then": estimate, "else": form(read_test) })
}

/// As in [`read_test`], all keys are read before the first `?`, so that everything that is wrong is reported at once.
fn read_estimate(table: Table<'_>) -> Option<Goal> {
    let of = table.text("estimate").about(&format!("The event whose probability is estimated: {EVENT}."));
    let of = of.refers_to(Referent::Property).spanned();
    let of = of.required();
    let half_width = table.number("half_width").rules(|| json!({ "minimum": 0.0005, "maximum": 0.25 })).spanned();
    let half_width = half_width.about("Half the width of an interval that is narrow enough.").required();
    let confidence = table.number("confidence").rules(|| between(0.5, 1.0));
    let confidence = confidence.about("The confidence of the interval.");
    let confidence = confidence.try_map(|value, span| sensible(span, Confidence::new(value)));
    let confidence = confidence.required_or("set the confidence, such as `confidence = 0.95`");
    let half_width = half_width?;
    let precision = sensible(&half_width.span, Precision::new(half_width.value, confidence?));
    let precision = precision.map_err(|problem| table.report(problem)).ok()?;
    Some(Goal { of: of?, question: Question::Estimate(precision) })
}

fn read_test(table: Table<'_>) -> Option<Goal> {
    let about = format!("The event whose probability is compared with `bound`: {EVENT}.");
    let of = table.text("test").about(&about).refers_to(Referent::Property).spanned().required();
    let number = |key, about, most: f64| table.number(key).about(about).rules(|| between(0.0, most));
    let bound = number("bound", "The probability to compare it with.", 1.0).spanned().required();
    let about = "The distance from `bound` within which either answer is acceptable.";
    let indifference = number("indifference", about, 0.5).required();
    let error = number("error", "The acceptable probability of a wrong answer.", 0.5);
    let error = error.required_or("set the probability of a wrong decision, such as `error = 0.05`");
    let bound = bound?;
    let sprt = sensible(&bound.span, Sprt::new(bound.value, indifference?, error?));
    let sprt = sprt.map_err(|problem| table.report(problem)).ok()?;
    Some(Goal { of: of?, question: Question::Test(sprt) })
}

/// The numbers between two others, exclusive, as JSON Schema.
fn between(least: f64, most: f64) -> Value {
    json!({ "exclusiveMinimum": least.written(), "exclusiveMaximum": most.written() })
}

/// Reports a value that the statistics reject, with its location in the file.
fn sensible<T>(span: &Span, result: Result<T, StatisticsError>) -> Result<T, Problem> {
    result.map_err(|error| span.problem(error.to_string()).with_label("this value"))
}
