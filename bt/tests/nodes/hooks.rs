//! The scripts that are attributes: `_failureIf`, `_successIf`, `_skipIf`, `_while`, `_onSuccess`, `_onFailure`,
//! `_onHalted` and `_post`.

use bt::{Execution, Status};

use crate::NOW;
use crate::stage::{Script, behaviors, play_with, tree};

behaviors! {
    failure_if_fails_without_a_tick: r#"<a _failureIf="true"/>"# => ["-> F"];
    failure_if_that_does_not_hold_lets_the_node_be_ticked: r#"<a _failureIf="false"/>"# => ["a=S -> S"];
    success_if_succeeds_without_a_tick: r#"<a _successIf="true"/>"# => ["-> S"];
    skip_if_skips: r#"<Sequence><a _skipIf="true"/><b/></Sequence>"# => ["b=S -> S"];
    while_that_does_not_hold_skips: r#"<Sequence><a _while="false"/><b/></Sequence>"# => ["b=S -> S"];
    while_that_holds_lets_the_node_be_ticked: r#"<a _while="true"/>"# => ["a=S -> S"];
    failure_if_comes_before_success_if: r#"<a _successIf="true" _failureIf="true"/>"# => ["-> F"];
    success_if_comes_before_skip_if: r#"<a _skipIf="true" _successIf="true"/>"# => ["-> S"];
    skip_if_comes_before_while: r#"<Fallback><a _while="true" _skipIf="true"/><b/></Fallback>"# => ["b=S -> S"];
    conditions_are_those_of_the_moment: r#"<Sequence><Script code="x := 1"/><a _skipIf="x == 1"/><b _skipIf="x == 2"/></Sequence>"# => ["b=S -> S"];
    skip_if_on_a_control_node: r#"<Fallback><Sequence _skipIf="true"><a/></Sequence><b/></Fallback>"# => ["b=S -> S"];
    failure_if_on_a_subtree_of_nodes: r#"<Fallback><Inverter _failureIf="true"><a/></Inverter><b/></Fallback>"# => ["b=S -> S"];

    on_success_runs_after_success: r#"<a _onSuccess="x := 1" _onFailure="x := 2"/>"# => ["a=R -> R | x=-", "a=S -> S | x=1"];
    on_failure_runs_after_failure: r#"<a _onSuccess="x := 1" _onFailure="x := 2"/>"# => ["a=F -> F | x=2"];
    post_runs_after_both: r#"<a _post="x := 3"/>"# => ["a=R -> R | x=-", "a=F -> F | x=3"];
    post_runs_after_the_other_two: r#"<a _onSuccess="x := 1" _post="x += 1"/>"# => ["a=S -> S | x=2"];
    post_does_not_run_when_the_node_is_skipped: r#"<Sequence><a _skipIf="true" _post="x := 1"/><b/></Sequence>"# => ["b=S -> S | x=-"];
    on_success_runs_when_success_if_holds: r#"<a _successIf="true" _onSuccess="x := 1"/>"# => ["-> S | x=1"];
    on_failure_runs_when_failure_if_holds: r#"<a _failureIf="true" _onFailure="x := 1"/>"# => ["-> F | x=1"];
    on_success_of_a_control_node_runs_after_its_children: r#"<Sequence _onSuccess="x += 1"><a _onSuccess="x := 1"/></Sequence>"# => ["a=S -> S | x=2"];

    on_halted_runs_when_a_running_node_is_halted:
        r#"<ReactiveSequence><c/><a _onHalted="x := 1"/></ReactiveSequence>"# => ["c=S a=R -> R | x=-", "c=F a=halt -> F | x=1"];
    on_halted_does_not_run_when_the_node_was_done:
        r#"<ReactiveSequence><c/><a _onHalted="x := 1"/><b/></ReactiveSequence>"# => ["c=S a=S b=R -> R", "c=F b=halt -> F | x=-"];
    on_halted_of_a_parent_runs_after_that_of_its_child:
        r#"<ReactiveSequence><c/><Sequence _onHalted="x := x .. 'p'"><a _onHalted="x := 'c'"/></Sequence></ReactiveSequence>"# => [
            "c=S a=R -> R",
            "c=F a=halt -> F | x='cp'",
        ];
    on_halted_of_a_condition_runs_although_it_is_not_told:
        r#"<ReactiveSequence><a/><Condition ID="look" _onHalted="x := 1"/></ReactiveSequence>"# => ["a=S look=R -> R", "a=F -> F | x=1"];
    on_halted_runs_for_every_node_when_the_tree_is_halted: r#"<Sequence><a/><b _onHalted="x := 1"/></Sequence>"# => [
        "a=R -> R",
        "halt tree: a=halt | x=1",
    ];

    while_halts_a_running_action_when_it_no_longer_holds:
        r#"<Sequence><Script code="x := 1"/><Parallel success_count="2"><a _while="x == 1"/><b _onSuccess="x := 2"/></Parallel></Sequence>"# => [
            "a=R b=S -> R",
            "a=halt -> R",
        ];
}

#[test]
fn only_while_is_checked_while_a_node_runs() {
    let body = r#"<a _failureIf="x == 1" _successIf="x == 2" _skipIf="x == 3" _while="x != 4"/>"#;
    let mut execution = Execution::new(tree(body));
    for (x, line) in
        [(0, "a=R -> R"), (1, "a=R -> R"), (2, "a=R -> R"), (3, "a=R -> R"), (4, "a=halt -> K"), (2, "-> S")]
    {
        execution.blackboard_mut().set("x", x).unwrap();
        play_with(&mut execution, &[line]);
    }
}

#[test]
fn while_on_a_control_node_halts_its_running_children() {
    let body = r#"<Fallback><Sequence _while="x == 1" _onHalted="y := 1"><a/><b/></Sequence><c/></Fallback>"#;
    let mut execution = Execution::new(tree(body));
    execution.blackboard_mut().set("x", 1).unwrap();
    play_with(&mut execution, &["a=S b=R -> R"]);
    execution.blackboard_mut().set("x", 2).unwrap();
    play_with(&mut execution, &["b=halt c=S -> S | y=1"]);
    execution.blackboard_mut().set("x", 1).unwrap();
    play_with(&mut execution, &["a=S b=S -> S"]);
}

#[test]
fn a_node_whose_scripts_cannot_be_evaluated_fails_with_a_reason() {
    for body in [r#"<a _skipIf="missing"/>"#, r#"<a _while="missing == 1"/>"#] {
        let tree = tree(body);
        let mut execution = Execution::new(tree.clone());
        assert_eq!(execution.tick(NOW, &mut Script::new(&tree, "")), Status::Failure);
        assert_eq!(execution.faults()[0].message, "the blackboard has no entry `missing`");
    }
    let tree = tree(r#"<a _onSuccess="missing += 1"/>"#);
    let mut execution = Execution::new(tree.clone());
    assert_eq!(execution.tick(NOW, &mut Script::new(&tree, "a=S")), Status::Failure);
    assert_eq!(execution.faults().len(), 1);
}
