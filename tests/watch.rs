//! The binary judges properties beside a robot that runs, by its bridge. `ros/network/tests/foreign.py` does the same
//! with the bridges of others.

use std::collections::BTreeMap;
use std::io::{BufRead as _, BufReader};
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread::JoinHandle;

use serde_json::{Value, json};
use tempfile::TempDir;
use tungstenite::handshake::server::{ErrorResponse, Request, Response};
use tungstenite::{Message, WebSocket};

use crate::live::browser::{Page, Socket, until};
use crate::localize_command::{bag, log};
use crate::steward::{binary, refusal, steward};

/// A folder with a mapping and properties.
fn files() -> (TempDir, String, String) {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).expect("room for a file");
        path.to_str().expect("a path in UTF-8").to_owned()
    };
    let entry = |topic: &str, from: &str, field: &str| {
        format!("[[messages]]\ntopic = \"{topic}\"\nfrom = \"{from}\"\nto = \"base\"\nfields = {{ x = \"{field}\" }}\n")
    };
    let mapping = format!(
        "tick_s = 0.1\nreorder_s = 0\n{}{}",
        entry("/charge", "battery", "data"),
        entry("/stop", "operator", "data")
    );
    let properties = "property charged := always (battery, base, m.x >= 20)\n\
        property answered := always ((operator, base, m.x = true) implies time_until (battery, base, true) <= 0.3 s)\n";
    let (mapping, properties) = (write("robot.toml", &mapping), write("safety.scope", properties));
    (folder, mapping, properties)
}

/// A bridge of a robot whose charge falls to 19.5 with its third message; then it is stopped, and says nothing more.
fn bridge(clients: usize) -> (String, JoinHandle<()>) {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
    let address = format!("ws://{}", listener.local_addr().expect("an address"));
    let serve = move || {
        for _ in 0..clients {
            let mut socket = accepted(listener.accept().expect("a client").0);
            let channel = |id: u64, topic: &str, kind: &str, schema: &str| json!({ "id": id, "topic": topic, "encoding": "cdr", "schemaName": kind, "schema": schema });
            let channels = [
                channel(1, "/charge", "std_msgs/msg/Float32", "float32 data"),
                channel(2, "/stop", "std_msgs/msg/Bool", "bool data"),
            ];
            say(&mut socket, &json!({ "op": "serverInfo", "name": "a robot" }));
            say(&mut socket, &json!({ "op": "advertise", "channels": channels }));
            let asked = socket.read().expect("a request").into_text().expect("a text");
            assert!(asked.contains("subscribe"), "{asked}");
            for (topic, body) in [30.0, 25.0, 19.5].map(|charge: f32| (0_u32, charge.to_le_bytes().to_vec())) {
                send(&mut socket, topic, &body);
            }
            send(&mut socket, 1, &[1]);
            while socket.read().is_ok() {}
        }
    };
    (address, std::thread::spawn(serve))
}

#[expect(clippy::result_large_err, reason = "tungstenite's own type")]
fn accepted(stream: TcpStream) -> WebSocket<TcpStream> {
    let choose = |_: &Request, mut response: Response| -> Result<Response, ErrorResponse> {
        let name = "foxglove.sdk.v1".parse().expect("a header");
        response.headers_mut().insert("sec-websocket-protocol", name);
        Ok(response)
    };
    tungstenite::accept_hdr(stream, choose).expect("a handshake")
}

fn say(socket: &mut WebSocket<TcpStream>, text: &Value) {
    socket.send(Message::text(text.to_string())).expect("a client");
}

fn send(socket: &mut WebSocket<TcpStream>, subscription: u32, body: &[u8]) {
    let frame = [&[1], &subscription.to_le_bytes()[..], &5_u64.to_le_bytes(), &[0, 1, 0, 0], body].concat();
    socket.send(Message::binary(frame)).expect("a client");
}

