//! Tests of whole models.

mod as2fm;
mod lift;
mod refused;
mod uc3;

use std::path::Path;

use channels::{Random, RoundRobin, Scheduler};
use roaml::{Model, Outcome, Run};
use robot::Streams;

fn load(path: &Path) -> Result<Model, String> {
    Model::load(path).map_err(|problems| problems.plain())
}

fn run_with(model: &Model, seed: u64, scheduler: Box<dyn Scheduler>) -> Outcome {
    let run = Run::new(model, seed, scheduler).expect("a system");
    run.finish(false, |_, _| ()).expect("a run that ends")
}

/// A run in which all messages are taken in turn.
fn run(model: &Model, seed: u64) -> Outcome {
    run_with(model, seed, Box::new(RoundRobin::default()))
}

/// A run in which messages are taken in any order.
fn run_at_random(model: &Model, seed: u64) -> Outcome {
    run_with(model, seed, Box::new(Random::new(Streams::new(seed).stream("channels/scheduler"))))
}

/// Whether the property with this name holds.
fn verdict(model: &Model, outcome: &Outcome, property: &str) -> bool {
    let place = model.properties.iter().position(|known| known.name == property).expect(property);
    outcome.verdicts[place]
}
