//! The records of logs that BehaviorTree.CPP wrote.

use std::fs;
use std::path::{Path, PathBuf};

use channels::EventKind;
use recording::{Ended, Recording, RunView};

fn captured(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../bt/logs/tests/captured").join(name)
}

/// Plays a log, and shows each step to `see`.
fn play(path: &Path, mut see: impl FnMut(&RunView)) -> RunView {
    let mut recording = Recording::open(path).unwrap();
    let mut view = recording.begin().unwrap();
    while view.end().is_none() {
        recording.advance(&mut view).unwrap();
        see(&view);
    }
    view
}

#[test]
fn a_node_tells_the_tree_its_answers_and_that_it_was_halted() {
    let mut told = Vec::new();
    let view = play(&captured("fetch.btlog"), |view| {
        told.extend(view.events().iter().filter_map(|event| {
            let EventKind::Received { channel, message } = &event.kind else { return None };
            let (node, tree) = view.topology().ends(*channel);
            assert_eq!(tree, "BT");
            Some((node.to_owned(), message.head().unwrap_or_default().to_owned()))
        }));
    });
    let of = |name: &str| -> Vec<&str> {
        told.iter().filter(|(node, _)| node == name).map(|(_, answer)| answer.as_str()).collect()
    };
    // In `captured/fetch.txt`, these are the nodes with the numbers 3, 13, 9 and 18.
    assert_eq!(of("BatteryLow"), ["failure", "failure", "failure", "failure", "failure", "success"]);
    assert_eq!(of("Drive_2"), ["running", "success"]);
    assert_eq!(of("deliver"), ["running", "success"]);
    assert_eq!(of("Scripted_2"), [""; 0]);
    assert_eq!(told.len() as u64, view.communications());
    assert_eq!(view.end().unwrap().ended, Ended::Recorded);
    assert!(!view.header().knows_ticks() && view.ticks() == 0);
    assert_eq!(view.header().origin.began.unwrap().timestamp_micros() / 1_000_000, 1_795_779_814);
}

#[test]
fn a_node_that_stops_running_without_an_answer_was_halted() {
    let mut halted = Vec::new();
    play(&captured("killed.btlog"), |view| {
        let was_halted = |node: &usize| view.outcomes()[*node] == Some(bt::Outcome::Halted);
        halted.extend((0..view.outcomes().len()).find(was_halted).map(|node| view.header().tree[node].process.clone()));
    });
    assert!(halted.iter().any(|name| name == "Drive_2"), "{halted:?}");
}

#[test]
fn what_was_answered_before_a_node_began_anew_is_forgotten() {
    let mut outcomes = Vec::new();
    play(&captured("fetch.btlog"), |view| {
        let at = |name: &str| view.header().tree.iter().position(|node| node.process == name).unwrap();
        let of = |name: &str| view.outcomes()[at(name)].map_or("-", bt::Outcome::name);
        outcomes.push((of("deliver"), of("Lift"), of("Drive_2")));
    });
    outcomes.dedup();
    let expected = [
        ("-", "-", "-"),
        ("running", "-", "-"),
        ("running", "-", "running"),
        ("running", "-", "success"),
        ("running", "running", "success"),
        ("running", "success", "success"),
        ("success", "success", "success"),
        ("-", "-", "-"),
    ];
    assert_eq!(outcomes, expected);
}

#[test]
fn a_log_that_was_cut_off_ends_there_and_says_so() {
    let whole = fs::read(captured("fetch.btlog")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cut.btlog");
    let start = whole.len() - 9 * 76;
    for (length, steps) in [(whole.len() - 4, 75), (start + 4, 1), (start, 1), (whole.len(), 76)] {
        fs::write(&path, &whole[..length]).unwrap();
        let mut count = 0;
        let view = play(&path, |_| count += 1);
        let is_cut = matches!(&view.end().unwrap().ended, Ended::CutOff(what) if what.contains("not whole"));
        assert_eq!((count, is_cut), (steps, !(length - start).is_multiple_of(9)), "{length}");
    }
    fs::write(&path, &whole[..100]).unwrap();
    assert!(Recording::open(&path).unwrap_err().to_string().contains("it ends within its tree"));
}

#[test]
fn a_clock_that_is_set_back_does_not_turn_time_back() {
    let mut bytes = fs::read(captured("fetch.btlog")).unwrap();
    let start = bytes.len() - 9 * 76;
    bytes[start + 9 * 40..][..6].copy_from_slice(&(-1_000_000_i64).to_le_bytes()[..6]);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("back.btlog");
    fs::write(&path, bytes).unwrap();
    let mut times = Vec::new();
    let view = play(&path, |view| times.push(view.time()));
    assert!(times.is_sorted());
    let words: Vec<&str> = view.moves().iter().map(|moved| moved.words.as_str()).collect();
    assert!(matches!(words[..], [one] if one.starts_with("the clock of the log went back by 1.")), "{words:?}");
}