#[test]
fn verdicts_fall_beside_a_robot_and_are_those_of_what_is_recorded() {
    let (folder, mapping, properties) = files();
    let (address, served) = bridge(2);
    let path = |name: &str| folder.path().join(name).to_str().expect("a path in UTF-8").to_owned();
    let asked = ["--map-channels", &mapping, "--property", &properties, "--json"];
    let (recording, out, hooked) = (path("run.mcap"), path("out"), path("hooked"));
    let hook = format!("cat >> {hooked}");
    let more = ["--record", &recording, "--out", &out, "--seconds", "1", "--on-violation", &hook];
    let output = steward(&[&["watch", "--foxglove", &address][..], &asked, &more].concat());
    assert_eq!(output.status.code(), Some(1), "{}", String::from_utf8_lossy(&output.stderr));
    let lines: Vec<Value> =
        String::from_utf8(output.stdout).expect("text").lines().map(|line| line.parse().expect("JSON")).collect();
    let what = |line: &Value| (line["property"].clone(), line["verdict"].clone());
    let [charged, answered, last] = lines.as_slice() else { panic!("{lines:?}") };
    assert_eq!(what(charged), ("charged".into(), "violated".into()));
    assert_eq!(charged["witness"]["step"], 3);
    // Nothing is said any more: it is time that shows it, before the end.
    assert_eq!(what(answered), ("answered".into(), "violated".into()));
    assert!(answered["time_s"].as_f64().is_some_and(|time_s| (0.3..0.7).contains(&time_s)), "{answered}");
    assert_eq!(last["loss"], "unknown");
    assert!(last["notes"].to_string().contains("as the bridge forwarded it"), "{last}");
    let verified = steward(&[&["verify", &recording][..], &asked].concat());
    let verified: Value = serde_json::from_slice(&verified.stdout).expect("JSON");
    assert_eq!((&verified["monitors"], &verified["start_s"]), (&last["monitors"], &last["start_s"]));
    if cfg!(unix) {
        // Nobody waits for the command, except this test.
        let called = loop {
            let text = std::fs::read_to_string(&hooked).unwrap_or_default();
            if text.lines().count() == 2 && text.ends_with('\n') {
                break text.lines().map(|line| line.parse().expect("JSON")).collect::<Vec<Value>>();
            }
            std::thread::yield_now();
        };
        assert!(called.contains(charged) && called.contains(answered), "{called:?}");
    }
    let page = std::fs::read_to_string(Path::new(&out).join("report.html")).expect("a page");
    assert!(page.contains("A robot, as forwarded by the bridge at ws://127.0.0.1"), "it says of what it is");

    let output = steward(&["watch", "--foxglove", &address, "--list"]);
    let listed = String::from_utf8(output.stdout).expect("text");
    assert!(listed.contains("# /charge  std_msgs/msg/Float32         3"), "{listed}");
    std::fs::write(&mapping, listed).expect("room for a mapping");
    std::fs::write(&properties, "property p := always (charge, monitor, m.data > 0)\n").expect("room for a property");
    let verified = steward(&["verify", &recording, "--map-channels", &mapping, "--property", &properties]);
    assert_eq!(verified.status.code(), Some(0), "the proposal is a mapping");
    served.join().expect("a bridge that ends");
}

/// A program that shows a page: what it notes after that, and the socket of the page.
fn shown(asked: &[&str]) -> (Child, impl Iterator<Item = String> + use<>, Socket) {
    let mut child = Command::new(binary())
        .args(asked)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the binary starts");
    let mut notes = BufReader::new(child.stderr.take().expect("a pipe")).lines().map(|line| line.expect("text"));
    let shown = notes.find_map(|note| note.strip_prefix("note: the page is at ").map(str::to_owned));
    let shown = shown.expect("an address");
    let page = Page::new(&shown, &shown);
    let socket = page.socket(&page.pilot);
    (child, notes, socket)
}

#[test]
fn the_page_shows_what_is_heard_until_it_is_no_longer_wanted() {
    let (_folder, mapping, properties) = files();
    let (address, served) = bridge(1);
    let asked = ["--map-channels", &mapping, "--property", &properties, "--seconds", "1", "--live", "--no-open"];
    let (mut child, mut notes, mut socket) = shown(&[&["watch", "--foxglove", &address][..], &asked].concat());
    let is_shown = |known: &Value| {
        let verdicts = known["verdicts"].as_str().unwrap_or_default();
        ["charged", "answered", "violated"].iter().all(|word| verdicts.contains(word))
    };
    until(&mut socket, is_shown);
    // Also after the end, until Ctrl-C.
    until(&mut socket, |known| known["grows"] == false);
    assert!(notes.any(|note| note == "note: Ctrl-C ends the page"));
    child.kill().and_then(|()| child.wait()).expect("it ends");
    served.join().expect("a bridge that ends");
}

/// A bridge of a robot that says what it said in a bag, as fast as it can.
fn replaying(bag: Vec<u8>) -> (String, JoinHandle<()>) {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
    let address = format!("ws://{}", listener.local_addr().expect("an address"));
    let serve = move || {
        let messages = || mcap::MessageStream::new(&bag).expect("a bag").map(|message| message.expect("a message"));
        let mut socket = accepted(listener.accept().expect("a client").0);
        let mut channels = BTreeMap::new();
        for mcap::Message { channel, .. } in messages() {
            let schema = channel.schema.as_ref().expect("a type");
            let text = String::from_utf8_lossy(&schema.data).into_owned();
            let known = json!({ "id": channel.id, "topic": channel.topic, "encoding": "cdr", "schemaName": schema.name, "schema": text });
            channels.insert(channel.id, known);
        }
        say(&mut socket, &json!({ "op": "serverInfo", "name": "a robot" }));
        say(&mut socket, &json!({ "op": "advertise", "channels": channels.values().collect::<Vec<_>>() }));
        let asked: Value = socket.read().expect("a request").to_text().expect("a text").parse().expect("JSON");
        let subscribed = asked["subscriptions"].as_array().expect("subscriptions").clone();
        for message in messages() {
            if let Some(of) = subscribed.iter().find(|of| of["channelId"] == message.channel.id) {
                send(&mut socket, of["id"].as_u64().expect("a number") as u32, &message.data[4..]);
            }
        }
        while socket.read().is_ok() {}
    };
    (address, std::thread::spawn(serve))
}

