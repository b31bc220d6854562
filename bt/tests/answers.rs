//! What BehaviorTree.CPP 4.10.0 answered to random trees with scripts, typed leaves, copies and subtrees.
//!
//! Each line of `answers/4.10.0.tsv` is a tree and its answer: `refused`, or the first letter of the answer to each of
//! three ticks, `!` for an exception, and then the entries `a` to `d`. `answers/generate.py SEED COUNT` writes the
//! trees, and `answers/driver.cpp`, linked with the library, answers them (its head has the commands). To compare other
//! trees, name a file of the same form in `STEWARD_ANSWERS`.

use std::sync::Arc;

use bt::{Execution, Leaf, Leaves, Loader, PortError, Status, Tree};

use crate::NOW;

const MODELS: &str = include_str!("answers/models.xml");

/// Leaves that write a constant, or show whether they can read an entry.
#[derive(Default)]
struct Typed {
    failed: Option<PortError>,
}

impl Leaves for Typed {
    fn tick(&mut self, mut leaf: Leaf<'_>) -> Status {
        if leaf.node().type_id().starts_with("Get") {
            return if leaf.input("in").is_ok() { Status::Success } else { Status::Failure };
        }
        let written = leaf.input("is").and_then(|value| leaf.output("out", value));
        self.failed = self.failed.take().or(written.err());
        Status::Success
    }

    fn halt(&mut self, _: Leaf<'_>) {}
}

/// Whether a warning is about a tree that the library refuses; others are about what happens when it runs.
fn is_refused(tree: &Tree) -> bool {
    let problems = tree.concerns().into_iter().flat_map(|concerns| concerns.problems());
    problems.into_iter().any(|problem| problem.message().contains("already has the type"))
}

/// The answer of this crate to a tree, in the library's form; an entry without a value is one that does not exist.
fn answer(trees: &str) -> String {
    let text = format!("<root BTCPP_format=\"4\" main_tree_to_execute=\"T\">{trees}{MODELS}</root>");
    let tree = match Loader::default().load("answer.xml", &text) {
        Ok(tree) if !is_refused(&tree) => tree,
        _ => return "refused".to_owned(),
    };
    let (mut execution, mut leaves) = (Execution::new(Arc::new(tree)), Typed::default());
    let mut answers = String::new();
    for _ in 0..3 {
        let status = execution.tick(NOW, &mut leaves);
        if leaves.failed.is_some() || !execution.faults().is_empty() {
            return answers + "!";
        }
        answers.push_str(&status.name()[..1].to_uppercase());
    }
    for key in ["a", "b", "c", "d"] {
        let value = match execution.blackboard().get(key) {
            Some(bt::Value::Text(text)) => format!("'{text}'"),
            Some(value) => value.to_string(),
            None => "-".to_owned(),
        };
        answers.push_str(&format!(" {key}={value}"));
    }
    answers
}

#[test]
fn random_trees_answer_as_in_the_library() {
    let file = std::env::var("STEWARD_ANSWERS").map(|path| std::fs::read_to_string(path).expect("a file"));
    let text = file.as_deref().unwrap_or(include_str!("answers/4.10.0.tsv"));
    let pairs = text.lines().map(|line| line.split_once('\t').expect("a tree and an answer"));
    let wrong: Vec<String> = pairs
        .map(|(trees, theirs)| (trees, theirs, answer(trees)))
        .filter(|(_, theirs, ours)| theirs != ours)
        .map(|(trees, theirs, ours)| format!("{trees}\n  library: {theirs}\n  here:    {ours}"))
        .collect();
    assert!(text.lines().count() >= 300, "the file is complete");
    assert!(wrong.is_empty(), "{} differences\n{}", wrong.len(), wrong.join("\n"));
}
