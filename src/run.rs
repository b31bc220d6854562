//! `steward run`, and `steward --scenario`: runs scenarios.

pub(crate) mod select;
mod table;

#[cfg(feature = "dds")]
use std::panic::resume_unwind;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

use bags::Remapping;
use campaigns::{Error, run_and_report};
use clap::Args;
#[cfg(feature = "dds")]
use partners::{BoxedController, ComponentNodes};
use recording::{Detail, RunView};
use reports::report::{OutcomeReport, Report};
use reports::results::Suite;
use reports::{Outputs, file_name, html};
use runs::{Partners, Run};
use scenarios::scenario::{Found, Scenario, find};
use serde_json::json;

use monitors::Warnings;

use crate::domain::DomainArgs;
use crate::names;
use crate::out_file::OutFile;
#[cfg(feature = "dds")]
use crate::output::note;
use crate::output::{note_elsewhere, print_json, warn};
use crate::progress::{CountProgress, RunProgress};
use crate::results::{self, ResultsArgs};
use crate::ros_names::remapping;
use crate::run::table::RunsTable;
use crate::serve_groot::{self as serve, ServeGrootArgs};
use crate::{browser, interrupt, summary};

/// The command's name in results.
const COMMAND: &str = "run";

/// The scenarios to run.
#[derive(Clone, Debug, Args)]
pub(crate) struct RunArgs {
    /// Scenarios: names (see `steward list`), files, folders, or patterns of names such as 'faults/*'; or RoAML
    /// models
    #[arg(value_name = "NAME|FILE", required_unless_present_any = ["all", "filter"], value_parser = names::SCENARIOS,
          hide_possible_values = true)]
    scenarios: Vec<String>,
    /// Runs all scenarios that come with the program
    #[arg(long, conflicts_with = "scenarios")]
    all: bool,
    /// Runs only scenarios whose names contain TEXT; if given more than once, any of the texts
    #[arg(long, value_name = "TEXT")]
    filter: Vec<String>,
    #[command(flatten)]
    options: RunOptions,
    #[command(flatten)]
    beside: BesideArgs,
    #[command(flatten)]
    serve: ServeGrootArgs,
}

/// How to find the nodes of ROS 2 that are components of a scenario.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct BesideArgs {
    #[command(flatten)]
    pub(crate) domain: DomainArgs,
    /// Waits for `/clock`, and takes its time; otherwise that is so if it is published when the run begins
    #[arg(long)]
    pub(crate) use_sim_time: bool,
    /// Gives a topic, a service or an action of a component another name, as in ROS 2; may be given more than once
    #[arg(long = "remap", value_name = "FROM:=TO", value_parser = remapping)]
    pub(crate) remapped: Vec<Remapping>,
}

/// How to run them, and what to write.
#[derive(Clone, Debug, Args)]
pub(crate) struct RunOptions {
    /// The root seed; by default the scenario's own
    #[arg(long, value_name = "N")]
    pub(crate) seed: Option<u64>,
    /// Where report and pictures go; with several scenarios, each gets a folder there [default: out/NAME, with --seed
    /// out/NAME-seed-N]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Changes a value of the scenario: `battery.initial_pct=50`, `faults.0.at_s=30`
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) set: Vec<String>,
    /// Writes an animation of the run
    #[arg(long, value_name = "FILE")]
    gif: Option<OutFile>,
    /// Records the run: `FILE.jsonl` is the event log, and `FILE.btlog` a log of the tree as BehaviorTree.CPP writes
    /// it; any other file has everything that `steward report` needs, and `FILE.mcap` also opens in Foxglove, Rerun and
    /// ROS tools
    #[arg(long, value_name = "FILE")]
    record: Option<OutFile>,
    #[command(flatten)]
    results: ResultsArgs,
    /// Opens the report in the browser
    #[arg(long)]
    open: bool,
    /// Takes no pictures
    #[arg(long)]
    no_snapshots: bool,
    /// Runs without monitors and ignores expectations about properties; the run is the same, but no violation ends it
    #[arg(long)]
    no_monitors: bool,
    /// Prints the report as JSON instead of a summary; for several runs, an array
    #[arg(long)]
    json: bool,
    /// Shows no progress and no summary
    #[arg(long, short)]
    quiet: bool,
}

/// A scenario that is ready to be run.
struct Job {
    scenario: Arc<Scenario>,
    seed: u64,
    /// Where its report goes.
    folder: PathBuf,
}

