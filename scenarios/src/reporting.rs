//! From a run that has ended to its report.

use std::time::Duration;

use channels::{Event, EventKind};
use monitors::{Outcome, ScopeMonitor, Sighting, Witness};
use serde_json::json;

use crate::ending::Ended;
use crate::given_up::GivenUp;
use crate::live::{Live, UndoneFault, Watched};
use crate::report::{
    BatteryReport, ExpectationReport, FaultReport, GivenUpReport, LocalizationReport, MonitorReport, OutcomeReport,
    PlaceReport, Report, RobotReport, SnapshotReport, TimingReport, TreeErrorReport, UndoneFaultReport,
};
use crate::trace::message_json;
use crate::tree_errors::TreeError;

/// The report of a run in its last step.
pub(crate) fn report(
    live: &Live,
    seed: u64,
    ended: &Ended,
    snapshots: Vec<SnapshotReport>,
    wall_time: Duration,
) -> Report {
    let expectations = expectations(live);
    let differences: Vec<String> = expectations.iter().filter_map(|expected| expected.difference.clone()).collect();
    let outcome = if differences.is_empty() { OutcomeReport::AsExpected } else { OutcomeReport::NotAsExpected };
    let sim_time_s = live.time().as_secs_f64();
    let wall_time_s = wall_time.as_secs_f64();
    Report {
        scenario: live.scenario().name.clone(),
        seed,
        version: env!("CARGO_PKG_VERSION").to_owned(),
        outcome,
        differences,
        expectations,
        sim_time_s,
        ended: ended.name(),
        ended_because: ended.to_string(),
        ticks: live.system().ticks(),
        overruns: live.tally().overruns,
        steps: live.system().steps(),
        trace_hash: live.trace_hash(),
        monitors: monitors(live),
        faults: faults(live),
        undone_faults: live.undone_faults().iter().map(undone_fault).collect(),
        tree_errors: live.tree_errors().iter().map(|error| tree_error(live, error)).collect(),
        battery: BatteryReport {
            initial: live.scenario().file.sim.battery.initial_pct,
            minimum: live.tally().minimum_pct,
            r#final: live.truth().battery().charge_pct,
        },
        robot: robot(live),
        places: live.visits().iter().map(place).collect(),
        snapshots,
        timing: TimingReport { wall_time_s, real_time_factor: sim_time_s / wall_time_s },
    }
}

/// What the scenario expects of the run, and where it is not so.
fn expectations(live: &Live) -> Vec<ExpectationReport> {
    let expect = &live.scenario().file.expect;
    let mut expectations = Vec::new();
    let mut note = |expected: String, difference: Option<String>| {
        expectations.push(ExpectationReport { expected, difference });
    };
    for (name, expected) in &expect.outcomes {
        let watched = live.watched().iter().zip(live.system().monitors());
        for (Watched { name, .. }, attached) in watched.filter(|(watched, _)| watched.name == name.value) {
            let outcome = Outcome::of(attached.monitor.as_ref());
            let difference = format!("{name} was expected to be {expected} and is {outcome}");
            note(format!("{name} is {expected}"), (outcome != *expected).then_some(difference));
        }
    }
    for place in &expect.reached {
        let missed = live.visits().iter().any(|visit| visit.place == place.value && visit.at.is_none());
        let difference = format!("{} was expected to be reached and was not", place.value);
        note(format!("{} is reached", place.value), missed.then_some(difference));
    }
    for place in &expect.not_reached {
        let reached = live.visits().iter().any(|visit| visit.place == place.value && visit.at.is_some());
        let difference = format!("{} was not expected to be reached and was", place.value);
        note(format!("{} is not reached", place.value), reached.then_some(difference));
    }
    if let Some(limit) = expect.max_collisions {
        let collisions = live.truth().collisions();
        let difference = format!("at most {limit} collisions were expected, and there were {collisions}");
        note(format!("there are at most {limit} collisions"), (collisions > limit).then_some(difference));
    }
    if let Some(limit) = expect.min_battery_pct {
        let minimum = live.tally().minimum_pct;
        let difference = format!("the battery was expected to stay at {limit} % or more and fell to {minimum:.2} %");
        note(format!("the battery stays at {limit} % or more"), (minimum < limit).then_some(difference));
    }
    if let Some(limit) = expect.max_localization_m {
        let (_, worst, _) = live.tally().localization_error();
        let difference = format!("localization was expected to stay within {limit} m and was {worst:.3} m off");
        note(format!("localization stays within {limit} m"), (worst > limit).then_some(difference));
    }
    expectations
}

