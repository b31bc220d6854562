//! The behavior of the nodes in the paper's tree and of related nodes, and how the states show it.

use std::sync::Arc;

use bt::{Execution, Status, Tree};

use crate::NOW;
use crate::stage::{Script, play, tree};

const ABC: &str = r#"<Action ID="a"/><Action ID="b"/><Action ID="c"/>"#;

fn with_abc(kind: &str) -> String {
    format!("<{kind}>{ABC}</{kind}>")
}

#[test]
fn sequence_continues_with_the_running_child() {
    play(&with_abc("Sequence"), &["a=S b=R -> R", "b=R -> R", "b=S c=S -> S", "a=R -> R"]);
}

#[test]
fn sequence_starts_over_after_a_failure() {
    play(&with_abc("Sequence"), &["a=S b=F -> F", "a=S b=S c=S -> S"]);
}

#[test]
fn sequence_starts_over_after_it_was_halted() {
    play(&with_abc("Sequence"), &["a=S b=R -> R", "halt tree: b=halt", "a=S b=S c=S -> S"]);
}

#[test]
fn fallback_continues_with_the_running_child() {
    play(&with_abc("Fallback"), &["a=F b=R -> R", "b=F c=F -> F", "a=F b=S -> S", "a=S -> S"]);
}

#[test]
fn reactive_sequence_ticks_all_children_again() {
    play(&with_abc("ReactiveSequence"), &["a=S b=R -> R", "a=S b=S c=R -> R", "a=S b=S c=S -> S"]);
}

#[test]
fn reactive_sequence_halts_a_running_child_when_an_earlier_one_fails() {
    play(&with_abc("ReactiveSequence"), &["a=S b=S c=R -> R", "a=S b=F c=halt -> F", "a=S b=F -> F"]);
}

#[test]
fn reactive_sequence_halts_a_later_child_when_an_earlier_one_runs() {
    play(&with_abc("ReactiveSequence"), &["a=S b=S c=R -> R", "a=R c=halt -> R", "a=S b=S c=R -> R"]);
}

#[test]
fn reactive_fallback_halts_a_running_child_when_an_earlier_one_succeeds() {
    play(&with_abc("ReactiveFallback"), &["a=F b=R -> R", "a=S b=halt -> S", "a=F b=F c=F -> F"]);
}

#[test]
fn reactive_fallback_halts_a_later_child_when_an_earlier_one_runs() {
    play(&with_abc("ReactiveFallback"), &["a=F b=F c=R -> R", "a=F b=R c=halt -> R", "a=F b=F c=S -> S"]);
}

#[test]
fn sequence_with_memory_does_not_tick_successful_children_again() {
    play(&with_abc("SequenceWithMemory"), &["a=S b=F -> F", "b=F -> F", "b=S c=S -> S", "a=F -> F"]);
}

#[test]
fn sequence_with_memory_remembers_even_when_it_is_halted() {
    play(&with_abc("SequenceWithMemory"), &["a=S b=R -> R", "halt tree: b=halt", "b=S c=R -> R"]);
}

#[test]
fn sequence_with_memory_has_the_tree_ticked_again_after_each_success() {
    let body = r#"<ReactiveSequence><Condition ID="ok"/><SequenceWithMemory><Action ID="a"/><Action ID="b"/></SequenceWithMemory></ReactiveSequence>"#;
    play(body, &["ok=S a=S ok=S b=R -> R", "ok=S b=S -> S", "ok=S a=S ok=F -> F", "ok=S b=S -> S"]);
}

#[test]
fn sequence_with_memory_continues_at_once_when_the_child_was_running() {
    let body = r#"<ReactiveSequence><Condition ID="ok"/><SequenceWithMemory><Action ID="a"/><Action ID="b"/></SequenceWithMemory></ReactiveSequence>"#;
    play(body, &["ok=S a=R -> R", "ok=S a=S b=R -> R"]);
}

