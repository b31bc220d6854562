//! A client and the replies of programs: a program with BehaviorTree.CPP 4.10, whose bytes were captured, and faulty
//! ones.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

mod program;
mod server;

use std::collections::VecDeque;
use std::io::Write as _;
use std::time::Duration;

use bt::Status;
use groot::{
    Blackboards, BoardValue, Client, GrootError, NodeSnapshot, TreeSnapshot, TreeUpdate, TreeWatch, Value, ZmtpError,
};
use program::{captured, program};
use proptest::prelude::*;
use tree_logs::{LoggedTransition, NodeStatus, StatusChange};

const TIMEOUT: Duration = Duration::from_millis(500);

/// The next captured reply to a request, with the number of the request.
fn reply(replies: &mut VecDeque<(String, Vec<u8>)>, parts: &[Vec<u8>]) -> Vec<u8> {
    assert!(parts[0].is_empty());
    let header = &parts[1];
    let words: Vec<&str> = parts[1..].iter().map(|part| std::str::from_utf8(part).unwrap_or_default()).collect();
    let asked =
        [&[char::from(header[1]).to_string()], &words[1..].iter().map(ToString::to_string).collect::<Vec<_>>()[..]]
            .concat()
            .join(" ");
    let at = replies.iter().position(|(request, _)| *request == asked);
    let (_, mut reply) = replies.remove(at.unwrap_or_else(|| panic!("{asked} was not asked"))).unwrap();
    reply[6..10].copy_from_slice(&header[2..6]);
    reply
}

/// A program with the captured replies.
fn replayed() -> String {
    let (greeting, mut replies) = captured();
    program(greeting, move |stream, parts| stream.write_all(&reply(&mut replies, &parts)).unwrap()).0
}

fn names(names: &[&str]) -> Vec<String> {
    names.iter().map(ToString::to_string).collect()
}

#[test]
fn all_replies_of_a_program_with_behaviortree_cpp_are_read() {
    let mut client = Client::connect(&replayed(), TIMEOUT).unwrap();
    let tree = client.tree().unwrap();
    let of: Vec<String> = tree.nodes().iter().map(|node| format!("{} {}", node.uid, node.path)).collect();
    assert_eq!(
        of[..7],
        [
            "1 main",
            "2 Script::2",
            "3 KeepRunningUntilFailure::3",
            "4 round",
            "5 count",
            "6 there",
            "7 there/Sequence::7",
        ]
    );
    assert_eq!(tree.blackboards(), ["Main", "there", "GoTo::12"]);
    assert_eq!(client.blackboards(&names(&["nobody"])).unwrap(), Blackboards::default());
    let began_us = client.start_recording().unwrap();
    let found = client.statuses().unwrap();
    assert_eq!(found.len(), tree.nodes().len());
    assert!(found.iter().all(|(uid, status)| (1..=17).contains(uid) && *status == 0));
    let boards = client.blackboards(&names(&["Main", "there"])).unwrap().boards;
    assert_eq!(boards[0].0, "Main");
    let entry = |key: &str, value: Value| (key.to_owned(), BoardValue::Whole(value));
    assert_eq!(boards[0].1, [entry("goal", "dock".into()), entry("trips", 1.into())]);

    let (_, replies) = captured();
    let asked = replies.iter().filter(|(request, _)| request == "t").count();
    let received: Vec<LoggedTransition> = (0..asked).flat_map(|_| client.transitions(began_us).unwrap()).collect();
    // A logger in the program wrote the same transitions. Its times differ by the time at which the recording began.
    let logged = include_str!("captured/board.txt").lines().skip(1).map(|line| {
        let numbers: Vec<i64> = line.split(' ').map(|number| number.parse().unwrap()).collect();
        LoggedTransition { at_us: numbers[0], uid: numbers[1], status: numbers[2] }
    });
    let logged: Vec<LoggedTransition> = logged.collect();
    assert_eq!(received.len(), logged.len());
    let apart_us = received[0].at_us - logged[0].at_us;
    assert!(apart_us.abs() < 1000, "{apart_us}");
    for (received, logged) in received.iter().zip(&logged) {
        assert_eq!((received.uid, received.status), (logged.uid, logged.status));
        assert!((received.at_us - logged.at_us - apart_us).abs() <= 1, "{received:?}, {logged:?}");
        tree.change(*received).unwrap();
    }
}

