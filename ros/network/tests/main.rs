//! Bridges against servers that these tests implement: correct ones, wrong ones, hostile ones, and none at all.
//! `foreign.py` starts servers that others have written.

use std::collections::BTreeSet;
use std::net::{TcpListener, TcpStream};
use std::thread::JoinHandle;

use bags::{Received, Source as _};
use network::{Bridge, Error, Live as _};
use proptest::prelude::*;
use serde_json::{Value, json};
use tungstenite::handshake::server::{ErrorResponse, Request, Response};
use tungstenite::{Message, WebSocket};

/// A server that sends these messages to one client, then waits until the client leaves. Returns the text messages of
/// the client.
fn server(messages: Vec<Message>) -> (String, JoinHandle<Vec<Value>>) {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
    let address = format!("ws://{}", listener.local_addr().expect("an address"));
    let served = std::thread::spawn(move || {
        let mut socket = accepted(listener.accept().expect("a client").0);
        for message in messages {
            if socket.send(message).is_err() {
                break;
            }
        }
        let mut requests = Vec::new();
        while let Ok(message) = socket.read() {
            requests.extend(message.to_text().ok().and_then(|text| serde_json::from_str(text).ok()));
        }
        requests
    });
    (address, served)
}

#[expect(clippy::result_large_err, reason = "tungstenite's own type")]
fn accepted(stream: TcpStream) -> WebSocket<TcpStream> {
    let choose = |request: &Request, mut response: Response| -> Result<Response, ErrorResponse> {
        assert_eq!(request.headers()["sec-websocket-protocol"], "foxglove.sdk.v1, foxglove.websocket.v1");
        let name = "foxglove.websocket.v1".parse().expect("a header");
        response.headers_mut().insert("sec-websocket-protocol", name);
        Ok(response)
    };
    tungstenite::accept_hdr(stream, choose).expect("a handshake")
}

fn text(value: &Value) -> Message {
    Message::text(value.to_string())
}

fn info() -> Message {
    text(&json!({ "op": "serverInfo", "name": "a robot", "capabilities": ["time"] }))
}

fn channel(id: u64, topic: &str) -> Value {
    json!({ "id": id, "topic": topic, "encoding": "cdr", "schemaName": "std_msgs/msg/Bool", "schema": "bool data" })
}

fn advertise(channels: &[Value]) -> Message {
    text(&json!({ "op": "advertise", "channels": channels }))
}

fn data(subscription: u32, sent_ns: u64, body: &[u8]) -> Message {
    Message::binary([&[1], &subscription.to_le_bytes()[..], &sent_ns.to_le_bytes(), body].concat())
}

/// The messages that are received until the connection breaks: their topics, stamps and bodies.
fn messages(bridge: &mut Bridge) -> Vec<(String, i64, Vec<u8>)> {
    let all = messages_and_gaps(bridge).into_iter();
    all.filter_map(|(topic, message)| message.map(|(sent_ns, body)| (topic, sent_ns, body))).collect()
}

/// A topic, and the stamp and body of its message. None if messages are missing.
type MessageOrGap = (String, Option<(i64, Vec<u8>)>);

/// The same, with the gaps between them.
fn messages_and_gaps(bridge: &mut Bridge) -> Vec<MessageOrGap> {
    let (mut all, mut body) = (Vec::new(), Vec::new());
    while !bridge.lost().last().is_some_and(|lost| lost.contains("broke at")) {
        let (topic, message) = match bridge.receive(&mut body) {
            Received::Message(head) => (head.topic, Some((head.publish_ns, body.clone()))),
            Received::Lost { topic, count: None, .. } => (topic, None),
            _ => continue,
        };
        all.push((bridge.survey().topics[topic].name.clone(), message));
    }
    all
}

