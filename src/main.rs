//! The command line `steward`.
//!
//! Results go to stdout, progress and diagnostics to stderr. [`EPILOGUE`] documents the exit status.

mod bag_tree;
mod browser;
mod campaign;
mod check;
mod completions;
mod domain;
mod entry;
mod faults;
mod fmt;
mod groot;
mod help;
mod hints;
mod init;
mod interrupt;
mod list;
mod live;
mod localize;
mod lsp;
mod man;
mod map;
mod matrix;
mod moment;
mod monitor;
mod names;
mod navigate;
mod out_file;
mod output;
mod progress;
mod prove;
mod render;
mod report;
mod reproduce;
mod results;
mod ros_names;
mod run;
mod serve_groot;
mod sim;
mod skill;
mod summary;
mod tree;
mod verify;
mod watch;

use std::process::ExitCode;
#[cfg(unix)]
use std::sync::Arc;

use campaigns::Error;
use clap::{Arg, CommandFactory, FromArgMatches, Parser, Subcommand};

use crate::output::{complain, print};
use crate::run::RunOptions;

/// The version with the commit from which the program was built.
const VERSION: &str = env!("STEWARD_VERSION");

/// The notices that the licenses of the program's parts require.
const NOTICES: &str = include_str!("../THIRD-PARTY.md");

/// The text at the end of the help.
const EPILOGUE: &str = "\
Examples:
  steward run battery_fault        run a scenario; report in out/battery_fault
  steward check my.toml            check a scenario without running it
  steward campaign noise --runs 8  run a scenario many times, with variations

Exit status:
    0  the run was as the scenario's [expect] says
    1  it was not, or no run of a campaign finished
    2  the input is wrong, or the processes that it describes cannot continue
    3  the program could not do its work, for example on a full disk
  130  a run or a campaign was interrupted";

/// A simulated service robot whose behavior tree runs under formal monitors.
#[derive(Debug, Parser)]
#[command(
    version = VERSION,
    args_conflicts_with_subcommands = true,
    arg_required_else_help = true,
    disable_help_subcommand = true,
    after_help = EPILOGUE
)]
#[command(override_usage = "steward <COMMAND>\n       steward --scenario <NAME|FILE> [OPTIONS of `steward run`]")]
struct Cli {
    /// Runs a scenario, as `steward run` does and with its options
    #[arg(long, value_name = "NAME|FILE", required = true, value_parser = names::SCENARIOS,
          hide_possible_values = true)]
    scenario: Option<String>,
    #[command(flatten)]
    options: RunOptions,
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Runs scenarios; one with a summary, several in a table
    Run(run::RunArgs),
    /// Checks files without a run: reads every file that they name, connects the processes, plans the paths, and
    /// reports all problems
    Check(check::CheckArgs),
    /// Gives trees, machines and property files one layout, without a change of what they mean
    Fmt(fmt::FmtArgs),
    /// Opens a page in the browser on which a person can watch a run and intervene
    Live(live::LiveArgs),
    /// Lists the scenarios and campaigns that come with the program
    List,
    /// Lists the kinds of faults; of one kind, its parameters and an example
    Faults(faults::FaultsArgs),
    /// Writes an application to start from: a scenario with all its files
    Init(init::InitArgs),
    /// Runs a scenario many times with varied values, and shows how likely each violation is
    Campaign(campaign::CampaignArgs),
    /// Shows which property detects which fault
    Matrix(matrix::MatrixArgs),
    /// Simulates the paper's experiments and checks them against each of its claims
    Reproduce(reproduce::ReproduceArgs),
    /// Proves properties of every run, or shows a shortest run that violates one
    Prove(prove::ProveArgs),
    /// Makes the report of a recorded run, with its page and pictures
    Report(report::ReportArgs),
    /// Checks event logs of runs and ROS 2 bags against properties
    Verify(verify::VerifyArgs),
    /// Checks a running ROS 2 robot against properties
    Watch(watch::WatchArgs),
    /// Lets others drive the simulated robot, as a robot of ROS 2
    Sim(sim::SimArgs),
    /// Behavior trees: checks files, shows them, ticks them without a robot
    #[command(subcommand)]
    Tree(tree::TreeCommand),
    /// Skills: checks machines, shows them, runs them without a robot
    #[command(subcommand)]
    Skill(skill::SkillCommand),
    /// Property files: checks them, explains them, exports their monitors
    #[command(subcommand)]
    Monitor(monitor::MonitorCommand),
    /// Measures navigation: trips between random places on maps, among people
    Navigate(navigate::NavigateArgs),
    /// Localizes a recorded robot on a map and shows how far off it was
    Localize(localize::LocalizeArgs),
    /// Makes a map from a log's corrected poses and scans
    Map(map::MapArgs),
    /// Explains a command or a topic: scenario, campaign, faults, scope, mapping
    Help(help::HelpArgs),
    /// Prints the JSON schema of scenario, campaign, interface or mapping files, for editors
    Schema {
        /// The kind of file
        file: help::SchemaFile,
    },
    /// Prints a script with which a shell completes commands
    Completions(completions::CompletionsArgs),
    /// Serves an editor: problems as you type, completion, explanations
    Lsp(lsp::LspArgs),
    /// Writes a man page for each command
    Man(man::ManArgs),
    /// Prints the notices that the licenses of the program's parts require
    Licenses,
}

