//! The matrix: which property detects which fault.

mod page;
mod suites;
mod table;

use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use diagnostics::counted;
use monitors::Outcome;
use recording::{Detail, Provenance};
use reports::Outputs;
use reports::report::{MonitorReport, Report};
use runs::Run;
use scenarios::scenario::Scenario;
use serde::Serialize;

use crate::Error;
use crate::run_and_report;

pub use table::table;

/// A scenario of the matrix, ready to run.
struct Job {
    scenario: Arc<Scenario>,
    seed: u64,
}

impl Job {
    fn conduct(&self, stories: bool) -> Result<Report, Error> {
        let run = Run::new(Arc::clone(&self.scenario), self.seed, true)?;
        let outputs = Outputs { stories, ..Outputs::default() };
        run_and_report(run, Detail::Verdicts, &outputs, None, |_| {}, |_| ControlFlow::Continue(()))
    }
}

/// The results of scenarios with faults, and of runs in the same world without faults.
#[derive(Clone, Debug, Serialize)]
pub struct Matrix {
    /// The properties, in the order in which the scenarios name them.
    pub properties: Vec<String>,
    /// The scenarios with faults, in the given order.
    pub rows: Vec<Row>,
    /// The runs without faults.
    pub fault_free: FaultFree,
}

/// A scenario with faults.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// The scenario's name.
    pub scenario: String,
    /// The root seed.
    pub seed: u64,
    /// What the run was made from.
    pub provenance: Provenance,
    /// Whether the scenario has faults. If not, the row does not count for their detection.
    pub has_fault: bool,
    /// What its faults do, in words; null if none took effect.
    pub fault: Option<String>,
    /// When its first fault took effect, in ticks and in seconds; null if none did.
    pub onset: Option<Onset>,
    /// The verdict of each property, in the order of the matrix; null where the scenario does not watch it.
    pub notices: Vec<Option<Notice>>,
    /// Whether the run was as the scenario expects.
    pub as_expected: bool,
    /// The differences, in words.
    pub differences: Vec<String>,
    /// The results of the monitors, with what led to each violation.
    #[serde(skip)]
    pub monitors: Vec<MonitorReport>,
    /// Whether something besides verdicts was not as expected.
    #[serde(skip)]
    pub differs_otherwise: bool,
    /// Contacts of the robot with anything else; null without a robot.
    pub collisions: Option<u64>,
    /// Whether the robot came to rest at its destination: a place at which the scenario stops, or any place if it stops
    /// at none.
    pub arrived: bool,
}

/// When a fault took effect.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Onset {
    /// The last tick generated before it; null if there was none.
    pub tick: Option<u64>,
    /// The time, in seconds.
    pub time_s: f64,
}

/// The verdict on a property in a run.
#[derive(Clone, Debug, Serialize)]
pub struct Notice {
    /// `satisfied`, `violated` or `inconclusive`.
    pub verdict: Outcome,
    /// How many ticks after the fault's onset it was violated; null if it was not violated, or was violated before the
    /// onset.
    pub ticks_after_onset: Option<u64>,
    /// Whether it was violated before any fault took effect.
    pub false_alarm: bool,
    /// Whether it was satisfied vacuously: a condition in it never occurred.
    pub vacuous: bool,
}

/// What a verdict means for the fault of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sign {
    /// The property was violated this many ticks after the fault took effect.
    Detected(u64),
    /// The same, but the property was also violated in a run without a fault.
    AlsoWithoutFault(u64),
    /// It was violated before the fault took effect.
    Early,
    /// It was violated although no fault took effect.
    WithoutFault,
    Satisfied,
    /// It was satisfied, but a condition in it never occurred.
    Vacuous,
    Inconclusive,
}

/// Whether a verdict shows something about a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum AboutFault {
    /// It does: the fault is detected, or does not violate the property.
    Something,
    /// It is the same without a fault, or open.
    Nothing,
    /// It is wrong: nothing had happened yet.
    FalseAlarm,
}

/// The results of the runs without faults.
#[derive(Clone, Debug, Serialize)]
pub struct FaultFree {
    /// The scenario.
    pub scenario: String,
    /// What the runs were made from.
    pub provenance: Provenance,
    /// The number of runs, with root seeds starting at 1.
    pub runs: u64,
    /// The properties that were violated in some of them. They need no fault for that, so they detect none.
    pub violated: Vec<String>,
    /// The runs in which a property was violated, or that were not as expected.
    pub alarms: Vec<Alarm>,
}

/// A false alarm.
#[derive(Clone, Debug, Serialize)]
pub struct Alarm {
    /// The root seed.
    pub seed: u64,
    /// What was violated, or not as expected, in words.
    pub what: Vec<String>,
    /// The results of the monitors, with what led to each violation.
    #[serde(skip)]
    pub monitors: Vec<MonitorReport>,
    /// Whether something besides verdicts was not as expected.
    #[serde(skip)]
    pub differs_otherwise: bool,
}

