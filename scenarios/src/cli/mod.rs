//! The command line.
//!
//! Results go to stdout, progress and diagnostics to stderr. Exit status: 0 the run was what the scenario's `[expect]`
//! says; 1 it was not, or no run of a campaign came to its end; 2 bad input; 3 the program could not do its work; 130 a
//! run or a campaign was interrupted.

mod campaign;
mod check;
mod faults;
mod init;
mod interrupt;
mod list;
mod localize;
mod map;
mod matrix;
mod monitor;
mod navigate;
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

use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};

use self::render::{rendered, visible};
use crate::Error;

/// Whose work the program is made of, as their licences ask for.
const NOTICES: &str = include_str!("../../../THIRD-PARTY.md");

/// A simulated service robot whose behavior tree runs under formal monitors.
#[derive(Debug, Parser)]
#[command(version, args_conflicts_with_subcommands = true, arg_required_else_help = true)]
pub struct Cli {
    #[command(flatten)]
    run: RunArgs,
    #[command(subcommand)]
    command: Option<Command>,
}

/// Runs a scenario and writes its report and pictures.
#[derive(Clone, Debug, Args)]
struct RunArgs {
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
    /// Holds properties against a recorded run
    Verify(verify::VerifyArgs),
}

/// Carries out a command line; what goes wrong is said on stderr.
#[must_use]
pub fn run(cli: &Cli) -> ExitCode {
    let done = match &cli.command {
        None => run::run(&cli.run),
        Some(Command::Campaign(args)) => campaign::campaign(args),
        Some(Command::Check(args)) => check::check(args),
        Some(Command::Init { dir, scenario }) => init::init(dir, scenario).map(|()| ExitCode::SUCCESS),
        Some(Command::Faults(args)) => faults::faults(args).map(|()| ExitCode::SUCCESS),
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
        Some(Command::Tree(command)) => tree::tree(command),
        Some(Command::Verify(args)) => verify::verify(args),
    };
    done.unwrap_or_else(|error| {
        complain(&error);
        ExitCode::from(error.exit_status())
    })
}

/// Writes an error to stderr, every diagnostic with the text that it is about.
fn complain(error: &Error) {
    match error {
        Error::BadInput(diagnostics) => {
            let diagnostics = diagnostics.iter().map(|diagnostic| -> &dyn miette::Diagnostic { &**diagnostic });
            let _ = io::stderr().write_all(rendered(diagnostics).as_bytes());
        }
        Error::Interrupted(what) => note(what),
        other => complain_of(&format!("error: {other}\n")),
    }
}

/// Writes to stderr what looks wrong, though it is accepted.
fn warn(diagnostic: &dyn miette::Diagnostic) {
    let _ = io::stderr().write_all(rendered([diagnostic]).as_bytes());
}

/// Writes lines to stderr, control characters made [visible].
fn complain_of(text: &str) {
    let _ = io::stderr().write_all(visible(text).as_bytes());
}

/// Writes to stderr, in a line, what a user should know of the input.
fn note(text: &str) {
    complain_of(&format!("note: {text}\n"));
}

/// Writes a result to stdout, control characters made [visible]. A reader that has gone away is no error.
///
/// # Errors
/// If stdout cannot be written to for another reason.
fn print(text: &str) -> Result<(), Error> {
    match io::stdout().write_all(visible(text).as_bytes()).and_then(|()| io::stdout().flush()) {
        Err(source) if source.kind() != io::ErrorKind::BrokenPipe => {
            Err(Error::Write { path: PathBuf::from("<stdout>"), source })
        }
        _ => Ok(()),
    }
}