#[test]
fn the_page_shows_the_robot_on_its_map() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).to_str().expect("a path in UTF-8").to_owned();
    let mapping = "tick_s = 0.1\nreorder_s = 0\n[robot]\nmap = \"/map\"\nscan = \"/scan\"\n[[messages]]\ntopic = \"/scan\"\n\
        from = \"laser\"\nto = \"robot\"\nfields = { x = \"range_max\" }\n";
    std::fs::write(path("robot.toml"), mapping).expect("room for a file");
    std::fs::write(path("far.scope"), "property far := always (laser, robot, m.x < 20)\n").expect("room for a file");
    let (address, served) = replaying(bag(&log(), &maps::house::map(), true));
    let [mapping, property] = [path("robot.toml"), path("far.scope")];
    let asked = ["watch", "--foxglove", &address, "--map-channels", &mapping, "--property", &property];
    let (mut child, _notes, mut socket) = shown(&[&asked[..], &["--live", "--no-open"]].concat());
    until(&mut socket, |known| {
        let hits = known["scene"]["hits"].as_array().map_or(0, Vec::len);
        known["greeting"]["floor"]["svg"].is_string() && known["pose"].is_array() && hits > 100
    });
    child.kill().and_then(|()| child.wait()).expect("it ends");
    served.join().expect("a bridge that ends");
}

/// A bridge of a robot of which there is nothing.
fn empty_bridge(clients: usize) -> (String, JoinHandle<()>) {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
    let address = format!("ws://{}", listener.local_addr().expect("an address"));
    let serve = move || {
        for _ in 0..clients {
            let mut socket = accepted(listener.accept().expect("a client").0);
            say(&mut socket, &json!({ "op": "serverInfo", "name": "a robot" }));
            say(&mut socket, &json!({ "op": "advertise", "channels": [] }));
            while socket.read().is_ok() {}
        }
    };
    (address, std::thread::spawn(serve))
}

/// What a bridge does not offer any more, nobody knows; what else there is stays sure, and so does what is seen later.
#[test]
fn a_topic_that_a_bridge_withdraws_makes_only_what_is_about_it_unsure() {
    let (_folder, mapping, properties) = files();
    let text = "property idle := always not (operator, base, m.x = true)\n\
                property charged := always (battery, base, m.x >= 20)\n";
    std::fs::write(&properties, text).expect("room for a property");
    for (returns, idle) in [(false, "unsure"), (true, "violated")] {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
        let address = format!("ws://{}", listener.local_addr().expect("an address"));
        let served = std::thread::spawn(move || {
            let mut socket = accepted(listener.accept().expect("a client").0);
            let channel = |id: u64, topic: &str, kind: &str, schema: &str| json!({ "id": id, "topic": topic, "encoding": "cdr", "schemaName": kind, "schema": schema });
            let stop = |id| channel(id, "/stop", "std_msgs/msg/Bool", "bool data");
            let channels = [channel(1, "/charge", "std_msgs/msg/Float32", "float32 data"), stop(2)];
            say(&mut socket, &json!({ "op": "serverInfo", "name": "a robot" }));
            say(&mut socket, &json!({ "op": "advertise", "channels": channels }));
            while !socket.read().expect("a request").is_text() {}
            send(&mut socket, 0, &30_f32.to_le_bytes());
            send(&mut socket, 1, &[0]);
            say(&mut socket, &json!({ "op": "unadvertise", "channelIds": [2] }));
            if returns {
                say(&mut socket, &json!({ "op": "advertise", "channels": [stop(3)] }));
                while !socket.read().expect("a request").is_text() {}
                send(&mut socket, 1, &[1]);
            }
            while socket.read().is_ok() {}
        });
        let asked = ["--map-channels", &mapping, "--property", &properties, "--seconds", "1", "--json"];
        let output = steward(&[&["watch", "--foxglove", &address][..], &asked].concat());
        served.join().expect("a bridge that ends");
        let text = String::from_utf8(output.stdout).expect("text");
        let last: Value = text.lines().last().expect("a line").parse().expect("JSON");
        let verdicts = last["monitors"].as_array().expect("monitors").iter();
        let verdicts: Vec<_> = verdicts.map(|of| (of["name"].as_str(), of["verdict"].as_str())).collect();
        assert_eq!(verdicts, [(Some("idle"), Some(idle)), (Some("charged"), Some("satisfied"))], "{last}");
        assert!(last["notes"].to_string().contains("the bridge no longer offers it"), "{last}");
        assert_eq!(output.status.code(), Some(1));
    }
}

