//! A client and what programs answer: one with BehaviorTree.CPP 4.10, whose every byte was captured, and hostile ones.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::collections::VecDeque;
use std::io::{Read as _, Write as _};
use std::net::{TcpListener, TcpStream};
use std::thread::JoinHandle;
use std::time::Duration;

use groot::{Client, GrootError, ZmtpError};
use proptest::prelude::*;
use tree_logs::LoggedTransition;

const PATIENCE: Duration = Duration::from_millis(500);

/// What the program said first, and then what it was asked and replied.
fn captured() -> (Vec<u8>, VecDeque<(String, Vec<u8>)>) {
    let mut lines = include_str!("captured/board.wire").lines();
    let replies = |line: &str| {
        let (request, reply) = line.rsplit_once(' ').unwrap();
        (request.to_owned(), bytes(reply))
    };
    (bytes(lines.next().unwrap()), lines.map(replies).collect())
}

fn bytes(hexadecimal: &str) -> Vec<u8> {
    let digits = hexadecimal.as_bytes().chunks(2);
    digits.map(|two| u8::from_str_radix(std::str::from_utf8(two).unwrap(), 16).unwrap()).collect()
}

/// A program that answers one client with `answer`, to which it passes each request.
fn program(
    greeting: Vec<u8>,
    mut answer: impl FnMut(&mut TcpStream, Vec<Vec<u8>>) + Send + 'static,
) -> (String, JoinHandle<()>) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let serving = std::thread::spawn(move || {
        let (mut stream, _) = listener.accept().unwrap();
        let _ = stream.write_all(&greeting);
        // A greeting, and a command that says that it is ready.
        if stream.read_exact(&mut [0; 64]).is_err() || frame(&mut stream).is_none() {
            return;
        }
        let mut parts = Vec::new();
        while let Some((flags, body)) = frame(&mut stream) {
            parts.push(body);
            if flags & 1 == 0 {
                answer(&mut stream, std::mem::take(&mut parts));
            }
        }
    });
    (address, serving)
}

/// A short frame: its flags, and what it has.
fn frame(stream: &mut TcpStream) -> Option<(u8, Vec<u8>)> {
    let mut head = [0; 2];
    stream.read_exact(&mut head).ok()?;
    let mut body = vec![0; usize::from(head[1])];
    stream.read_exact(&mut body).ok()?;
    Some((head[0], body))
}

/// The next reply that was captured to a request, with the request's own number.
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

/// The program whose answers were captured.
fn replayed() -> String {
    let (greeting, mut replies) = captured();
    program(greeting, move |stream, parts| stream.write_all(&reply(&mut replies, &parts)).unwrap()).0
}

fn names(names: &[&str]) -> Vec<String> {
    names.iter().map(ToString::to_string).collect()
}

#[test]
fn all_that_a_program_with_behaviortree_cpp_told_is_read() {
    let mut client = Client::connect(&replayed(), PATIENCE).unwrap();
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
    assert_eq!(client.blackboards(&names(&["nobody"])).unwrap(), []);
    let began_us = client.start_recording().unwrap();
    let found = client.statuses().unwrap();
    assert_eq!(found.len(), tree.nodes().len());
    assert!(found.iter().all(|(uid, status)| (1..=17).contains(uid) && *status == 0));
    let boards = client.blackboards(&names(&["Main", "there"])).unwrap();
    let entries = |of: &[(&str, &str)]| -> Vec<(String, String)> {
        of.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect()
    };
    assert_eq!(boards[0], ("Main".to_owned(), entries(&[("goal", "\"dock\""), ("trips", "1")])));

    let (_, replies) = captured();
    let asked = replies.iter().filter(|(request, _)| request == "t").count();
    let told: Vec<LoggedTransition> = (0..asked).flat_map(|_| client.transitions(began_us).unwrap()).collect();
    // A logger inside the program heard the same, with times that differ by that at which the recording began.
    let heard = include_str!("captured/board.txt").lines().skip(1).map(|line| {
        let numbers: Vec<i64> = line.split(' ').map(|number| number.parse().unwrap()).collect();
        LoggedTransition { at_us: numbers[0], uid: numbers[1], status: numbers[2] }
    });
    let heard: Vec<LoggedTransition> = heard.collect();
    assert_eq!(told.len(), heard.len());
    let apart_us = told[0].at_us - heard[0].at_us;
    assert!(apart_us.abs() < 1000, "{apart_us}");
    for (told, heard) in told.iter().zip(&heard) {
        assert_eq!((told.uid, told.status), (heard.uid, heard.status));
        assert!((told.at_us - heard.at_us - apart_us).abs() <= 1, "{told:?}, {heard:?}");
        tree.change(*told).unwrap();
    }
}

