//! Proofs about the paper's system.

use std::sync::Arc;

use channels::{Event, Verdict};
use explorer::{Limits, Order, Outcome, Path};
use runs::Run;
use scenarios::scenario::{ProofOutcome, Scenario, find};

use super::{Answer, Proof, Question, SCHEDULE};

mod texts;
mod waiting;

/// The result for the first property of `nominal` with these settings. A run that violates it is replayed.
fn outcome(overrides: &[&str]) -> Option<ProofOutcome> {
    let overrides: Vec<String> = overrides.iter().map(|text| (*text).to_owned()).collect();
    let found = find::find("nominal").expect("it is shipped");
    let scenario = Scenario::load_for_proof(&found, &overrides).expect("a sound scenario");
    let proof = Proof::new(Arc::new(scenario), &[]).expect("it can be proved");
    let question = &proof.questions()[0];
    let answer = proof.prove(question, &Limits::default(), &mut |_| {}).expect("it can be explored");
    if let Outcome::Violated(path) = &answer.exploration.outcome {
        let replay = path.replay(&answer.model, proof.monitor(question)).expect("a run of the system");
        assert_eq!(replay.verdict(), Verdict::False, "{:#?}", replay.lines());
    }
    answer.outcome()
}

/// phi1, as the monitor of the paper's figure.
const PHI1: [&str; 4] =
    ["properties=[]", "monitors=[{figure='5 (a)', name='phi1'}]", "prove.properties=[]", "expect={}"];

#[test]
#[ignore = "long: .ci/run runs it"]
fn a_longer_trip_drains_the_battery_too_far() {
    let with = |set: &[&str]| outcome(&[&PHI1[..], &["prove.expect={}"], set].concat());
    assert_eq!(with(&["prove.trips.ticks=9"]), Some(ProofOutcome::Proved));
    assert_eq!(with(&["prove.battery.drain_pct_per_tick=1.01"]), Some(ProofOutcome::Violated));
}

#[test]
fn a_battery_without_bounds_violates_within_a_tick() {
    assert_eq!(outcome(&[&PHI1[..], &["prove={}"]].concat()), Some(ProofOutcome::Violated));
}

/// The result of writing the run and following it in a system without wrapped processes, whose faults are those of the
/// catalogue.
///
/// Returns the text of the schedule and the events.
fn followed(proof: &Proof, question: &Question, answer: &Answer, path: &Path) -> (String, Vec<Event>) {
    let folder = tempfile::tempdir().expect("a folder");
    let file = proof.write_run(question, answer, path, folder.path()).expect("room for a run");
    let found = find::find(file.to_str().expect("a path in UTF-8")).expect("it was written");
    let scenario = Scenario::load(&found, &[]).expect("a sound scenario");
    let (mut run, mut events) = (Run::new(Arc::new(scenario), 1, true).expect("a sound scenario"), Vec::new());
    while !run.is_over() {
        run.step().expect("the schedule fits");
        events.extend_from_slice(run.events());
    }
    (std::fs::read_to_string(folder.path().join(SCHEDULE)).expect("it was written"), events)
}

/// The schedule of a violation of the proof's first property. A run that follows it has the same events.
fn schedule_of_violation(proof: &Proof, order: Order) -> String {
    let question = &proof.questions()[0];
    let limits = Limits { order, ..Limits::default() };
    let answer = proof.prove(question, &limits, &mut |_| {}).expect("it can be explored");
    let Outcome::Violated(path) = &answer.exploration.outcome else { panic!("{question:?}: {order:?}") };
    let replay = path.replay(&answer.model, proof.monitor(question)).expect("a run of the system");
    assert_eq!(replay.verdict(), Verdict::False);
    let events: Vec<Event> = replay.events.into_iter().map(|(_, event)| event).collect();
    let (schedule, followed) = followed(proof, question, &answer, path);
    assert_eq!(followed, events, "{question:?}, {order:?}");
    schedule
}

#[test]
fn the_faults_of_a_proof_match_those_of_the_catalogue() {
    let mistake = "skill_mutant='FollowPath: no transition leaves `following`', count=2";
    let mut seen = Vec::new();
    for (name, property, faults) in [
        ("nav2/halted_early_fixed", "stands_still", format!("{mistake}, component_frozen='ControllerServer'")),
        ("nav2/halted_early_fixed", "stands_still", format!("{mistake}, component_crash='ControllerServer'")),
        ("nominal", "phi1", "component_wrong_reply='BatteryReader'".to_owned()),
    ] {
        let set = [format!("prove.faults={{{faults}}}")];
        let found = find::find(name).expect("it is shipped");
        let scenario = Scenario::load_for_proof(&found, &set).expect("a sound scenario");
        let proof = Proof::new(Arc::new(scenario), &[property.to_owned()]).expect("it can be proved");
        // Longer runs meet more faults.
        for order in [Order::Breadth, Order::Depth] {
            let schedule = schedule_of_violation(&proof, order);
            let kinds = ["component_frozen", "component_crash", "component_wrong_reply", "skill_mutant"];
            for happens in ["begins", "ends"] {
                let written = |kind: &&&str| schedule.contains(&format!("{happens} = {{ {kind} = "));
                seen.extend(kinds.iter().filter(written).map(|kind| (*kind, happens)));
            }
        }
    }
    seen.sort_unstable();
    seen.dedup();
    let expected = [
        ("component_crash", "begins"),
        ("component_crash", "ends"),
        ("component_frozen", "begins"),
        ("component_frozen", "ends"),
        ("component_wrong_reply", "begins"),
        ("skill_mutant", "begins"),
    ];
    assert_eq!(seen, expected);
}
