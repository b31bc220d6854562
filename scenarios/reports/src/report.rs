//! The report of a run: `report.json`.

use std::time::Duration;

use diagnostics::seconds;
use monitors::{Outcome, Violation, Violations};
use recording::{Certainty, Provenance, ShownVerdict};
use serde::{Serialize, Serializer};

use crate::WitnessReport;

/// The report of a run. Keys are stable; absent values are null. Only [`timing`](Self::timing) may differ between two
/// runs of one scenario and seed.
///
/// Its fields are the keys of the file, in their order. What several of them describe together is a struct of its own.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// The scenario's name.
    pub scenario: String,
    /// The root seed.
    pub seed: u64,
    /// The program's version.
    pub version: String,
    /// What the run was made from.
    pub provenance: Provenance,
    /// Whether the run met the scenario's `[expect]`.
    pub outcome: OutcomeReport,
    /// Differences from `[expect]`, in words; empty when there are none.
    pub differences: Vec<String>,
    /// Every expectation in `[expect]`, and whether it was met; empty for an interrupted run.
    pub expectations: Vec<ExpectationReport>,
    /// How long the run took, in simulated seconds.
    pub sim_time_s: f64,
    /// Why the run ended: `arrival`, `violation`, `settled`, `time_limit`, `schedule`, `interrupted`, or of a
    /// recording of something else `recorded`, or `cut_off` if it ends in the middle of something.
    pub ended: &'static str,
    /// The same in words.
    pub ended_because: String,
    /// How many ticks were generated.
    pub ticks: u64,
    /// How many of them could not be delivered.
    pub overruns: u64,
    /// How many communications there were.
    pub steps: u64,
    /// BLAKE3 hash of the trace.
    pub trace_hash: String,
    /// The properties with the results of their monitors.
    pub monitors: Vec<MonitorReport>,
    /// The faults that took effect, in order.
    pub faults: Vec<FaultReport>,
    /// The faults that were due but could not be injected, in order.
    pub undone_faults: Vec<UndoneFaultReport>,
    /// The faults of the scenario that never came: the run ended before, or their trigger or probability did not let
    /// them.
    pub absent_faults: Vec<AbsentFaultReport>,
    /// The latest failure of the whole tree; null if it never failed, or in a campaign.
    pub tree_failure: Option<TreeFailureReport>,
    /// Errors in nodes of the tree, each once, in the order of first occurrence.
    pub tree_errors: Vec<TreeErrorReport>,
    /// What a recording lacks, in words: the first few losses, and how many more there are.
    pub lost: Vec<String>,
    /// Remarks about the log of a tree, in words: when its clock was set back. The first few times, and
    /// how many more there are.
    pub remarks: Vec<String>,
    /// Errors in the machines and programs of skills and components, each once, in the order of first occurrence.
    pub skill_errors: Vec<SkillErrorReport>,
    /// What speakers said, in order.
    pub said: Vec<SaidReport>,
    /// The battery's charge; null without a battery.
    pub battery: Option<BatteryReport>,
    /// The results of the robot; null without a robot.
    pub robot: Option<RobotReport>,
    /// When each place was reached.
    pub places: Vec<PlaceReport>,
    /// The pictures that were made.
    pub snapshots: Vec<SnapshotReport>,
    /// How long the computer took.
    pub timing: TimingReport,
}

/// Whether a run met its scenario's expectations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum OutcomeReport {
    /// It was.
    AsExpected,
    /// It was not.
    NotAsExpected,
    /// It was interrupted before that was known.
    Interrupted,
}

/// Something that the scenario expects of its runs.
#[derive(Clone, Debug, Serialize)]
pub struct ExpectationReport {
    /// The expectation, in words: `phi1 to be violated`.
    pub expected: String,
    /// What is so if it is met: `the robot came to rest at Kitchen`; none for a property, which has a verdict.
    #[serde(skip)]
    pub met: Option<String>,
    /// What was found instead, in words; null if it was as expected.
    pub difference: Option<String>,
    /// Whether it is about the verdict of a property.
    #[serde(skip)]
    pub is_of_verdict: bool,
}

