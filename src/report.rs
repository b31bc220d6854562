//! `steward report RECORDING`: the report of a recorded run.

use std::path::PathBuf;
use std::process::ExitCode;

use campaigns::{Error, refuse_campaign};
use clap::Args;
use reports::{Outputs, html, report_recording};

use crate::{browser, summary};

/// Which run to report on, and how.
#[derive(Debug, Args)]
pub(crate) struct ReportArgs {
    /// The recording: what a run with `--record FILE.rec` has written
    #[arg(value_name = "RECORDING")]
    recording: PathBuf,
    /// Where the report and the pictures go
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Writes an animation of the run
    #[arg(long, value_name = "FILE")]
    gif: Option<PathBuf>,
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

/// Makes the report of a recorded run with its page and pictures. The exit status is that of the run.
pub(crate) fn report(args: &ReportArgs) -> Result<ExitCode, Error> {
    let outputs = Outputs { folder: Some(args.out.clone()), snapshots: !args.no_snapshots, gif: args.gif.clone() };
    refuse_campaign(&outputs)?;
    let report = report_recording(&args.recording, &outputs)?;
    let status = summary::tell(&report, &args.out, args.quiet)?;
    if args.open {
        browser::open(&args.out.join(html::FILE));
    }
    Ok(status)
}
