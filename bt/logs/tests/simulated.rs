//! The changes of status in our own runs of trees: those that BehaviorTree.CPP logged for the same tree and answers.

use std::collections::BTreeMap;
use std::fs;
use std::sync::Arc;
use std::time::Duration;

use bt::{Execution, Leaf, Leaves, NodeId, Status, Tree};
use tree_logs::{Log, LogWriter, LoggedTransition, NodeStatus};

use crate::{captured, heard, read};

/// Leaves that answer one after the other what their port `answers` says.
#[derive(Default)]
pub(crate) struct Scripted(BTreeMap<NodeId, usize>);

impl Leaves for Scripted {
    fn tick(&mut self, leaf: Leaf<'_>) -> Status {
        let answers = leaf.node().attribute("answers").unwrap().as_bytes();
        let next = self.0.entry(leaf.node().id()).or_default();
        *next += 1;
        match answers[(*next - 1) % answers.len()] {
            b'r' => Status::Running,
            b's' => Status::Success,
            b'f' => Status::Failure,
            _ => Status::Skipped,
        }
    }

    fn halt(&mut self, _: Leaf<'_>) {}
}

const MODELS: &str = r#"<TreeNodesModel>
    <Action ID="Scripted"> <input_port name="answers" type="std::string"/> </Action>
    <Condition ID="Look"> <input_port name="answers" type="std::string"/> </Condition>
</TreeNodesModel> </root>"#;

/// A tree file, with the models of its leaves.
pub(crate) fn with_models(xml: &str) -> String {
    xml.replace("</root>", MODELS)
}

/// The time of a tick.
pub(crate) fn at_tick(tick: u64) -> Duration {
    Duration::from_millis(20 * tick)
}

fn loaded(file: &str) -> Arc<Tree> {
    let text = fs::read_to_string(captured(file)).unwrap();
    Arc::new(Tree::from_xml(file, &with_models(&text)).unwrap())
}

/// The changes in this many ticks, and in a halt after them.
fn run(tree: &Arc<Tree>, ticks: u64) -> Vec<(u16, i64)> {
    let (mut execution, mut leaves) = (Execution::new(Arc::clone(tree)), Scripted::default());
    execution.note_transitions();
    for tick in 0..ticks {
        execution.tick(at_tick(tick), &mut leaves);
    }
    execution.halt(at_tick(ticks), &mut leaves);
    let number = |status: Option<Status>| status.map_or(NodeStatus::Idle, NodeStatus::Answered).number();
    let told = execution.take_transitions().into_iter();
    told.map(|told| (u16::try_from(told.node.index() + 1).unwrap(), number(told.status).into())).collect()
}

#[test]
fn the_changes_in_our_run_of_a_tree_are_those_that_the_library_logged() {
    // In the other one, a subtree is ticked again while it still has its answer.
    for (name, session, ticks) in [("fetch", 1, 12), ("fetch", 2, 8), ("again", 1, 12)] {
        let heard = heard(&format!("{name}.txt"), session).into_iter().map(|(_, uid, status)| (uid, status));
        assert_eq!(run(&loaded(&format!("{name}.xml")), ticks), heard.collect::<Vec<_>>(), "{name}");
    }
}

#[test]
fn a_log_of_our_own_is_read_back() {
    let tree = loaded("fetch.xml");
    let changes = run(&tree, 12);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("own.btlog");
    let times = (0..).map(|place| 5_000_000 + 100_000 * place);
    let changes: Vec<(i64, u16, i64)> = times.zip(changes).map(|(at, (uid, status))| (at, uid, status)).collect();
    let mut writer = LogWriter::begin(fs::File::create(&path).unwrap(), &tree.to_instance_xml(), 5_000_000).unwrap();
    for (at_us, uid, status) in &changes {
        writer.write(LoggedTransition { at_us: *at_us, uid: (*uid).into(), status: *status }).unwrap();
    }
    let unfit = LoggedTransition { at_us: 5_000_000 + (1 << 47), uid: 1, status: 1 };
    assert!(writer.write(unfit).unwrap_err().to_string().contains("does not fit the format"));
    writer.finish().unwrap();
    let (read, error) = read(&path);
    assert!(error.is_none() && read == changes);
    // The tree is put together to what the library's own log of it gives.
    let [own, theirs] = [path, captured("fetch.btlog")].map(|path| Log::open(&path).unwrap());
    assert_eq!(own.tree(), theirs.tree());
}