/// A monitor's result at the end of a run.
#[derive(Clone, Debug, Serialize)]
pub struct MonitorReport {
    /// The property's name.
    pub name: String,
    /// Its formula.
    pub property: String,
    /// Whether it is a `timed property`, whose durations are measured and not counted in ticks.
    pub timed: bool,
    /// `satisfied`, `violated` or `inconclusive`.
    pub verdict: Outcome,
    /// What the scenario expects it to be; null without an expectation.
    pub expected: Option<Outcome>,
    /// The monitor's location.
    pub state: String,
    /// The tick of the violation; null if it is not known when the tree was ticked.
    pub tick: Option<u64>,
    /// The time of the violation, in seconds.
    pub time_s: Option<f64>,
    /// Every violation; null if there was none, or if the monitor has only the first one.
    pub violations: Option<ViolationsReport>,
    /// Why the property was violated: the communication that violated it, and the messages that led to it.
    pub witness: Option<WitnessReport>,
    /// How sure the verdict is: `sure`; `unless` a message was lost that could not be noticed yet; `unsure`, as
    /// messages are missing that could change it; or `none`, if nothing vouches that messages could have come. In the
    /// last two cases, `verdict` is `inconclusive`.
    #[serde(serialize_with = "by_name")]
    pub certainty: Certainty,
    /// Why it is not sure, in words; null if it is.
    pub unsure: Option<String>,
    /// What is assumed of the messages, in words, such as "the recorder wrote every message that was sent, once".
    pub assumptions: Vec<String>,
    /// The channels of the property on which there was no message, as "from A to B".
    pub silent: Vec<String>,
    /// Obligations still pending when the run ended, in words.
    pub open: Vec<String>,
    /// The clauses that were vacuously satisfied: their condition never occurred.
    pub vacuous: Vec<String>,
    /// If the property requires a battery level in messages and is satisfied although the true level fell below it:
    /// that no message reported it, in words.
    pub unheard: Option<String>,
    /// Errors in the scripts, if the monitor is a machine; each once.
    pub errors: Vec<String>,
    /// The story of its first violation, as it is on the page, in sentences with code in backquotes; empty without a
    /// violation or without a page.
    #[serde(skip)]
    pub story: Vec<String>,
}

fn by_name<S: Serializer>(certainty: &Certainty, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(certainty.name())
}

impl MonitorReport {
    /// The verdict that may be shown.
    #[must_use]
    pub fn found(&self) -> ShownVerdict {
        self.certainty.verdict(self.verdict)
    }

    /// When it was violated, in words.
    #[must_use]
    pub fn moment(&self) -> Option<String> {
        let time_s = self.time_s?;
        Some(match self.tick {
            Some(tick) => format!("tick {tick}, {time_s:.2} s"),
            None => format!("{time_s:.2} s"),
        })
    }
}

/// How often, when and how long a property was violated.
#[derive(Clone, Debug, Serialize)]
pub struct ViolationsReport {
    /// How many violations there were.
    pub count: u64,
    /// How long at least one of them lasted, in seconds.
    pub total_s: f64,
    /// Whether the property was judged anew after each violation; otherwise, it was violated once and for good.
    pub goes_on: bool,
    /// The first of them, at most 1000: when each began, of a missed deadline the deadline, and when it was over, in
    /// seconds; null if it lasted to the end.
    pub first: Vec<ViolationReport>,
    /// How often and how long, in words, if that is more than the first violation.
    #[serde(skip)]
    pub words: Option<String>,
}

/// A violation.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct ViolationReport {
    /// When it began, in seconds: of a missed deadline, the deadline.
    pub from_s: f64,
    /// When it was over, in seconds: the property was checked next and held, or what it waited for came too late. Null
    /// if it lasted to the end.
    pub until_s: Option<f64>,
}

impl ViolationsReport {
    /// The violations of a run that has ended at this time.
    #[must_use]
    pub fn of(violations: &Violations, end: Duration) -> Self {
        let violation = |Violation { from, until }: &Violation| ViolationReport {
            from_s: seconds(from.time),
            until_s: until.map(|until| seconds(until.time)),
        };
        Self {
            count: violations.count,
            total_s: seconds(violations.lasting(end)),
            goes_on: violations.goes_on,
            first: violations.first.iter().map(violation).collect(),
            words: violations.in_words(end),
        }
    }
}

/// What a speaker said.
#[derive(Clone, Debug, Serialize)]
pub struct SaidReport {
    /// When it became audible, in seconds.
    pub time_s: f64,
    /// The speaker's name.
    pub by: String,
    /// The text.
    pub text: String,
}

/// A fault that took effect.
#[derive(Clone, Debug, Serialize)]
pub struct FaultReport {
    /// The kind of fault.
    pub kind: String,
    /// When it took effect, in seconds.
    pub time_s: f64,
    /// The last tick that had been generated then; null if none had.
    pub tick: Option<u64>,
    /// When it ended, in seconds; null if it lasted until the end or happened at one instant.
    pub until_s: Option<f64>,
    /// Its effect, in words.
    pub effect: String,
    /// The values of its parameters, angles in degrees.
    pub arguments: serde_json::Map<String, serde_json::Value>,
    /// How many messages it damaged in the run; null for a fault that damages none.
    pub messages: Option<u64>,
}

/// A fault that was due but could not be injected.
#[derive(Clone, Debug, Serialize)]
pub struct UndoneFaultReport {
    /// The kind of fault.
    pub kind: String,
    /// When it was due, in seconds.
    pub time_s: f64,
    /// Its intended effect, in words.
    pub effect: String,
    /// Why it could not be injected, in words.
    pub reason: String,
}

