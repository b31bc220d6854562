//! SubTree: what its blackboard shares with the containing tree.

use bt::Execution;

use crate::stage::{file, play_file, play_with, shown};

/// A main tree that sets `x` and uses `S`, and `S`.
fn with_subtree(attributes: &str, inside: &str) -> String {
    format!(
        r#"<BehaviorTree ID="T"><Sequence><Script code="x := 1"/><SubTree ID="S" {attributes}/></Sequence></BehaviorTree>
        <BehaviorTree ID="S">{inside}</BehaviorTree>"#
    )
}

#[test]
fn subtree_has_its_own_blackboard() {
    play_file(&with_subtree("", r#"<Script code="x := 5; y := 6"/>"#), &["-> S | x=1 y=-"]);
}

#[test]
fn subtree_does_not_see_entries_that_are_not_remapped() {
    play_file(&with_subtree("", r#"<a _skipIf="x == 1"/>"#), &["-> F"]);
}

#[test]
fn subtree_reads_and_writes_remapped_entries() {
    play_file(&with_subtree(r#"inner="{x}""#, r#"<Script code="inner += 1"/>"#), &["-> S | x=2 inner=-"]);
}

#[test]
fn subtree_creates_remapped_entries() {
    play_file(&with_subtree(r#"inner="{fresh}""#, r#"<Script code="inner := 7"/>"#), &["-> S | fresh=7"]);
}

#[test]
fn subtree_remaps_an_entry_to_its_own_name() {
    play_file(&with_subtree(r#"x="{=}""#, r#"<Script code="x += 1"/>"#), &["-> S | x=2"]);
}

#[test]
fn subtree_gets_an_equals_sign_without_braces_as_a_string() {
    play_file(&with_subtree(r#"x="=""#, r#"<Script code="@y := x"/>"#), &["-> S | x=1 y='='"]);
}

#[test]
fn subtree_gets_infinity_as_a_number_but_not_what_is_out_of_range() {
    for (constant, value) in [("inf", "inf"), ("1e999", "'1e999'"), ("1e-999", "'1e-999'"), ("0e9", "0.0")] {
        let line = format!("-> S | y={value}");
        play_file(&with_subtree(&format!("d=\"{constant}\""), r#"<Script code="@y := d"/>"#), &[&line]);
    }
}

#[test]
fn subtree_with_autoremap_shares_all_entries() {
    play_file(&with_subtree(r#"_autoremap="true""#, r#"<Script code="x += 1; y := 3"/>"#), &["-> S | x=2 y=3"]);
}

#[test]
fn subtree_with_autoremap_does_not_share_private_entries() {
    play_file(&with_subtree(r#"_autoremap="true""#, r#"<Script code="_z := 3"/>"#), &["-> S | _z=-"]);
}

#[test]
fn subtree_without_autoremap_shares_nothing() {
    play_file(&with_subtree(r#"_autoremap="false""#, r#"<Script code="y := 3"/>"#), &["-> S | y=-"]);
}

#[test]
fn subtree_gets_constants_as_numbers_and_strings() {
    let inside = r#"<Script code="@a := n; @b := r; @c := t"/>"#;
    play_file(&with_subtree(r#"n="3" r="2.5" t="home""#, inside), &["-> S | a=3 b=2.5 c='home'"]);
}

#[test]
fn subtree_constants_are_invisible_above_even_with_autoremap() {
    play_file(&with_subtree(r#"x="9" _autoremap="true""#, r#"<Script code="x += 1; y := x"/>"#), &["-> S | x=1 y=10"]);
}

#[test]
fn subtree_in_a_subtree_passes_remapped_entries_through() {
    let trees = r#"<BehaviorTree ID="T"><Sequence><Script code="x := 1"/><SubTree ID="S" a="{x}"/></Sequence></BehaviorTree>
        <BehaviorTree ID="S"><SubTree ID="U" b="{a}"/></BehaviorTree>
        <BehaviorTree ID="U"><Script code="b += 10; @z := 5; c := 3"/></BehaviorTree>"#;
    play_file(trees, &["-> S | x=11 z=5 c=-"]);
}

#[test]
fn subtree_used_twice_has_two_blackboards() {
    let trees = r#"<BehaviorTree ID="T"><Sequence><SubTree ID="S" out="{x}"/><SubTree ID="S" out="{y}"/></Sequence></BehaviorTree>
        <BehaviorTree ID="S"><Script code="n := 1; out := n"/></BehaviorTree>"#;
    let mut execution = Execution::new(file(trees));
    play_with(&mut execution, &["-> S | x=1 y=1"]);
    let own: Vec<usize> =
        execution.blackboard().entries().filter(|(_, key, _)| *key == "n").map(|(scope, ..)| scope).collect();
    assert_eq!(own, [1, 2]);
    assert_eq!(shown(execution.blackboard().get("n")), "-");
}

#[test]
fn subtree_ports_have_the_defaults_of_the_model() {
    let trees = format!(
        r#"{}<TreeNodesModel><SubTree ID="S"><input_port name="speed" default="3"/><inout_port name="goal" default="{{place}}"/></SubTree></TreeNodesModel>"#,
        with_subtree("", r#"<Script code="@v := speed; goal := 'home'"/>"#)
    );
    play_file(&trees, &["-> S | v=3 place='home'"]);
    let given =
        trees.replace(r#"ID="S" />"#, r#"ID="S" speed="5" goal="{x}"/>"#).replace("goal := 'home'", "goal := 2");
    play_file(&given, &["-> S | v=5 x=2 place=-"]);
}

#[test]
fn subtree_has_its_own_scripts() {
    play_file(&with_subtree(r#"_skipIf="x == 1""#, "<a/>"), &["-> S"]);
    play_file(&with_subtree(r#"_onSuccess="x := 7""#, "<a/>"), &["a=S -> S | x=7"]);
}

#[test]
fn subtree_returns_the_status_of_its_tree() {
    play_file(&with_subtree("", "<a/>"), &["a=R -> R", "a=F -> F", "a=S -> S"]);
    let trees = r#"<BehaviorTree ID="T"><Fallback><SubTree ID="S"/><b/></Fallback></BehaviorTree><BehaviorTree ID="S"><a/></BehaviorTree>"#;
    play_file(trees, &["a=K b=S -> S"]);
}

#[test]
fn subtree_of_version_3_has_names_of_entries_in_its_attributes() {
    let text = r#"<root main_tree_to_execute="T">
        <BehaviorTree ID="T"><Sequence><SetBlackboard value="go" output_key="x"/><SubTree ID="S" inner="x"/></Sequence></BehaviorTree>
        <BehaviorTree ID="S"><SetBlackboard value="done" output_key="inner"/></BehaviorTree></root>"#;
    let tree = std::sync::Arc::new(bt::Tree::from_xml("old.xml", text).unwrap());
    play_with(&mut Execution::new(tree), &["-> S | x='done'"]);
}

#[test]
fn subtree_plus_of_version_3_is_a_subtree() {
    let text = r#"<root main_tree_to_execute="T">
        <BehaviorTree ID="T"><SubTreePlus ID="S" __autoremap="1" n="3"/></BehaviorTree>
        <BehaviorTree ID="S"><Script code="y := n + 1"/></BehaviorTree></root>"#;
    let tree = std::sync::Arc::new(bt::Tree::from_xml("old.xml", text).unwrap());
    play_with(&mut Execution::new(tree), &["-> S | y=4.0"]);
}
