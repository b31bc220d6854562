//! `steward reproduce`: the paper's experiments, run again.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;

use super::print;
use super::progress::Bar;
use crate::Error;
use crate::reproduce::{Reproduction, table};

/// How often to run the experiments.
#[derive(Debug, Args)]
pub(super) struct ReproduceArgs {
    /// How often each experiment is run, with the root seeds from 1 on
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    seeds: u64,
    /// Where page and data go
    #[arg(long, value_name = "DIR", default_value = "out/reproduce")]
    out: PathBuf,
    /// Prints the results as JSON instead of a table
    #[arg(long)]
    json: bool,
    /// Shows no progress
    #[arg(long, short)]
    quiet: bool,
}

/// Runs everything and prints the table. Exit status 1 if anything was not as the paper says.
pub(super) fn reproduce(args: &ReproduceArgs) -> Result<ExitCode, Error> {
    let bar = Bar::new(args.quiet || args.json, "runs");
    let reproduction = Reproduction::run(args.seeds, |done, all| bar.show(done, all))?;
    bar.finish();
    reproduction.write(&args.out)?;
    if args.json {
        print(&(serde_json::to_string_pretty(&reproduction).expect("results are always JSON") + "\n"))?;
    } else {
        print(&format!("{}wrote {}\n", table(&reproduction), args.out.join("index.html").display()))?;
    }
    Ok(ExitCode::from(u8::from(!reproduction.is_as_printed())))
}
