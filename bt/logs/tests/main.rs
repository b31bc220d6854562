//! Logs that BehaviorTree.CPP wrote, and broken ones. `captured/writer.cpp` says how they were made; it has also
//! written down what a logger inside the program heard.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

mod random;
mod simulated;

use std::fs;
use std::path::{Path, PathBuf};

use proptest::prelude::*;
use tree_logs::{Log, LogEntry, LogError, NodeStatus, StatusChange};

fn captured(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/captured").join(name)
}

/// The transitions of a session as they were heard: when, the node's number, and its status.
fn heard(name: &str, session: usize) -> Vec<(i64, u16, i64)> {
    let text = fs::read_to_string(captured(name)).unwrap();
    let lines = text.split("session\n").nth(session).expect("the session was heard").lines();
    let transition = |line: &str| {
        let numbers: Vec<i64> = line.split(' ').map(|number| number.parse().unwrap()).collect();
        (numbers[0], u16::try_from(numbers[1]).unwrap(), numbers[2])
    };
    lines.map(transition).collect()
}

/// All transitions of a log, and why there are no more, if not because it ends.
fn read(path: &Path) -> (Vec<(i64, u16, i64)>, Option<LogError>) {
    let (mut log, mut all) = match Log::open(path) {
        Ok(log) => (log, Vec::new()),
        Err(error) => return (Vec::new(), Some(error)),
    };
    loop {
        match log.next_entry() {
            Ok(None) => return (all, None),
            Ok(Some(LogEntry::Changed(StatusChange { at_us, node, status, .. }))) => {
                all.push((at_us, log.tree().nodes()[node].uid, number(status)));
            }
            Ok(Some(LogEntry::Lost(gap))) => panic!("{gap:?}"),
            Err(error) => return (all, Some(error)),
        }
    }
}

fn number(status: NodeStatus) -> i64 {
    match status {
        NodeStatus::Idle => 0,
        NodeStatus::Answered(bt::Status::Running) => 1,
        NodeStatus::Answered(bt::Status::Success) => 2,
        NodeStatus::Answered(bt::Status::Failure) => 3,
        NodeStatus::Answered(bt::Status::Skipped) => 4,
    }
}

/// Two loggers hear a transition at different times, by up to a microsecond of rounding.
fn assert_same(logged: &[(i64, u16, i64)], heard: &[(i64, u16, i64)]) {
    assert_eq!(logged.len(), heard.len());
    for (one, other) in logged.iter().zip(heard) {
        assert!(one.0.abs_diff(other.0) <= 1 && (one.1, one.2) == (other.1, other.2), "{one:?}, {other:?}");
    }
}

#[test]
fn a_file_has_what_a_logger_inside_the_program_heard() {
    for (name, session, count) in [("fetch", 2, 76), ("killed", 1, 320)] {
        let (logged, error) = read(&captured(&format!("{name}.btlog")));
        assert!(error.is_none() && logged.len() == count, "{error:?}");
        assert_same(&logged, &heard(&format!("{name}.txt"), session));
    }
}

#[test]
fn the_tree_is_put_together_from_its_parts() {
    let log = Log::open(&captured("fetch.btlog")).unwrap();
    let lines = log.tree().nodes().iter().map(|node| {
        let parent = node.parent.map_or_else(|| "-".to_owned(), |parent| log.tree().nodes()[parent].uid.to_string());
        let leaf = if node.is_leaf { " leaf" } else { "" };
        format!("{} below {parent}: {} {} ({}){leaf}", node.uid, node.type_id, node.path, node.name)
    });
    let lines: Vec<String> = lines.collect();
    let expected = [
        "1 below -: ReactiveFallback main (main)",
        "2 below 1: Sequence Sequence::2 (Sequence)",
        "3 below 2: Scripted BatteryLow (BatteryLow) leaf",
        "4 below 2: GoTo dock (dock)",
        "5 below 4: Fallback dock/Fallback::5 (Fallback)",
        "6 below 5: Scripted dock/AtPlace (AtPlace) leaf",
        "7 below 5: Scripted dock/Drive (Drive) leaf",
        "8 below 1: RetryUntilSuccessful RetryUntilSuccessful::8 (RetryUntilSuccessful)",
        "9 below 8: Sequence deliver (deliver)",
        "10 below 9: GoTo GoTo::10 (GoTo)",
        "11 below 10: Fallback GoTo::10/Fallback::11 (Fallback)",
        "12 below 11: Scripted GoTo::10/AtPlace (AtPlace) leaf",
        "13 below 11: Scripted GoTo::10/Drive (Drive) leaf",
        "14 below 9: Parallel Parallel::14 (Parallel)",
        "15 below 14: Scripted Lift (Lift) leaf",
        "16 below 14: Inverter Inverter::16 (Inverter)",
        "17 below 16: Scripted Scripted::17 (Scripted) leaf",
        "18 below 9: Scripted Scripted::18 (Scripted) leaf",
    ];
    assert_eq!(lines, expected);
}

