//! `steward report RECORDING`: the report of a recorded run.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use campaigns::{Error, refuse_campaign};
use clap::Args;
use recording::Recording;
use reports::{Outputs, html, report_recording};

use crate::bag_tree::BagTreeArgs;
use crate::out_file::OutFile;
use crate::{browser, summary};

/// The run to report on, and how.
#[derive(Debug, Args)]
pub(crate) struct ReportArgs {
    /// The recording: a file that a run with `--record FILE.rec` or `--record FILE.mcap` wrote, or a log of
    /// BehaviorTree.CPP, `.btlog`, `.db3` or `.btdb`; `FILE#2` is the second session of one that has several. With
    /// `--tree`, a ROS 2 bag
    #[arg(value_name = "RECORDING")]
    recording: PathBuf,
    #[command(flatten)]
    tree: BagTreeArgs,
    /// Where the report and the pictures go [default: out/NAME, with the recording's name]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Writes an animation of the run
    #[arg(long, value_name = "FILE")]
    gif: Option<OutFile>,
    /// Records the run again: `FILE.jsonl`, `FILE.btlog`, `FILE.mcap` and others, as with `steward run`
    #[arg(long, value_name = "FILE")]
    record: Option<OutFile>,
    /// Opens the report in the browser
    #[arg(long)]
    open: bool,
    /// Takes no pictures
    #[arg(long)]
    no_snapshots: bool,
    /// Shows no summary
    #[arg(long, short)]
    quiet: bool,
}

/// Makes the report of a recorded run, with its page and pictures. The exit status is that of the run.
pub(crate) fn report(args: &ReportArgs) -> Result<ExitCode, Error> {
    let stem = || Path::new("out").join(args.recording.file_stem().unwrap_or_default());
    let out = args.out.clone().unwrap_or_else(stem);
    let outputs = Outputs {
        folder: Some(out.clone()),
        snapshots: !args.no_snapshots,
        gif: args.gif.as_deref().map(Path::to_owned),
        ..Outputs::default()
    };
    refuse_campaign(&outputs)?;
    outputs.check()?;
    let tree = args.tree.load(std::slice::from_ref(&args.recording))?;
    let recording = Recording::open_with(&args.recording, tree.as_ref()).map_err(reports::Error::from)?;
    let report = report_recording(recording, &outputs, args.record.as_deref())?;
    let status = summary::print(&report, &out, args.quiet)?;
    if args.open {
        browser::open(&out.join(html::FILE));
    }
    Ok(status)
}