#[test]
fn inverter_inverts_final_results() {
    play(r#"<Inverter><Action ID="a"/></Inverter>"#, &["a=R -> R", "a=S -> F", "a=F -> S"]);
}

#[test]
fn forced_results_wait_for_the_child() {
    play(r#"<ForceSuccess><Action ID="a"/></ForceSuccess>"#, &["a=R -> R", "a=S -> S", "a=F -> S"]);
    play(r#"<ForceFailure><Action ID="a"/></ForceFailure>"#, &["a=R -> R", "a=S -> F", "a=F -> F"]);
}

#[test]
fn always_success_and_always_failure_call_no_leaf() {
    play(r#"<Sequence><AlwaysSuccess/><Action ID="a"/><AlwaysFailure/></Sequence>"#, &["a=S -> F", "a=R -> R"]);
}

#[test]
fn a_condition_is_never_halted() {
    let body = r#"<ReactiveFallback><Action ID="a"/><Condition ID="c"/></ReactiveFallback>"#;
    play(body, &["a=F c=R -> R", "a=S -> S", "a=F c=R -> R", "halt tree:"]);
}

#[test]
fn running_children_are_halted_in_order_and_others_not_at_all() {
    // Two actions run at once only below nodes that are halted together; a halt goes down to both.
    let body = r#"<ReactiveFallback>
        <Condition ID="stop"/>
        <Sequence><Action ID="a"/><Fallback><Action ID="b"/><Action ID="c"/></Fallback></Sequence>
    </ReactiveFallback>"#;
    play(body, &["stop=F a=S b=F c=R -> R", "stop=S c=halt -> S", "stop=F a=R -> R", "stop=S a=halt -> S"]);
}

#[test]
fn a_tree_of_one_leaf_is_a_tree() {
    play(r#"<Action ID="a"/>"#, &["a=R -> R", "halt tree: a=halt", "halt tree:", "a=S -> S", "halt tree:", "a=F -> F"]);
}

#[test]
fn a_subtree_is_ticked_and_halted_as_part_of_the_tree() {
    let text = r#"<root BTCPP_format="4" main_tree_to_execute="Main">
        <BehaviorTree ID="Main"><ReactiveSequence><Condition ID="ok"/><SubTree ID="Other" name="the other"/></ReactiveSequence></BehaviorTree>
        <BehaviorTree ID="Other"><Sequence><Action ID="a"/><Action ID="b"/></Sequence></BehaviorTree>
    </root>"#;
    let tree = Arc::new(Tree::from_xml("test.xml", text).unwrap());
    assert_eq!(tree.to_string(), "→\n  ok\n  ▸ the other\n    →*\n      a\n      b\n");
    let mut execution = Execution::new(tree.clone());
    let mut tick = |line: &'static str| {
        let mut script = Script::new(&tree, line);
        let status = execution.tick(NOW, &mut script);
        assert!(script.is_over());
        status
    };
    assert_eq!(tick("ok=S a=S b=R"), Status::Running);
    assert_eq!(tick("ok=S b=R"), Status::Running);
    assert_eq!(tick("ok=F b=halt"), Status::Failure);
    assert_eq!(tick("ok=S a=S b=S"), Status::Success);
}

#[test]
fn the_states_show_what_the_last_tick_did() {
    let tree = tree(&with_abc("ReactiveFallback"));
    let mut execution = Execution::new(tree.clone());
    let mut tick = |line: &'static str| {
        execution.tick(NOW, &mut Script::new(&tree, line));
        execution
            .states()
            .into_iter()
            .map(|state| state.outcome.map_or("-", |outcome| outcome.name()))
            .collect::<Vec<_>>()
    };
    assert_eq!(tick("a=F b=R"), ["running", "failure", "running", "-"]);
    assert_eq!(tick("a=S b=halt"), ["success", "success", "halted", "-"]);
    assert_eq!(tick("a=F b=F c=F"), ["failure", "failure", "failure", "failure"]);
}
