//! `steward reproduce`: repeats the paper's experiments.

use std::path::PathBuf;
use std::process::ExitCode;

use campaigns::Error;
use campaigns::reproduce::{Reproduction, Settings, table};
use clap::Args;
use scenarios::scenario::TreeForm;

use crate::output::{print_json, print_wrapped};
use crate::progress::CountProgress;

/// How often to run the experiments.
#[derive(Debug, Args)]
pub(crate) struct ReproduceArgs {
    /// How often to run each experiment, with root seeds from 1
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    seeds: u64,
    /// Another map: a ROS map_server YAML file
    #[arg(long, value_name = "FILE")]
    map: Option<PathBuf>,
    /// Other places: a file with `start`, `RechargingStation` and `Destination`
    #[arg(long, value_name = "FILE")]
    places: Option<PathBuf>,
    /// Another start: x and y in meters, heading in degrees
    #[arg(long, value_name = "X,Y,DEG", value_parser = parse_start, allow_hyphen_values = true)]
    start: Option<[f64; 3]>,
    /// The tree as one process, or as one process per node, as in the paper
    #[arg(long, value_name = "whole|nodes", value_parser = ["whole", "nodes"])]
    tree: Option<String>,
    /// Where the page and the data go
    #[arg(long, value_name = "DIR", default_value = "out/reproduce")]
    out: PathBuf,
    /// Prints the results as JSON instead of a table
    #[arg(long)]
    json: bool,
    /// Shows no progress
    #[arg(long, short)]
    quiet: bool,
}

/// Runs everything and prints the table. Exit status 1 if a claim did not hold in every run.
pub(crate) fn reproduce(args: &ReproduceArgs) -> Result<ExitCode, Error> {
    let bar = CountProgress::new(args.quiet || args.json, "runs");
    let tree = args.tree.as_ref().map(|form| if form == "nodes" { TreeForm::Nodes } else { TreeForm::Whole });
    let settings =
        Settings { seeds: args.seeds, map: args.map.clone(), places: args.places.clone(), start: args.start, tree };
    let reproduction = Reproduction::run(&settings, &args.out, |done, all| bar.show(done, all))?;
    drop(bar);
    reproduction.write(&args.out)?;
    if args.json {
        print_json(&reproduction)?;
    } else {
        print_wrapped(format!("{}wrote {}\n", table(&reproduction), args.out.join("index.html").display()))?;
    }
    Ok(ExitCode::from(u8::from(!reproduction.all_hold())))
}

/// `X,Y,DEG`
fn parse_start(text: &str) -> Result<[f64; 3], String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
    let start = numbers.and_then(|numbers| <[f64; 3]>::try_from(numbers).ok());
    start.filter(|start| start.iter().all(|number| number.is_finite())).ok_or("three numbers, as in 0,0.5,0".to_owned())
}
