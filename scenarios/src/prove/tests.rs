//! Proofs about the paper's system.

use std::sync::Arc;
use std::time::Duration;

use channels::{Disturbance, Enabled, EnabledKind, Event, Verdict};
use explorer::{Limits, Outcome, Path, PathStep};
use skills::SkillProcess;

use super::Proof;
use super::faults::Effect;
use crate::scenario::{ProofOutcome, Scenario, find};

/// What comes of the first property of `nominal` with these settings. A run that violates it is replayed.
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
fn a_longer_trip_drains_the_battery_too_far() {
    let with = |set: &[&str]| outcome(&[&PHI1[..], &["prove.expect={}"], set].concat());
    assert_eq!(with(&["prove.trips.ticks=9"]), Some(ProofOutcome::Proved));
    assert_eq!(with(&["prove.battery.drain_pct_per_tick=1.01"]), Some(ProofOutcome::Violated));
}

#[test]
fn a_free_battery_falls_within_a_tick() {
    assert_eq!(outcome(&[&PHI1[..], &["prove={}"]].concat()), Some(ProofOutcome::Violated));
}

/// A proof of the shipped scenario with this name.
fn proof(name: &str, overrides: &[&str]) -> Proof {
    let overrides: Vec<String> = overrides.iter().map(|text| (*text).to_owned()).collect();
    let found = find::find(name).expect("it is shipped");
    let scenario = Scenario::load_for_proof(&found, &overrides).expect("a sound scenario");
    Proof::new(Arc::new(scenario), &[]).expect("it can be proved")
}

/// What happens in a system without anything around its processes, in which faults do what those of a run do.
fn by_the_catalogue(proof: &Proof, path: &Path) -> Vec<Event> {
    let mut system = proof.system.fork();
    let topology = Arc::clone(system.topology());
    let generator = proof.ids.tree.expect("a tree").tick_generator;
    let (mut now, mut events, mut disturbances) = (Duration::ZERO, Vec::new(), Vec::new());
    for step in path.steps() {
        match step {
            PathStep::Environment { words, .. } => {
                for fault in &proof.faults {
                    let (begins, ends) = (words.contains(&fault.begins), words.contains(&fault.ends));
                    let id = fault.process;
                    match &fault.effect {
                        Effect::Outage { crashed } if begins || ends => {
                            system.suspend(id, begins);
                            if ends && *crashed {
                                let before = system.process::<SkillProcess>(id).expect("a machine");
                                let after = before.succeeding(before, now);
                                system.replace(id, Box::new(after)).expect("the same channels");
                            }
                        }
                        Effect::WrongReply if begins => {
                            for channel in topology.channels().filter(|channel| topology.get(*channel).source == id) {
                                let effect = channels::Effect::Replace(crate::faults::opposite(&topology, channel));
                                disturbances.push(system.disturb(Disturbance::all(channel, effect)));
                            }
                        }
                        Effect::WrongReply if ends => disturbances.drain(..).for_each(|id| _ = system.calm(id)),
                        Effect::Machine { mutant, sound } if begins || ends => {
                            let before = system.process::<SkillProcess>(id).expect("a machine");
                            let after = if begins { mutant } else { sound }.succeeding(before, now);
                            system.replace(id, Box::new(after)).expect("the same channels");
                        }
                        _ => {}
                    }
                }
            }
            PathStep::Wait(span) => {
                now += *span;
                system.advance(now);
            }
            PathStep::Tick { delivered } => {
                let (event, taken) = system.generate_tick(generator);
                assert_eq!(taken, *delivered);
                events.push(event);
            }
            PathStep::Take { enabled, .. } => {
                assert!(system.enabled().contains(enabled), "{step:?}");
                events.extend(system.take(enabled).expect("a message within its domain"));
                let hits = |enabled: &Enabled| matches!(enabled.kind, EnabledKind::Disturb(_));
                if let Some(acts) = system.enabled().into_iter().find(hits) {
                    system.take(&acts).expect("nothing is sent");
                }
            }
        }
    }
    events
}

#[test]
fn the_faults_of_a_proof_are_those_of_the_catalogue() {
    let mut seen = Vec::new();
    for faults in [
        "skill_mutant='FollowPath: the transition in `halting` on `ControllerServer.follow_path.accepted` is removed'",
        "skill_mutant='FollowPath: no transition leaves `following`', component_frozen='ControllerServer', count=2",
    ] {
        let set = format!("prove.faults={{{faults}}}");
        let proof = proof("nav2/halted_early_fixed", &[&set]);
        for question in proof.questions() {
            let answer = proof.prove(question, &Limits::default(), &mut |_| {}).expect("it can be explored");
            let Outcome::Violated(path) = &answer.exploration.outcome else { continue };
            let replay = path.replay(&answer.model, proof.monitor(question)).expect("a run of the system");
            assert_eq!(replay.verdict(), Verdict::False);
            let events: Vec<Event> = replay.events.into_iter().map(|(_, event)| event).collect();
            assert_eq!(by_the_catalogue(&proof, path), events, "{faults}");
            seen.push(question.property.clone());
        }
    }
    assert_eq!(seen, ["stands_still", "stands_still"]);
}