/// The error of the first request to a program that sends this greeting, and then these bytes for every request.
fn refusal(greeting: &[u8], reply: &[u8]) -> GrootError {
    let reply = reply.to_owned();
    let (address, _) = program(greeting.to_owned(), move |stream, _| _ = stream.write_all(&reply));
    let asked = Client::connect(&address, TIMEOUT).and_then(|mut client| client.tree());
    asked.expect_err("the reply is invalid")
}

#[test]
fn every_invalid_reply_has_one_error_message() {
    let (greeting, mut replies) = captured();
    let (_, tree) = replies.pop_front().unwrap();
    let is_timeout = |error: GrootError| matches!(error, GrootError::Connection { source: ZmtpError::Timeout(_), .. });
    assert!(is_timeout(refusal(b"", b"")));
    assert!(is_timeout(refusal(&greeting[..70], b"")));
    assert!(is_timeout(refusal(&greeting, b"")));
    assert!(is_timeout(refusal(&greeting, &tree[..1000])));
    for (greeting, reply, why) in [
        (
            &b"HTTP/1.1 400 Bad Request\r\nContent-Type: text/plain\r\nContent-Length: 0\r\n\r\n"[..],
            &b""[..],
            "its greeting is another one",
        ),
        (&[&greeting[..10], b"\x02"].concat(), b"", "within"),
        (&[&greeting[..12], b"CURVE", &greeting[17..]].concat(), b"", "authentication or encryption"),
        (&[&greeting[..greeting.len() - 1], b"Q"].concat(), b"", "it is a socket REQ"),
        (&[&greeting[..64], b"\x04\x06\x05ERROR"].concat(), b"", "does not report that it is ready"),
        (&greeting, b"\x00\x00", "its reply has 0 parts"),
        (&greeting, b"\x01\x00\x00\x03abc", "not to the request"),
        (&greeting, b"\x08\x00", "begins with the byte 8"),
        (&greeting, b"\x02\xff\xff\xff\xff\xff\xff\xff\xff", "more than 67108864 bytes"),
        (&greeting, b"\x06\x00\x00\x00\x00\x00\x01\x00\x00", "more than 1024 bytes"),
        (&greeting, &b"\x01\x00".repeat(20), "more than 8 frames"),
        (&greeting, b"\x01\x00\x01\x05error\x00\x02no", "refuses: no"),
        (&greeting, b"\x01\x00\x01\x05error\x00\x02\xff\n", "refuses: \u{fffd}\\n"),
    ] {
        let error = refusal(greeting, reply).to_string();
        assert!(error.contains(why), "{why}: {error}");
    }
}

#[test]
fn the_end_of_a_connection_is_an_error() {
    let (greeting, _) = captured();
    let (address, _) = program(greeting, |stream, _| stream.shutdown(std::net::Shutdown::Both).unwrap());
    let error = Client::connect(&address, TIMEOUT).unwrap().tree().unwrap_err();
    assert_eq!(error.to_string(), format!("{address}: the connection was closed"));
}

#[test]
fn another_tree_is_noticed() {
    let (greeting, mut replies) = captured();
    let mut asked = 0;
    let (address, _) = program(greeting, move |stream, parts| {
        let mut reply = reply(&mut replies, &parts);
        asked += 1;
        reply[10] ^= u8::from(asked > 1);
        stream.write_all(&reply).unwrap();
    });
    let mut client = Client::connect(&address, TIMEOUT).unwrap();
    client.tree().unwrap();
    assert!(matches!(client.statuses(), Err(GrootError::OtherTree { .. })));
}

const TREE: &[u8] =
    br#"<root><BehaviorTree ID="Main" _fullpath=""><Inverter name="not" _uid="1"><Act name="act" _uid="2"/>
    </Inverter></BehaviorTree></root>"#;

/// The bytes of a reply to a request.
fn to(request: &[u8], body: &[u8]) -> Vec<u8> {
    let long = (body.len() as u64).to_be_bytes();
    [b"\x01\x00\x01\x16", request, b"0123456789abcdef\x02", &long, body].concat()
}

