//! Runs of scenarios, from their files to their reports.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

mod asking;
mod components;
mod controllers;
mod devices;
mod experiments;
mod fault_combinations;
mod faults;
mod leaves;
mod monitors;
mod navigation;
mod protocol;
mod published;
mod ready_made_monitors;
mod roaml_models;
mod robot_settings;
mod schedules;
mod stop;
mod without_a_map;
mod world;
mod zones;

use std::error;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;

use diagnostics::Part;
use miette::{Diagnostic, LabeledSpan};
use recording::{Detail, RunView, conduct};
use reports::report::Report;
use reports::{Outputs, Presentation};
use runs::Run;
use scenarios::Error;
use scenarios::scenario::{Scenario, find};
use serde_json::{Value, json};

/// The scenario with this name or path in UTF-8, with these settings.
fn load(scenario: impl AsRef<Path>, set: &[&str]) -> Result<Arc<Scenario>, Error> {
    let set: Vec<String> = set.iter().map(|set| (*set).to_owned()).collect();
    Ok(Arc::new(Scenario::load(&find::find(scenario.as_ref().to_str().unwrap())?, &set)?))
}

/// Its run, at the start.
fn start(scenario: impl AsRef<Path>, set: &[&str]) -> Run {
    let scenario = load(scenario, set).unwrap();
    let seed = scenario.file.seed;
    Run::new(scenario, seed, true).unwrap()
}

/// Takes a run to its end, and returns its report. It may have outputs, and may be recorded in a file.
fn report_of(
    run: Run,
    detail: Detail,
    outputs: &Outputs,
    record: Option<&Path>,
) -> Result<Report, Box<dyn error::Error>> {
    let begin = |view: &RunView| Ok::<_, Box<dyn error::Error>>(Presentation::begin(view, outputs)?);
    let (presentation, view) = conduct(run, detail, record, begin, |_| ControlFlow::Continue(()))?;
    Ok(presentation.finish(&view)?)
}

/// The report of a run of a scenario with these settings.
fn report(scenario: impl AsRef<Path>, set: &[&str]) -> Value {
    json!(report_of(start(scenario, set), Detail::Full, &Outputs::default(), None).unwrap())
}

/// The report of such a run that is recorded in a file.
fn recorded(scenario: impl AsRef<Path>, set: &[&str], record: &Path) -> Value {
    json!(report_of(start(scenario, set), Detail::Full, &Outputs::default(), Some(record)).unwrap())
}

/// What a report has about a monitor.
fn monitor<'r>(report: &'r Value, name: &str) -> &'r Value {
    report["monitors"].as_array().unwrap().iter().find(|monitor| monitor["name"] == name).expect("a known monitor")
}

/// The monitors of a report with their verdicts.
fn verdicts(report: &Value) -> Vec<(&str, &str)> {
    let monitors = report["monitors"].as_array().unwrap();
    monitors.iter().map(|it| (it["name"].as_str().unwrap(), it["verdict"].as_str().unwrap())).collect()
}

/// When the robot first came to a place.
fn reached(report: &Value, place: &str) -> Option<f64> {
    let places = report["places"].as_array().unwrap();
    places.iter().find(|known| known["name"] == place).expect("a known place")["reached_at_s"].as_f64()
}

/// Everything that is wrong with a scenario with these settings, each with its place and with advice.
fn problems(scenario: impl AsRef<Path>, set: &[&str]) -> Vec<String> {
    let name = scenario.as_ref().display().to_string();
    let prepared = load(scenario, set).and_then(|scenario| {
        let seed = scenario.file.seed;
        Run::prepare(scenario, seed, true)
    });
    let Err(Error::BadInput(problems)) = prepared else { panic!("{name} with {set:?} is not refused") };
    problems.iter().flat_map(|problem| diagnostics::parts(&**problem)).map(in_words).collect()
}

/// What seems wrong with a scenario that can be run: all that `steward check` warns of.
fn concerns(scenario: &Arc<Scenario>) -> Vec<String> {
    let run = Run::prepare(Arc::clone(scenario), scenario.file.seed, true).unwrap();
    let mut all: Vec<Box<dyn Diagnostic + Send + Sync>> = scenario.concerns();
    all.extend(scenario.machine_concerns().into_iter().map(|concerns| Box::new(concerns) as _));
    all.extend(scenario.doubts().into_iter().map(|doubt| Box::new(doubt) as _));
    all.extend(run.warnings().iter().map(|warnings| Box::new(warnings.clone()) as _));
    all.iter().flat_map(|concern| diagnostics::parts(&**concern)).map(in_words).collect()
}

fn in_words((problem, text): Part<'_>) -> String {
    let labels: Vec<LabeledSpan> = problem.labels().into_iter().flatten().collect();
    let read =
        |around| labels.first().zip(text).and_then(|(label, text)| text.read_span(label.inner(), around, around).ok());
    let place = read(0).map(|it| format!("{}:{}:{}", it.name().unwrap_or_default(), it.line() + 1, it.column() + 1));
    let lines = read(1).map(|it| String::from_utf8_lossy(it.data()).into_owned());
    let labels: Vec<&str> = labels.iter().filter_map(LabeledSpan::label).collect();
    let help = problem.help().map(|help| help.to_string());
    [place, lines, Some(problem.to_string()), Some(labels.join(" ")), help]
        .into_iter()
        .flatten()
        .collect::<Vec<_>>()
        .join("\n")
}
