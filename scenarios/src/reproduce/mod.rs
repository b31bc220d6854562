//! The paper's experiments, run again and held against what the paper says.

mod experiments;
mod film;
mod page;
mod shots;
mod table;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::Serialize;

use crate::Error;
use crate::batch;
use crate::conduct::{Outputs, conduct};
use crate::error::Complaints;
use crate::report::Report;
use crate::scenario::{Scenario, find};

use experiments::{EXPERIMENTS, Experiment};
use film::Still;

pub(crate) use table::table;

/// What came of running the experiments again.
#[derive(Debug, Serialize)]
pub struct Reproduction {
    /// Each experiment was run with the root seeds from 1 to this.
    pub seeds: u64,
    /// The experiments, in the order of the paper.
    pub experiments: Vec<ExperimentResult>,
    /// The moments that the paper's figures show, of the runs with seed 1.
    #[serde(skip)]
    stills: Vec<Still>,
}

/// What came of an experiment.
#[derive(Clone, Debug, Serialize)]
pub struct ExperimentResult {
    /// The scenario.
    pub scenario: &'static str,
    /// What the paper calls it.
    pub title: &'static str,
    /// What the paper says must happen, and what did.
    pub claims: Vec<ClaimResult>,
}

/// What came of a claim.
#[derive(Clone, Debug, Serialize)]
pub struct ClaimResult {
    /// What the paper says, in words.
    pub says: &'static str,
    /// Where it does.
    pub source: &'static str,
    /// In how many runs it was so.
    pub runs: u64,
    /// The runs in which it was not.
    pub differences: Vec<Difference>,
}

/// A run that was not as the paper says.
#[derive(Clone, Debug, Serialize)]
pub struct Difference {
    /// The root seed.
    pub seed: u64,
    /// What was found instead, in words.
    pub found: String,
}

/// Something to be done on one of the cores.
enum Job {
    /// A run for its report.
    Run(Arc<Scenario>, u64),
    /// A run for its pictures.
    Film(Arc<Scenario>),
}

enum Done {
    Run(Box<Report>),
    Film(Vec<Still>),
}

impl Reproduction {
    /// Runs every experiment with the root seeds from 1 to `seeds`, on all cores. `progress` is told how many runs of how
    /// many are done.
    ///
    /// # Errors
    /// What is wrong with a scenario, or why a run cannot go on.
    pub fn run(seeds: u64, progress: impl Fn(usize, usize) + Sync) -> Result<Self, Error> {
        let mut complaints = Complaints::default();
        let load = |experiment: &Experiment| {
            let loaded = find::find(experiment.scenario).and_then(|found| Scenario::load(&found, &[]));
            complaints.take(loaded).map(Arc::new)
        };
        let scenarios: Vec<_> = EXPERIMENTS.iter().filter_map(load).collect();
        complaints.check()?;
        let films = scenarios.iter().map(|scenario| Job::Film(Arc::clone(scenario)));
        let runs = scenarios.iter().flat_map(|scenario| (1..=seeds).map(|seed| Job::Run(Arc::clone(scenario), seed)));
        let jobs: Vec<Job> = films.chain(runs).collect();
        let done = batch::run(&jobs, Job::carry_out, |done| progress(done, jobs.len()));
        let (mut stills, mut reports) = (Vec::new(), Vec::new());
        for done in done {
            match done? {
                Done::Film(film) => stills.extend(film),
                Done::Run(report) => reports.push(*report),
            }
        }
        let of_each = EXPERIMENTS.iter().zip(reports.chunks(seeds.max(1) as usize));
        let experiments = of_each.map(|(experiment, reports)| ExperimentResult::of(experiment, reports)).collect();
        Ok(Self { seeds, experiments, stills })
    }

    /// Whether everything was in every run as the paper says.
    #[must_use]
    pub fn is_as_printed(&self) -> bool {
        self.claims().all(|claim| claim.differences.is_empty())
    }

    fn claims(&self) -> impl Iterator<Item = &ClaimResult> {
        self.experiments.iter().flat_map(|experiment| &experiment.claims)
    }

    /// Writes the results as `reproduce.json` and as a page, `index.html`, to a folder.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn write(&self, folder: &Path) -> Result<(), Error> {
        let failed = |path: PathBuf| move |source| Error::Write { path, source };
        std::fs::create_dir_all(folder).map_err(failed(folder.to_owned()))?;
        let json = serde_json::to_string_pretty(self).expect("results are always JSON") + "\n";
        for (name, text) in [("reproduce.json", json), ("index.html", page::page(self))] {
            let path = folder.join(name);
            std::fs::write(&path, text).map_err(failed(path.clone()))?;
        }
        Ok(())
    }
}

impl Job {
    fn carry_out(&self) -> Result<Done, Error> {
        match self {
            Self::Run(scenario, seed) => {
                let report = conduct(Arc::clone(scenario), *seed, true, &Outputs::default(), |_| {})?;
                Ok(Done::Run(Box::new(report)))
            }
            Self::Film(scenario) => film::film(scenario).map(Done::Film),
        }
    }
}

impl ExperimentResult {
    fn of(experiment: &Experiment, reports: &[Report]) -> Self {
        let mut claims: Vec<ClaimResult> = experiment
            .claims
            .iter()
            .map(|claim| ClaimResult::of(claim.says, claim.source, reports, claim.differs))
            .collect();
        let as_expected = |run: &Report| (!run.differences.is_empty()).then(|| run.differences.join("; "));
        claims.push(ClaimResult::of("and all that the scenario expects", "[expect]", reports, as_expected));
        Self { scenario: experiment.scenario, title: experiment.title, claims }
    }
}

impl ClaimResult {
    fn of(
        says: &'static str,
        source: &'static str,
        reports: &[Report],
        differs: impl Fn(&Report) -> Option<String>,
    ) -> Self {
        let difference = |run: &Report| differs(run).map(|found| Difference { seed: run.seed, found });
        let differences: Vec<Difference> = reports.iter().filter_map(difference).collect();
        Self { says, source, runs: (reports.len() - differences.len()) as u64, differences }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_experiment_is_a_scenario_that_comes_with_the_program() {
        for experiment in &EXPERIMENTS {
            let found = find::find(experiment.scenario).expect("a shipped scenario");
            Scenario::load(&found, &[]).expect("a sound scenario");
        }
    }

    #[test]
    fn a_run_of_another_scenario_is_not_what_the_paper_says() {
        let found = find::find("already_there").expect("a shipped scenario");
        let scenario = Arc::new(Scenario::load(&found, &[]).expect("a sound scenario"));
        let report = conduct(scenario, 1, true, &Outputs::default(), |_| {}).expect("a run");
        for experiment in &EXPERIMENTS {
            let result = ExperimentResult::of(experiment, std::slice::from_ref(&report));
            assert!(result.claims.iter().any(|claim| claim.runs == 0 && claim.differences[0].seed == 1), "{result:?}");
        }
    }
}