/// A program with the tree that sends the replies of each kind in turn, and repeats the last one.
fn scripted(answers: &[(u8, &[&[u8]])]) -> String {
    let mut answers: Vec<(u8, VecDeque<Vec<u8>>)> =
        answers.iter().map(|(kind, of)| (*kind, of.iter().map(|body| body.to_vec()).collect())).collect();
    answers.extend([(b'T', VecDeque::from([TREE.to_vec()])), (b'B', VecDeque::from([vec![0xc0]]))]);
    program(captured().0, move |stream, parts| {
        let (_, of) = answers.iter_mut().find(|(kind, _)| *kind == parts[1][1]).unwrap();
        let body = if of.len() > 1 { of.pop_front().unwrap() } else { of[0].clone() };
        let _ = stream.write_all(&to(&parts[1], &body));
    })
    .0
}

/// Transitions of nodes: time in microseconds, node, status.
fn transitions(all: &[(u8, u8, u8)]) -> Vec<u8> {
    all.iter().flat_map(|(at_us, uid, status)| [*at_us, 0, 0, 0, 0, 0, *uid, 0, *status]).collect()
}

const RUNNING: NodeStatus = NodeStatus::Answered(Status::Running);
const SUCCESS: NodeStatus = NodeStatus::Answered(Status::Success);

fn begin(address: &str, is_passive: bool) -> Result<(TreeWatch, TreeSnapshot), GrootError> {
    TreeWatch::begin(Client::connect(address, TIMEOUT)?, is_passive)
}

/// The next update.
fn next(watch: &mut TreeWatch) -> TreeUpdate {
    loop {
        if let Some(update) = watch.next_update().unwrap() {
            return update;
        }
    }
}

#[test]
fn a_watch_begins_with_all_earlier_changes() {
    // The second node succeeds after the statuses were sent, and is reset.
    let earlier = transitions(&[(5, 2, 1), (6, 2, 2), (7, 2, 0)]);
    let address = scripted(&[
        (b'r', &[b"1000"]),
        (b'S', &[&[1, 0, 1, 2, 0, 1]]),
        (b't', &[&earlier, &transitions(&[(8, 1, 2)])]),
    ]);
    let (mut watch, found) = begin(&address, false).unwrap();
    let nodes =
        vec![NodeSnapshot { status: RUNNING, last: RUNNING }, NodeSnapshot { status: NodeStatus::Idle, last: SUCCESS }];
    assert_eq!((found.at_us, found.nodes), (1007, nodes));
    assert_eq!(
        next(&mut watch),
        TreeUpdate::Change(StatusChange { at_us: 1008, node: 0, before: None, status: SUCCESS })
    );
}

#[test]
fn what_is_missing_is_noticed() {
    let idle: &[u8] = &[1, 0, 0, 2, 0, 0];
    let many = transitions(&[(1, 1, 1), (2, 1, 0)]).repeat(500);
    let twice = transitions(&[(1, 1, 1), (2, 1, 1)]);
    let back = transitions(&[(9, 1, 1), (1, 1, 0)]);
    for (received, why) in
        [(many, "more changed at once"), (twice, "another client has requested"), (back, "restarted the recording")]
    {
        let address =
            scripted(&[(b'r', &[b"1000"]), (b'S', &[idle, &[1, 0, 12, 2, 0, 1]]), (b't', &[b"", &received, b""])]);
        let (mut watch, _) = begin(&address, false).unwrap();
        loop {
            match next(&mut watch) {
                TreeUpdate::Missing { why: reason, snapshot } => {
                    assert!(reason.contains(why), "{reason}");
                    let nodes = [(NodeStatus::Idle, SUCCESS), (RUNNING, RUNNING)];
                    assert_eq!(snapshot.nodes, nodes.map(|(status, last)| NodeSnapshot { status, last }));
                    break;
                }
                TreeUpdate::Change(change) => assert_eq!(change.node, 0),
                other => panic!("{other:?}"),
            }
        }
    }
    // No transition is sent, but a node has another status: another client has received the transition.
    let address = scripted(&[(b'r', &[b"1000"]), (b'S', &[idle, &[1, 0, 2, 2, 0, 0]]), (b't', &[b""])]);
    let (mut watch, _) = begin(&address, false).unwrap();
    assert!(matches!(next(&mut watch), TreeUpdate::Missing { why, .. } if why.contains("another client")));
}

