//! `steward --scenario …`: runs a scenario.

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

use campaigns::{Error, run_and_report};
use clap::Args;
use recording::Detail;
use reports::{Outputs, file_name, junit};
use scenarios::live::Live;
use scenarios::scenario::{Scenario, find};

use crate::output::print;
use crate::progress::Progress;
use crate::{interrupt, summary};

/// Runs a scenario and writes its report and pictures.
#[derive(Clone, Debug, Args)]
pub(crate) struct RunArgs {
    /// The scenario to run: a name (see `steward list`) or a file
    #[arg(long, value_name = "NAME|FILE", required = true)]
    scenario: Option<String>,
    /// The root seed; the scenario's own if not given
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Where report and pictures go [default: out/<scenario>]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Changes a value of the scenario: `battery.initial_pct=50`, `faults.0.at_s=30`
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Writes an animation of the run
    #[arg(long, value_name = "FILE")]
    gif: Option<PathBuf>,
    /// Records the run: `FILE.jsonl` is the event log, any other file all that `steward report` needs
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// Writes the results as JUnit XML: a test case a property and expectation
    #[arg(long, value_name = "FILE")]
    junit: Option<PathBuf>,
    /// Takes no pictures
    #[arg(long)]
    no_snapshots: bool,
    /// Runs without monitors and expects nothing of the properties; the run is the same, but no violation ends it
    #[arg(long)]
    no_monitors: bool,
    /// Prints the report as JSON instead of a summary
    #[arg(long)]
    json: bool,
    /// Shows no progress and no summary
    #[arg(long, short)]
    quiet: bool,
}

pub(crate) fn run(args: &RunArgs) -> Result<ExitCode, Error> {
    let found = find::find(args.scenario.as_deref().unwrap_or_default())?;
    let scenario = Arc::new(Scenario::load(&found, &args.set)?);
    let folder = args.out.clone().unwrap_or_else(|| default_folder(&scenario.name));
    let outputs = Outputs { folder: Some(folder.clone()), snapshots: !args.no_snapshots, gif: args.gif.clone() };
    let seed = args.seed.unwrap_or(scenario.file.seed);
    scenario.place_concerns().iter().for_each(|concern| crate::output::warn(concern));
    let live = Live::new(Arc::clone(&scenario), seed, !args.no_monitors)?;
    live.warnings().iter().for_each(|warning| crate::output::warn(warning));
    let _ = interrupt::listen();
    let progress = Progress::new(args.quiet || args.json, scenario.file.execution.max_time);
    let report = run_and_report(live, Detail::Full, &outputs, args.record.as_deref(), |view| {
        progress.show(view);
        interrupt::flow()
    });
    progress.finish();
    let report = report?;
    if let Some(path) = &args.junit {
        junit::write(path, &scenario.file.expect.told(), &report)?;
    }
    if args.json {
        print(&(serde_json::to_string_pretty(&report).expect("a report is always JSON") + "\n"))?;
    }
    summary::tell(&report, &folder, args.quiet || args.json)
}

/// `out/NAME`, where the name of a scenario that shows a fault is `faults/KIND`.
fn default_folder(name: &str) -> PathBuf {
    ["out".to_owned()].into_iter().chain(name.split('/').map(file_name)).collect()
}
