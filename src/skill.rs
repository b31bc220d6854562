//! `steward skill`: machines without a robot.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Duration;

use campaigns::Error;
use checks::{FileKind, named_files};
use clap::{Subcommand, ValueEnum};
use diagnostics::Disk;
use reports::pictures;
use runs::machine_record;
use scenarios::files::Kind;
use scenarios::scenario::{Scenario, find};
use skills::{Chart, Cues, SkillError, Status, Strictness, rehearse};

use crate::check;
use crate::output::print;
use crate::results::ResultsArgs;

/// What to do with a machine.
#[derive(Debug, Subcommand)]
pub(crate) enum SkillCommand {
    /// Reports everything that is wrong, or looks wrong, with machines, as strictly as for a scenario; `run` is more
    /// lenient
    Check {
        /// Machines: SCXML files, or names of shipped ones
        #[arg(value_name = "FILE", required = true)]
        files: Vec<PathBuf>,
        /// The scenario with the processes to which they may send [default: those of the shipped scenarios]
        #[arg(long, value_name = "NAME|FILE")]
        scenario: Option<String>,
    },
    /// Prints a machine's states and transitions
    Show {
        /// The machine: an SCXML file, or the name of a shipped one; with `--scenario`, the leaf or component that runs
        /// it
        file: PathBuf,
        /// The scenario whose machine it is, such as one that is written for what a leaf needs
        #[arg(long, value_name = "NAME|FILE")]
        scenario: Option<String>,
        /// An outline, a graph for Graphviz, a drawing, or the machine as it is written
        #[arg(long, value_enum, default_value_t = Format::Text)]
        format: Format,
    },
    /// Lists the single mistakes that a machine may have, as the fault `skill_mutant` names them
    Mutants {
        /// Machines: SCXML files, or names of shipped ones [default: those of the shipped tree]
        files: Vec<PathBuf>,
    },
    /// Runs a machine on its own: prints its log, every configuration that it enters, and the last one
    Run {
        /// The machine: an SCXML file, or the name of a shipped one
        file: PathBuf,
        /// Events to give it, one JSON object per line: {"event": "BT.tick", "time_s": 1.5, "data": {}}
        #[arg(long, value_name = "FILE")]
        events: Option<PathBuf>,
        /// Stops it after this many simulated seconds, if delayed events keep it going
        #[arg(long, value_name = "SECONDS", default_value_t = 3600.0)]
        until: f64,
        /// Prints one JSON object per line
        #[arg(long)]
        json: bool,
    },
}

/// How to show a machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Format {
    Text,
    Dot,
    Svg,
    Scxml,
}

/// Carries out a command on a machine.
pub(crate) fn skill(command: &SkillCommand) -> Result<ExitCode, Error> {
    match command {
        SkillCommand::Check { files, scenario } => check::each(files, false, &ResultsArgs::default(), |file| {
            FileKind::Machine.examine(&Disk::default(), file, scenario.as_deref()).result
        }),
        SkillCommand::Show { file, scenario, format } => show(file, scenario.as_deref(), *format),
        SkillCommand::Mutants { files } => mutants(files),
        SkillCommand::Run { file, events, until, json } => run(file, events.as_deref(), *until, *json),
    }
}

fn show(file: &Path, scenario: Option<&str>, format: Format) -> Result<ExitCode, Error> {
    let chart = match scenario {
        Some(scenario) => machine_of(scenario, &file.to_string_lossy())?,
        None => named_files::machine(&Disk::default(), file, Strictness::Standard)?,
    };
    match format {
        Format::Text => print(&chart.outline())?,
        Format::Dot => print(&chart.to_dot())?,
        Format::Scxml => print(chart.file().text())?,
        Format::Svg => print(&pictures::machine_svg(&machine_record(chart.name(), &chart)))?,
    }
    Ok(ExitCode::SUCCESS)
}

/// The machine that a process of a scenario runs.
fn machine_of(scenario: &str, process: &str) -> Result<Arc<Chart>, Error> {
    let scenario = Scenario::load(&find::find(scenario)?, &[])?;
    let found = scenario.machine_processes().find(|(name, _)| *name == process);
    let found = found.map(|(_, skill)| Arc::clone(&skill.machine));
    found.ok_or_else(|| {
        let known: Vec<&str> = scenario.machine_processes().map(|(name, _)| name).collect();
        let message = format!("no leaf or component called `{process}` runs a machine in this scenario");
        Error::refused(message, diagnostics::nearest_or_all(process, "machines", &known))
    })
}

fn mutants(files: &[PathBuf]) -> Result<ExitCode, Error> {
    let mut text = String::new();
    let mut list = |name: &str, machine: &str| {
        let skill = Path::new(name).file_stem().unwrap_or_default().to_string_lossy();
        let mistakes = skills::mutations(name, machine).map_err(Error::bad_input)?;
        text.extend(mistakes.iter().map(|mistake| format!("{skill}: {mistake}\n")));
        Ok::<(), Error>(())
    };
    for file in files {
        let (path, machine) = named_files::read(&Disk::default(), Kind::Skill, file)?;
        list(&path.to_string_lossy(), &machine)?;
    }
    if files.is_empty() {
        for (name, machine) in skills::SHIPPED {
            list(&format!("{name}.scxml"), machine)?;
        }
    }
    print(&text)?;
    Ok(ExitCode::SUCCESS)
}

fn run(file: &Path, events: Option<&Path>, until_s: f64, json: bool) -> Result<ExitCode, Error> {
    let chart = named_files::machine(&Disk::default(), file, Strictness::Standard)?;
    let cues = match events {
        Some(events) => read_cues(events)?,
        None => Cues::default(),
    };
    let until = Duration::try_from_secs_f64(until_s)
        .map_err(|_| Error::refused(format!("{until_s} s is not a time"), "give a number of seconds, zero or more"))?;
    let mut printed = Ok(());
    let ending = rehearse(&chart, &cues, until, &mut |line| {
        if printed.is_ok() {
            let text = if json { line.to_json() } else { line.to_string() };
            printed = print(&format!("{text}\n"));
        }
    });
    printed?;
    Ok(match ending.status {
        Status::Done => ExitCode::SUCCESS,
        Status::Stuck => ExitCode::FAILURE,
        _ if ending.unhandled_errors => ExitCode::FAILURE,
        _ => ExitCode::SUCCESS,
    })
}

fn read_cues(file: &Path) -> Result<Cues, Error> {
    let name = file.to_string_lossy();
    let text = diagnostics::from_disk_or_pipe(file)
        .and_then(diagnostics::text)
        .map_err(|error| Error::bad_input(SkillError::Read { reason: format!("cannot read {name}: {error}") }))?;
    Cues::parse(&name, &text).map_err(Error::bad_input)
}
