//! Makes the report of a run that has ended.

use std::time::Duration;

use channels::EventKind;
use monitors::{EventTime, Sighting, Witness};
use recording::{
    BatteryTally, Decision, End, Ended, FaultRecord, GivenUp, LocalizationError, MonitorView, RunView, Said,
    SkillError, TreeError, Truth, UndoneFault, message_json,
};
use serde_json::json;

use crate::report::{
    BatteryReport, ExpectationReport, FaultReport, GivenUpReport, LocalizationReport, MonitorReport, OutcomeReport,
    PlaceReport, Report, RobotReport, SaidReport, SkillErrorReport, SnapshotReport, TimingReport, TreeErrorReport,
    UndoneFaultReport,
};
use crate::unheard::unheard_level;

/// The report of a finished run.
pub(crate) fn report(view: &RunView, end: &End, snapshots: Vec<SnapshotReport>, wall_time: Duration) -> Report {
    let interrupted = end.ended == Ended::Interrupted;
    let mut expectations = if interrupted { Vec::new() } else { expectations(view) };
    expectations.extend(failed_programs(view, &end.skill_errors, interrupted));
    let differences: Vec<String> = expectations.iter().filter_map(|expected| expected.difference.clone()).collect();
    let outcome = match differences.as_slice() {
        [] if interrupted => OutcomeReport::Interrupted,
        [] => OutcomeReport::AsExpected,
        _ => OutcomeReport::NotAsExpected,
    };
    let sim_time_s = view.time().as_secs_f64();
    let wall_time_s = wall_time.as_secs_f64();
    Report {
        scenario: view.header().scenario.clone(),
        seed: view.header().seed,
        version: view.header().version.clone(),
        outcome,
        differences,
        expectations,
        sim_time_s,
        ended: end.ended.name(),
        ended_because: end.ended.to_string(),
        ticks: view.ticks(),
        overruns: view.overruns(),
        steps: view.communications(),
        trace_hash: end.trace_hash.clone(),
        monitors: monitors(view),
        faults: faults(view, end),
        undone_faults: view.undone_faults().iter().map(undone_fault).collect(),
        tree_errors: view.tree_errors().iter().map(|error| tree_error(view, error)).collect(),
        skill_errors: end.skill_errors.iter().map(|error| skill_error(view, error)).collect(),
        said: view.said().iter().map(said).collect(),
        battery: battery(view),
        robot: robot(view),
        places: view.visits().zip(view.entries()).map(|(visit, (_, entered))| place(visit, entered)).collect(),
        snapshots,
        timing: TimingReport { wall_time_s, real_time_factor: sim_time_s / wall_time_s },
    }
}

fn skill_error(view: &RunView, error: &SkillError) -> SkillErrorReport {
    let SkillError { skill, state, message, time, times } = error.clone();
    let kind = if view.header().components.contains(&skill) { "component" } else { "skill" };
    SkillErrorReport { kind, skill, state, message, time_s: time.as_secs_f64(), times }
}

/// Which programs must fail, and which have failed.
fn failed_programs(view: &RunView, errors: &[SkillError], interrupted: bool) -> Vec<ExpectationReport> {
    let expected = &view.header().expected.failed_programs;
    let failed = || errors.iter().filter(|error| is_of_program(view, error));
    let unexpected = failed().filter(|error| !expected.contains(&error.skill)).map(|error| {
        let difference = Some(format!("the component {} failed: {}", error.skill, error.message));
        ExpectationReport { expected: format!("the program of {} not to fail", error.skill), difference }
    });
    let expected = expected.iter().filter(|_| !interrupted).map(|name| {
        let has_failed = failed().any(|error| error.skill == *name);
        let difference = (!has_failed).then(|| format!("the program of {name} was expected to fail and did not"));
        ExpectationReport { expected: format!("the program of {name} to fail"), difference }
    });
    expected.chain(unexpected).collect()
}

