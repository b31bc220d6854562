//! Runs the paper's experiments again and checks them against the paper's claims.

mod deviations;
mod experiments;
mod film;
mod observed;
mod page;
mod shots;
mod table;

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use diagnostics::counted;
use drawing::ExecutionContext;
use recording::{Detail, RunView, conduct};
use reports::{Outputs, Presentation};
use runs::Run;
use scenarios::Complaints;
use scenarios::files::Kind;
use scenarios::scenario::{Scenario, TreeForm, find};
use serde::Serialize;

use crate::Error;

use experiments::{Claim, EXPERIMENTS, Experiment, ExperimentRun};
use film::{Film, Still};
use observed::Observed;

const FILES: [&str; 2] = ["reproduce.json", "index.html"];

pub use table::table;

/// How to run the experiments again.
#[derive(Clone, Debug, Default)]
pub struct Settings {
    /// Each experiment is run with the root seeds from 1 to this.
    pub seeds: u64,
    /// Another map than the project's own.
    pub map: Option<PathBuf>,
    /// Other places than the project's own.
    pub places: Option<PathBuf>,
    /// Another start than the places': x and y in meters, heading in degrees.
    pub start: Option<[f64; 3]>,
    /// Another form of the tree's process than in the scenarios.
    pub tree: Option<TreeForm>,
}

/// The results of running the experiments again.
#[derive(Debug, Serialize)]
pub struct Reproduction {
    /// The program's version.
    pub version: &'static str,
    /// Each experiment was run with the root seeds from 1 to this.
    pub seeds: u64,
    /// The changes to all scenarios, in the syntax of `--set`.
    pub settings: Vec<String>,
    /// The experiments, in the order of the paper.
    pub experiments: Vec<ExperimentResult>,
    /// The moments that the paper's figures show, from the runs with seed 1.
    #[serde(skip)]
    stills: Vec<Still>,
    /// The system that was run, and its properties.
    #[serde(skip)]
    context: ExecutionContext,
    #[serde(skip)]
    properties: Vec<(String, String)>,
}

/// The result of an experiment.
#[derive(Clone, Debug, Serialize)]
pub struct ExperimentResult {
    /// The scenario.
    pub scenario: &'static str,
    /// The paper's name for it.
    pub title: &'static str,
    /// How it is carried out here.
    pub here: &'static str,
    /// The paper's claims, and the results.
    pub claims: Vec<ClaimResult>,
    /// The claims that this project adds, and the results.
    pub ours: Vec<ClaimResult>,
    /// The runs.
    pub runs: Vec<RunResult>,
}

/// A run, for comparison with the same run elsewhere.
#[derive(Clone, Debug, Serialize)]
pub struct RunResult {
    /// The root seed.
    pub seed: u64,
    /// BLAKE3 hash of the trace; monitors do not affect it.
    pub trace_hash: String,
    /// The violated monitors, with the ticks of their violations.
    pub violated_at_tick: BTreeMap<String, u64>,
}

/// The result of a claim.
#[derive(Clone, Debug, Serialize)]
pub struct ClaimResult {
    /// The claim, in words.
    pub says: &'static str,
    /// Where the paper makes it, or what it follows from.
    pub source: &'static str,
    /// In how many runs it was true.
    pub runs: u64,
    /// The runs in which it was not true.
    pub differences: Vec<Difference>,
}

/// A run in which a claim was not true.
#[derive(Clone, Debug, Serialize)]
pub struct Difference {
    /// The root seed.
    pub seed: u64,
    /// What was found instead, in words.
    pub found: String,
}

/// A job for one of the cores.
enum Job {
    /// A run for its report.
    ExperimentRun(Arc<Scenario>, u64),
    /// A run for its pictures.
    Film(Arc<Scenario>),
}

enum Done {
    ExperimentRun(Box<ExperimentRun>),
    Film(Film),
}

impl Settings {
    /// The settings in the syntax of `--set`; every scenario also gets the monitors of the paper's figure.
    fn overrides(&self) -> Vec<String> {
        let path = |key: &str, kind: Kind, path: &Option<PathBuf>| {
            let path = path.as_ref().map(|path| kind.path(path, &diagnostics::Disk::default()).display().to_string());
            path.map(|path| format!("{key}={path:?}"))
        };
        let form = |form| match form {
            TreeForm::Whole => "execution.tree=whole".to_owned(),
            TreeForm::Nodes => "execution.tree=nodes".to_owned(),
        };
        let map = path("map", Kind::Map, &self.map);
        let places = path("places", Kind::Places, &self.places);
        let start = self.start.map(|[x_m, y_m, heading_deg]| format!("sites.start=[{x_m:?},{y_m:?},{heading_deg:?}]"));
        map.into_iter().chain(places).chain(start).chain(self.tree.map(form)).collect()
    }
}

