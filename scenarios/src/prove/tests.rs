//! Proofs about the paper's system.

use std::sync::Arc;

use channels::Verdict;
use explorer::{Limits, Outcome};

use super::Proof;
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
        let replay = path.replay(&answer.model, Some(proof.monitor(question))).expect("a run of the system");
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