/// The library's own paths are in the table `Nodes`. What it had not yet written when it ended or was killed is lost.
#[cfg(feature = "sqlite")]
#[test]
fn a_session_has_a_beginning_of_what_was_heard() {
    for (file, name, session, count) in
        [("fetch.db3#1", "fetch.txt", 1, 88), ("fetch.db3", "fetch.txt", 2, 76), ("killed.db3", "killed.txt", 1, 42)]
    {
        let (logged, error) = read(&captured(file));
        assert!(error.is_none() && logged.len() == count, "{file}: {error:?}");
        assert_eq!(logged[..], heard(name, session)[..count]);
    }
    let file = rusqlite::Connection::open(captured("fetch.db3")).unwrap();
    let log = Log::open(&captured("fetch.db3#2")).unwrap();
    for node in log.tree().nodes() {
        let path = "SELECT fullpath FROM Nodes WHERE session_id = 2 AND node_uid = ?1";
        let path: String = file.query_row(path, [node.uid], |row| row.get(0)).unwrap();
        assert_eq!(node.path, path);
    }
    let (_, error) = read(&captured("fetch.db3#3"));
    assert!(error.unwrap().to_string().contains("it has no session 3"));
}

#[cfg(feature = "sqlite")]
#[test]
fn a_session_may_have_the_first_and_the_last_of_all_times() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("extreme.db3");
    fs::copy(captured("fetch.db3"), &path).unwrap();
    let file = rusqlite::Connection::open(&path).unwrap();
    for (time, state) in [(i64::MIN, 1), (i64::MAX, 2)] {
        let add = "INSERT INTO Transitions (timestamp, session_id, node_uid, duration, state) VALUES (?1, 1, 1, 0, ?2)";
        file.execute(add, [time, state]).unwrap();
    }
    drop(file);
    let (logged, problem) = read(&folder.path().join("extreme.db3#1"));
    assert!(problem.is_none());
    assert_eq!(logged.first(), Some(&(i64::MIN, 1, 1)));
    assert_eq!(logged.last(), Some(&(i64::MAX, 1, 2)));
    assert!(logged.is_sorted());
}

/// The search for the row after one that is out of order leads back, so that reading would not end.
#[cfg(feature = "sqlite")]
#[test]
fn a_session_whose_times_are_out_of_order_is_damaged() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("order.db3");
    let mut bytes = fs::read(captured("fetch.db3")).unwrap();
    // The time of a row in the table of transitions.
    bytes[6123] = 129;
    fs::write(&path, bytes).unwrap();
    let (logged, problem) = read(&path);
    assert!(problem.unwrap().to_string().contains("not in the order of their times"));
    assert!(!logged.is_empty() && logged.is_sorted());
}

