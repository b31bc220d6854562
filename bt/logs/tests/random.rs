//! The states of 500 random trees: at every moment that BehaviorTree.CPP 4.10.0 logged, those in our own run of the
//! same tree with the same answers.
//!
//! `random/4.10.0.gz` has the trees, each with the file of `FileLogger2` about it. `random/generate.py SEED COUNT`
//! writes the trees, and `random/record.cpp`, linked with the library, ticks them (its head has the commands). To
//! compare other trees, name a file of the same form in `STEWARD_LOGS`.

use std::io::{BufRead as _, BufReader, Cursor, Read as _};
use std::path::Path;
use std::sync::Arc;
use std::{env, fs};

use bt::{Execution, Status, Tree};
use flate2::bufread::GzDecoder;
use tree_logs::{Log, LogEntry, LoggedTree, NodeStatus};

use crate::simulated::{Scripted, at_tick, with_models};

/// How often each tree is ticked before it is halted.
const TICKS: u64 = 12;

/// The statuses of all nodes.
type Statuses = Vec<Option<Status>>;

/// The trees, and the log of each.
fn recorded() -> Vec<(String, Vec<u8>)> {
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/random/4.10.0.gz");
    let file = fs::read(env::var_os("STEWARD_LOGS").map_or(own, Into::into)).unwrap();
    let (mut input, mut all) = (BufReader::new(GzDecoder::new(Cursor::new(file))), Vec::new());
    loop {
        let [mut xml, mut length] = [String::new(), String::new()];
        if input.read_line(&mut xml).unwrap() == 0 {
            return all;
        }
        input.read_line(&mut length).unwrap();
        let mut log = vec![0; length.trim().parse().unwrap()];
        input.read_exact(&mut log).unwrap();
        all.push((xml, log));
    }
}

/// The statuses of all nodes after each change in a log, after those before the first.
fn logged(log: &mut Log) -> Vec<Statuses> {
    let mut statuses = vec![None; log.tree().nodes().len()];
    let mut all = vec![statuses.clone()];
    while let Some(entry) = log.next_entry().unwrap() {
        let LogEntry::Changed(change) = entry else { panic!("{entry:?}") };
        statuses[change.node] = match change.status {
            NodeStatus::Idle => None,
            NodeStatus::Answered(status) => Some(status),
        };
        all.push(statuses.clone());
    }
    all
}

/// The same of our own run, and how many changes there are after each tick and after the halt.
fn run(tree: &Arc<Tree>) -> (Vec<Statuses>, Vec<usize>) {
    let (mut execution, mut leaves) = (Execution::new(Arc::clone(tree)), Scripted::default());
    let mut statuses = vec![None; tree.nodes().len()];
    let (mut all, mut ends) = (vec![statuses.clone()], Vec::new());
    execution.note_transitions();
    for tick in 0..=TICKS {
        if tick < TICKS {
            execution.tick(at_tick(tick), &mut leaves);
        } else {
            execution.halt(at_tick(tick), &mut leaves);
        }
        assert!(execution.faults().is_empty(), "{:?}", execution.faults());
        for change in execution.take_transitions() {
            statuses[change.node.index()] = change.status;
            all.push(statuses.clone());
        }
        let states: Statuses = execution.states().into_iter().map(|state| state.status).collect();
        assert_eq!(statuses, states, "after tick {tick}, what was told adds up to the state of the tree");
        ends.push(all.len());
    }
    (all, ends)
}

#[test]
fn random_trees_have_the_states_that_the_library_logged() {
    let recorded = recorded();
    assert!(recorded.len() >= 500, "the file is complete");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("random.btlog");
    let mut wrong = Vec::new();
    for (xml, log) in &recorded {
        fs::write(&path, log).unwrap();
        let mut log = Log::open(&path).unwrap();
        let tree = Arc::new(
            Tree::from_xml("random.xml", &with_models(xml)).unwrap_or_else(|error| panic!("{error:?}\n{xml}")),
        );
        assert_eq!(log.tree().nodes(), LoggedTree::of(&tree).nodes(), "{xml}");
        let (theirs, (ours, ends)) = (logged(&mut log), run(&tree));
        if theirs != ours {
            let same = theirs.iter().zip(&ours).take_while(|(theirs, ours)| theirs == ours).count();
            let tick = ends.iter().take_while(|end| **end <= same).count();
            wrong.push(format!(
                "{xml}  change {same}, in tick {tick}\n  library: {:?}\n  here:    {:?}",
                theirs.get(same),
                ours.get(same)
            ));
        }
    }
    assert!(wrong.is_empty(), "{} differences\n{}", wrong.len(), wrong.join("\n"));
}