/// Why the first question to a program that says these bytes first, and then these to every request, has no answer.
fn refusal(greeting: &[u8], said: &[u8]) -> GrootError {
    let said = said.to_owned();
    let (address, _) = program(greeting.to_owned(), move |stream, _| _ = stream.write_all(&said));
    let asked = Client::connect(&address, PATIENCE).and_then(|mut client| client.tree());
    asked.expect_err("this is no answer")
}

#[test]
fn whatever_a_stranger_says_there_is_one_message() {
    let (greeting, mut replies) = captured();
    let (_, tree) = replies.pop_front().unwrap();
    let silent = |error: GrootError| matches!(error, GrootError::Connection { source: ZmtpError::Silent(_), .. });
    assert!(silent(refusal(b"", b"")));
    assert!(silent(refusal(&greeting[..70], b"")));
    assert!(silent(refusal(&greeting, b"")));
    assert!(silent(refusal(&greeting, &tree[..1000])));
    for (greeting, said, why) in [
        (
            &b"HTTP/1.1 400 Bad Request\r\nContent-Type: text/plain\r\nContent-Length: 0\r\n\r\n"[..],
            &b""[..],
            "its greeting is another one",
        ),
        (&[&greeting[..10], b"\x02"].concat(), b"", "within"),
        (&[&greeting[..12], b"CURVE", &greeting[17..]].concat(), b"", "authentication or encryption"),
        (&[&greeting[..greeting.len() - 1], b"Q"].concat(), b"", "it is a socket REQ"),
        (&[&greeting[..64], b"\x04\x06\x05ERROR"].concat(), b"", "does not say that it is ready"),
        (&greeting, b"\x00\x00", "its reply has 0 parts"),
        (&greeting, b"\x01\x00\x00\x03abc", "not to what was asked"),
        (&greeting, b"\x08\x00", "begins with the byte 8"),
        (&greeting, b"\x02\xff\xff\xff\xff\xff\xff\xff\xff", "more than 67108864 bytes"),
        (&greeting, b"\x06\x00\x00\x00\x00\x00\x01\x00\x00", "more than 1024 bytes"),
        (&greeting, &b"\x01\x00".repeat(20), "more than 8 frames"),
        (&greeting, b"\x01\x00\x01\x05error\x00\x02no", "refuses: no"),
        (&greeting, b"\x01\x00\x01\x05error\x00\x02\xff\n", "refuses: \u{fffd}\\n"),
    ] {
        let error = refusal(greeting, said).to_string();
        assert!(error.contains(why), "{why}: {error}");
    }
}

#[test]
fn a_connection_that_ends_says_so() {
    let (greeting, _) = captured();
    let (address, _) = program(greeting, |stream, _| stream.shutdown(std::net::Shutdown::Both).unwrap());
    let error = Client::connect(&address, PATIENCE).unwrap().tree().unwrap_err();
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
    let mut client = Client::connect(&address, PATIENCE).unwrap();
    client.tree().unwrap();
    assert!(matches!(client.statuses(), Err(GrootError::OtherTree { .. })));
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
        let mut client = Client::connect(&address, PATIENCE).unwrap();
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
