//! Makes the report of a run that has ended.

use std::time::Duration;

use diagnostics::seconds;
use monitors::{Formula, OpenObligation, Outcome, Sighting};
use recording::{
    BatteryTally, Certainty, End, Ended, Fault, FaultRecord, GivenUp, LocalizationError, MonitorView, Moved, RunView,
    Said, SkillError, TreeError, TreeFailure, Truth, UndoneFault,
};

use crate::report::{
    AbsentFaultReport, BatteryReport, ExpectationReport, FaultReport, GivenUpReport, LocalizationReport, MonitorReport,
    OutcomeReport, PlaceReport, Report, RobotReport, SaidReport, SkillErrorReport, SnapshotReport, TimingReport,
    TreeErrorReport, TreeFailureReport, UndoneFaultReport, ViolationsReport,
};
use crate::unheard::unheard_level;
use crate::witness::WitnessReport;

/// The report of a finished run.
///
/// Whether a run is *as expected* is decided here, and nowhere else: it is if no expectation has a difference. They are
/// those that the scenario names, that no other property is violated ([`Expected::admits`]) or unsure, and that no
/// error occurs that it does not name.
pub(crate) fn report(view: &RunView, end: &End, snapshots: Vec<SnapshotReport>, wall_time: Duration) -> Report {
    let interrupted = end.ended == Ended::Interrupted;
    let mut expectations = if interrupted { Vec::new() } else { expectations(view) };
    expectations.extend(errors(view, &end.skill_errors, interrupted));
    let differences: Vec<String> = expectations.iter().filter_map(|expected| expected.difference.clone()).collect();
    // An interrupted run may still differ: an error has occurred, whatever would have come later.
    let outcome = match differences.as_slice() {
        [] if interrupted => OutcomeReport::Interrupted,
        [] => OutcomeReport::AsExpected,
        _ => OutcomeReport::NotAsExpected,
    };
    let sim_time_s = seconds(view.time());
    let wall_time_s = wall_time.as_secs_f64();
    Report {
        scenario: view.header().scenario.clone(),
        seed: view.header().seed,
        version: view.header().version.clone(),
        provenance: view.header().provenance(),
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
        absent_faults: view.absent_faults().map(absent_fault).collect(),
        tree_failure: view.tree_failure().map(|failure| tree_failure(view, failure)),
        tree_errors: view.tree_errors().iter().map(|error| tree_error(view, error)).collect(),
        lost: first_few(view.lost().to_vec()),
        remarks: first_few(remarks(view)),
        skill_errors: end.skill_errors.iter().map(|error| skill_error(view, error)).collect(),
        said: view.said().iter().map(said).collect(),
        battery: battery(view),
        robot: robot(view),
        places: view.visits().zip(view.entered()).map(|(visit, (_, entered))| place(view, visit, entered)).collect(),
        snapshots,
        timing: TimingReport { wall_time_s, real_time_factor: sim_time_s / wall_time_s },
    }
}

fn first_few(mut all: Vec<String>) -> Vec<String> {
    /// More of them would not be read.
    const MOST: usize = 5;
    let more = all.len().saturating_sub(MOST);
    all.truncate(MOST);
    all.extend((more > 0).then(|| format!("and {more} more like these")));
    all
}

/// Nothing moves around a tree that was logged: what happened besides is about the log.
fn remarks(view: &RunView) -> Vec<String> {
    let moves = view.moves().iter().filter(|_| !view.header().knows_ticks());
    moves.map(|Moved { time, words }| format!("at {:.2} s, {words}", time.as_secs_f64())).collect()
}

fn skill_error(view: &RunView, error: &SkillError) -> SkillErrorReport {
    let SkillError { skill, state, message, time, times } = error.clone();
    let kind = if view.header().components.contains(&skill) { "component" } else { "skill" };
    SkillErrorReport { kind, skill, state, message, time_s: seconds(time), times }
}