#[test]
fn the_wanted_topics_are_subscribed_to_and_received() {
    let sent = vec![
        info(),
        advertise(&[channel(7, "/stop"), channel(9, "/image")]),
        data(0, 5, &[0, 1, 0, 0, 1]),
        // A node was started again: its topic has another channel.
        text(&json!({ "op": "unadvertise", "channelIds": [7] })),
        data(0, 6, &[2]),
        advertise(&[channel(11, "/stop")]),
        data(0, 7, &[3]),
        // These were not subscribed to.
        data(5, 8, &[4]),
        Message::binary(vec![2, 0, 0, 0, 0, 0, 0, 0, 0]),
        text(&json!({ "op": "connectionGraphUpdate", "publishedTopics": [] })),
        Message::Close(None),
    ];
    let (address, served) = server(sent);
    let wanted = BTreeSet::from(["/stop".to_owned()]);
    let mut bridge = Bridge::connect(&address, Some(wanted)).expect("a bridge");
    assert_eq!((bridge.name(), bridge.survey().topics.len()), ("a robot", 1));
    let expected = [Some((5, vec![0, 1, 0, 0, 1])), None, Some((7, vec![3]))];
    assert_eq!(messages_and_gaps(&mut bridge), expected.map(|message| ("/stop".to_owned(), message)));
    assert_eq!(bridge.lost().len(), 1, "{:?}", bridge.lost());
    assert!(bridge.notes()[1].contains("the bridge no longer offers it"), "{:?}", bridge.notes());
    drop(bridge);
    let requests = served.join().expect("a server that ends");
    let subscriptions = |id: u64| json!({ "op": "subscribe", "subscriptions": [{ "id": 0, "channelId": id }] });
    assert_eq!(requests, [subscriptions(7), subscriptions(11)]);
}

/// Messages on a topic are missing before the bridge offers it, and after the bridge has withdrawn it. At first, a
/// bridge may offer its topics in several parts.
#[test]
fn messages_are_missing_while_a_bridge_does_not_offer_their_topic() {
    let unadvertise = |id: u64| text(&json!({ "op": "unadvertise", "channelIds": [id] }));
    let withdrawn = [data(0, 5, &[1]), unadvertise(7)];
    let late = [advertise(&[channel(9, "/late")]), data(1, 6, &[2])];
    let gap = |topic: &str| (topic.to_owned(), None);
    let message = |topic: &str, sent_ns, body| (topic.to_owned(), Some((sent_ns, vec![body])));
    for (shown, first, later, expected) in [
        ("", vec![], withdrawn.to_vec(), vec![message("/stop", 5, 1), gap("/stop")]),
        ("/stop", vec![], withdrawn.to_vec(), vec![message("/stop", 5, 1)]),
        ("", vec![], late.to_vec(), vec![gap("/late"), message("/late", 6, 2)]),
        ("/late", vec![], late.to_vec(), vec![message("/late", 6, 2)]),
        ("", late[..1].to_vec(), late[1..].to_vec(), vec![message("/late", 6, 2)]),
        // One topic stays withdrawn. The other is not affected.
        ("", late[..1].to_vec(), [&[unadvertise(7)], &late[1..]].concat(), vec![gap("/stop"), message("/late", 6, 2)]),
    ] {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
        let address = format!("ws://{}", listener.local_addr().expect("an address"));
        let served = std::thread::spawn(move || {
            let mut socket = accepted(listener.accept().expect("a client").0);
            let first = [vec![info(), advertise(&[channel(7, "/stop")])], first].concat();
            first.into_iter().for_each(|message| socket.send(message).expect("a client"));
            while !socket.read().expect("a client").is_ping() {}
            socket.flush().expect("a client");
            later.into_iter().for_each(|message| socket.send(message).expect("a client"));
            socket.close(None).expect("a client");
            while socket.read().is_ok() {}
        });
        let mut bridge = Bridge::connect(&address, None).expect("a bridge");
        bridge.only_show(BTreeSet::from([shown.to_owned()]));
        bridge.begin().expect("a bridge");
        assert_eq!(messages_and_gaps(&mut bridge), expected);
        let gaps = expected.iter().filter(|(_, message)| message.is_none()).count();
        assert_eq!(bridge.notes().len(), 1 + gaps, "{:?}", bridge.notes());
        served.join().expect("a server that ends");
    }
}