/// Whether it is the failure of a component's program. Every other component that can have errors has a machine.
fn is_of_program(view: &RunView, error: &SkillError) -> bool {
    let header = view.header();
    header.components.contains(&error.skill) && !header.machines.iter().any(|machine| machine.process == error.skill)
}

/// The scenario's expectations of the run, and which are not met.
fn expectations(view: &RunView) -> Vec<ExpectationReport> {
    let expect = &view.header().expected;
    let mut expectations = Vec::new();
    let mut note = |expected: String, difference: Option<String>| {
        expectations.push(ExpectationReport { expected, difference });
    };
    for (name, expected) in &expect.outcomes {
        for monitor in view.monitors().filter(|monitor| monitor.name() == name) {
            let outcome = monitor.outcome();
            let difference = format!("{name} was expected to be {expected} and is {outcome}");
            note(format!("{name} to be {expected}"), (outcome != *expected).then_some(difference));
        }
    }
    for place in &expect.reached {
        let missed = view.visits().any(|(name, at)| name == place && at.is_none());
        let difference = format!("the robot was expected to come to rest at {place} and did not");
        note(format!("the robot to come to rest at {place}"), missed.then_some(difference));
    }
    for place in &expect.not_reached {
        let entered = view.entries().find_map(|(name, at)| at.filter(|_| name == place));
        let difference = entered.map(|at| {
            let at_s = at.as_secs_f64();
            format!("the robot was expected never to be at {place} and was there at {at_s:.2} s")
        });
        note(format!("the robot never to be at {place}"), difference);
    }
    if let Some((limit, Truth { collisions, .. })) = expect.max_collisions.zip(view.robot().truth) {
        let (expected, wanted) = match limit {
            0 => ("no collisions".to_owned(), "no collisions were".to_owned()),
            1 => ("at most 1 collision".to_owned(), "at most 1 collision was".to_owned()),
            _ => (format!("at most {limit} collisions"), format!("at most {limit} collisions were")),
        };
        let difference = format!("{wanted} expected, and there were {collisions}");
        note(expected, (collisions > limit).then_some(difference));
    }
    if let Some((limit, battery)) = expect.min_battery_pct.zip(view.tally().battery()) {
        let minimum = battery.minimum_pct;
        let difference = format!("the battery was expected never to fall below {limit} % and fell to {minimum:.2} %");
        note(format!("the battery never to fall below {limit} %"), (minimum < limit).then_some(difference));
    }
    if let Some((limit, error)) = expect.max_localization_m.zip(view.tally().localization_error()) {
        let worst = error.max_m;
        let difference = format!("localization was expected to stay within {limit} m and was {worst:.3} m off");
        note(format!("localization to stay within {limit} m"), (worst > limit).then_some(difference));
    }
    expectations
}

fn monitors(view: &RunView) -> Vec<MonitorReport> {
    let report = |monitor: MonitorView<'_>| {
        let decision = monitor.violation();
        let said = monitor.ending();
        MonitorReport {
            name: monitor.name().to_owned(),
            property: monitor.about.property.clone(),
            verdict: monitor.outcome(),
            state: monitor.state.location.clone(),
            tick: decision.map(|decision| decision.event.tick),
            time_s: decision.map(|decision| decision.event.time.as_secs_f64()),
            witness: decision.map(|decision| violation(decision, view)),
            unsure: said.unsure,
            open: words(&said.open),
            vacuous: words(&said.vacuous),
            unheard: unheard_level(monitor.about, monitor.outcome(), view),
            errors: said.errors,
        }
    };
    view.monitors().map(report).collect()
}

fn words<T: ToString>(items: &[T]) -> Vec<String> {
    items.iter().map(T::to_string).collect()
}

/// The event at which a property was violated, and why, as data and in words.
fn violation(Decision { event, witness: why, .. }: &Decision, view: &RunView) -> serde_json::Value {
    let mut witness = why.as_ref().map_or_else(|| moment(&EventTime::of(event)), witness);
    if let EventKind::Received { channel, message } = &event.kind {
        let (from, to) = view.topology().ends(*channel);
        witness["from"] = from.into();
        witness["to"] = to.into();
        witness["message"] = message_json(message);
    }
    witness
}

