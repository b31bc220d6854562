//! A model of this project's own: an action with feedback and chance, a service, topics, ports and types.

use std::path::Path;

use bt::Status;
use channels::{EventKind, RoundRobin};
use roaml::{Ended, Model, Run};

use crate::{load, run, run_at_random, verdict};

fn model() -> Model {
    load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/models/lift/main.xml")).expect("a sound model")
}

/// The seeds of a run in which both rides succeed, and of one in which the first fails.
fn seeds(model: &Model) -> (u64, u64) {
    let with = |wanted| (0..100).find(|seed| run(model, *seed).tree == Some(wanted)).expect("one of a hundred");
    (with(Status::Success), with(Status::Failure))
}

#[test]
fn leaves_with_one_id_are_processes_of_their_own() {
    let names: Vec<String> = model().machines().map(|(name, _)| name.to_owned()).collect();
    assert_eq!(names, ["Lift", "Door", "up", "down", "leave"]);
}

#[test]
fn a_run_depends_on_its_seed_alone() {
    let model = model();
    let (good, bad) = seeds(&model);
    let told = |seed: u64| {
        let mut told = String::new();
        let run = Run::new(&model, seed, Box::new(RoundRobin::default())).expect("a system");
        let outcome = run.finish(false, |event, topology| {
            if let EventKind::Received { channel, message } = &event.kind {
                told += &format!("{:?} {} {message}\n", event.time, topology.describe(*channel));
            }
        });
        (told, outcome.expect("a run that ends"))
    };
    assert_eq!(told(good), told(good));
    assert_ne!(told(good).0, told(bad).0);
    let (said, outcome) = told(good);
    assert_eq!((outcome.errors.as_slice(), outcome.ended), (&[][..], Ended::TimeLimit));
    for expected in [
        "1s Lift → up [<action_ride_feedback>, 0, \"{\\\"from\\\":0,\\\"to\\\":3}\"]",
        "Door → leave [<srv_door__open_response>, true]",
        "Lift → Door [<topic_floor_msg>, 3]",
    ] {
        assert!(said.contains(expected), "{expected} is not in\n{said}");
    }
}

#[test]
fn a_formula_is_true_or_false_in_a_run() {
    let model = model();
    let (good, bad) = seeds(&model);
    let of = |seed, property| verdict(&model, &run(&model, seed), property);
    assert!(of(good, "up_and_down") && !of(bad, "up_and_down"));
    assert!(of(good, "never_above_three") && of(bad, "never_above_three"));
    assert!(of(good, "third_floor_before_an_answer"));
    assert_eq!(model.properties[1].formula, "G (topic_floor_msg.data ≤ 3)");
}

#[test]
fn a_probability_is_that_of_its_targets_whatever_the_order_of_messages() {
    let model = model();
    let happened = (0..2000).filter(|seed| verdict(&model, &run_at_random(&model, *seed), "up_and_down")).count();
    // 0.75², with five standard deviations to either side.
    assert!((1014..=1236).contains(&happened), "{happened} of 2000");
}