impl Matrix {
    /// Runs the scenarios with their own seeds, and the fault-free one `runs` times, on all cores. Calls `progress`
    /// with the number of finished runs, the total, and the report of the run that has just finished, if it reached its
    /// end. With `stories`, the results of the monitors include the story of each violation.
    ///
    /// # Errors
    /// What is wrong with a scenario, why a run cannot continue, or that the scenario without faults has some.
    pub fn run(
        scenarios: Vec<Arc<Scenario>>,
        fault_free: &Arc<Scenario>,
        runs: u64,
        stories: bool,
        progress: impl Fn(usize, usize, Option<&Report>) + Sync,
    ) -> Result<Self, Error> {
        if !fault_free.file.faults.is_empty() {
            let message =
                format!("the scenario {} has faults, so it cannot show what happens without any", fault_free.name);
            return Err(Error::refused(message, "name another scenario with `--fault-free`"));
        }
        let faulty = scenarios.into_iter().map(|scenario| Job { seed: scenario.file.seed, scenario });
        let sound = (1..=runs).map(|seed| Job { scenario: Arc::clone(fault_free), seed });
        // One list of jobs, so that no core waits for the slowest faulty scenario before the fault-free runs begin.
        let jobs: Vec<Job> = faulty.chain(sound).collect();
        let done = AtomicUsize::new(0);
        let one = |job: &Job| {
            let report = job.conduct(stories);
            progress(done.fetch_add(1, Ordering::Relaxed) + 1, jobs.len(), report.as_ref().ok());
            report
        };
        let reports = batch::run(&jobs, one, |_| {});
        let reports = reports.into_iter().collect::<Result<Vec<_>, _>>()?;
        let (faulty, sound) = reports.split_at(jobs.len() - runs as usize);
        let properties = properties(&reports);
        let rows = faulty.iter().zip(&jobs).map(|(report, job)| Row::of(report, &job.scenario, &properties)).collect();
        let alarms = sound.iter().filter_map(Alarm::of).collect();
        let is_violated = |name: &&String| sound.iter().any(|report| violated(report).any(|found| found == *name));
        let violated = properties.iter().filter(is_violated).cloned().collect();
        let provenance = fault_free.origin.provenance(recording::commit());
        let fault_free = FaultFree { scenario: fault_free.name.clone(), provenance, runs, violated, alarms };
        Ok(Self { properties, rows, fault_free })
    }

    /// The rows whose fault is not detected by any property. A violation before the fault detects nothing, nor does
    /// that of a property that is also violated without a fault; and a scenario without faults has none to detect.
    pub fn unnoticed(&self) -> impl Iterator<Item = &Row> {
        let is_detected = |row: &Row| self.signs(row).flatten().any(|sign| matches!(sign, Sign::Detected(_)));
        self.rows.iter().filter(move |row| row.has_fault && !is_detected(row))
    }

    /// What each property's verdict means for the fault of a row; `None` where the scenario does not watch it.
    fn signs(&self, row: &Row) -> impl Iterator<Item = Option<Sign>> {
        let sign = |(name, notice): (&String, &Option<Notice>)| {
            let notice = notice.as_ref()?;
            let ticks = notice.ticks_after_onset.unwrap_or_default();
            Some(match notice.verdict {
                Outcome::Satisfied if notice.vacuous => Sign::Vacuous,
                Outcome::Satisfied => Sign::Satisfied,
                Outcome::Inconclusive => Sign::Inconclusive,
                Outcome::Violated if row.onset.is_none() => Sign::WithoutFault,
                Outcome::Violated if notice.false_alarm => Sign::Early,
                Outcome::Violated if self.fault_free.violated.contains(name) => Sign::AlsoWithoutFault(ticks),
                Outcome::Violated => Sign::Detected(ticks),
            })
        };
        self.properties.iter().zip(&row.notices).map(sign)
    }