#[test]
fn wherever_a_file_is_cut_off_all_before_is_read() {
    let whole = fs::read(captured("fetch.btlog")).unwrap();
    let (all, _) = read(&captured("fetch.btlog"));
    let start = whole.len() - 9 * all.len();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cut.btlog");
    for length in (0..start).step_by(61).chain(start - 9..=whole.len()) {
        fs::write(&path, &whole[..length]).unwrap();
        let (read, error) = read(&path);
        assert_eq!(read, all[..length.saturating_sub(start) / 9]);
        match error {
            None => assert!(length >= start && (length - start).is_multiple_of(9)),
            Some(LogError::Foreign(_)) => assert!(length < 18),
            Some(LogError::CutOff { .. }) => assert!(length >= 18),
            // Of a file without a byte, that is said.
            Some(error) => assert_eq!(length, 0, "{error}"),
        }
    }
}

#[test]
fn what_cannot_be_a_log_is_refused_with_a_reason() {
    let xml = |body: &str| format!("<root>{body}</root>");
    let node = r#"<A _uid="1"/>"#;
    let tree = |path: &str, body: &str| format!(r#"<BehaviorTree ID="T" _fullpath="{path}">{body}</BehaviorTree>"#);
    let deep = "<A _uid=\"1\">".repeat(3000) + &"</A>".repeat(3000);
    let twice = tree("", r#"<Sequence _uid="1"><A _uid="2"/><A _uid="2"/></Sequence>"#);
    let circle = tree("", r#"<SubTree ID="T" _fullpath="" _uid="1"/>"#);
    let cases = [
        ("<root".to_owned(), "is not XML"),
        (xml(""), "no tree"),
        (xml(&tree("", "")), "no node"),
        (xml(&tree("", &node.repeat(2))), "more than one node"),
        (xml(&tree("", "<A/>")), "no number `_uid`"),
        (xml(&tree("", r#"<A _uid="70000"/>"#)), "no number `_uid`"),
        (xml(&twice), "two nodes with the number 2"),
        (xml(&(tree("a", node) + &tree("a", node))), "two trees with the path `a`"),
        (xml(&circle), "subtree `` has no tree"),
        (xml(&tree("", r#"<SubTree ID="T" _fullpath="b" _uid="1"/>"#)), "subtree `b` has no tree"),
        (xml(&tree("", &deep)), "two nodes with the number 1"),
    ];
    for (xml, problem) in cases {
        let error = written(&xml, &[]).1.expect(problem);
        assert!(error.to_string().contains(problem), "{error}");
    }
    let good = xml(&tree("", node));
    for (record, problem) in [([0, 0, 0, 0, 0, 0, 2, 0, 1], "number 2"), ([0, 0, 0, 0, 0, 0, 1, 0, 9], "number 9")] {
        let error = written(&good, &record).1.expect(problem);
        assert!(error.to_string().contains(problem), "{error}");
    }
    // Half a second before the beginning: the clock was set back.
    let early = [(-500_000_i64).to_le_bytes()[..6].to_vec(), vec![1, 0, 1]].concat();
    let (transitions, error) = written(&good, &early);
    assert!(error.is_none() && transitions == [(1_500_000, 1, 1)], "{transitions:?}");
}

/// What is read of a file with this tree, begun two seconds after 1970, and these transitions.
fn written(xml: &str, transitions: &[u8]) -> (Vec<(i64, u16, i64)>, Option<LogError>) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.btlog");
    let length = i32::try_from(xml.len()).unwrap().to_le_bytes();
    let parts = [b"BTCPP4-FileLogger2\x01", &length[..], xml.as_bytes(), &2_000_000_i64.to_le_bytes(), transitions];
    fs::write(&path, parts.concat()).unwrap();
    read(&path)
}

proptest! {
    #[test]
    fn no_damage_to_a_log_causes_a_crash(changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..20), file in 0..2_usize) {
        let name = ["fetch.btlog", if cfg!(feature = "sqlite") { "fetch.db3" } else { "killed.btlog" }][file];
        let mut bytes = fs::read(captured(name)).unwrap();
        for (place, byte) in changes {
            let place = place.index(bytes.len());
            bytes[place] = byte;
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        fs::write(&path, bytes).unwrap();
        let (transitions, _) = read(&path);
        prop_assert!(transitions.len() <= 1000);
    }
}