/// Either the bridge does not answer any more, or its messages were not received.
#[test]
#[expect(clippy::disallowed_methods, reason = "a server is silent in real time")]
fn messages_are_lost_if_the_bridge_did_not_answer_before_the_end() {
    let later = || std::time::Instant::now() + std::time::Duration::from_secs(2);
    let first = || vec![info(), advertise(&[channel(1, "/a")])];
    // It answers pings until the end.
    let (address, served) = server(first());
    let mut bridge = Bridge::connect(&address, None).expect("a bridge");
    let receive = |bridge: &mut Bridge| {
        let until = later();
        while std::time::Instant::now() < until {
            bridge.receive(&mut Vec::new());
        }
    };
    receive(&mut bridge);
    bridge.end();
    assert_eq!(bridge.lost(), [""; 0]);
    served.join().expect("a server that ends");
    for is_received in [true, false] {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
        let address = format!("ws://{}", listener.local_addr().expect("an address"));
        let served = std::thread::spawn(move || {
            let mut socket = accepted(listener.accept().expect("a client").0);
            first().into_iter().for_each(|message| socket.send(message).expect("a client"));
            // It answers the first ping only.
            while !socket.read().is_ok_and(|message| message.is_ping()) {}
            socket.flush().expect("a client");
            socket
        });
        let mut bridge = Bridge::connect(&address, None).expect("a bridge");
        while !matches!(bridge.receive(&mut Vec::new()), Received::ClockAdvanced(_)) {}
        if is_received {
            receive(&mut bridge);
        } else {
            std::thread::sleep(std::time::Duration::from_secs(2));
        }
        assert_eq!(bridge.lost(), [""; 0]);
        bridge.end();
        assert!(bridge.lost()[0].starts_with("nothing is known of ws://"), "{:?}", bridge.lost());
        drop(served.join());
    }
}

#[test]
fn nodes_and_services_are_reported_if_all_topics_are_wanted() {
    let sent = [
        text(&json!({ "op": "serverInfo", "name": "a robot", "capabilities": ["connectionGraph"] })),
        advertise(&[]),
        text(
            &json!({ "op": "advertiseServices", "services": [{ "id": 1, "name": "/dock", "type": "std_srvs/srv/Trigger" }] }),
        ),
        text(&json!({
            "op": "connectionGraphUpdate",
            "publishedTopics": [{ "name": "/scan", "publisherIds": ["/laser"] }, { "name": "/go/_action/status", "publisherIds": [] }],
            "subscribedTopics": [{ "name": "/scan", "subscriberIds": ["/amcl", "/laser"] }],
            "advertisedServices": [{ "name": "/dock", "providerIds": ["/dock_server"] }, { "name": "/x", "providerIds": [] }, { "name": "/go/_action/send_goal", "providerIds": [] }],
        })),
        Message::Close(None),
    ];
    for (wanted, has_requests) in [(None, true), (Some(BTreeSet::new()), false)] {
        let (address, served) = server(sent.to_vec());
        let mut bridge = Bridge::connect(&address, wanted).expect("a bridge");
        messages(&mut bridge);
        let robot = bridge.robot().clone();
        assert_eq!(robot.nodes.iter().collect::<Vec<_>>(), ["/amcl", "/dock_server", "/laser"]);
        assert_eq!(robot.services["/dock"].as_deref(), Some("std_srvs/srv/Trigger"));
        assert_eq!((&robot.services["/x"], robot.services.len()), (&None, 2));
        assert_eq!(robot.actions.keys().collect::<Vec<_>>(), ["/go"]);
        drop(bridge);
        let requests = served.join().expect("a server that ends");
        assert_eq!(!requests.is_empty(), has_requests, "{requests:?}");
    }
}

