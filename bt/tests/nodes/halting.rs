//! Which nodes are halted, when, and in which order.

use bt::{LeafBehavior, Rehearsal, Status, table};

use crate::NOW;
use crate::stage::{behaviors, tree};

behaviors! {
    an_action_that_was_not_ticked_is_not_halted: "<ReactiveFallback><c/><Sequence><a/><b/></Sequence></ReactiveFallback>" => [
        "c=F a=R -> R",
        "c=S a=halt -> S",
    ];
    an_action_that_has_succeeded_is_not_halted: "<ReactiveFallback><c/><Sequence><a/><b/></Sequence></ReactiveFallback>" => [
        "c=F a=S b=R -> R",
        "c=S b=halt -> S",
    ];
    an_action_is_halted_only_once: "<ReactiveFallback><c/><a/></ReactiveFallback>" => ["c=F a=R -> R", "c=S a=halt -> S", "c=S -> S"];
    children_of_a_parallel_are_halted_in_their_order: "<ReactiveFallback><f/><Parallel><a/><b/><c/></Parallel></ReactiveFallback>" => [
        "f=F a=R b=R c=R -> R",
        "f=S a=halt b=halt c=halt -> S",
    ];
    a_halt_goes_down_before_it_goes_on:
        "<ReactiveFallback><f/><Parallel><Sequence><a/><b/></Sequence><Inverter><c/></Inverter><d/></Parallel></ReactiveFallback>" => [
            "f=F a=S b=R c=R d=R -> R",
            "f=S b=halt c=halt d=halt -> S",
        ];
    earlier_children_are_halted_before_later_ones_when_one_in_between_runs:
        r#"<ReactiveSequence><a/><b/><c/></ReactiveSequence>"# => ["a=S b=S c=R -> R", "a=S b=R c=halt -> R"];
    the_child_that_fails_is_ticked_before_the_others_are_halted:
        "<Parallel><a/><b/><c/></Parallel>" => ["a=R b=R c=R -> R", "a=R b=F a=halt c=halt -> F"];
    a_halted_sequence_starts_over: "<ReactiveFallback><f/><Sequence><a/><b/></Sequence></ReactiveFallback>" => [
        "f=F a=S b=R -> R",
        "f=S b=halt -> S",
        "f=F a=R -> R",
    ];
    a_halted_sequence_with_memory_goes_on: "<ReactiveFallback><f/><SequenceWithMemory><a/><b/></SequenceWithMemory></ReactiveFallback>" => [
        "f=F a=S f=F b=R -> R",
        "f=S b=halt -> S",
        "f=F b=S -> S",
    ];
    a_sequence_with_memory_resets_the_child_that_fails_and_those_behind: "<SequenceWithMemory><a/><Sequence><b/><c/></Sequence></SequenceWithMemory>" => [
        "a=S b=S c=F -> F",
        "b=S c=S -> S",
    ];
    a_decorator_passes_a_halt_on: "<ReactiveFallback><f/><ForceSuccess><Inverter><a/></Inverter></ForceSuccess></ReactiveFallback>" => [
        "f=F a=R -> R",
        "f=S a=halt -> S",
    ];
    halting_the_tree_halts_all_that_run: "<Parallel><a/><Sequence><b/></Sequence><c/></Parallel>" => [
        "a=R b=R c=S -> R",
        "halt tree: a=halt b=halt",
        "halt tree:",
    ];
    halting_a_tree_that_has_not_been_ticked_does_nothing: "<Sequence><a/></Sequence>" => ["halt tree:", "a=S -> S"];
    a_subtree_is_halted_as_what_it_stands_for: r#"<ReactiveFallback><f/><Inverter><Sequence><a/></Sequence></Inverter></ReactiveFallback>"# => [
        "f=F a=R -> R",
        "f=S a=halt -> S",
        "f=F a=F -> S",
    ];
    a_loop_halts_its_child: r#"<ReactiveFallback><f/><LoopInt queue="1;2"><a/></LoopInt></ReactiveFallback>"# => [
        "f=F a=R -> R",
        "f=S a=halt -> S",
    ];
    an_if_then_else_halts_its_chosen_child: "<ReactiveFallback><f/><IfThenElse><a/><b/></IfThenElse></ReactiveFallback>" => [
        "f=F a=S b=R -> R",
        "f=S b=halt -> S",
        "f=F a=R -> R",
    ];
}

/// Its parent, too, was running, and has only been skipped since.
#[test]
fn a_node_that_was_running_is_shown_as_halted_even_if_it_was_skipped_since() {
    let tree = tree("<ReactiveSequence><Sequence><a/></Sequence><b/></ReactiveSequence>");
    let behaviors = [
        LeafBehavior::new([Status::Running.into(), Status::Skipped.into()]),
        LeafBehavior::new([Status::Running.into()]),
    ];
    let mut rehearsal = Rehearsal::new(tree.clone(), behaviors);
    let moments = [rehearsal.tick(NOW), rehearsal.tick(NOW), rehearsal.halt(NOW)];
    let lines = [
        "              1    2 halt",
        "→             R    R    H",
        "  →*          R    H    ·",
        "    a         R    H    ·",
        "  b           ·    R    H",
    ];
    assert_eq!(table(&tree, &moments).lines().collect::<Vec<_>>(), lines);
}

/// In BehaviorTree.CPP a sequence is running once it has begun, so it is halted; but it has not run.
#[test]
fn a_control_node_that_was_skipped_is_shown_as_skipped_after_its_reset() {
    let tree = tree("<ReactiveSequence><Sequence><AlwaysSuccess _skipIf=\"true\"/></Sequence><a/></ReactiveSequence>");
    let mut rehearsal = Rehearsal::new(tree.clone(), [LeafBehavior::new([Status::Running.into()])]);
    let moments = [rehearsal.tick(NOW), rehearsal.tick(NOW), rehearsal.halt(NOW)];
    let lines = [
        "                       1    2 halt",
        "→                      R    R    H",
        "  →*                   K    K    ·",
        "    AlwaysSuccess      K    K    ·",
        "  a                    R    R    H",
    ];
    assert_eq!(table(&tree, &moments).lines().collect::<Vec<_>>(), lines);
}
