//! The command line `steward`.
//!
//! Results go to stdout, progress and diagnostics to stderr. Exit status: 0 the run was what the scenario's `[expect]`
//! says; 1 it was not, or no run of a campaign came to its end; 2 bad input; 3 the program could not do its work; 130 a
//! run or a campaign was interrupted.

mod campaign;
mod check;
mod entry;
mod faults;
mod help;
mod init;
mod interrupt;
mod list;
mod localize;
mod map;
mod matrix;
mod monitor;
mod navigate;
mod output;
mod progress;
mod render;
mod report;
mod reproduce;
mod run;
mod skill;
mod summary;
mod tree;
mod tree_script;
mod verify;

use std::path::PathBuf;
use std::process::ExitCode;
#[cfg(unix)]
use std::sync::Arc;

use clap::{CommandFactory, Parser, Subcommand};

use crate::output::{complain, print};
use crate::run::RunArgs;

/// Whose work the program is made of, as their licences ask for.
const NOTICES: &str = include_str!("../THIRD-PARTY.md");

/// A simulated service robot whose behavior tree runs under formal monitors.
#[derive(Debug, Parser)]
#[command(
    version,
    args_conflicts_with_subcommands = true,
    arg_required_else_help = true,
    disable_help_subcommand = true
)]
struct Cli {
    #[command(flatten)]
    run: RunArgs,
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Runs a scenario many times with what varies, and says how likely it is that a property is violated
    Campaign(campaign::CampaignArgs),
    /// Tries everything short of a run: reads every file that is named, wires, plans, and says what is wrong or looks wrong
    Check(check::CheckArgs),
    /// Writes a copy of a scenario with its map, tree, skills and places, for editing
    Init {
        /// The folder to write to; it must be new or empty
        dir: PathBuf,
        /// The scenario to copy: a name (see `steward list`) or a file
        #[arg(long, value_name = "NAME|FILE", default_value = "battery_fault")]
        scenario: String,
    },
    /// Lists the kinds of faults with what they do; with a kind, its parameters and an example
    Faults(faults::FaultsArgs),
    /// Explains a command or a topic: scenario, campaign, faults, scope
    Help(help::HelpArgs),
    /// Prints the notices of those whose work the program is made of
    Licenses,
    /// Lists the scenarios that come with the program
    List,
    /// Shows which property notices which fault
    Matrix(matrix::MatrixArgs),
    /// Localizes a recorded robot on a map and says how far off it was
    Localize(localize::LocalizeArgs),
    /// Makes a map of a log's corrected poses and scans
    Map(map::MapArgs),
    /// Property files: check them, have them explained, write their monitors out
    #[command(subcommand)]
    Monitor(monitor::MonitorCommand),
    /// Measures navigation: trips between random places on maps, among people
    Navigate(navigate::NavigateArgs),
    /// Behavior trees: check files, show them, tick them without a robot
    #[command(subcommand)]
    Tree(tree::TreeCommand),
    /// Skills: check machines, show them, run them without a robot
    #[command(subcommand)]
    Skill(skill::SkillCommand),
    /// Makes the report of a recorded run, with its page and pictures
    Report(report::ReportArgs),
    /// Simulates the paper's experiments and checks them against each of its claims
    Reproduce(reproduce::ReproduceArgs),
    /// Prints the JSON schema of scenario or campaign files, for editors
    Schema {
        /// Of which files
        file: help::SchemaFile,
    },
    /// Holds properties against a recorded run
    Verify(verify::VerifyArgs),
}

fn main() -> ExitCode {
    // Beyond the limit of a file's size (`ulimit -f`), writing fails like on a full disk; the signal would end the program
    // without a word. It is only heard because somebody listens.
    #[cfg(unix)]
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::default());
    carry_out(&Cli::parse())
}

/// Carries out a command line; what goes wrong is said on stderr.
fn carry_out(cli: &Cli) -> ExitCode {
    let done = match &cli.command {
        None => run::run(&cli.run),
        Some(Command::Campaign(args)) => campaign::campaign(args),
        Some(Command::Check(args)) => check::check(args),
        Some(Command::Init { dir, scenario }) => init::init(dir, scenario).map(|()| ExitCode::SUCCESS),
        Some(Command::Faults(args)) => faults::faults(args).map(|()| ExitCode::SUCCESS),
        Some(Command::Help(args)) => help::help(args, Cli::command()).map(|()| ExitCode::SUCCESS),
        Some(Command::Licenses) => print(NOTICES).map(|()| ExitCode::SUCCESS),
        Some(Command::List) => list::list().map(|()| ExitCode::SUCCESS),
        Some(Command::Localize(args)) => localize::localize(args),
        Some(Command::Map(args)) => map::map(args),
        Some(Command::Skill(command)) => skill::skill(command),
        Some(Command::Matrix(args)) => matrix::matrix(args),
        Some(Command::Monitor(command)) => monitor::run(command).map(|()| ExitCode::SUCCESS),
        Some(Command::Navigate(args)) => navigate::navigate(args),
        Some(Command::Report(args)) => report::report(args),
        Some(Command::Reproduce(args)) => reproduce::reproduce(args),
        Some(Command::Schema { file }) => help::schema(*file).map(|()| ExitCode::SUCCESS),
        Some(Command::Tree(command)) => tree::tree(command),
        Some(Command::Verify(args)) => verify::verify(args),
    };
    done.unwrap_or_else(|error| {
        complain(&error);
        ExitCode::from(error.exit_status())
    })
}
