//! Switch2 to Switch6.

use bt::Execution;

use crate::stage::{behaviors, play_with, tree};

const BY_X: &str = r#"<Switch2 variable="{x}" case_1="1" case_2="two"><a/><b/><c/></Switch2>"#;

/// Plays the lines with `x` set before each.
fn play_with_x(steps: &[(&str, &str)]) {
    let mut execution = Execution::new(tree(BY_X));
    for (x, line) in steps {
        execution.blackboard_mut().set("x", *x).unwrap();
        play_with(&mut execution, &[line]);
    }
}

#[test]
fn switch_ticks_the_child_of_the_equal_case() {
    play_with_x(&[("1", "a=S -> S"), ("two", "b=S -> S")]);
}

#[test]
fn switch_ticks_the_last_child_if_no_case_is_equal() {
    play_with_x(&[("3", "c=F -> F"), ("", "c=S -> S")]);
}

#[test]
fn switch_halts_the_running_child_when_another_case_is_equal() {
    play_with_x(&[("1", "a=R -> R"), ("1", "a=R -> R"), ("two", "a=halt b=R -> R"), ("none", "b=halt c=S -> S")]);
}

#[test]
fn switch_compares_numbers_as_numbers() {
    play_with_x(&[("1.0", "a=S -> S"), ("1.00000001", "a=S -> S"), ("01", "a=S -> S"), ("1a", "c=S -> S")]);
}

behaviors! {
    switch_without_a_value_ticks_the_last_child: BY_X => ["c=S -> S"];
    switch_reads_numbers_that_a_script_wrote:
        r#"<Sequence><Script code="x := 2"/><Switch3 variable="{x}" case_1="1" case_2="2" case_3="3"><a/><b/><c/><d/></Switch3></Sequence>"# => ["b=S -> S"];
    switch_knows_constants_by_their_names:
        r#"<Sequence><Script code="x := GREEN"/><Switch2 variable="{x}" case_1="RED" case_2="GREEN"><a/><b/><c/></Switch2></Sequence>"# => ["b=S -> S"];
    switch_compares_to_entries:
        r#"<Sequence><Script code="x := 'go'; y := 'go'"/><Switch2 variable="{x}" case_1="{z}" case_2="{y}"><a/><b/><c/></Switch2></Sequence>"# => ["b=S -> S"];
    switch_takes_the_first_of_two_equal_cases:
        r#"<Switch2 variable="1" case_1="1" case_2="1"><a/><b/><c/></Switch2>"# => ["a=S -> S"];
    switch_with_a_case_that_is_missing: r#"<Switch2 variable="1" case_2="1"><a/><b/><c/></Switch2>"# => ["b=S -> S"];
    switch_with_six_cases:
        r#"<Switch6 variable="6" case_1="1" case_2="2" case_3="3" case_4="4" case_5="5" case_6="6"><a/><a/><a/><a/><a/><b/><c/></Switch6>"# => ["b=S -> S"];
    switch_is_skipped_when_the_chosen_child_is:
        r#"<Fallback><Switch2 variable="1" case_1="1" case_2="2"><a/><b/><c/></Switch2><d/></Fallback>"# => ["a=K d=S -> S"];
    switch_halts_its_running_child: r#"<Switch2 variable="1" case_1="1" case_2="2"><a/><b/><c/></Switch2>"# => [
        "a=R -> R",
        "halt tree: a=halt",
        "a=S -> S",
    ];
}

/// The first node that names an entry determines its type.
#[test]
fn switch_compares_a_number_in_an_entry_named_by_an_earlier_node() {
    let switch = "<Switch2 variable=\"{y}\" case_1=\"0\" case_2=\"1\"><a/><b/><c/></Switch2>";
    let mut execution = Execution::new(tree(&format!("<WaitValueUpdate entry=\"{{y}}\">{switch}</WaitValueUpdate>")));
    execution.blackboard_mut().set("y", 0).unwrap();
    play_with(&mut execution, &["a=S -> S"]);
    execution.blackboard_mut().set("y", 1).unwrap();
    play_with(&mut execution, &["b=F -> F"]);
}