/// The server never reads and so never answers a ping, as if the network were gone.
#[test]
fn the_clock_advances_only_if_the_bridge_answers() {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
    let address = format!("ws://{}", listener.local_addr().expect("an address"));
    let served = std::thread::spawn(move || {
        let mut socket = accepted(listener.accept().expect("a client").0);
        socket.send(info()).and_then(|()| socket.send(advertise(&[channel(1, "/a")]))).expect("a client");
        socket
    });
    let mut bridge = Bridge::connect(&address, None).expect("a bridge");
    let mut socket = served.join().expect("a server");
    let mut body = Vec::new();
    while bridge.lost().is_empty() {
        assert_eq!(bridge.receive(&mut body), Received::Idle);
    }
    assert!(bridge.lost()[0].contains("it has sent nothing for 5 s"), "{:?}", bridge.lost());
    // A server that reads answers.
    drop(socket.read());
    let (address, served) = server(vec![info(), advertise(&[channel(1, "/a")])]);
    let mut bridge = Bridge::connect(&address, None).expect("a bridge");
    let mut times = Vec::new();
    while times.len() < 3 {
        match bridge.receive(&mut body) {
            Received::ClockAdvanced(at_ns) => times.push(at_ns),
            received => assert_eq!(received, Received::Idle),
        }
    }
    assert!(times.is_sorted(), "{times:?}");
    bridge.end();
    served.join().expect("a server that ends");
}

#[test]
#[expect(clippy::disallowed_methods, reason = "a process is paused in real time")]
fn messages_that_arrive_while_the_process_is_paused_are_late() {
    let (address, served) = server(vec![info(), advertise(&[channel(7, "/a")]), data(0, 1, &[1]), data(0, 2, &[2])]);
    let mut bridge = Bridge::connect(&address, None).expect("a bridge");
    bridge.begin().expect("the same bridge");
    std::thread::sleep(std::time::Duration::from_millis(400));
    let (mut received, mut body) = (Vec::new(), Vec::new());
    while received.len() < 4 {
        received.extend(
            Some(bridge.receive(&mut body)).filter(|it| !matches!(it, Received::Idle | Received::ClockAdvanced(_))),
        );
    }
    let [Received::Message(_), Received::Late { since_ns, .. }, Received::Message(head), Received::Late { .. }] =
        received[..]
    else {
        panic!("{received:?}")
    };
    assert!(head.log_ns - since_ns > 250_000_000, "{received:?}");
    bridge.end();
    served.join().expect("a server that ends");
    // A message that is read in time is not late.
    let (address, served) = server(vec![info(), advertise(&[channel(7, "/a")]), data(0, 1, &[1])]);
    let mut bridge = Bridge::connect(&address, None).expect("a bridge");
    let mut received = Vec::new();
    while !received.iter().any(|it| matches!(it, Received::ClockAdvanced(_))) {
        received.push(bridge.receive(&mut body));
    }
    assert!(received.iter().any(|it| matches!(it, Received::Message(_))), "{received:?}");
    assert!(!received.iter().any(|it| matches!(it, Received::Late { .. })), "{received:?}");
    bridge.end();
    served.join().expect("a server that ends");
}

#[test]
fn a_full_bridge_or_one_that_reports_an_error_loses_messages() {
    let status = |level: u8, message: &str| text(&json!({ "op": "status", "level": level, "message": message }));
    let harmless = [status(0, "hello"), status(1, "no definition of x/msg/Y")];
    for loss in [status(1, "Send buffer limit reached"), status(2, "subscription failed")] {
        let rest = [advertise(&[channel(1, "/a")]), data(0, 1, &[1]), loss, Message::Close(None)];
        let all = [&[info()][..], &harmless, &rest].concat();
        let (address, _) = server(all);
        let mut bridge = Bridge::connect(&address, None).expect("a bridge");
        assert_eq!(messages(&mut bridge).len(), 1);
        assert!(bridge.lost()[0].starts_with("the bridge reports: S") || bridge.lost()[0].ends_with("failed"));
    }
}

