//! `steward --scenario …`: runs a scenario.

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

use super::progress::Progress;
use super::{RunArgs, print, summary};
use crate::Error;
use crate::conduct::{Outputs, conduct};
use crate::junit;
use crate::report::OutcomeReport;
use crate::scenario::{Scenario, find};

pub(super) fn run(args: &RunArgs) -> Result<ExitCode, Error> {
    let found = find::find(args.scenario.as_deref().unwrap_or_default())?;
    let scenario = Arc::new(Scenario::load(&found, &args.set)?);
    let folder = args.out.clone().unwrap_or_else(|| PathBuf::from("out").join(&scenario.name));
    let outputs = Outputs {
        folder: Some(folder.clone()),
        snapshots: !args.no_snapshots,
        gif: args.gif.clone(),
        record: args.record.clone(),
    };
    let seed = args.seed.unwrap_or(scenario.file.seed);
    let progress = Progress::new(args.quiet || args.json, scenario.file.execution.max_time);
    let report = conduct(Arc::clone(&scenario), seed, !args.no_monitors, &outputs, |live| {
        if live.time().is_zero() {
            live.warnings().iter().for_each(super::warn);
        }
        progress.show(live);
    })?;
    progress.finish();
    if let Some(path) = &args.junit {
        junit::write(path, &scenario, &report)?;
    }
    if args.json {
        print(&(serde_json::to_string_pretty(&report).expect("a report is always JSON") + "\n"))?;
    } else if !args.quiet {
        print(&summary::summary(&report, &folder))?;
    }
    Ok(ExitCode::from(u8::from(report.outcome == OutcomeReport::NotAsExpected)))
}
