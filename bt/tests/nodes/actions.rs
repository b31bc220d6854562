//! AlwaysSuccess, AlwaysFailure, Script, ScriptCondition, SetBlackboard and UnsetBlackboard.

use bt::{Execution, Status};

use crate::NOW;
use crate::stage::{Script, behaviors, tree};

behaviors! {
    always_success_succeeds: "<AlwaysSuccess/>" => ["-> S", "-> S"];
    always_failure_fails: "<AlwaysFailure/>" => ["-> F", "-> F"];

    script_runs_and_succeeds: r#"<Script code="x := 1; y := x + 1"/>"# => ["-> S | x=1 y=2.0"];
    script_runs_at_every_tick: r#"<Sequence><RunOnce><Script code="x := 0"/></RunOnce><Script code="x += 1"/></Sequence>"# => [
        "-> S | x=1",
        "-> S | x=2",
    ];
    script_condition_that_holds_succeeds: r#"<ScriptCondition code="1 &lt; 2"/>"# => ["-> S"];
    script_condition_that_does_not_hold_fails: r#"<ScriptCondition code="1 > 2"/>"# => ["-> F"];
    script_condition_reads_entries: r#"<Sequence><Script code="x := 'go'"/><ScriptCondition code="x == 'go'"/></Sequence>"# => ["-> S"];

    set_blackboard_writes_a_text: r#"<SetBlackboard value="42" output_key="x"/>"# => ["-> S | x='42'"];
    set_blackboard_copies_an_entry:
        r#"<Sequence><Script code="x := 4.5"/><SetBlackboard value="{x}" output_key="y"/></Sequence>"# => ["-> S | y=4.5"];
    set_blackboard_reads_the_key_from_the_blackboard:
        r#"<Sequence><Script code="k := 'goal'"/><SetBlackboard value="home" output_key="{k}"/></Sequence>"# => ["-> S | goal='home' k='goal'"];
    set_blackboard_converts_to_the_type_of_the_entry:
        r#"<Sequence><SetBlackboard value="2" output_key="n"/><Repeat num_cycles="{n}"><a/></Repeat></Sequence>"# => ["a=S a=S -> S | n=2"];

    unset_blackboard_removes_an_entry: r#"<Sequence><Script code="x := 1"/><UnsetBlackboard key="x"/></Sequence>"# => ["-> S | x=-"];
    unset_blackboard_of_what_is_not_there_succeeds: r#"<UnsetBlackboard key="x"/>"# => ["-> S"];
    unset_blackboard_lets_the_entry_be_made_anew_with_another_type:
        r#"<Sequence><Script code="x := 1"/><UnsetBlackboard key="x"/><Script code="x := 'a'"/></Sequence>"# => ["-> S | x='a'"];
    unset_blackboard_does_not_reach_the_main_tree: r#"<Sequence><Script code="x := 1"/><UnsetBlackboard key="@x"/></Sequence>"# => ["-> S | x=1"];
}

/// The fault in the first tick, which fails.
fn fault(body: &str) -> String {
    let tree = tree(body);
    let mut execution = Execution::new(tree.clone());
    assert_eq!(execution.tick(NOW, &mut Script::new(&tree, "")), Status::Failure);
    assert_eq!(execution.faults().len(), 1, "{:?}", execution.faults());
    execution.faults()[0].message.clone()
}

#[test]
fn a_script_does_not_calculate_with_an_integer_of_more_than_53_bits() {
    let theirs = "Loss of precision when converting a large integer number to floating point";
    for code in ["x &gt; 0", "y := x + 1", "x += 1", "y := x ? 1 : 2", "y := -x", "y := 1.5; y := x"] {
        let message = fault(&format!("<Script code=\"x := 1700000000000000001; {code}\"/>"));
        assert!(message.contains(theirs) || message.contains("cannot take `1700000000000000001`"), "{code}: {message}");
    }
}

#[test]
fn a_script_assigns_no_string_to_a_watched_entry_or_a_status() {
    let watched = r#"<Sequence><Script code="x := 'a'"/><WasEntryUpdated entry="{x}"/></Sequence>"#;
    assert_eq!(fault(watched), "the entry `x` has the type BT::Any and cannot take `a`");
    let status =
        r#"<Sequence><Script code="x := 'FAILURE'"/><Precondition if="0" else="{x}"><a/></Precondition></Sequence>"#;
    assert_eq!(fault(status), "the entry `x` has the type BT::NodeStatus and cannot take `FAILURE`");
}

#[test]
fn script_that_cannot_be_evaluated_fails_with_a_reason() {
    assert_eq!(fault(r#"<Script code="x = 1"/>"#), "the blackboard has no entry `x`; use `:=` to create one");
    assert_eq!(fault(r#"<Script code="x := y"/>"#), "the blackboard has no entry `y`");
    assert_eq!(fault(r#"<Script code="x := 'a' * 2"/>"#), "`*` cannot be applied to `a` and `2`");
    assert_eq!(fault(r#"<Script code="x := 1; x = 'a'"/>"#), "`a` is not a number");
    assert_eq!(fault(r#"<Script code="x := 'a'; x = 1"/>"#), "the entry `x` holds `a` and cannot take `1`");
    assert_eq!(fault(r#"<Script code="x := 1; x = 0.5"/>"#), "the entry `x` holds `1` and cannot take `0.500000`");
}

#[test]
fn script_condition_that_is_not_a_truth_value_fails_with_a_reason() {
    assert_eq!(fault(r#"<ScriptCondition code="'yes'"/>"#), "`yes` is not true or false");
    assert_eq!(fault(r#"<ScriptCondition code="2"/>"#), "`2` is not true or false");
}

#[test]
fn set_blackboard_from_an_unknown_entry_fails_with_a_reason() {
    assert_eq!(fault(r#"<SetBlackboard value="1" output_key="{k}"/>"#), "the entry `k` has no value");
}

#[test]
fn set_blackboard_cannot_write_a_text_to_a_number() {
    let body =
        r#"<Sequence><SetBlackboard value="many" output_key="n"/><Repeat num_cycles="{n}"><a/></Repeat></Sequence>"#;
    assert_eq!(fault(body), "`many` is not a whole number in range");
}
