//! RoAML models, which `steward run`, `steward campaign` and `steward check` take as they take scenarios.

use std::fmt::{self, Write};
use std::path::Path;
use std::process::ExitCode;

use campaigns::Error;
use campaigns::statistics::{Confidence, Count};
use channels::{Random, WiringError};
use diagnostics::Problem;
use roaml::{Ended, Model, Outcome, Run};
use robot::Streams;
use serde_json::json;

use crate::interrupt;
use crate::output::{BAD, GOOD, HEAD, Text, note, print_json, say, warn};
use crate::progress::Bar;

/// The seed of a run, if none is given.
const SEED: u64 = 1;
/// How many runs a campaign has, if no number is given.
const RUNS: u64 = 1000;
/// The confidence of its intervals.
const CONFIDENCE: f64 = 0.95;

/// Whether a file is the main file of a model.
pub(crate) fn is_model(path: &Path) -> bool {
    let is_xml = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("xml"));
    is_xml && diagnostics::text_from_disk(path).is_ok_and(|text| roaml::is_model(&text))
}

/// Refuses an option that needs a scenario.
pub(crate) fn refuse(options: &[(&str, bool)]) -> Result<(), Error> {
    match options.iter().find(|(_, given)| *given) {
        Some((option, _)) => {
            let help = "of a model there is a summary, and with `steward run FILE --json` its data";
            Err(Error::refused(format!("`{option}` is for scenarios, and this is a RoAML model"), help))
        }
        None => Ok(()),
    }
}

fn load(path: &Path) -> Result<Model, Error> {
    let model = Model::load(path).map_err(Error::bad_input)?;
    model.warnings.iter().for_each(|warning| warn(warning));
    Ok(model)
}

/// One run of a model; its machines and the order of its messages depend on the seed.
fn run_once(model: &Model, seed: u64, settles: bool) -> Result<Outcome, Error> {
    let scheduler = Random::new(Streams::new(seed).stream("channels/scheduler"));
    let misfit = |error: WiringError| Error::bad_input(Problem::new(error.to_string()));
    let run = Run::new(model, seed, Box::new(scheduler)).map_err(misfit)?;
    run.finish(settles, |_, _| ()).map_err(|error| {
        let help = "somewhere machines answer each other without end: let a timer come between";
        Error::refused(format!("the model cannot go on with seed {seed}: {error}"), help)
    })
}

/// Runs a model once and tells its verdicts.
pub(crate) fn run(path: &Path, seed: Option<u64>, as_json: bool, quiet: bool) -> Result<ExitCode, Error> {
    let (model, seed) = (load(path)?, seed.unwrap_or(SEED));
    let outcome = run_once(&model, seed, false)?;
    if as_json {
        print_json(&report(&model, seed, &outcome))?;
    } else if !quiet {
        let mut text = Text::default();
        // Writing to a string cannot fail.
        let _ = write_outcome(&mut text, &model, seed, &outcome);
        say(text)?;
    }
    Ok(ExitCode::SUCCESS)
}

fn report(model: &Model, seed: u64, outcome: &Outcome) -> serde_json::Value {
    let properties = model.properties.iter().zip(&outcome.verdicts);
    let properties: Vec<_> = properties
        .map(|(property, holds)| json!({ "name": property.name, "formula": property.formula, "holds": holds }))
        .collect();
    let errors: Vec<_> =
        outcome.errors.iter().map(|(process, error)| json!({ "process": process, "error": error })).collect();
    json!({
        "model": model.name,
        "seed": seed,
        "time_s": outcome.time.as_secs_f64(),
        "ended": name(outcome.ended),
        "tree": outcome.tree.map(bt::Status::name),
        "communications": outcome.communications,
        "properties": properties,
        "errors": errors,
    })
}

fn name(ended: Ended) -> &'static str {
    match ended {
        Ended::TimeLimit => "time limit",
        Ended::Quiet => "quiet",
        Ended::Settled => "settled",
    }
}

fn write_outcome(text: &mut Text, model: &Model, seed: u64, outcome: &Outcome) -> fmt::Result {
    text.paint(HEAD, &model.name, 0);
    let why = match outcome.ended {
        Ended::TimeLimit => "the model's time is over",
        Ended::Quiet => "nothing can happen any more",
        Ended::Settled => "every property has its verdict",
    };
    write!(text, ", seed {seed}: {why} after {:.1} s", outcome.time.as_secs_f64())?;
    match outcome.tree {
        Some(status) => writeln!(text, "; the tree's last answer is {}", status.name())?,
        None => writeln!(text)?,
    }
    let widest = widest(model);
    for (property, holds) in model.properties.iter().zip(&outcome.verdicts) {
        write!(text, "  {:<widest$}  ", property.name)?;
        text.paint(HEAD, if *holds { "true" } else { "false" }, 5);
        writeln!(text, "  {}", property.formula)?;
    }
    for (process, error) in &outcome.errors {
        text.paint(BAD, "  !", 0);
        writeln!(text, " {process}: {error}")?;
    }
    Ok(())
}

fn widest(model: &Model) -> usize {
    model.properties.iter().map(|property| property.name.chars().count()).fold(0, usize::max).min(32)
}

/// Estimates the probability of each property from many runs, with the seeds 0, 1, 2, …
pub(crate) fn campaign(path: &Path, runs: Option<u64>, quiet: bool) -> Result<ExitCode, Error> {
    let (model, runs) = (load(path)?, runs.unwrap_or(RUNS));
    let interrupted = interrupt::listen();
    let bar = Bar::new(quiet, "runs");
    let mut counts = vec![Count::default(); model.properties.len()];
    let (mut done, mut with_errors) = (0_u64, None);
    let all = usize::try_from(runs).unwrap_or(usize::MAX);
    bar.show(0, all);
    let work = |seed: u64| run_once(&model, seed, true);
    batch::in_order(0..runs, batch::threads(), interrupted, work, |seed, outcome| {
        let outcome = outcome?;
        counts.iter_mut().zip(&outcome.verdicts).for_each(|(count, holds)| count.push(*holds));
        if with_errors.is_none() {
            with_errors = outcome.errors.into_iter().next().map(|(process, error)| (seed, process, error));
        }
        done += 1;
        bar.show(usize::try_from(done).unwrap_or(usize::MAX), all);
        Ok::<_, Error>(true)
    })?;
    bar.finish();
    if done < runs {
        note(&format!("interrupted after {done} of {runs} runs"));
        return Ok(ExitCode::from(interrupt::STATUS));
    }
    if !quiet {
        let mut text = Text::default();
        // Writing to a string cannot fail.
        let _ = write_estimates(&mut text, &model, runs, &counts);
        if let Some((seed, process, error)) = with_errors {
            text.paint(BAD, "!", 0);
            let _ = writeln!(text, " seed {seed}: {process}: {error}");
        }
        say(text)?;
    }
    Ok(ExitCode::SUCCESS)
}

fn write_estimates(text: &mut Text, model: &Model, runs: u64, counts: &[Count]) -> fmt::Result {
    text.paint(HEAD, &format!("{runs} runs of {}", model.name), 0);
    writeln!(text)?;
    let (widest, confidence) = (widest(model), Confidence::new(CONFIDENCE).expect("a confidence"));
    for (property, count) in model.properties.iter().zip(counts) {
        write!(text, "{:<widest$}  true in {} of {}: ", property.name, count.happened(), count.runs())?;
        text.paint(GOOD, &format!("{:.4}", count.rate().unwrap_or(0.0)), 0);
        writeln!(text, " (95 %: {:.4})", count.interval(confidence))?;
    }
    Ok(())
}