    /// What each property's verdict means for the fault of a row, in words. Properties that the scenario does not
    /// watch are left out.
    fn verdicts<'m>(&'m self, row: &'m Row) -> impl Iterator<Item = (&'m str, String, AboutFault)> {
        let after = |ticks: u64| format!("{} after the fault", counted(ticks, "tick"));
        let verdict = move |(name, (sign, notice)): (&'m String, (Option<Sign>, &Option<Notice>))| {
            let words = match sign? {
                Sign::Detected(ticks) => format!("violated {}, which it detects", after(ticks)),
                Sign::AlsoWithoutFault(ticks) => format!("violated {}, but also in a run without one", after(ticks)),
                Sign::Early => "violated before the fault".to_owned(),
                Sign::WithoutFault => "violated although no fault took effect".to_owned(),
                Sign::Satisfied => "satisfied".to_owned(),
                Sign::Vacuous => "satisfied, but a condition in it never occurred".to_owned(),
                Sign::Inconclusive => "inconclusive".to_owned(),
            };
            let about = match sign? {
                _ if notice.as_ref().is_some_and(|notice| notice.false_alarm) => AboutFault::FalseAlarm,
                Sign::Detected(_) => AboutFault::Something,
                Sign::Satisfied if row.onset.is_some() => AboutFault::Something,
                _ => AboutFault::Nothing,
            };
            Some((name.as_str(), words, about))
        };
        self.properties.iter().zip(self.signs(row).zip(&row.notices)).filter_map(verdict)
    }

    /// Whether a sign of this kind occurs in the matrix, so that it must be explained.
    fn shows(&self, is_wanted: fn(&Sign) -> bool) -> bool {
        self.rows.iter().flat_map(|row| self.signs(row)).flatten().any(|sign| is_wanted(&sign))
    }

    /// False alarms, in words: violations without a fault, or before the fault.
    #[must_use]
    pub fn false_alarms(&self) -> Vec<String> {
        let sound = self.fault_free.alarms.iter().map(|alarm| {
            format!("{}, seed {}, without a fault: {}", self.fault_free.scenario, alarm.seed, alarm.what.join("; "))
        });
        let early = self.rows.iter().flat_map(|row| {
            let named = self.properties.iter().zip(&row.notices);
            let early = named.filter(|(_, notice)| notice.as_ref().is_some_and(|notice| notice.false_alarm));
            let when = if row.onset.is_some() { "before the fault" } else { "although no fault took effect" };
            early.map(move |(name, _)| format!("{}: {name} was violated {when}", row.scenario))
        });
        sound.chain(early).collect()
    }
}

/// The properties that a run has violated.
fn violated(report: &Report) -> impl Iterator<Item = &str> {
    let violated = report.monitors.iter().filter(|monitor| monitor.verdict == Outcome::Violated);
    violated.map(|monitor| monitor.name.as_str())
}

/// Whether something besides verdicts was not as expected in a run.
fn differs_otherwise(report: &Report) -> bool {
    report.expectations.iter().any(|expected| expected.difference.is_some() && !expected.is_of_verdict)
}

/// The names of all properties, in order of first appearance.
fn properties(reports: &[Report]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for monitor in reports.iter().flat_map(|report| &report.monitors) {
        if !names.contains(&monitor.name) {
            names.push(monitor.name.clone());
        }
    }
    names
}

impl Row {
    fn of(report: &Report, scenario: &Scenario, properties: &[String]) -> Self {
        let has_fault = !scenario.file.faults.is_empty();
        let first = report.faults.first();
        let onset = first.map(|fault| Onset { tick: fault.tick, time_s: fault.time_s });
        let notice = |name: &String| {
            let monitor = report.monitors.iter().find(|monitor| monitor.name == *name)?;
            let late = monitor.tick.zip(onset).and_then(|(tick, onset)| ticks_after(onset.tick, tick));
            // What is violated before the fault took effect is not violated because of it.
            let early = has_fault && monitor.time_s.is_some_and(|at| onset.is_none_or(|onset| at < onset.time_s));
            let vacuous = monitor.verdict == Outcome::Satisfied && !monitor.vacuous.is_empty();
            let ticks_after_onset = late.filter(|_| !early);
            Some(Notice { verdict: monitor.verdict, ticks_after_onset, false_alarm: early, vacuous })
        };
        let stop = &scenario.file.stop.at;
        let is_destination = |name: &str| stop.is_empty() || stop.iter().any(|place| place.value == name);
        Self {
            scenario: report.scenario.clone(),
            seed: report.seed,
            provenance: report.provenance.clone(),
            has_fault,
            fault: first.is_some().then(|| effects(report)),
            onset,
            notices: properties.iter().map(notice).collect(),
            as_expected: report.differences.is_empty(),
            differences: report.differences.clone(),
            monitors: report.monitors.clone(),
            differs_otherwise: differs_otherwise(report),
            collisions: report.robot.as_ref().map(|robot| robot.collisions),
            arrived: report.arrivals().iter().any(|(_, name)| is_destination(name)),
        }
    }
}

/// What the first faults of a run do, in words.
fn effects(report: &Report) -> String {
    /// More than this would not fit into a row.
    const MOST: usize = 3;
    let all = report.faults_in_words();
    let first: Vec<&str> = all.iter().take(MOST).map(|(effect, _)| effect.as_str()).collect();
    let more = all.len().saturating_sub(MOST);
    first.join("; ") + &if more == 0 { String::new() } else { format!("; and {more} more") }
}

/// The number of ticks from one tick to another; none if the other came first.
fn ticks_after(last_before: Option<u64>, tick: u64) -> Option<u64> {
    tick.checked_add(1)?.checked_sub(last_before.map_or(0, |last| last + 1))
}

impl Alarm {
    /// The alarm raised by a run without faults; none if everything is as expected.
    fn of(report: &Report) -> Option<Self> {
        let mut what: Vec<String> = violated(report).map(|name| format!("{name} is violated")).collect();
        what.extend(report.differences.iter().cloned());
        (!what.is_empty()).then(|| Self {
            seed: report.seed,
            what,
            monitors: report.monitors.clone(),
            differs_otherwise: differs_otherwise(report),
        })
    }
}
