//! The record of a run.

use std::time::Duration;

use diagnostics::seconds;
use monitors::Outcome;
use reports::report::{MonitorReport, OutcomeReport, Report};
use serde::{Deserialize, Serialize};

use super::{Measure, ParameterValue, PlannedRun};

/// One run of a campaign and its result. Nothing in it depends on the computer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunRecord {
    /// The run's number, from 0.
    pub k: u64,
    /// Its root seed.
    pub seed: u64,
    /// The parameters' values, in the order of the campaign's file.
    pub values: Vec<ParameterValue>,
    /// How it went.
    pub outcome: RunOutcome,
    /// The expectations of the scenario that the run did not meet, in words; empty if the run failed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub unmet: Vec<String>,
    /// Why there are no facts, in words: what the scenario rejected, why the run could not continue, or how it
    /// panicked.
    pub failure: Option<String>,
    /// The measurements; none if the run failed.
    pub facts: Option<RunFacts>,
}

/// The outcome of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RunOutcome {
    /// It was as the scenario expects.
    AsExpected,
    /// It was not.
    NotAsExpected,
    /// It did not reach its end.
    Failed,
}

impl RunOutcome {
    /// The outcome's name in results.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::AsExpected => "as_expected",
            Self::NotAsExpected => "not_as_expected",
            Self::Failed => "failed",
        }
    }
}

/// The measurements of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunFacts {
    /// Why the run ended: `arrival`, `violation`, `settled`, `time_limit` or `schedule`.
    pub ended: String,
    /// How long the run took, in simulated seconds.
    pub sim_time_s: f64,
    /// How many ticks were generated.
    pub ticks: u64,
    /// When the robot first came to rest at one of the places where the scenario stops, in seconds.
    pub arrived_s: Option<f64>,
    /// The lowest charge of the battery, in percent; none without a robot, as for the following five.
    pub battery_minimum_pct: Option<f64>,
    /// Its charge at the end, in percent.
    pub battery_final_pct: Option<f64>,
    /// Distance driven, in meters.
    pub distance_m: Option<f64>,
    /// Contacts of the robot with anything else.
    pub collisions: Option<u64>,
    /// Root mean square of the distance between the estimated and the true position, in meters.
    pub localization_rmse_m: Option<f64>,
    /// The greatest such distance, in meters.
    pub localization_max_m: Option<f64>,
    /// How many faults took effect.
    pub faults: u64,
    /// When the first fault took effect, in seconds.
    pub fault_onset_s: Option<f64>,
    /// BLAKE3 hash of the run's trace.
    pub trace_hash: String,
    /// The verdicts of the monitors, in the order of [`Plan::properties`](super::Plan::properties).
    pub monitors: Vec<MonitorFacts>,
}

impl RunFacts {
    /// A measured value, if it exists.
    #[must_use]
    pub fn measured(&self, measure: Measure) -> Option<f64> {
        match measure {
            Measure::ArrivedS => self.arrived_s,
            Measure::BatteryMinimumPct => self.battery_minimum_pct,
            Measure::DistanceM => self.distance_m,
            Measure::Collisions => self.collisions.map(|collisions| collisions as f64),
            Measure::LocalizationRmseM => self.localization_rmse_m,
            Measure::LocalizationMaxM => self.localization_max_m,
        }
    }
}

/// The final verdict of a monitor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MonitorFacts {
    /// `satisfied`, `violated` or `inconclusive`.
    pub verdict: Outcome,
    /// The tick of the violation.
    pub tick: Option<u64>,
    /// The time of the violation, in seconds.
    pub time_s: Option<f64>,
    /// Time from the first fault's onset to the violation, in seconds; none if there was no violation after the onset.
    pub latency_s: Option<f64>,
    /// The number of violations. A property that is violated for good, or whose monitor does not go on, has one.
    pub violations: u64,
    /// How long they lasted together, in seconds; none if there were none, or if the monitor does not go on.
    pub violated_s: Option<f64>,
    /// Whether it was satisfied vacuously: a condition in it never occurred.
    pub vacuous: bool,
}

impl RunRecord {
    /// The record of a run that has ended.
    pub(super) fn of(run: PlannedRun, report: &Report, stops: &[&str]) -> Self {
        let onset = report.faults.first().map(|fault| fault.time_s);
        let stops = report.places.iter().filter(|place| stops.contains(&&*place.name));
        let robot = report.robot.as_ref();
        let localization = robot.and_then(|robot| robot.localization);
        let facts = RunFacts {
            ended: report.ended.to_owned(),
            sim_time_s: report.sim_time_s,
            ticks: report.ticks,
            arrived_s: stops.filter_map(|place| place.reached_at_s).min_by(f64::total_cmp),
            battery_minimum_pct: report.battery.map(|battery| battery.minimum),
            battery_final_pct: report.battery.map(|battery| battery.r#final),
            distance_m: robot.map(|robot| robot.distance_m),
            collisions: robot.map(|robot| robot.collisions),
            localization_rmse_m: localization.map(|error| error.rmse_m),
            localization_max_m: localization.map(|error| error.max_m),
            faults: report.faults.len() as u64,
            fault_onset_s: onset,
            trace_hash: report.trace_hash.clone(),
            monitors: report.monitors.iter().map(|monitor| MonitorFacts::of(monitor, onset)).collect(),
        };
        // An interrupted campaign finishes the runs that have begun. If one were interrupted, it would not be a result.
        let outcome = match report.outcome {
            OutcomeReport::AsExpected => RunOutcome::AsExpected,
            OutcomeReport::NotAsExpected => RunOutcome::NotAsExpected,
            OutcomeReport::Interrupted => RunOutcome::Failed,
        };
        let unmet = report.expectations.iter().filter(|expectation| expectation.difference.is_some());
        let unmet = unmet.map(|expectation| expectation.expected.clone()).collect();
        let PlannedRun { k, seed, values } = run;
        Self { k, seed, values, outcome, unmet, failure: None, facts: Some(facts) }
    }

    /// The record of a run that did not reach its end.
    pub(super) fn failed(run: PlannedRun, why: String) -> Self {
        let PlannedRun { k, seed, values } = run;
        Self { k, seed, values, outcome: RunOutcome::Failed, unmet: Vec::new(), failure: Some(why), facts: None }
    }

    /// Whether the property with this index in [`Plan::properties`](super::Plan::properties) was violated. None for a
    /// failed run, which does not count for any property.
    #[must_use]
    pub fn violated(&self, property: usize) -> Option<bool> {
        Some(self.facts.as_ref()?.monitors.get(property)?.verdict == Outcome::Violated)
    }

    /// Whether the run was not as the scenario expects. A failed run was not.
    #[must_use]
    pub fn unexpected(&self) -> bool {
        self.outcome != RunOutcome::AsExpected
    }
}

impl MonitorFacts {
    fn of(monitor: &MonitorReport, onset: Option<f64>) -> Self {
        let latency = monitor.time_s.zip(onset).filter(|(time, onset)| time >= onset).map(|(time, onset)| {
            let [time, onset] = [time, onset].map(Duration::from_secs_f64);
            seconds(time - onset)
        });
        let all = monitor.violations.as_ref();
        let once = u64::from(monitor.verdict == Outcome::Violated);
        Self {
            verdict: monitor.verdict,
            tick: monitor.tick,
            time_s: monitor.time_s,
            latency_s: latency,
            violations: all.map_or(once, |all| all.count),
            violated_s: all.filter(|all| all.goes_on).map(|all| all.total_s),
            vacuous: monitor.verdict == Outcome::Satisfied && !monitor.vacuous.is_empty(),
        }
    }
}