/// What the paper says and no run can show here.
const NOT_CLAIMED: &str = "Not among them is that the safety monitor waits for requests, as the captions of Figure 6 (c) \
                           and (d) say: it watches only the replies, as in Figure 5 (a).";

/// Additions to every scenario: the monitors of the paper's Figure 5, of which it expects nothing.
const FIGURE_MONITORS: [&str; 3] = [
    r#"monitors=[{ figure = "5 (a)" }, { figure = "5 (b)" }]"#,
    r#"expect.figure_5a="any""#,
    r#"expect.figure_5b="any""#,
];

impl Reproduction {
    /// Runs every experiment on all cores; the results are to be [written](Self::write) to `folder`. `progress` gets
    /// the number of finished runs and the total.
    ///
    /// # Errors
    /// What is wrong with a scenario, or why a run cannot continue; if the results would overwrite an input.
    pub fn run(settings: &Settings, folder: &Path, progress: impl Fn(usize, usize) + Sync) -> Result<Self, Error> {
        let changes = settings.overrides();
        let overrides: Vec<String> = changes.iter().cloned().chain(FIGURE_MONITORS.map(str::to_owned)).collect();
        let mut complaints = Complaints::default();
        let load = |experiment: &Experiment| {
            let loaded = find::find(experiment.scenario).and_then(|found| Scenario::load(&found, &overrides));
            complaints.take(loaded).map(Arc::new)
        };
        let scenarios: Vec<_> = EXPERIMENTS.iter().filter_map(load).collect();
        complaints.check()?;
        FILES.iter().try_for_each(|name| diagnostics::check_unread(&folder.join(name)))?;
        let seeds = settings.seeds;
        // Results come in the order of the jobs, so the runs of an experiment are next to each other.
        let films = scenarios.iter().map(|scenario| Job::Film(Arc::clone(scenario)));
        let runs = scenarios
            .iter()
            .flat_map(|scenario| (1..=seeds).map(|seed| Job::ExperimentRun(Arc::clone(scenario), seed)));
        let jobs: Vec<Job> = films.chain(runs).collect();
        let done = batch::run(&jobs, Job::carry_out, |done| progress(done, jobs.len()));
        let (mut films, mut runs) = (Vec::new(), Vec::new());
        for done in done {
            match done? {
                Done::Film(film) => films.push(film),
                Done::ExperimentRun(run) => runs.push(*run),
            }
        }
        let of_each = EXPERIMENTS.iter().zip(runs.chunks(seeds.max(1) as usize));
        Ok(Self {
            version: env!("CARGO_PKG_VERSION"),
            seeds,
            settings: changes,
            experiments: of_each.map(|(experiment, runs)| ExperimentResult::of(experiment, runs)).collect(),
            context: films.first().map(|film| film.context.clone()).unwrap_or_default(),
            properties: scenarios.first().map(|scenario| scenario.properties.clone()).unwrap_or_default(),
            stills: films.into_iter().flat_map(|film| film.stills).collect(),
        })
    }

    /// Whether every claim of the paper and of this project was true of every run.
    #[must_use]
    pub fn all_hold(&self) -> bool {
        self.experiments
            .iter()
            .flat_map(|experiment| experiment.claims.iter().chain(&experiment.ours))
            .all(ClaimResult::holds)
    }

    /// The results of the paper's claims, in a sentence or two.
    fn outcome(&self) -> String {
        let claims = || self.experiments.iter().flat_map(|experiment| &experiment.claims);
        let ours = || self.experiments.iter().flat_map(|experiment| &experiment.ours);
        let (all, failed) = (claims().count(), claims().filter(|claim| !claim.holds()).count());
        let failed_ours = ours().filter(|claim| !claim.holds()).count();
        let all_runs = counted(self.seeds * self.experiments.len() as u64, "run");
        let simulated = format!(
            "{all_runs} in simulation, {} of the undisturbed scenario and of each of the three experiments",
            self.seeds
        );
        let papers = match failed {
            0 => format!(
                "{simulated}: each of the {all} claims taken from the paper was true of every run of its experiment. \
                 {NOT_CLAIMED}"
            ),
            _ => format!(
                "{simulated}: {failed} of the {all} claims taken from the paper were not true of every run. {NOT_CLAIMED}"
            ),
        };
        match failed_ours {
            0 => papers,
            _ => format!(
                "{papers} {failed_ours} of the {} claims that this project adds were not true of every run.",
                ours().count()
            ),
        }
    }
}