/// Runs the scenario with this name or path.
pub(crate) fn scenario(name: &str, options: &RunOptions) -> Result<ExitCode, Error> {
    options.results.begin()?;
    let found = options.results.or_refused(COMMAND, &[name.to_owned()], find::find(name))?;
    alone(&found, options, &BesideArgs::default(), &ServeGrootArgs::default())
}

/// Runs a scenario alone, beside the nodes of ROS 2 that are components of it.
fn alone(found: &Found, options: &RunOptions, beside: &BesideArgs, serve: &ServeGrootArgs) -> Result<ExitCode, Error> {
    let job =
        options.results.or_refused(COMMAND, std::slice::from_ref(&found.argument), Job::load(found, options, false))?;
    let partners = beside.join(&job.scenario)?;
    one(&job, options, partners, serve)
}

impl BesideArgs {
    /// The nodes of ROS 2 that are components of a scenario, if there are any.
    pub(crate) fn join(&self, scenario: &Scenario) -> Result<Partners, scenarios::Error> {
        match scenario.remote_components().next() {
            None if self.remapped.is_empty() => Ok(Partners::None),
            None => {
                let help = "leave it out, or name a scenario with a component in a namespace of ROS 2";
                Err(scenarios::Error::refused("`--remap` is for components that are nodes of ROS 2", help))
            }
            #[cfg(feature = "dds")]
            Some(_) => {
                let nodes = ComponentNodes::of(scenario, &self.remapped)?;
                nodes.join(self.domain.options()?, self.use_sim_time, note).map(Partners::Components)
            }
            #[cfg(not(feature = "dds"))]
            Some(_) => Err(scenarios::Error::refused(crate::domain::WITHOUT, crate::domain::HOW)),
        }
    }
}

/// Runs a scenario with a controller of its robot; or several times at once, for robots in these namespaces, with
/// consecutive seeds.
#[cfg(feature = "dds")]
pub(crate) fn controlled(
    name: &str,
    options: &RunOptions,
    namespaces: &[String],
    controllers: impl FnOnce(&Scenario) -> Result<Vec<BoxedController>, scenarios::Error>,
) -> Result<ExitCode, Error> {
    options.results.begin()?;
    let found = &options.results.or_refused(COMMAND, &[name.to_owned()], find::find(name))?;
    let job =
        options.results.or_refused(COMMAND, std::slice::from_ref(&found.argument), Job::load(found, options, false))?;
    if namespaces.len() > 1 {
        options.refuse_for_several(namespaces.len(), "robots")?;
    }
    match <[BoxedController; 1]>::try_from(controllers(&job.scenario)?) {
        Ok([only]) => one(&job, options, Partners::Controller(only), &ServeGrootArgs::default()),
        Err(controllers) => together(&job, options, namespaces, controllers),
    }
}

/// Runs a scenario for each controller, all at once.
#[cfg(feature = "dds")]
fn together(
    job: &Job,
    options: &RunOptions,
    namespaces: &[String],
    controllers: Vec<BoxedController>,
) -> Result<ExitCode, Error> {
    let jobs: Vec<Job> = (0..).zip(namespaces).map(|(place, namespace)| job.in_namespace(place, namespace)).collect();
    let _ = interrupt::listen();
    let mut table = RunsTable::new(options.is_silent());
    // They have the same properties.
    let warn_once = |job: &Job, warnings: &[Warnings]| {
        if job.seed == jobs[0].seed {
            warnings.iter().for_each(|warning| warn(warning));
        }
    };
    let reports = std::thread::scope(|scope| {
        let warn_once = &warn_once;
        let run = |(job, controller): (_, BoxedController)| {
            let warned = move |warnings: &[Warnings]| warn_once(job, warnings);
            scope.spawn(move || {
                job.conduct(options, Partners::Controller(controller), &ServeGrootArgs::default(), warned, |_| {})
            })
        };
        let runs: Vec<_> = std::iter::zip(&jobs, controllers).map(run).collect();
        let join = |run: std::thread::ScopedJoinHandle<'_, _>| run.join().unwrap_or_else(|panic| resume_unwind(panic));
        runs.into_iter().map(join).collect::<Vec<_>>()
    });
    let results: Vec<(&Job, Result<Report, Error>)> = jobs.iter().zip(reports).collect();
    results.iter().try_for_each(|(job, report)| table.add(job.names(), report))?;
    conclude(&results, options, table, &job.folder.join("NAMESPACE"))
}