/// In which skills, components and nodes of the tree an error must occur, and in which one has occurred.
fn errors(view: &RunView, errors: &[SkillError], interrupted: bool) -> Vec<ExpectationReport> {
    let expected = &view.header().expected.errors;
    let found = first_errors(view, errors);
    let unexpected =
        found.iter().filter(|error| !expected.contains(&error.name)).map(|FirstError { kind, name, message }| {
            let difference = Some(format!("there was an error in the {kind} {name}: {message}"));
            expectation(format!("no error in the {kind} {name}"), None, difference)
        });
    let expected = expected.iter().filter(|_| !interrupted).map(|name| {
        let has_failed = found.iter().any(|error| error.name == *name);
        let difference = (!has_failed).then(|| format!("an error in {name} was expected, and there was none"));
        expectation(format!("an error in {name}"), Some(format!("there was an error in {name}")), difference)
    });
    expected.chain(unexpected).collect()
}

/// The first error in a skill, a component or a node of the tree.
struct FirstError {
    /// What it is, in words.
    kind: &'static str,
    name: String,
    message: String,
}

/// Of each skill, component and node of the tree with errors, the first.
fn first_errors(view: &RunView, errors: &[SkillError]) -> Vec<FirstError> {
    let in_machines = errors.iter().map(|error| {
        let SkillErrorReport { kind, skill: name, message, .. } = skill_error(view, error);
        FirstError { kind, name, message }
    });
    let in_tree = view.tree_errors().iter().map(|error| {
        let TreeErrorReport { label: name, message, .. } = tree_error(view, error);
        FirstError { kind: "tree node", name, message }
    });
    let mut first: Vec<FirstError> = Vec::new();
    for error in in_machines.chain(in_tree) {
        if first.iter().all(|other| (other.kind, &other.name) != (error.kind, &error.name)) {
            first.push(error);
        }
    }
    first
}

/// The scenario's expectations of the run, and which are not met.
fn expectations(view: &RunView) -> Vec<ExpectationReport> {
    let limits = [max_collisions(view), min_battery(view), max_localization(view)];
    outcomes(view).chain(unexpected_violations(view)).chain(places(view)).chain(limits.into_iter().flatten()).collect()
}

fn outcomes(view: &RunView) -> impl Iterator<Item = ExpectationReport> {
    view.header().expected.outcomes.iter().flat_map(move |(name, expected)| {
        let watched = view.monitors().filter(move |monitor| monitor.name() == name);
        watched.map(move |monitor| {
            let outcome = monitor.outcome();
            let found = match unsure(&monitor) {
                Some(why) => Some(format!("unsure: {why}")),
                None => (!view.header().expected.admits(name, outcome)).then(|| outcome.to_string()),
            };
            let difference = found.map(|found| format!("{name} was expected to be {expected} and is {found}"));
            ExpectationReport {
                is_of_verdict: true,
                ..expectation(format!("{name} to be {expected}"), None, difference)
            }
        })
    })
}

/// Why the verdict of a property is unsure, if it is.
fn unsure(monitor: &MonitorView<'_>) -> Option<String> {
    match monitor.end?.evidence.certainty() {
        Certainty::Unsure(why) => Some(why.clone()),
        _ => None,
    }
}

/// The properties that are violated, or may be, and for which the scenario expects nothing.
fn unexpected_violations(view: &RunView) -> impl Iterator<Item = ExpectationReport> {
    let expected = &view.header().expected;
    let unnamed = view.monitors().filter(|monitor| expected.of(monitor.name()).is_none());
    unnamed.filter(|monitor| !expected.is_open(monitor.name())).filter_map(|monitor| {
        let name = monitor.name();
        let difference = match (unsure(&monitor), monitor.outcome()) {
            (Some(why), _) => format!("{name} is unsure: {why}"),
            (None, Outcome::Violated) => format!("{name} is violated, and the scenario does not expect it"),
            _ => return None,
        };
        Some(ExpectationReport {
            is_of_verdict: true,
            ..expectation(format!("{name} not to be violated"), None, Some(difference))
        })
    })
}

