//! One behavior per test, as a play: a body of nodes, and one line per tick.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Duration;

use bt::{Execution, Leaf, Leaves, Loader, NodeId, Status, Tree, Value};

/// The tree of a body, in which `<a/>` to `<f/>` are actions.
pub(crate) fn tree(body: &str) -> Arc<Tree> {
    file(&format!(r#"<BehaviorTree ID="T">{body}</BehaviorTree>"#))
}

/// The tree `T` among others.
pub(crate) fn file(trees: &str) -> Arc<Tree> {
    let text = format!(r#"<root BTCPP_format="4" main_tree_to_execute="T">{trees}</root>"#);
    let loader = Loader::default().leaves(["a", "b", "c", "d", "e", "f"]).constants([("RED", 1), ("GREEN", 2)]);
    Arc::new(loader.load("test.xml", &text).unwrap_or_else(|error| panic!("{error:?}")))
}

/// Leaves that follow the script of one tick and check that they are called in its order.
pub(crate) struct Script<'a> {
    tree: Arc<Tree>,
    calls: VecDeque<&'a str>,
}

impl<'a> Script<'a> {
    pub(crate) fn new(tree: &Arc<Tree>, calls: &'a str) -> Self {
        Self { tree: tree.clone(), calls: calls.split_whitespace().collect() }
    }

    pub(crate) fn is_over(&self) -> bool {
        self.calls.is_empty()
    }

    fn next(&mut self, leaf: NodeId) -> &'a str {
        let id = self.tree.node(leaf).type_id().to_owned();
        let call = self.calls.pop_front().unwrap_or_else(|| panic!("{id} is called out of turn"));
        let (name, rest) = call.split_once('=').unwrap();
        assert_eq!(name, id, "expected {call}");
        rest
    }
}

impl Leaves for Script<'_> {
    fn tick(&mut self, leaf: Leaf<'_>) -> Status {
        status(self.next(leaf.id()))
    }

    fn halt(&mut self, leaf: Leaf<'_>) {
        assert_eq!(self.next(leaf.id()), "halt");
    }
}

pub(crate) fn status(letter: &str) -> Status {
    match letter {
        "S" => Status::Success,
        "F" => Status::Failure,
        "R" => Status::Running,
        "K" => Status::Skipped,
        other => panic!("{other} is not a status"),
    }
}

/// Plays the lines with the tree of a body.
pub(crate) fn play(body: &str, lines: &[&str]) {
    play_with(&mut Execution::new(tree(body)), lines);
}

/// Plays the lines with the tree `T` among others.
pub(crate) fn play_file(trees: &str, lines: &[&str]) {
    play_with(&mut Execution::new(file(trees)), lines);
}

pub(crate) fn play_with(execution: &mut Execution, lines: &[&str]) {
    let mut now = Duration::ZERO;
    for line in lines {
        let (line, board) = line.split_once('|').map_or((*line, ""), |(line, board)| (line, board));
        let mut rest = line.trim();
        if let Some((time, after)) = rest.strip_prefix('@').and_then(|timed| timed.split_once(' ')) {
            now = Duration::from_millis(time.parse().unwrap());
            rest = after;
        }
        let (calls, expected) = match rest.strip_prefix("halt tree:") {
            Some(calls) => (calls, None),
            None => rest.split_once("->").map(|(calls, result)| (calls, Some(result.trim()))).unwrap(),
        };
        let mut script = Script::new(execution.tree(), calls);
        match expected {
            Some(expected) => assert_eq!(execution.tick(now, &mut script), status(expected), "{line}"),
            None => execution.halt(now, &mut script),
        }
        assert!(script.calls.is_empty(), "{line}: not called: {:?}", script.calls);
        for entry in board.split_whitespace() {
            let (key, value) = entry.split_once('=').unwrap();
            assert_eq!(shown(execution.blackboard().get(key)), value, "{line}: {key}");
        }
    }
}

/// A value as the lines write it: `1`, `1.5`, `'a'`.
pub(crate) fn shown(value: Option<&Value>) -> String {
    match value {
        None => "-".to_owned(),
        Some(Value::Real(number)) => format!("{number:?}"),
        Some(Value::Text(text)) => format!("'{text}'"),
        Some(other) => other.to_string(),
    }
}

/// One test per behavior: its name, the body, and the lines.
macro_rules! behaviors {
    ($($name:ident: $body:expr => [$($line:expr),* $(,)?];)*) => {
        $(
            #[test]
            fn $name() {
                $crate::stage::play($body, &[$($line),*]);
            }
        )*
    };
}

pub(crate) use behaviors;
