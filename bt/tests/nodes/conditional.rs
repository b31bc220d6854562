//! IfThenElse and WhileDoElse.

use bt::{Execution, Status};

use crate::NOW;
use crate::stage::{Script, behaviors, tree};

behaviors! {
    if_then_else_ticks_the_second_child_if_the_first_succeeds: "<IfThenElse><a/><b/><c/></IfThenElse>" => ["a=S b=S -> S"];
    if_then_else_ticks_the_third_child_if_the_first_fails: "<IfThenElse><a/><b/><c/></IfThenElse>" => ["a=F c=S -> S"];
    if_then_else_answers_what_the_chosen_child_does: "<IfThenElse><a/><b/><c/></IfThenElse>" => ["a=S b=F -> F", "a=F c=F -> F"];
    if_then_else_fails_without_a_third_child: "<IfThenElse><a/><b/></IfThenElse>" => ["a=F -> F", "a=S b=S -> S"];
    if_then_else_waits_for_its_condition: "<IfThenElse><a/><b/><c/></IfThenElse>" => ["a=R -> R", "a=S b=S -> S"];
    if_then_else_does_not_ask_its_condition_again_while_the_chosen_child_runs: "<IfThenElse><a/><b/><c/></IfThenElse>" => [
        "a=S b=R -> R",
        "b=R -> R",
        "b=S -> S",
        "a=F c=R -> R",
        "c=S -> S",
    ];
    if_then_else_asks_again_after_a_halt: "<IfThenElse><a/><b/><c/></IfThenElse>" => [
        "a=S b=R -> R",
        "halt tree: b=halt",
        "a=F c=S -> S",
    ];
    if_then_else_is_skipped_when_the_chosen_child_is: "<Fallback><IfThenElse><a/><b/></IfThenElse><c/></Fallback>" => [
        "a=S b=K c=S -> S",
    ];

    if_then_else_does_not_halt_a_condition_that_failed_before_and_is_skipped: "<Sequence><IfThenElse><a/><b/></IfThenElse></Sequence>" => [
        "a=F -> F",
        "a=K -> F",
    ];

    while_do_else_asks_its_condition_at_every_tick: "<WhileDoElse><a/><b/><c/></WhileDoElse>" => ["a=S b=R -> R", "a=S b=S -> S"];
    while_do_else_halts_the_second_child_when_the_condition_fails: "<WhileDoElse><a/><b/><c/></WhileDoElse>" => [
        "a=S b=R -> R",
        "a=F b=halt c=R -> R",
    ];
    while_do_else_halts_the_third_child_when_the_condition_succeeds: "<WhileDoElse><a/><b/><c/></WhileDoElse>" => [
        "a=F c=R -> R",
        "a=S c=halt b=R -> R",
    ];
    while_do_else_without_a_third_child_fails_and_halts_the_second: "<WhileDoElse><a/><b/></WhileDoElse>" => [
        "a=S b=R -> R",
        "a=F b=halt -> F",
    ];
    while_do_else_waits_for_its_condition_and_leaves_the_child_running: "<WhileDoElse><a/><b/><c/></WhileDoElse>" => [
        "a=S b=R -> R",
        "a=R -> R",
        "a=S b=S -> S",
    ];
    while_do_else_answers_what_the_chosen_child_does: "<WhileDoElse><a/><b/><c/></WhileDoElse>" => ["a=F c=F -> F", "a=S b=F -> F"];
    while_do_else_is_skipped_when_the_chosen_child_is: "<Fallback><WhileDoElse><a/><b/></WhileDoElse><c/></Fallback>" => [
        "a=S b=K c=S -> S",
    ];
}

#[test]
fn a_skipped_condition_is_a_fault_and_the_node_fails() {
    for kind in ["IfThenElse", "WhileDoElse"] {
        let tree = tree(&format!("<{kind}><a/><b/></{kind}>"));
        let mut execution = Execution::new(tree.clone());
        assert_eq!(execution.tick(NOW, &mut Script::new(&tree, "a=K")), Status::Failure);
        assert_eq!(execution.faults()[0].message, "its condition was skipped");
        assert_eq!(execution.tick(NOW, &mut Script::new(&tree, "a=S b=S")), Status::Success);
        assert!(execution.faults().is_empty(), "faults are those of the last tick");
    }
}