/// Runs the requested scenarios.
pub(crate) fn run(args: &RunArgs) -> Result<ExitCode, Error> {
    let options = &args.options;
    options.results.begin()?;
    let found = options.results.or_refused(COMMAND, &args.scenarios, select::select(&args.scenarios, &args.filter))?;
    let found = match <[_; 1]>::try_from(found) {
        Ok([(argument, only)]) => {
            let only = options.results.or_refused(COMMAND, &[argument], only)?;
            return alone(&only, options, &args.beside, &args.serve);
        }
        Err(found) => found,
    };
    if args.serve.is_given() {
        return Err(Error::refused("`--serve-groot` is for a single run", "name one scenario"));
    }
    options.refuse_for_several(found.len(), "scenarios")?;
    let arguments: Vec<String> = found.iter().map(|(argument, _)| argument.clone()).collect();
    let load = |found: Found| Job::load(&found, options, true).map_err(Error::from);
    let loaded = found.into_iter().map(|(argument, found)| (argument, found.and_then(load)));
    let Some(jobs) = options.results.all_or_refused(COMMAND, loaded)? else { return Ok(ExitCode::from(2)) };
    let folders = jobs.iter().map(|job| (job.scenario.origin.argument.as_str(), job.folder.clone()));
    options.results.or_refused(COMMAND, &arguments, select::check_folders(folders))?;
    several(&jobs, options)
}

impl RunOptions {
    /// Refuses options that are only for a single run.
    fn refuse_for_several(&self, count: usize, runs: &str) -> Result<(), Error> {
        let of_one = [("--gif", self.gif.is_some()), ("--record", self.record.is_some()), ("--open", self.open)];
        match of_one.iter().find(|(_, given)| *given) {
            Some((option, _)) => {
                let message = format!("`{option}` is for a single run, but {count} {runs} are to be run");
                Err(Error::refused(message, format!("run one alone for that: `steward … {option} …`")))
            }
            None => Ok(()),
        }
    }

    /// Whether to show neither progress nor summary.
    fn is_silent(&self) -> bool {
        self.quiet || self.json
    }
}

impl Job {
    /// Its scenario's name, and how the command line names it.
    fn names(&self) -> [&str; 2] {
        [&self.scenario.name, &self.scenario.origin.argument]
    }

    /// Loads a scenario, alone or one of `several`.
    fn load(found: &Found, options: &RunOptions, several: bool) -> Result<Self, scenarios::Error> {
        let scenario = Arc::new(Scenario::load(found, &options.set)?);
        scenario.concerns().iter().for_each(|concern| warn(&**concern));
        note_elsewhere(&scenario);
        let seed = options.seed.unwrap_or(scenario.file.seed);
        let name = options.seed.map_or(scenario.name.clone(), |seed| format!("{}-seed-{seed}", scenario.name));
        let parts = name.split('/').map(file_name);
        let folder = match &options.out {
            None => Path::new("out").join(parts.collect::<PathBuf>()),
            Some(out) if several => out.join(parts.collect::<PathBuf>()),
            Some(out) => out.clone(),
        };
        Ok(Self { scenario, seed, folder })
    }

    /// The same for the robot with this number in a namespace.
    #[cfg(feature = "dds")]
    fn in_namespace(&self, place: u64, namespace: &str) -> Self {
        let name = namespace.trim_start_matches('/');
        let mut scenario = Scenario::clone(&self.scenario);
        scenario.name = format!("{}/{name}", scenario.name);
        let seed = self.seed.wrapping_add(place);
        Self { scenario: Arc::new(scenario), seed, folder: self.folder.join(name) }
    }

    /// Runs the scenario and writes its outputs except results. `ready` receives the warnings.
    fn conduct(
        &self,
        options: &RunOptions,
        partners: Partners,
        serve: &ServeGrootArgs,
        ready: impl FnOnce(&[Warnings]),
        mut follow: impl FnMut(&RunView),
    ) -> Result<Report, Error> {
        let outputs = Outputs {
            folder: Some(self.folder.clone()),
            snapshots: !options.no_snapshots,
            gif: options.gif.as_deref().map(Path::to_owned),
            ..Outputs::default()
        };
        // A run starts the programs of its components.
        outputs.check()?;
        let run = Run::with_partners(Arc::clone(&self.scenario), self.seed, !options.no_monitors, partners)?;
        ready(run.warnings());
        if serve.is_given() {
            serve::check(&run.header())?;
        }
        let mut audience = serve.open()?.map(|server| (serve::audience(server), serve::real_time()));
        let show = |view: &RunView| {
            if let Some((show, wait)) = &mut audience {
                show(view);
                wait(view);
            }
        };
        run_and_report(run, Detail::Full, &outputs, options.record.as_deref(), show, |view| {
            follow(view);
            interrupt::flow()
        })
    }
}