/// Another client receives the transitions, and then the watch ends.
#[test]
fn what_is_missing_at_the_end_is_noticed_too() {
    let idle: &[u8] = &[1, 0, 0, 2, 0, 0];
    let address = scripted(&[(b'r', &[b"1000", b""]), (b'S', &[idle, &[1, 0, 13, 2, 0, 0]]), (b't', &[b""])]);
    let (mut watch, _) = begin(&address, false).unwrap();
    let last = watch.end().unwrap();
    assert!(matches!(&last[..], [TreeUpdate::Missing { why, .. }] if why.contains("another client")), "{last:?}");
}

/// MessagePack of {"Main": {key: value, …}}.
fn board(entries: &[(&str, Value)]) -> Vec<u8> {
    let entries = entries.iter().map(|(key, value)| ((*key).into(), value.clone())).collect();
    let mut bytes = Vec::new();
    rmpv::encode::write_value(&mut bytes, &Value::Map(vec![("Main".into(), Value::Map(entries))])).unwrap();
    bytes
}

#[test]
fn long_values_and_many_values_are_kept_only_in_part() {
    let read = |entries: &[(&str, Value)]| {
        let bytes = board(entries);
        let address = scripted(&[(b'B', &[&bytes])]);
        let mut client = Client::connect(&address, TIMEOUT).unwrap();
        client.blackboards(&names(&["Main"])).unwrap()
    };
    let map = Value::Array(vec![0.into(); 3_000_000]);
    let Blackboards { boards, left_out } =
        read(&[("map", map), ("image", Value::Binary(vec![0; 5000])), ("goal", "dock".into())]);
    let entry = |key: &str, value: BoardValue| (key.to_owned(), value);
    let expected = [
        entry("map", BoardValue::Long(3_000_005)),
        entry("image", BoardValue::Long(5003)),
        entry("goal", BoardValue::Whole("dock".into())),
    ];
    assert_eq!((&boards[0].1[..], left_out), (&expected[..], 0));
    let keys: Vec<String> = (0..2000).map(|number| format!("key {number}")).collect();
    let many: Vec<(&str, Value)> = keys.iter().map(|key| (key.as_str(), "x".repeat(1000).into())).collect();
    let Blackboards { boards, left_out } = read(&many);
    assert!((900..1000).contains(&boards[0].1.len()), "{}", boards[0].1.len());
    assert_eq!(boards[0].1.len() as u64 + left_out, 2000);
}

#[test]
fn blackboards_that_are_no_longer_read_are_removed() {
    let full = board(&[("goal", "dock".into())]);
    let address = scripted(&[(b'r', &[b"1000"]), (b'S', &[&[1, 0, 0, 2, 0, 0]]), (b't', &[b""]), (b'B', &[&full])]);
    let (mut watch, _) = begin(&address, false).unwrap();
    assert!(matches!(next(&mut watch), TreeUpdate::Blackboards(of) if of.boards.len() == 1));
    watch.read_every(None);
    assert_eq!(watch.next_update().unwrap(), Some(TreeUpdate::Blackboards(Blackboards::default())));
    assert_eq!(watch.next_update().unwrap(), None);
}