fn monitors(live: &Live) -> Vec<MonitorReport> {
    let attached = live.watched().iter().zip(live.system().monitors());
    attached
        .map(|(watched, attached)| {
            let monitor = attached.monitor.as_ref();
            let outcome = Outcome::of(monitor);
            let violation = watched.decided.as_ref().filter(|_| outcome == Outcome::Violated);
            let scope = monitors::scope_monitor(monitor);
            MonitorReport {
                name: watched.name.clone(),
                property: watched.formula.clone(),
                verdict: outcome.name(),
                state: monitor.location(),
                tick: violation.map(|event| event.tick),
                time_s: violation.map(|event| event.time.as_secs_f64()),
                witness: violation.map(|event| witness(event, scope.and_then(ScopeMonitor::witness), live)),
                open: scope.map_or_else(Vec::new, |scope| words(&scope.open_obligations())),
                vacuous: scope.map_or_else(Vec::new, vacuous),
            }
        })
        .collect()
}

/// The clauses that said nothing about the run, in words.
fn vacuous(monitor: &ScopeMonitor) -> Vec<String> {
    monitor.vacuous().iter().map(|vacuity| format!("said nothing: {} never held", vacuity.antecedent)).collect()
}

fn words<T: ToString>(items: &[T]) -> Vec<String> {
    items.iter().map(T::to_string).collect()
}

/// The event at which a property was violated, and why, as data and in words.
fn witness(event: &Event, why: Option<&Witness>, live: &Live) -> serde_json::Value {
    let mut witness = json!({ "step": event.step, "tick": event.tick, "time_s": event.time.as_secs_f64() });
    if let EventKind::Received { channel, message } = &event.kind {
        let (from, to) = live.system().topology().ends(*channel);
        witness["from"] = from.into();
        witness["to"] = to.into();
        witness["message"] = message_json(message);
    }
    if let Some(why) = why {
        witness["clause"] = why.clause.as_str().into();
        witness["messages"] = why.messages.iter().map(sighting).collect();
        witness["since_tick"] = why.since.map(|since| since.tick).into();
        witness["deadline_tick"] = why.deadline_tick.into();
        witness["missing"] = why.missing.as_deref().into();
        witness["words"] = why.to_string().into();
    }
    witness
}

fn sighting(seen: &Sighting) -> serde_json::Value {
    json!({
        "step": seen.at.step,
        "tick": seen.at.tick,
        "time_s": seen.at.time.as_secs_f64(),
        "from": seen.from,
        "to": seen.to,
        "message": message_json(&seen.message),
    })
}

fn faults(live: &Live) -> Vec<FaultReport> {
    let report = |fault: &crate::live::FaultRecord| FaultReport {
        kind: fault.fault.kind().name.to_owned(),
        time_s: fault.time.as_secs_f64(),
        tick: fault.tick,
        until_s: fault.until.map(|until| until.as_secs_f64()),
        effect: fault.fault.words(),
        arguments: fault.fault.arguments().iter().map(|(name, value)| (name.to_owned(), value.to_json())).collect(),
        messages: live.messages_hit(fault),
    };
    live.faults().iter().map(report).collect()
}

fn undone_fault(undone: &UndoneFault) -> UndoneFaultReport {
    UndoneFaultReport {
        kind: undone.fault.kind().name.to_owned(),
        time_s: undone.time.as_secs_f64(),
        effect: undone.fault.words(),
        reason: undone.reason.clone(),
    }
}

fn tree_error(live: &Live, error: &TreeError) -> TreeErrorReport {
    TreeErrorReport {
        node: error.node.index(),
        label: live.scenario().tree.node(error.node).label().to_owned(),
        message: error.message.clone(),
        tick: error.tick,
        time_s: error.time.as_secs_f64(),
    }
}

fn robot(live: &Live) -> RobotReport {
    let truth = live.truth();
    let pose = truth.pose();
    let (rmse_m, max_m, rmse_rad) = live.tally().localization_error();
    RobotReport {
        final_pose: [pose.translation.x, pose.translation.y, maps::heading(&pose)],
        distance_m: truth.distance_m(),
        collisions: truth.collisions(),
        given_up: live.given_up().iter().map(given_up).collect(),
        localization: LocalizationReport { rmse_m, max_m, rmse_rad },
    }
}

fn given_up(given_up: &GivenUp) -> GivenUpReport {
    GivenUpReport { time_s: given_up.time.as_secs_f64(), reason: given_up.reason.to_string() }
}

fn place(visit: &crate::live::Visit) -> PlaceReport {
    PlaceReport { name: visit.place.clone(), reached_at_s: visit.at.map(|at| at.as_secs_f64()) }
}