impl Job {
    fn carry_out(&self) -> Result<Done, Error> {
        match self {
            Self::ExperimentRun(scenario, seed) => {
                let run = Run::new(Arc::clone(scenario), *seed, true)?;
                let begin = |view: &RunView| {
                    Ok::<_, Error>((Presentation::begin(view, &Outputs::default())?, Observed::begin(view)))
                };
                let followed = conduct(run, Detail::Full, None, begin, |_| ControlFlow::Continue(()))?;
                let ((presentation, observed), view) = followed;
                let report = presentation.finish(&view)?;
                Ok(Done::ExperimentRun(Box::new(ExperimentRun { report, observed })))
            }
            Self::Film(scenario) => film::film(scenario).map(Done::Film),
        }
    }
}

impl ExperimentResult {
    fn of(experiment: &Experiment, runs: &[ExperimentRun]) -> Self {
        let results = |claims: &[Claim]| -> Vec<ClaimResult> {
            claims.iter().map(|claim| ClaimResult::of(claim.says, claim.source, runs, claim.differs)).collect()
        };
        let mut ours = results(experiment.ours);
        let as_expected =
            |run: &ExperimentRun| (!run.report.differences.is_empty()).then(|| run.report.differences.join("; "));
        let says = "everything else that the scenario expects: φ3, places, collisions, charge";
        ours.push(ClaimResult::of(says, "the scenario’s [expect]", runs, as_expected));
        let result = |run: &ExperimentRun| RunResult {
            seed: run.report.seed,
            trace_hash: run.report.trace_hash.clone(),
            violated_at_tick: violations(run),
        };
        Self {
            scenario: experiment.scenario,
            title: experiment.title,
            here: experiment.here,
            claims: results(experiment.claims),
            ours,
            runs: runs.iter().map(result).collect(),
        }
    }
}

fn violations(run: &ExperimentRun) -> BTreeMap<String, u64> {
    run.report.monitors.iter().filter_map(|monitor| Some((monitor.name.clone(), monitor.tick?))).collect()
}

impl ClaimResult {
    fn of(
        says: &'static str,
        source: &'static str,
        runs: &[ExperimentRun],
        differs: impl Fn(&ExperimentRun) -> Option<String>,
    ) -> Self {
        let difference = |run: &ExperimentRun| differs(run).map(|found| Difference { seed: run.report.seed, found });
        let differences: Vec<Difference> = runs.iter().filter_map(difference).collect();
        Self { says, source, runs: (runs.len() - differences.len()) as u64, differences }
    }

    fn holds(&self) -> bool {
        self.differences.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(scenario: &str, overrides: &[&str]) -> ExperimentRun {
        let found = find::find(scenario).expect("a shipped scenario");
        let overrides: Vec<String> = overrides.iter().copied().chain(FIGURE_MONITORS).map(str::to_owned).collect();
        let scenario = Arc::new(Scenario::load(&found, &overrides).expect("a sound scenario"));
        let Done::ExperimentRun(run) = Job::ExperimentRun(scenario, 1).carry_out().expect("a run") else {
            panic!("a run")
        };
        *run
    }

    /// The claims about an experiment that are not true of a run.
    fn wrong(experiment: &str, run: &ExperimentRun) -> Vec<&'static str> {
        let experiment = EXPERIMENTS.iter().find(|known| known.scenario == experiment).expect("an experiment");
        let result = ExperimentResult::of(experiment, std::slice::from_ref(run));
        let all = result.claims.iter().chain(&result.ours);
        all.filter(|claim| !claim.holds()).map(|claim| claim.says).collect()
    }

    #[test]
    fn a_run_of_a_different_scenario_does_not_satisfy_the_papers_claims() {
        let other = run("already_there", &[]);
        for experiment in &EXPERIMENTS {
            assert!(!wrong(experiment.scenario, &other).is_empty(), "{}", experiment.title);
        }
    }

    #[test]
    fn a_robot_that_leaves_the_station_early_did_not_wait_until_it_was_full() {
        let early = run(
            "nominal",
            &[
                "battery.charge_pct_per_s=2",
                r#"faults=[{ kind = "charging_status_wrong", at_s = 65, charging = false }]"#,
            ],
        );
        let full = run("nominal", &["battery.charge_pct_per_s=2"]);
        let says = |run: &ExperimentRun| wrong("nominal", run).iter().any(|claim| claim.starts_with("it waits there"));
        assert!(!says(&full), "{:?}", full.observed.charges);
        assert!(says(&early), "{:?}", early.observed.charges);
    }

    #[test]
    fn a_robot_that_turns_back_at_a_different_level_is_noticed() {
        let says = |threshold: &str| {
            let fault =
                format!(r#"{{ kind = "skill_threshold", at_s = 0, skill = "BatteryLevel", value = "{threshold}" }}"#);
            let run = run("nominal", &[&format!("faults=[{fault}]"), "battery.charge_pct_per_s=2"]);
            wrong("nominal", &run).iter().any(|claim| claim.starts_with("the robot sets out"))
        };
        assert!(says("31"), "it sets out too early");
        assert!(says("29"), "it sets out too late");
    }
}
