//! Runs that proofs find, and runs that follow their schedules.

use std::collections::BTreeSet;
use std::error;
use std::ops::ControlFlow;
use std::sync::Arc;

use channels::Event;
use explorer::{Order, Outcome, Path};
use proofs::{Answer, Proof, Question, SCHEDULE};
use recording::{Detail, Ended, RunView, conduct};
use runs::Run;
use scenarios::files::scenario_names;
use scenarios::scenario::{ProofOutcome, Scenario, find};
use tempfile::{TempDir, tempdir};

use crate::{answer, load, prove};

/// The result for the first property of `nominal` with these settings.
fn outcome(set: &[&str]) -> Option<ProofOutcome> {
    let proof = load("nominal", &[], set).unwrap();
    answer(&proof, &proof.questions()[0], Order::Breadth).outcome()
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

/// Writes a run that violates a property, and runs the written scenario: it ends with its schedule, with the verdicts
/// and the errors that it expects, and the property is violated. Returns the folder and the scenario.
pub(crate) fn written(proof: &Proof, question: &Question, answer: &Answer, path: &Path) -> (TempDir, Arc<Scenario>) {
    let folder = tempdir().unwrap();
    let file = proof.write_run(question, answer, path, folder.path()).unwrap();
    let scenario = Arc::new(Scenario::load(&find::find(file.to_str().unwrap()).unwrap(), &[]).unwrap());
    let run = Run::new(Arc::clone(&scenario), scenario.file.seed, true).unwrap();
    let nobody = |_: &RunView| Ok::<_, Box<dyn error::Error>>(());
    let ((), view) = conduct(run, Detail::Verdicts, None, nobody, |_| ControlFlow::Continue(())).unwrap();
    let (end, expected) = (view.end().unwrap(), &view.header().expected);
    assert_eq!(end.ended, Ended::Scheduled, "{question:?}");
    assert_eq!(expected.of(&question.property), Some(monitors::Outcome::Violated), "{question:?}");
    for monitor in view.monitors() {
        let (name, outcome) = (monitor.name(), monitor.outcome());
        assert!(expected.admits(name, outcome), "{question:?}: {name} is {outcome}");
    }
    let in_tree = view.tree_errors().iter().map(|error| &view.header().tree[error.node].process);
    let errors: BTreeSet<&String> = end.skill_errors.iter().map(|error| &error.skill).chain(in_tree).collect();
    assert_eq!(errors, expected.errors.iter().collect::<BTreeSet<_>>(), "{question:?}");
    (folder, scenario)
}

/// Writes a run and follows it in a system without wrapped processes, whose faults are those of the catalogue: it has
/// the same events. Returns the text of the schedule.
fn follow(proof: &Proof, question: &Question, answer: &Answer, path: &Path) -> String {
    let (folder, scenario) = written(proof, question, answer, path);
    let (mut run, mut followed) = (Run::new(scenario, 1, true).unwrap(), Vec::new());
    while !run.is_over() {
        run.step().unwrap();
        followed.extend_from_slice(run.events());
    }
    let replay = path.replay(&answer.model, proof.monitor(question)).unwrap();
    let found: Vec<Event> = replay.events.into_iter().map(|(_, event)| event).collect();
    assert_eq!(followed, found, "{}: {question:?}", proof.scenario().name);
    std::fs::read_to_string(folder.path().join(SCHEDULE)).unwrap()
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
        let set = format!("prove.faults={{{faults}}}");
        let proof = load(name, &[property], &[&set]).unwrap();
        // Longer runs meet more faults.
        for order in [Order::Breadth, Order::Depth] {
            let (question, answer) = prove(&proof, order).swap_remove(0);
            let Outcome::Violated(run) = &answer.exploration.outcome else { panic!("{question:?}: {order:?}") };
            let schedule = follow(&proof, &question, &answer, run);
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

#[test]
fn every_run_that_violates_a_shipped_property_can_be_followed() {
    let mut count = 0;
    for form in ["execution.tree=whole", "execution.tree=nodes"] {
        let long = [form, "prove.expect.phi1='violated'", "prove.trips.ticks=10"];
        let of_nav2 = scenario_names().filter(|name| name.starts_with("nav2/")).map(|name| (name, &long[..1]));
        for (name, set) in of_nav2.chain([("nominal", &long[..1]), ("nominal", &long[..])]) {
            let proof = load(name, &[], set).unwrap();
            for (question, answer) in prove(&proof, Order::Breadth) {
                assert_eq!(answer.outcome(), Some(question.expected), "{name}: {question:?}");
                if let Outcome::Violated(run) = &answer.exploration.outcome {
                    follow(&proof, &question, &answer, run);
                    count += 1;
                }
            }
        }
    }
    assert_eq!(count, 10);
}