fn main() -> ExitCode {
    // The program starts itself again as the keeper of the programs that components run.
    #[cfg(unix)]
    if let Some(status) = programs::keep() {
        return status;
    }
    // And as the process that listens to a robot's nodes.
    #[cfg(feature = "dds")]
    if let Some(status) = network::listen() {
        return status;
    }
    // Beyond the limit of a file's size (`ulimit -f`), writing then fails as on a full disk; otherwise, the signal
    // would silently end the program. Any handler prevents that.
    #[cfg(unix)]
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::default());
    option_env!("STEWARD_COMMIT").into_iter().for_each(recording::set_commit);
    let mut command = command();
    let matches = command.try_get_matches_from_mut(std::env::args_os());
    let matches = matches.unwrap_or_else(|error| hints::with_hints(error).exit());
    let cli = Cli::from_arg_matches(&matches).unwrap_or_else(|error| error.exit());
    let done = out_file::guard(&command, &matches).and_then(|()| carry_out(&cli));
    done.unwrap_or_else(|error| {
        complain(&error);
        ExitCode::from(error.exit_status())
    })
}

/// The command line. Only `steward run --help` shows the options of a run.
fn command() -> clap::Command {
    let is_shown = |arg: &Arg| ["scenario", "help", "version"].contains(&arg.get_id().as_str());
    Cli::command().mut_args(|arg| if is_shown(&arg) { arg } else { arg.hide(true) })
}

/// Carries out a command line.
fn carry_out(cli: &Cli) -> Result<ExitCode, Error> {
    match &cli.command {
        None => run::scenario(cli.scenario.as_deref().unwrap_or_default(), &cli.options),
        Some(Command::Run(args)) => run::run(args),
        Some(Command::Campaign(args)) => campaign::campaign(args),
        Some(Command::Check(args)) => check::check(args),
        Some(Command::Completions(args)) => completions::completions(args, command()).map(|()| ExitCode::SUCCESS),
        Some(Command::Init(args)) => init::init(args).map(|()| ExitCode::SUCCESS),
        Some(Command::Faults(args)) => faults::faults(args).map(|()| ExitCode::SUCCESS),
        Some(Command::Fmt(args)) => fmt::fmt(args),
        Some(Command::Help(args)) => help::help(args, command()).map(|()| ExitCode::SUCCESS),
        Some(Command::Licenses) => print(NOTICES).map(|()| ExitCode::SUCCESS),
        Some(Command::List) => list::list().map(|()| ExitCode::SUCCESS),
        Some(Command::Live(args)) => match &args.groot.groot {
            Some(address) => groot::live(&args.groot, address, &args.page),
            None => live::live(args),
        },
        Some(Command::Localize(args)) => localize::localize(args),
        Some(Command::Lsp(args)) => lsp::lsp(args),
        Some(Command::Man(args)) => man::man(args, command()).map(|()| ExitCode::SUCCESS),
        Some(Command::Map(args)) => map::map(args),
        Some(Command::Sim(args)) => sim::sim(args),
        Some(Command::Skill(command)) => skill::skill(command),
        Some(Command::Matrix(args)) => matrix::matrix(args),
        Some(Command::Monitor(command)) => monitor::run(command),
        Some(Command::Navigate(args)) => navigate::navigate(args),
        Some(Command::Prove(args)) => prove::prove(args),
        Some(Command::Report(args)) => report::report(args),
        Some(Command::Reproduce(args)) => reproduce::reproduce(args),
        Some(Command::Schema { file }) => help::schema(*file).map(|()| ExitCode::SUCCESS),
        Some(Command::Tree(command)) => tree::tree(command),
        Some(Command::Verify(args)) => verify::verify(args),
        Some(Command::Watch(args)) => watch::watch(args),
    }
}