/// A fault that never came.
#[derive(Clone, Debug, Serialize)]
pub struct AbsentFaultReport {
    /// The kind of fault.
    pub kind: String,
    /// Its intended effect, in words.
    pub effect: String,
    /// The values of its parameters, angles in degrees.
    pub arguments: serde_json::Map<String, serde_json::Value>,
}

/// A failure of the whole tree.
#[derive(Clone, Debug, Serialize)]
pub struct TreeFailureReport {
    /// The number of the node that made the tree fail, in document order.
    pub node: usize,
    /// Its name.
    pub label: String,
    /// The tick of the failure; if the tree failed at several ticks in a row, the first.
    pub tick: u64,
    /// Its time, in seconds.
    pub time_s: f64,
    /// The last message from a component to the leaf's skill up to then, in words; null without one. What came before
    /// the leaf sent a request, or before it began to wait, is not why it failed.
    pub message: Option<String>,
    /// What the leaf's skill requested of a component and did not get, in words: there was no answer, or the skill
    /// called it off. Null if there is no such request.
    pub unmet: Option<String>,
    /// Whether the skill called it off.
    pub is_called_off: bool,
    /// How long the leaf had been running, in seconds; null if it answered at once.
    pub ran_s: Option<f64>,
    /// Whether the tree still failed at the end.
    pub lasts: bool,
}

impl TreeFailureReport {
    /// Why the tree failed.
    #[must_use]
    pub fn words(&self) -> String {
        let Self { label, tick, time_s, .. } = self;
        let ran = self.ran_s.map_or_else(String::new, |ran_s| format!(" after {ran_s:.2} s"));
        let why = match (&self.unmet, &self.message) {
            (Some(request), _) if self.is_called_off => format!("{ran}, and had called off {request}"),
            (Some(request), _) => format!("{ran}, without an answer to {request}"),
            (None, Some(message)) => format!("{ran}, after {message}"),
            (None, None) => ran,
        };
        let end = if self.lasts { "; it still failed at the end" } else { "; later it did not" };
        format!("failed at tick {tick}, {time_s:.2} s, because {label} failed{why}{end}")
    }
}

/// An error in a node of the tree, such as a script that cannot be evaluated or a port without a value.
#[derive(Clone, Debug, Serialize)]
pub struct TreeErrorReport {
    /// The node's number in document order.
    pub node: usize,
    /// Its name.
    pub label: String,
    /// The error, in words.
    pub message: String,
    /// The tick of its first occurrence.
    pub tick: u64,
    /// The time of its first occurrence, in seconds.
    pub time_s: f64,
}

/// An error in the machine or program of a skill or component, such as an expression or a script that failed, or a
/// program that ended.
#[derive(Clone, Debug, Serialize)]
pub struct SkillErrorReport {
    /// `skill` or `component`.
    pub kind: &'static str,
    /// The name of the skill or component.
    pub skill: String,
    /// The state that contains the failing element in the machine's file, or the last state that the program reported;
    /// null for elements outside states.
    pub state: Option<String>,
    /// The error, in words.
    pub message: String,
    /// The time of its first occurrence, in seconds.
    pub time_s: f64,
    /// How often it occurred.
    pub times: u64,
}

impl SkillErrorReport {
    /// The skill or component and its state: `BatteryLevel, state get`.
    pub fn place(&self) -> String {
        self.state.as_ref().map_or_else(|| self.skill.clone(), |state| format!("{}, state {state}", self.skill))
    }

    /// The error, and how often it occurred if more than once.
    pub fn words(&self) -> String {
        match self.times {
            1 => self.message.clone(),
            times => format!("{} ({times} times)", self.message),
        }
    }
}

impl Report {
    /// The faults in words, each once: its effect and when it happened. Those that could not be injected come last.
    pub fn faults_in_words(&self) -> Vec<(String, String)> {
        let mut groups: Vec<(&str, Vec<&FaultReport>)> = Vec::new();
        for fault in &self.faults {
            match groups.iter_mut().find(|(effect, _)| *effect == fault.effect) {
                Some((_, times)) => times.push(fault),
                None => groups.push((&fault.effect, vec![fault])),
            }
        }
        let done = groups.iter().map(|(effect, times)| ((*effect).to_owned(), when(times)));
        let undone = self.undone_faults.iter().map(|UndoneFaultReport { effect, reason, time_s, .. }| {
            (format!("NOT DONE: {effect} ({reason})"), format!("at {time_s:.2} s"))
        });
        done.chain(undone).collect()
    }