/// The places to which the robot must come, and those where it must never be, not even on its way.
fn places(view: &RunView) -> Vec<ExpectationReport> {
    let expected = &view.header().expected;
    let reached = expected.reached.iter().map(|place| {
        let missed = !view.arrivals().any(|(name, _)| name == place);
        let difference = format!("the robot was expected to come to rest at {place} and did not");
        let met = format!("the robot came to rest at {place}");
        expectation(format!("the robot to come to rest at {place}"), Some(met), missed.then_some(difference))
    });
    let avoided = expected.not_reached.iter().map(|place| {
        let entered = view.entered().find_map(|(name, at)| at.filter(|_| name == place));
        let difference = entered.map(|at| {
            let at_s = at.as_secs_f64();
            format!("the robot was expected never to be at {place} and was there at {at_s:.2} s")
        });
        let met = format!("the robot was never at {place}");
        expectation(format!("the robot never to be at {place}"), Some(met), difference)
    });
    reached.chain(avoided).collect()
}

fn max_collisions(view: &RunView) -> Option<ExpectationReport> {
    let (limit, Truth { collisions, .. }) = view.header().expected.max_collisions.zip(view.robot().truth)?;
    let (expected, wanted) = match limit {
        0 => ("no collisions".to_owned(), "no collisions were".to_owned()),
        1 => ("at most 1 collision".to_owned(), "at most 1 collision was".to_owned()),
        _ => (format!("at most {limit} collisions"), format!("at most {limit} collisions were")),
    };
    let difference = format!("{wanted} expected, and there were {collisions}");
    Some(expectation(expected.clone(), Some(expected), (collisions > limit).then_some(difference)))
}

fn min_battery(view: &RunView) -> Option<ExpectationReport> {
    let (limit, battery) = view.header().expected.min_battery_pct.zip(view.tally().battery())?;
    let minimum = battery.minimum_pct;
    let difference = format!("the battery was expected never to fall below {limit} % and fell to {minimum:.2} %");
    // No battery falls below 0 %.
    let met = (limit > 0.0).then(|| format!("the battery never fell below {limit} %"));
    Some(expectation(
        format!("the battery never to fall below {limit} %"),
        met,
        (minimum < limit).then_some(difference),
    ))
}

fn max_localization(view: &RunView) -> Option<ExpectationReport> {
    let (limit, error) = view.header().expected.max_localization_m.zip(view.tally().localization_error())?;
    let worst = error.max_m;
    let difference = format!("localization was expected to stay within {limit} m and was {worst:.3} m off");
    let met = format!("localization stayed within {limit} m");
    Some(expectation(
        format!("localization to stay within {limit} m"),
        Some(met),
        (worst > limit).then_some(difference),
    ))
}

fn expectation(expected: String, met: Option<String>, difference: Option<String>) -> ExpectationReport {
    ExpectationReport { expected, met, difference, is_of_verdict: false }
}

fn monitors(view: &RunView) -> Vec<MonitorReport> {
    let report = |monitor: MonitorView<'_>| {
        let (decision, ending) = (monitor.violation(), monitor.ending());
        let knows_ticks = view.header().knows_ticks();
        let open = |owed: &OpenObligation| if knows_ticks { owed.to_string() } else { format!("{owed:#}") };
        MonitorReport {
            name: monitor.name().to_owned(),
            property: monitor.about.property.clone(),
            timed: monitor.about.formula.as_ref().is_some_and(Formula::is_timed),
            verdict: monitor.outcome(),
            expected: view.header().expected.of(monitor.name()),
            state: monitor.state.location.clone(),
            tick: decision.map(|decision| decision.at().tick).filter(|_| knows_ticks),
            time_s: decision.map(|decision| seconds(decision.at().time)),
            violations: ending.violations.as_ref().map(|all| ViolationsReport::of(all, view.time())),
            witness: decision.map(|decision| WitnessReport::of(decision, view.topology(), knows_ticks)),
            certainty: ending.evidence.certainty().clone(),
            unsure: ending.evidence.certainty().why().map(str::to_owned),
            assumptions: ending.evidence.assumptions().to_vec(),
            silent: ending.evidence.silent().to_vec(),
            open: ending.open.iter().map(open).collect(),
            vacuous: words(&ending.vacuous),
            unheard: unheard_level(monitor.about, monitor.outcome(), view),
            errors: ending.errors,
            story: Vec::new(),
        }
    };
    view.monitors().map(report).collect()
}

