//! A model of this project's own: an action with feedback and chance, a service, topics, ports and types.

use std::ops::ControlFlow;
use std::sync::Arc;

use channels::EventKind;
use monitors::Outcome;
use recording::{Detail, RunView, conduct};
use runs::Run;
use scenarios::scenario::Scenario;

use super::{LIFT, holds, run};
use crate::load;

/// The model under a round-robin schedule.
fn model() -> Arc<Scenario> {
    load(LIFT, &["execution.policy=round-robin"]).expect("a sound model")
}

/// The seeds of a run in which both rides succeed, and of one in which the first fails.
fn seeds(model: &Arc<Scenario>) -> (u64, u64) {
    let with = |wanted| (0..100).find(|seed| holds(&run(model, *seed), "up_and_down") == wanted);
    (with(true).expect("one of a hundred"), with(false).expect("one of a hundred"))
}

#[test]
fn leaves_with_the_same_id_are_separate_processes() {
    let model = model();
    let names: Vec<&str> = model.machine_processes().map(|(name, _)| name).collect();
    assert_eq!(names, ["down", "leave", "up", "Door", "Lift"]);
}

#[test]
fn a_run_depends_on_its_seed_alone() {
    let model = model();
    let (good, bad) = seeds(&model);
    let told = |seed: u64| {
        let mut told = String::new();
        let run = Run::new(Arc::clone(&model), seed, true).expect("a system");
        let begin = |_: &RunView| Ok::<_, scenarios::Error>(());
        let conducted = conduct(run, Detail::Full, None, begin, |view| {
            for event in view.events() {
                if let EventKind::Received { channel, message } = &event.kind {
                    told += &format!("{:?} {} {message}\n", event.time, view.topology().describe(*channel));
                }
            }
            ControlFlow::Continue(())
        });
        let ((), view) = conducted.expect("a run that ends");
        (told, view.end().expect("its end").trace_hash.clone())
    };
    assert_eq!(told(good), told(good));
    assert_ne!(told(good).0, told(bad).0);
    let (said, hash) = told(good);
    // A run of which less is recorded is the same run.
    assert_eq!(run(&model, good).trace_hash, hash);
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
    let of = |seed, property| holds(&run(&model, seed), property);
    assert!(of(good, "up_and_down") && !of(bad, "up_and_down"));
    assert!(of(good, "never_above_three") && of(bad, "never_above_three"));
    assert!(of(good, "third_floor_before_an_answer"));
    let report = run(&model, good);
    assert_eq!(report.monitors[1].property, "G (topic_floor_msg.data ≤ 3)");
    assert!(report.monitors.iter().all(|monitor| monitor.verdict != Outcome::Inconclusive && monitor.open.is_empty()));
}

#[test]
fn probabilities_do_not_depend_on_the_order_of_messages() {
    let model = load(LIFT, &["stop.when_settled=true"]).expect("a sound model");
    let happened = (0..2000).filter(|seed| holds(&run(&model, *seed), "up_and_down")).count();
    // 0.75², with five standard deviations on either side.
    assert!((1014..=1236).contains(&happened), "{happened} of 2000");
}

#[test]
fn a_tree_of_processes_gives_the_same_verdicts() {
    let model = load(LIFT, &["execution.tree=nodes"]).expect("a sound model");
    let happened = (0..400).filter(|seed| holds(&run(&model, *seed), "up_and_down")).count();
    assert!((175..=275).contains(&happened), "{happened} of 400");
}