/// Images cost a robot something: who only has them in a mapping does not need them.
#[test]
fn images_that_no_property_mentions_are_not_subscribed_to() {
    let (_folder, mapping, properties) = files();
    let entry = "[[messages]]\ntopic = \"/camera\"\ntype = \"sensor_msgs/msg/Image\"\nfrom = \"camera\"\nto = \"base\"\n\
                 fields = { height = \"height\" }\n";
    let text = std::fs::read_to_string(&mapping).expect("a mapping");
    std::fs::write(&mapping, format!("{text}{entry}")).expect("room for a mapping");
    let noted = |more: &[&str]| {
        let (address, served) = bridge(1);
        let asked = ["--map-channels", &mapping, "--property", &properties, "--seconds", "0.5", "--json"];
        let output = steward(&[&["watch", "--foxglove", &address][..], &asked, more].concat());
        served.join().expect("a bridge that ends");
        let report = String::from_utf8(output.stdout).expect("text");
        assert!(report.contains("\"violated\""), "{report}");
        String::from_utf8(output.stderr).expect("text").contains("not subscribed to") && !report.contains("/camera")
    };
    assert!(noted(&[]));
    let folder = tempfile::tempdir().expect("a folder");
    let recording = folder.path().join("all.mcap");
    assert!(!noted(&["--record", recording.to_str().expect("a path in UTF-8")]));
    let named = "property high := always (camera, base, m.height > 0)\n";
    let text = std::fs::read_to_string(&properties).expect("properties");
    std::fs::write(&properties, format!("{text}{named}")).expect("room for a property");
    assert!(!noted(&[]));
}

/// Nothing is listed, and nothing is satisfied, where nothing is: neither through a bridge nor in a domain.
#[test]
fn a_robot_of_which_there_is_nothing_satisfies_nothing() {
    let (folder, mapping, properties) = files();
    let text = std::fs::read_to_string(&mapping).expect("a mapping");
    let text = text.replace("topic = \"/stop\"\n", "topic = \"/stop\"\ntype = \"std_msgs/msg/Bool\"\n");
    let text = text.replace("topic = \"/charge\"\n", "topic = \"/charge\"\ntype = \"std_msgs/msg/Float32\"\n");
    std::fs::write(&mapping, text).expect("room for a mapping");
    let (address, served) = empty_bridge(3);
    let nowhere = |target: &[&str], why: &str| {
        let list = [&["watch", "--list"][..], target].concat();
        let out = folder.path().join("out");
        let out = out.to_str().expect("a path in UTF-8");
        let asked = ["--map-channels", &mapping, "--property", &properties, "--seconds", "0.5", "--out", out];
        let judged = [&["watch"][..], target, &asked].concat();
        for words in [list.clone(), [&list[..], &["--json"]].concat(), judged] {
            let text = refusal(&words);
            assert!(text.contains(why) && text.contains("domain"), "{words:?}: {text}");
        }
        let report = std::fs::read_to_string(Path::new(out).join("report.html")).expect("a page");
        assert!(report.contains("There is no verdict"), "the page shows that nothing could be judged");
    };
    nowhere(&["--foxglove", &address], "offers none of the topics");
    served.join().expect("a bridge that ends");
    if cfg!(feature = "dds") {
        nowhere(&["--domain", "187", "--discovery-range", "localhost"], "no node, no topic");
    }
}

#[test]
fn what_cannot_be_watched_is_refused() {
    let (folder, mapping, properties) = files();
    let refused = |address: &str, mapping: &[&str]| {
        refusal(&[&["watch", "--foxglove", address, "--property", &properties][..], mapping].concat())
    };
    assert!(refused("ws://127.0.0.1:1", &[]).contains("--list"), "it proposes a mapping");
    let mapped = ["--map-channels", mapping.as_str()];
    assert!(refused("robot:8765", &mapped).contains("is not the address of a bridge"));
    assert!(refused("wss://robot", &mapped).contains("forward the port"));
    assert!(refused("ws://127.0.0.1:1", &mapped).contains("foxglove_bridge_launch.xml"));
    // The violations would become a part of the bag.
    std::fs::write(folder.path().join("metadata.yaml"), "").expect("room for a file");
    let out = ["--map-channels", mapping.as_str(), "--out", folder.path().to_str().expect("a path in UTF-8")];
    assert!(refused("ws://127.0.0.1:1", &out).contains("into the folder of a bag"));
}