fn words<T: ToString>(items: &[T]) -> Vec<String> {
    items.iter().map(T::to_string).collect()
}

fn faults(view: &RunView, end: &End) -> Vec<FaultReport> {
    let report = |FaultRecord { time, until, tick, fault, index, .. }: &FaultRecord| FaultReport {
        kind: fault.kind.clone(),
        time_s: seconds(*time),
        tick: *tick,
        until_s: until.map(seconds),
        effect: fault.words.clone(),
        arguments: arguments(fault),
        messages: end.messages_hit[*index],
    };
    view.faults().iter().map(report).collect()
}

fn absent_fault(fault: &Fault) -> AbsentFaultReport {
    AbsentFaultReport { kind: fault.kind.clone(), effect: fault.words.clone(), arguments: arguments(fault) }
}

fn arguments(fault: &Fault) -> serde_json::Map<String, serde_json::Value> {
    fault.arguments.iter().map(|(name, value)| (name.clone(), value.to_json())).collect()
}

fn undone_fault(undone: &UndoneFault) -> UndoneFaultReport {
    UndoneFaultReport {
        kind: undone.fault.kind.clone(),
        time_s: seconds(undone.time),
        effect: undone.fault.words.clone(),
        reason: undone.reason.clone(),
    }
}

fn tree_failure(view: &RunView, failure: TreeFailure) -> TreeFailureReport {
    let TreeFailure { node, tick, time, message, unmet, ran, lasts } = failure;
    let words = |seen: Sighting| format!("{} → {} {}", seen.from, seen.to, seen.message_in_words());
    TreeFailureReport {
        node,
        label: view.header().tree[node].process.clone(),
        tick,
        time_s: seconds(time),
        message: message.map(words),
        is_called_off: unmet.as_ref().is_some_and(|unmet| unmet.is_called_off),
        unmet: unmet.map(|unmet| words(unmet.request)),
        ran_s: ran.map(seconds),
        lasts,
    }
}

fn tree_error(view: &RunView, error: &TreeError) -> TreeErrorReport {
    TreeErrorReport {
        node: error.node,
        label: view.header().tree[error.node].process.clone(),
        message: error.message.clone(),
        tick: error.tick,
        time_s: seconds(error.time),
    }
}

fn battery(view: &RunView) -> Option<BatteryReport> {
    let BatteryTally { initial_pct, minimum_pct, empty_at } = view.tally().battery()?;
    Some(BatteryReport {
        initial: initial_pct,
        minimum: minimum_pct,
        r#final: view.robot().battery?.charge_pct,
        empty_at_s: empty_at.map(seconds),
    })
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
    GivenUpReport { time_s: seconds(given_up.time), reason: given_up.reason.clone() }
}

fn said(said: &Said) -> SaidReport {
    SaidReport { time_s: seconds(said.time), by: said.by.clone(), text: said.text.clone() }
}

fn place(view: &RunView, (name, reached): (&str, Option<Duration>), entered: Option<Duration>) -> PlaceReport {
    PlaceReport {
        name: name.to_owned(),
        reached_at_s: reached.map(seconds),
        entered_at_s: entered.map(seconds),
        arrived: reached.is_some_and(|at| view.is_arrival(at)),
    }
}