#[test]
fn implausibly_large_advertisements_end_the_connection() {
    let many: Vec<Value> = (0..10_001).map(|id| channel(id, &format!("/{id}"))).collect();
    let again: Vec<Value> = (0..10_001).map(|id| channel(id, "/same")).collect();
    let long = json!({ "id": 1, "topic": "/a", "encoding": "cdr", "schemaName": "x".repeat(1 << 20), "schema": "" });
    let big = |id: u64| json!({ "id": id, "topic": "/a", "encoding": "cdr", "schemaName": format!("p/msg/T{id}"), "schema": " ".repeat(40 << 20) });
    for sent in [vec![advertise(&many)], vec![advertise(&again)], vec![advertise(&[big(1)]), advertise(&[big(2)])]] {
        let (address, _) = server([vec![info(), advertise(&[channel(1, "/b")])], sent].concat());
        let mut bridge = Bridge::connect(&address, None).expect("a bridge");
        assert_eq!(messages(&mut bridge), []);
        assert!(bridge.lost()[0].contains("it advertises more than 10,000 topics"), "{:?}", bridge.lost());
    }
    let (address, _) = server(vec![info(), advertise(&[long]), Message::Close(None)]);
    assert!(Bridge::connect(&address, None).is_ok_and(|bridge| bridge.survey().topics.len() == 1));
}

#[test]
fn only_bridges_are_accepted() {
    let refused = |address: &str| Bridge::connect(address, None).err().expect("an error");
    for address in ["", "robot", "robot:8765", "http://robot:8765", "ws://"] {
        assert!(matches!(refused(address), Error::Address(_)), "{address}");
    }
    assert!(matches!(refused("wss://robot:8765"), Error::Encrypted(_)));
    // Nothing listens at the address, or another kind of server does.
    let free = TcpListener::bind("127.0.0.1:0").and_then(|listener| listener.local_addr()).expect("a free port");
    assert!(refused(&format!("ws://{free}")).to_string().contains("the connection is refused"));
    for sent in [vec![Message::text("{}")], vec![Message::text("hello")], vec![Message::Close(None)]] {
        let (address, _) = server(sent);
        assert!(matches!(refused(&address), Error::Silent { .. }));
    }
    let web = TcpListener::bind("127.0.0.1:0").expect("a free port");
    let address = format!("ws://{}", web.local_addr().expect("an address"));
    let served = std::thread::spawn(move || {
        let (mut stream, _) = web.accept().expect("a client");
        std::io::Write::write_all(&mut stream, b"HTTP/1.1 200 OK\r\ncontent-length: 2\r\n\r\nhi").expect("a client");
    });
    assert!(matches!(refused(&address), Error::Silent { .. }));
    served.join().expect("a server that ends");
}

/// A frame that a server may send, right or wrong.
fn frame() -> impl Strategy<Value = Message> {
    let texts = [
        json!({ "op": "advertise", "channels": [channel(1, "/a"), channel(2, "/b")] }).to_string(),
        json!({ "op": "unadvertise", "channelIds": [1] }).to_string(),
        json!({ "op": "status", "level": 1, "message": "hm" }).to_string(),
        info().to_string(),
    ];
    let mutated = (0..texts.len(), any::<prop::sample::Index>(), any::<char>()).prop_map(move |(which, at, by)| {
        let mut letters: Vec<char> = texts[which].chars().collect();
        let at = at.index(letters.len());
        letters[at] = by;
        Message::text(letters.into_iter().collect::<String>())
    });
    let bytes = prop::collection::vec(any::<u8>(), 0..40);
    prop_oneof![
        mutated,
        bytes.clone().prop_map(Message::binary),
        (0..3_u32, any::<u64>(), bytes).prop_map(|(subscription, sent_ns, body)| data(subscription, sent_ns, &body)),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn any_frames_are_tolerated(frames in prop::collection::vec(frame(), 0..60)) {
        let first = vec![info(), advertise(&[channel(1, "/a")])];
        let (address, served) = server([first, frames, vec![Message::Close(None)]].concat());
        let mut bridge = Bridge::connect(&address, None).expect("a bridge");
        messages(&mut bridge);
        drop(bridge);
        prop_assert!(served.join().is_ok());
    }
}
