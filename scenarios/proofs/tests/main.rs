//! Proofs about scenarios, from their files to the answers.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

mod followed;
mod levels;
mod shipped;
mod world;

use std::sync::Arc;

use explorer::{Limits, Order};
use proofs::{Answer, Proof, Question};
use scenarios::Error;
use scenarios::scenario::{ProofOutcome, Scenario, find};

/// The proof of these properties of a scenario with these settings; without any, of those that it names.
fn load(scenario: &str, only: &[&str], set: &[&str]) -> Result<Proof, Error> {
    let [only, set] = [only, set].map(|texts| texts.iter().map(|text| (*text).to_owned()).collect::<Vec<_>>());
    Proof::new(Arc::new(Scenario::load_for_proof(&find::find(scenario)?, &set)?), &only)
}

/// The answer to a question. A run that it found is replayed, and is as it was found.
fn answer(proof: &Proof, question: &Question, order: Order) -> Answer {
    let prove = &proof.scenario().file.prove;
    let memory = usize::try_from(prove.memory_bytes).unwrap();
    let limits = Limits { memory, visits: prove.states, order, ..Limits::default() };
    let answer = proof.prove(question, &limits, &mut |_| {}).unwrap();
    let replayed = proof.replay(question, &answer).unwrap();
    assert!(replayed.as_ref().is_none_or(|run| run.is_as_found), "{}: {replayed:#?}", question.property);
    answer
}

/// All answers of a proof.
fn prove(proof: &Proof, order: Order) -> Vec<(Question, Answer)> {
    proof.questions().iter().map(|question| (question.clone(), answer(proof, question, order))).collect()
}

/// The answers for a scenario, which are all as expected, or not.
fn proved(as_expected: bool, scenario: &str, only: &[&str], set: &[&str]) -> Vec<(Question, Answer)> {
    let found = prove(&load(scenario, only, set).unwrap(), Order::Breadth);
    let is_met = |(question, answer): &(Question, Answer)| answer.outcome() == Some(question.expected);
    assert_eq!(found.iter().all(is_met), as_expected, "{scenario} with {set:?}: {:?}", results(&found));
    found
}

/// Each property with its result.
fn results(found: &[(Question, Answer)]) -> Vec<(&str, &str)> {
    let result = |answer: &Answer| answer.outcome().map_or("not decided", ProofOutcome::name);
    found.iter().map(|(question, answer)| (question.property.as_str(), result(answer))).collect()
}

/// The assumptions of a proof, in words.
fn assumptions(proof: &Proof) -> Vec<String> {
    proof.assumptions().into_iter().map(|assumption| assumption.words).collect()
}