    /// What the faults that never came would have done, each effect once.
    #[must_use]
    pub fn absent_effects(&self) -> Vec<&str> {
        let mut effects: Vec<&str> = Vec::new();
        for fault in &self.absent_faults {
            if !effects.contains(&fault.effect.as_str()) {
                effects.push(&fault.effect);
            }
        }
        effects
    }

    /// The places to which the robot has come, with the time in seconds at which it first came to rest at each, in the
    /// order of these times.
    #[must_use]
    pub fn arrivals(&self) -> Vec<(f64, &str)> {
        let arrivals = self.places.iter().filter_map(|place| Some((place.arrived_at_s()?, place.name.as_str())));
        let mut arrivals: Vec<(f64, &str)> = arrivals.collect();
        arrivals.sort_by(|a, b| a.0.total_cmp(&b.0));
        arrivals
    }
}

/// When a fault took effect, in words. There is at least one time.
fn when(times: &[&FaultReport]) -> String {
    let (first, last) = (times[0], times[times.len() - 1]);
    let until = last.until_s.map_or(String::new(), |until| format!(" to {until:.2} s"));
    match times.len() {
        1 if until.is_empty() => format!("at {:.2} s", first.time_s),
        1 => format!("from {:.2} s{until}", first.time_s),
        count => format!("{count} times, from {:.2} s{until}", first.time_s),
    }
}

/// The battery's charge over a run, in percent.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct BatteryReport {
    /// At the start.
    pub initial: f64,
    /// The minimum.
    pub minimum: f64,
    /// At the end.
    pub r#final: f64,
    /// When it was empty for the first time, in seconds; null if it never was. Then the robot stands still.
    pub empty_at_s: Option<f64>,
}

/// The results of the robot.
#[derive(Clone, Debug, Serialize)]
pub struct RobotReport {
    /// True pose at the end: x and y in meters, heading in radians.
    pub final_pose: [f64; 3],
    /// Distance driven, in meters.
    pub distance_m: f64,
    /// Contacts of the robot with anything else.
    pub collisions: u64,
    /// The trips that navigation gave up, in order.
    pub given_up: Vec<GivenUpReport>,
    /// The error of localization; null without localization.
    pub localization: Option<LocalizationReport>,
}

impl RobotReport {
    /// Why trips were given up: each reason once, with the number of trips and the time of the first.
    pub fn given_up_in_words(&self) -> Vec<String> {
        let mut reasons: Vec<(&GivenUpReport, usize)> = Vec::new();
        for trip in &self.given_up {
            match reasons.iter_mut().find(|(first, _)| first.reason == trip.reason) {
                Some((_, count)) => *count += 1,
                None => reasons.push((trip, 1)),
            }
        }
        let words = |(first, count): &(&GivenUpReport, usize)| match count {
            1 => format!("a trip at {:.2} s: {}", first.time_s, first.reason),
            count => format!("{count} trips, the first at {:.2} s: {}", first.time_s, first.reason),
        };
        reasons.iter().map(words).collect()
    }
}

/// A trip that navigation gave up.
#[derive(Clone, Debug, Serialize)]
pub struct GivenUpReport {
    /// When, in seconds.
    pub time_s: f64,
    /// Why, in words.
    pub reason: String,
}

/// The error of the estimated pose relative to the true one, over all steps.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct LocalizationReport {
    /// Root mean square of the distance, in meters.
    pub rmse_m: f64,
    /// Greatest distance, in meters.
    pub max_m: f64,
    /// Root mean square of the heading's error, in radians.
    pub rmse_rad: f64,
}

/// When a place was reached.
#[derive(Clone, Debug, Serialize)]
pub struct PlaceReport {
    /// The place's name.
    pub name: String,
    /// When the robot first came to rest there, in seconds; if it stood there from the start, when it first came back,
    /// if it has.
    pub reached_at_s: Option<f64>,
    /// When its true position was first there, at rest or on its way, in seconds.
    pub entered_at_s: Option<f64>,
    /// Whether it came to rest there after the first step: it did not stand there from the start.
    #[serde(skip)]
    pub arrived: bool,
}

impl PlaceReport {
    /// When the robot arrived there, in seconds.
    fn arrived_at_s(&self) -> Option<f64> {
        self.reached_at_s.filter(|_| self.arrived)
    }
}

/// A picture of the run.
#[derive(Clone, Debug, Serialize)]
pub struct SnapshotReport {
    /// The file, in the output folder.
    pub file: String,
    /// When it was taken, in seconds.
    pub time_s: f64,
    /// What happened then.
    pub why: String,
    /// Whether it was taken because of the time, not because of something that happened.
    pub by_clock: bool,
    /// The property of whose violation it is; null if it is of something else.
    pub violated: Option<String>,
}

/// How long the computer took.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct TimingReport {
    /// For the run and its pictures, in seconds.
    pub wall_time_s: f64,
    /// Simulated seconds per second of computing.
    pub real_time_factor: f64,
}
