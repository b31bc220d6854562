//! `steward matrix`: which property detects which fault.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::{Arc, Mutex, PoisonError};

use campaigns::Error;
use campaigns::matrix::{Matrix, table};
use clap::Args;
use cockpit::{Board, Tally};
use monitors::Outcome;
use reports::report::Report;
use runs::topology;
use scenarios::faults::KINDS;
use scenarios::scenario::{Scenario, find};

use crate::live::BoardArgs;
use crate::output::{note_elsewhere, print_json, print_wrapped};
use crate::progress::CountProgress;
use crate::results::{ResultsArgs, on_disk, places, refused};

/// Counts in how many runs each property was violated, and of how many.
fn count(counts: &mut BTreeMap<String, [u64; 2]>, report: Option<&Report>) -> Vec<Tally> {
    for monitor in report.iter().flat_map(|report| &report.monitors) {
        let [happened, of] = counts.entry(monitor.name.clone()).or_default();
        *happened += u64::from(monitor.verdict == Outcome::Violated);
        *of += 1;
    }
    let tally = |(name, [happened, of]): (&String, &[u64; 2])| Tally {
        name: format!("{name} violated"),
        happened: *happened,
        of: *of,
        interval: None,
    };
    counts.iter().map(tally).collect()
}

/// Which scenarios to run.
#[derive(Debug, Args)]
pub(crate) struct MatrixArgs {
    /// Scenarios with faults, by name or file [default: those of all kinds of faults]
    #[arg(value_name = "SCENARIO")]
    scenarios: Vec<String>,
    /// The same world without any fault
    #[arg(long, value_name = "SCENARIO", default_value = "errand")]
    fault_free: String,
    /// How often to run the scenario without a fault, with root seeds from 1; each scenario with faults runs once, with
    /// its own seed
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u64).range(..=100_000))]
    runs: u64,
    /// Where the page and the data go
    #[arg(long, value_name = "DIR", default_value = "out/matrix")]
    out: PathBuf,
    #[command(flatten)]
    results: ResultsArgs,
    /// Prints the matrix as JSON instead of a table
    #[arg(long)]
    json: bool,
    /// Shows no progress
    #[arg(long, short)]
    quiet: bool,
    #[command(flatten)]
    board: BoardArgs,
}

/// Runs everything and prints the matrix. Exit status 1 if there was a false alarm, or if a run was not as expected.
pub(crate) fn matrix(args: &MatrixArgs) -> Result<ExitCode, Error> {
    args.results.begin()?;
    let names = match args.scenarios.as_slice() {
        [] => KINDS.iter().map(|kind| format!("faults/{}", kind.name)).collect(),
        given => given.to_vec(),
    };
    let load = |name: &String| {
        let scenario = find::find(name).and_then(|found| Scenario::load(&found, &[]));
        // What is wrong with its properties is known only with its channels.
        let scenario = scenario.and_then(|scenario| {
            topology(&scenario).and_then(|topology| scenario.monitoring(&topology))?;
            Ok(scenario)
        });
        (name.clone(), scenario.map(Arc::new))
    };
    let loaded = args.results.all_or_refused("matrix", names.iter().chain([&args.fault_free]).map(load))?;
    let Some(mut scenarios) = loaded else { return Ok(ExitCode::from(2)) };
    let fault_free = scenarios.pop().expect("the last one is that without faults");
    scenarios.iter().chain([&fault_free]).for_each(|scenario| note_elsewhere(scenario));
    args.results.or_refused("matrix", &names, Matrix::check(&args.out))?;
    let bar = CountProgress::new(args.quiet || args.json, "runs");
    let board = args.board.open("matrix")?;
    let counts = Mutex::default();
    let stories = args.results.have_stories();
    let matrix = Matrix::run(scenarios.clone(), &fault_free, args.runs, stories, |done, all, report| {
        bar.show(done, all);
        let unexpected = report.filter(|report| !report.differences.is_empty());
        let named =
            |report: &Report| format!("{}, seed {}: {}", report.scenario, report.seed, report.differences.join("; "));
        if let Some(board) = &board {
            let tallies = count(&mut counts.lock().unwrap_or_else(PoisonError::into_inner), report);
            board.show(done as u64, all as u64, unexpected.map(named), || tallies);
        }
    });
    let matrix = args.results.or_refused("matrix", &names, matrix)?;
    drop(bar);
    board.into_iter().for_each(Board::finish);
    let (page, written) = (args.out.join("index.html"), matrix.write(&args.out));
    args.results.write("matrix", || {
        let page = written.is_ok().then_some(page.as_path());
        let unwritten =
            written.as_ref().err().map(|error| refused(&args.out.display().to_string(), error, on_disk::<&str>(&[])));
        matrix.suites(page, &scenarios, &fault_free, places).into_iter().chain(unwritten).collect()
    })?;
    written?;
    if args.json {
        print_json(&matrix)?;
    } else {
        print_wrapped(format!("{}wrote {}\n", table(&matrix), page.display()))?;
    }
    let sound = matrix.false_alarms().is_empty() && matrix.rows.iter().all(|row| row.as_expected);
    Ok(ExitCode::from(u8::from(!sound)))
}
