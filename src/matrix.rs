//! `steward matrix`: which property detects which fault.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::{Arc, Mutex, PoisonError};

use campaigns::Error;
use campaigns::matrix::{AboutFault, FaultFree, Matrix, Row, table};
use clap::Args;
use cockpit::{Board, Tally};
use editor::counted;
use monitors::Outcome;
use reports::file_place::FilePlace;
use reports::report::Report;
use reports::results::{Case, CaseResult, Suite};
use scenarios::Complaints;
use scenarios::faults::KINDS;
use scenarios::scenario::{Scenario, find};

use crate::live::BoardArgs;
use crate::output::{print_json, print_wrapped};
use crate::progress::CountProgress;
use crate::results::{ResultsArgs, on_disk, places};

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

/// A suite per scenario: whether its run was as expected, and which verdicts say what about its fault. The last one
/// is about the runs without a fault. `files` are theirs.
fn suites(matrix: &Matrix, out: &Path, files: Vec<FilePlace>) -> Vec<Suite> {
    let failed = |message: String| CaseResult::Failed { message, details: String::new() };
    let page = Some(out.join("index.html"));
    let row = |(row, file): (&Row, &FilePlace)| {
        let result = match (row.as_expected, &row.fault) {
            (false, _) => failed(row.differences.join("; ")),
            (true, Some(_)) => CaseResult::Passed,
            (true, None) => CaseResult::Skipped("no fault took effect".to_owned()),
        };
        let found = row.fault.clone().unwrap_or_else(|| "no fault took effect".to_owned());
        let run = Case { group: "matrix", name: "as expected".to_owned(), result, found, ..Case::default() };
        let verdict = |(property, words, about): (&str, String, AboutFault)| Case {
            group: "matrix",
            name: property.to_owned(),
            result: match about {
                AboutFault::Something => CaseResult::Passed,
                AboutFault::Nothing => CaseResult::Skipped("it says nothing about the fault".to_owned()),
                AboutFault::FalseAlarm => failed(format!("{property} is {words}")),
            },
            found: words,
            ..Case::default()
        };
        Suite {
            name: row.scenario.clone(),
            facts: vec![("seed", row.seed.to_string())],
            cases: std::iter::once(run).chain(matrix.verdicts(row).map(verdict)).collect(),
            file: Some(file.clone()),
            page: page.clone(),
            ..Suite::default()
        }
        .with_paths(on_disk(&[&file.file]))
    };
    let FaultFree { scenario, runs, alarms, .. } = &matrix.fault_free;
    let details: Vec<String> =
        alarms.iter().map(|alarm| format!("seed {}: {}", alarm.seed, alarm.what.join("; "))).collect();
    let result = match alarms.len() {
        0 => CaseResult::Passed,
        count => {
            let message = format!("in {count} of {}, something was violated or not as expected", counted(runs, "run"));
            CaseResult::Failed { message, details: details.join("\n") }
        }
    };
    let name = format!("no false alarm in {} without a fault", counted(runs, "run"));
    let sound = Suite {
        name: scenario.clone(),
        notes: matrix.unnoticed().map(|row| format!("no property detects the fault of {}", row.scenario)).collect(),
        cases: vec![Case { group: "matrix", name, result, ..Case::default() }],
        file: files.last().cloned(),
        page: page.clone(),
        ..Suite::default()
    };
    let sound = sound.with_paths(|file| on_disk(&[file])(file));
    matrix.rows.iter().zip(&files).map(row).chain([sound]).collect()
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
    let names = match args.scenarios.as_slice() {
        [] => KINDS.iter().map(|kind| format!("faults/{}", kind.name)).collect(),
        given => given.to_vec(),
    };
    let mut complaints = Complaints::default();
    let mut load = |name: &String| {
        let scenario = find::find(name).and_then(|found| Scenario::load(&found, &[]));
        complaints.take(scenario).map(Arc::new)
    };
    let scenarios: Vec<_> = names.iter().filter_map(&mut load).collect();
    // Loaded before the problems of the others are reported, so that all of them are.
    let fault_free = load(&args.fault_free);
    args.results.or_refused("matrix", &names, complaints.check())?;
    let files: Vec<FilePlace> =
        scenarios.iter().chain(&fault_free).filter_map(|scenario| places(scenario).file).collect();
    let fault_free = fault_free.expect("a file that could not be loaded was reported");
    let bar = CountProgress::new(args.quiet || args.json, "runs");
    let board = args.board.open("matrix")?;
    let counts = Mutex::default();
    let matrix = Matrix::run(scenarios, &fault_free, args.runs, |done, all, report| {
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
    args.results.or_refused("matrix", &names, matrix.write(&args.out))?;
    args.results.write("matrix", || suites(&matrix, &args.out, files))?;
    if args.json {
        print_json(&matrix)?;
    } else {
        let page = args.out.join("index.html");
        print_wrapped(format!("{}wrote {}\n", table(&matrix), page.display()))?;
    }
    let sound = matrix.false_alarms().is_empty() && matrix.rows.iter().all(|row| row.as_expected);
    Ok(ExitCode::from(u8::from(!sound)))
}
