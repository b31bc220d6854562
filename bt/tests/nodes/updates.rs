//! SkipUnlessUpdated, WaitValueUpdate and WasEntryUpdated.

use bt::Execution;

use crate::stage::{play_with, tree};

/// Plays the lines; before those that begin with `!`, the entry is written.
fn play_with_updates(body: &str, lines: &[&str]) {
    let mut execution = Execution::new(tree(body));
    for line in lines {
        let line = match line.strip_prefix('!') {
            Some(line) => {
                execution.blackboard_mut().set("x", 1).unwrap();
                line
            }
            None => line,
        };
        play_with(&mut execution, &[line]);
    }
}

#[test]
fn skip_unless_updated_is_skipped_without_the_entry() {
    play_with_updates(
        r#"<Fallback><SkipUnlessUpdated entry="{x}"><a/></SkipUnlessUpdated><b/></Fallback>"#,
        &["b=S -> S", "b=F -> F"],
    );
}

#[test]
fn skip_unless_updated_ticks_its_child_once_after_each_update() {
    let body = r#"<Fallback><SkipUnlessUpdated entry="{x}"><a/></SkipUnlessUpdated><b/></Fallback>"#;
    play_with_updates(body, &["!a=S -> S", "b=S -> S", "!a=F b=S -> S", "b=S -> S"]);
}

#[test]
fn skip_unless_updated_continues_with_a_running_child() {
    let body = r#"<Fallback><SkipUnlessUpdated entry="{x}"><a/></SkipUnlessUpdated><b/></Fallback>"#;
    play_with_updates(body, &["!a=R -> R", "a=R -> R", "a=S -> S", "b=S -> S"]);
}

#[test]
fn skip_unless_updated_that_was_halted_waits_for_the_next_update() {
    let body = r#"<Fallback><SkipUnlessUpdated entry="{x}"><a/></SkipUnlessUpdated><b/></Fallback>"#;
    play_with_updates(body, &["!a=R -> R", "halt tree: a=halt", "b=S -> S", "!a=S -> S"]);
}

#[test]
fn wait_value_update_returns_running_without_an_update() {
    play_with_updates(
        r#"<WaitValueUpdate entry="{x}"><a/></WaitValueUpdate>"#,
        &["-> R", "!a=S -> S", "-> R", "!a=F -> F"],
    );
}

#[test]
fn wait_value_update_continues_with_a_running_child() {
    play_with_updates(r#"<WaitValueUpdate entry="{x}"><a/></WaitValueUpdate>"#, &["!a=R -> R", "a=S -> S", "-> R"]);
}

#[test]
fn wait_value_update_accepts_its_entry_without_braces() {
    play_with_updates(r#"<WaitValueUpdate entry="x"><a/></WaitValueUpdate>"#, &["-> R", "!a=S -> S"]);
}

#[test]
fn was_entry_updated_succeeds_once_after_each_update() {
    play_with_updates(r#"<WasEntryUpdated entry="{x}"/>"#, &["-> F", "!-> S", "-> F", "!-> S", "-> F"]);
}

#[test]
fn writing_the_same_value_is_an_update() {
    play_with_updates(
        r#"<Sequence><Script code="x := 5"/><WasEntryUpdated entry="{x}"/></Sequence>"#,
        &["-> S", "-> S"],
    );
}

#[test]
fn each_node_tracks_updates_of_an_entry_separately() {
    let body = r#"<Sequence><WasEntryUpdated entry="{x}"/><WasEntryUpdated entry="{x}"/></Sequence>"#;
    play_with_updates(body, &["!-> S", "-> F"]);
}