/// Runs a scenario alone, with a summary.
fn one(job: &Job, options: &RunOptions, partners: Partners, serve: &ServeGrootArgs) -> Result<ExitCode, Error> {
    let _ = interrupt::listen();
    let progress = RunProgress::new(options.is_silent());
    let ready = |warnings: &[Warnings]| warnings.iter().for_each(|one| warn(one));
    let report = job.conduct(options, partners, serve, ready, |view| progress.show(view));
    drop(progress);
    let result = [(job, report)];
    write_results(options, &result)?;
    let [(_, report)] = result;
    let report = report?;
    if options.json {
        print_json(&report)?;
    }
    let status = summary::print(&report, &job.folder, options.is_silent())?;
    if options.open {
        browser::open(&job.folder.join(html::FILE));
    }
    Ok(status)
}

/// Runs scenarios on all cores, and prints one line for each, in order.
fn several(jobs: &[Job], options: &RunOptions) -> Result<ExitCode, Error> {
    let interrupted = interrupt::listen();
    let bar = CountProgress::new(options.is_silent(), "runs");
    let mut table = RunsTable::new(options.is_silent());
    let mut results: Vec<(&Job, Result<Report, Error>)> = Vec::new();
    bar.show(0, jobs.len());
    let work = |place: u64| {
        // Runs end in any order; their warnings are printed with their lines, in the order of the scenarios.
        let mut collected = Vec::new();
        let report = jobs[place as usize].conduct(
            options,
            Partners::None,
            &ServeGrootArgs::default(),
            |warnings| collected.extend_from_slice(warnings),
            |_| {},
        );
        (collected, report)
    };
    let all = 0..jobs.len() as u64;
    batch::in_order(all, batch::threads(), interrupted, work, |place, (warnings, report)| {
        let job = &jobs[place as usize];
        bar.above(|| {
            warnings.iter().for_each(|warning| warn(warning));
            table.add(job.names(), &report)
        })?;
        results.push((job, report));
        bar.show(place as usize + 1, jobs.len());
        Ok::<_, Error>(true)
    })?;
    drop(bar);
    let name = options.seed.map_or("NAME".to_owned(), |seed| format!("NAME-seed-{seed}"));
    conclude(&results, options, table, &options.out.as_deref().unwrap_or(Path::new("out")).join(name))
}

/// Writes the results of several runs, each in a folder like this one, and returns the exit status.
fn conclude(
    results: &[(&Job, Result<Report, Error>)],
    options: &RunOptions,
    table: RunsTable,
    folder: &Path,
) -> Result<ExitCode, Error> {
    write_results(options, results)?;
    if options.json {
        let of = |(job, result): &(&Job, Result<Report, Error>)| match result {
            Ok(report) => json!(report),
            Err(error) => json!({ "scenario": job.scenario.name, "outcome": "error", "error": error.reasons() }),
        };
        print_json(&results.iter().map(of).collect::<Vec<_>>())?;
    }
    table.end(results.len(), &folder.join(html::FILE))
}

/// Writes the results for CI systems, if requested.
fn write_results(options: &RunOptions, results: &[(&Job, Result<Report, Error>)]) -> Result<(), Error> {
    let is_interrupted = |report: &Report| report.outcome == OutcomeReport::Interrupted;
    if results.iter().any(|(_, result)| result.as_ref().is_ok_and(is_interrupted)) {
        options.results.none_yet("the run");
        return Ok(());
    }
    let suite = |(job, result): &(&Job, Result<Report, Error>)| {
        let (scenario, places) = (&job.scenario, results::places(&job.scenario));
        let suite = match result {
            Ok(report) => Suite {
                findings: results::warnings(scenario),
                ..Suite::of_run(&scenario.expected(), report, &job.folder, &places)
            },
            Err(error) => {
                let paths = results::on_disk(&[&scenario.origin.argument]);
                Suite { file: places.file, ..results::refused(&scenario.name, error, paths) }
            }
        };
        let notes = suite.notes.iter().cloned().chain(scenario.elsewhere_in_words()).collect();
        Suite { notes, ..suite }.with_paths(results::on_disk(&[&scenario.origin.argument]))
    };
    options.results.write(COMMAND, || results.iter().map(suite).collect())
}