/// Why a property is violated, as in `report.json`: as data and in words.
pub fn witness(why: &Witness) -> serde_json::Value {
    let mut witness = moment(&why.settled);
    witness["clause"] = why.clause.as_str().into();
    witness["messages"] = why.messages.iter().map(sighting).collect();
    witness["since_tick"] = why.since.map(|since| since.tick).into();
    witness["deadline_tick"] = why.deadline_tick.into();
    witness["missing"] = why.missing.as_deref().into();
    witness["words"] = why.to_string().into();
    witness
}

fn sighting(seen: &Sighting) -> serde_json::Value {
    let mut sighting = moment(&seen.at);
    sighting["from"] = seen.from.as_str().into();
    sighting["to"] = seen.to.as_str().into();
    sighting["message"] = message_json(&seen.message);
    sighting
}

fn moment(at: &EventTime) -> serde_json::Value {
    json!({ "step": at.step, "tick": at.tick, "time_s": at.time.as_secs_f64() })
}

fn faults(view: &RunView, end: &End) -> Vec<FaultReport> {
    let report = |FaultRecord { time, until, tick, fault, index, .. }: &FaultRecord| FaultReport {
        kind: fault.kind.clone(),
        time_s: time.as_secs_f64(),
        tick: *tick,
        until_s: until.map(|until| until.as_secs_f64()),
        effect: fault.words.clone(),
        arguments: fault.arguments.iter().map(|(name, value)| (name.clone(), value.to_json())).collect(),
        messages: end.messages_hit[*index],
    };
    view.faults().iter().map(report).collect()
}

fn undone_fault(undone: &UndoneFault) -> UndoneFaultReport {
    UndoneFaultReport {
        kind: undone.fault.kind.clone(),
        time_s: undone.time.as_secs_f64(),
        effect: undone.fault.words.clone(),
        reason: undone.reason.clone(),
    }
}

fn tree_error(view: &RunView, error: &TreeError) -> TreeErrorReport {
    TreeErrorReport {
        node: error.node,
        label: view.header().tree[error.node].process.clone(),
        message: error.message.clone(),
        tick: error.tick,
        time_s: error.time.as_secs_f64(),
    }
}

fn battery(view: &RunView) -> Option<BatteryReport> {
    let BatteryTally { initial_pct, minimum_pct } = view.tally().battery()?;
    Some(BatteryReport { initial: initial_pct, minimum: minimum_pct, r#final: view.robot().battery?.charge_pct })
}

fn robot(view: &RunView) -> Option<RobotReport> {
    let Truth { pose, distance_m, collisions } = view.robot().truth?;
    let localization = view.tally().localization_error();
    let report = |LocalizationError { rmse_m, max_m, rmse_rad }| LocalizationReport { rmse_m, max_m, rmse_rad };
    Some(RobotReport {
        final_pose: [pose.translation.x, pose.translation.y, maps::heading(&pose)],
        distance_m,
        collisions,
        given_up: view.given_up().iter().map(given_up).collect(),
        localization: localization.map(report),
    })
}

fn given_up(given_up: &GivenUp) -> GivenUpReport {
    GivenUpReport { time_s: given_up.time.as_secs_f64(), reason: given_up.reason.clone() }
}

fn said(said: &Said) -> SaidReport {
    SaidReport { time_s: said.time.as_secs_f64(), by: said.by.clone(), text: said.text.clone() }
}

fn place((name, reached): (&str, Option<Duration>), entered: Option<Duration>) -> PlaceReport {
    let seconds = |at: Duration| at.as_secs_f64();
    PlaceReport { name: name.to_owned(), reached_at_s: reached.map(seconds), entered_at_s: entered.map(seconds) }
}