/// Any value of MessagePack, in any of its forms.
fn value() -> impl Strategy<Value = Value> {
    let numbers = prop_oneof![
        any::<i64>().prop_map(Value::from),
        any::<u64>().prop_map(Value::from),
        (-200..200_i64).prop_map(Value::from),
        any::<f32>().prop_map(Value::from),
        any::<f64>().prop_map(Value::from),
    ];
    let bytes =
        prop_oneof![prop::collection::vec(any::<u8>(), 0..40), (200..70_000_usize).prop_map(|length| vec![7; length]),];
    let leaf = prop_oneof![
        numbers,
        Just(Value::Nil),
        any::<bool>().prop_map(Value::from),
        "[a-z]{0,40}".prop_map(Value::from),
        bytes.clone().prop_map(Value::Binary),
        (any::<i8>(), bytes).prop_map(|(kind, bytes)| Value::Ext(kind, bytes)),
        (0..20_u32, any::<u8>()).prop_map(|(power, byte)| Value::Ext(1, vec![byte; 1 << (power % 5)])),
    ];
    leaf.prop_recursive(3, 60, 20, |inner| {
        prop_oneof![
            prop::collection::vec(inner.clone(), 0..20).prop_map(Value::Array),
            prop::collection::vec((inner.clone(), inner), 0..20).prop_map(Value::Map),
        ]
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn every_value_is_kept_or_measured(values in prop::collection::vec(value(), 0..5)) {
        let keys = ["a", "b", "c", "d", "e"];
        let bytes = board(&keys.into_iter().zip(values.clone()).collect::<Vec<_>>());
        let address = scripted(&[(b'B', &[&bytes])]);
        let mut client = Client::connect(&address, TIMEOUT).unwrap();
        let read = client.blackboards(&names(&["Main"])).unwrap();
        for (value, (_, read)) in values.iter().zip(&read.boards[0].1) {
            let mut bytes = Vec::new();
            rmpv::encode::write_value(&mut bytes, value).unwrap();
            match read {
                BoardValue::Whole(whole) => prop_assert_eq!(format!("{whole}"), format!("{value}")),
                BoardValue::Long(length) => prop_assert!(*length == bytes.len() && bytes.len() > 4096),
            }
        }
    }
}

#[test]
fn a_passive_watch_finds_changes_between_statuses() {
    let address = scripted(&[(b'S', &[&[1, 0, 0, 2, 0, 0], &[1, 0, 1, 2, 0, 12], &[1, 0, 11, 2, 0, 12]])]);
    let (mut watch, found) = begin(&address, true).unwrap();
    assert!(found.nodes.iter().all(|node| node.status == NodeStatus::Idle));
    let seen: Vec<(usize, NodeStatus)> = (0..4)
        .map(|_| match next(&mut watch) {
            TreeUpdate::Change(change) => (change.node, change.status),
            other => panic!("{other:?}"),
        })
        .collect();
    assert_eq!(seen, [(0, RUNNING), (1, SUCCESS), (1, NodeStatus::Idle), (0, NodeStatus::Idle)]);
}

#[test]
fn invalid_statuses_are_refused() {
    for (statuses, why) in [
        (&[1, 0, 0][..], "not report the statuses of all nodes"),
        (&[1, 0, 0, 2, 0, 5], "no status with the number 5"),
        (&[1, 0, 0, 2, 0, 10], "no status with the number 10"),
        (&[1, 0, 0, 2, 0, 21], "no status with the number 21"),
        (&[1, 0, 0, 9, 0, 1], "no node with the number 9"),
        (&[1, 0], "not three bytes"),
    ] {
        let address = scripted(&[(b'r', &[b"1000"]), (b'S', &[statuses]), (b't', &[b""])]);
        let error = begin(&address, false).unwrap_err().to_string();
        assert!(error.contains(why), "{error}");
    }
}

proptest! {
    #[test]
    fn no_damage_to_a_reply_causes_a_crash(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..20),
        which in any::<prop::sample::Index>(),
    ) {
        let (greeting, replies) = captured();
        let (request, reply) = which.get(&Vec::from(replies)).clone();
        let (mut reply, length) = (reply.clone(), reply.len());
        changes.iter().for_each(|(at, byte)| reply[at.index(length)] = *byte);
        let (address, serving) = program(greeting, move |stream, parts| {
            if reply.len() > 10 {
                reply[6..10].copy_from_slice(&parts[1][2..6]);
            }
            let _ = stream.write_all(&reply);
            let _ = stream.shutdown(std::net::Shutdown::Write);
        });
        let mut client = Client::connect(&address, TIMEOUT).unwrap();
        match request.as_bytes()[0] {
            b'S' => drop(client.statuses()),
            b'B' => drop(client.blackboards(&names(&["Main"]))),
            b't' => drop(client.transitions(i64::MAX)),
            b'r' => drop(client.start_recording()),
            _ => drop(client.tree()),
        }
        drop(client);
        serving.join().unwrap();
    }
}
