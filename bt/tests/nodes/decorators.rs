//! Inverter, ForceSuccess, ForceFailure, KeepRunningUntilFailure, RunOnce and Precondition.

use bt::{Execution, Status};

use crate::NOW;
use crate::stage::{Script, behaviors, play_with, tree};

behaviors! {
    inverter_passes_on_running_and_skipped: "<Fallback><Inverter><a/></Inverter><b/></Fallback>" => ["a=K b=S -> S", "a=R -> R"];
    inverter_of_an_inverter: "<Inverter><Inverter><a/></Inverter></Inverter>" => ["a=S -> S", "a=F -> F"];
    inverter_halts_its_child: "<Inverter><a/></Inverter>" => ["a=R -> R", "halt tree: a=halt"];
    force_success_turns_failure_to_success: "<ForceSuccess><a/></ForceSuccess>" => ["a=F -> S", "a=S -> S"];
    force_success_passes_on_running_and_skipped: "<Fallback><ForceSuccess><a/></ForceSuccess><b/></Fallback>" => [
        "a=K b=F -> F", "a=R -> R",
    ];
    force_failure_turns_success_to_failure: "<ForceFailure><a/></ForceFailure>" => ["a=S -> F", "a=F -> F"];
    force_failure_passes_on_running_and_skipped: "<Sequence><ForceFailure><a/></ForceFailure><b/></Sequence>" => [
        "a=K b=S -> S", "a=R -> R",
    ];

    keep_running_until_failure_returns_running_to_success: "<KeepRunningUntilFailure><a/></KeepRunningUntilFailure>" => [
        "a=S -> R",
        "a=S -> R",
        "a=R -> R",
        "a=F -> F",
    ];
    keep_running_until_failure_returns_running_when_its_child_is_skipped:
        "<KeepRunningUntilFailure><a/></KeepRunningUntilFailure>" => ["a=K -> R"];
    keep_running_until_failure_halts_its_child: "<KeepRunningUntilFailure><a/></KeepRunningUntilFailure>" => [
        "a=R -> R",
        "halt tree: a=halt",
    ];

    run_once_is_skipped_after_its_child_has_succeeded: "<Fallback><RunOnce><a/></RunOnce><b/></Fallback>" => [
        "a=S -> S",
        "b=S -> S",
        "b=F -> F",
    ];
    run_once_is_skipped_after_its_child_has_failed: "<Fallback><RunOnce><a/></RunOnce><b/></Fallback>" => ["a=F b=S -> S", "b=S -> S"];
    run_once_ticks_a_running_child_until_it_is_done: "<Fallback><RunOnce><a/></RunOnce><b/></Fallback>" => [
        "a=R -> R",
        "a=S -> S",
        "b=S -> S",
    ];
    run_once_that_does_not_skip_answers_the_same_for_ever: r#"<RunOnce then_skip="false"><a/></RunOnce>"# => [
        "a=F -> F",
        "-> F",
        "-> F",
    ];
    run_once_that_was_halted_has_not_run: "<Fallback><RunOnce><a/></RunOnce><b/></Fallback>" => [
        "a=R -> R",
        "halt tree: a=halt",
        "a=S -> S",
        "b=S -> S",
    ];
    run_once_stays_done_when_the_tree_is_halted: "<Fallback><RunOnce><a/></RunOnce><b/></Fallback>" => [
        "a=S -> S",
        "halt tree:",
        "b=S -> S",
    ];
    run_once_whose_child_is_skipped_has_not_run: "<Fallback><RunOnce><a/></RunOnce><b/></Fallback>" => ["a=K b=S -> S", "a=S -> S"];

    precondition_that_holds_ticks_the_child: r#"<Precondition if="true"><a/></Precondition>"# => ["a=S -> S", "a=F -> F"];
    precondition_that_does_not_hold_fails: r#"<Precondition if="false"><a/></Precondition>"# => ["-> F"];
    precondition_that_does_not_hold_answers_what_it_is_told_to:
        r#"<Fallback><Precondition if="false" else="SKIPPED"><a/></Precondition><b/></Fallback>"# => ["b=S -> S"];
    precondition_can_wait: r#"<Sequence><Precondition if="false" else="RUNNING"><a/></Precondition><b/></Sequence>"# => ["-> R", "-> R"];
    precondition_can_succeed_without_its_child: r#"<Precondition if="false" else="SUCCESS"><a/></Precondition>"# => ["-> S"];
}

#[test]
fn precondition_is_not_checked_again_while_its_child_runs() {
    let tree = tree(r#"<Precondition if="x == 1"><a/></Precondition>"#);
    let mut execution = Execution::new(tree);
    execution.blackboard_mut().set("x", 1).unwrap();
    play_with(&mut execution, &["a=R -> R"]);
    execution.blackboard_mut().set("x", 2).unwrap();
    play_with(&mut execution, &["a=R -> R", "a=S -> S", "-> F"]);
}

#[test]
fn precondition_whose_script_cannot_be_evaluated_is_a_fault() {
    let tree = tree(r#"<Precondition if="missing"><a/></Precondition>"#);
    let mut execution = Execution::new(tree.clone());
    assert_eq!(execution.tick(NOW, &mut Script::new(&tree, "")), Status::Failure);
    assert_eq!(execution.faults()[0].message, "the blackboard has no entry `missing`");
}
