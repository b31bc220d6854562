//! `steward --scenario …`: runs a scenario.

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

use recording::Detail;

use super::progress::Progress;
use super::{RunArgs, interrupt, print, summary};
use crate::Error;
use crate::conduct::conduct;
use crate::files::file_name;
use crate::junit;
use crate::live::Live;
use crate::presentation::Outputs;
use crate::scenario::{Scenario, find};

pub(super) fn run(args: &RunArgs) -> Result<ExitCode, Error> {
    let found = find::find(args.scenario.as_deref().unwrap_or_default())?;
    let scenario = Arc::new(Scenario::load(&found, &args.set)?);
    let folder = args.out.clone().unwrap_or_else(|| default_folder(&scenario.name));
    let outputs = Outputs { folder: Some(folder.clone()), snapshots: !args.no_snapshots, gif: args.gif.clone() };
    let seed = args.seed.unwrap_or(scenario.file.seed);
    scenario.place_concerns().iter().for_each(|concern| super::warn(concern));
    let live = Live::new(Arc::clone(&scenario), seed, !args.no_monitors)?;
    live.warnings().iter().for_each(|warning| super::warn(warning));
    let _ = interrupt::listen();
    let progress = Progress::new(args.quiet || args.json, scenario.file.execution.max_time);
    let report = conduct(live, Detail::Full, &outputs, args.record.as_deref(), |view| {
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
