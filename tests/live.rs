//! `steward live`: who may see a run, and what is done by hand is a scenario that gives the same run.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use serde_json::{Value, json};
use tungstenite::client::IntoClientRequest;
use tungstenite::{Message, WebSocket};

use crate::steward::{refusal, report};

/// A running `steward live`, which ends with the test.
struct Live {
    child: Child,
    host: String,
    pilot: String,
    viewer: String,
}

impl Drop for Live {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Live {
    fn start(scenario: &str, arguments: &[&str]) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_steward"))
            .args(["live", scenario, "--no-open"])
            .args(arguments)
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut said = BufReader::new(child.stdout.take().unwrap()).lines().map(Result::unwrap);
        let address = said.next().unwrap();
        let (host, pilot) = address.strip_prefix("http://").unwrap().split_once("/?token=").unwrap();
        let viewer = said.next().unwrap().split_once("/?token=").unwrap().1.to_owned();
        Self { child, host: host.to_owned(), pilot: pilot.to_owned(), viewer }
    }

    /// The answer to a request for a path with these headers, as text.
    fn get(&self, path: &str, headers: &str) -> String {
        let mut stream = TcpStream::connect(&self.host).unwrap();
        write!(stream, "GET {path} HTTP/1.1\r\nConnection: close\r\n{headers}\r\n").unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        answer
    }

    fn try_socket(&self, token: &str, origin: Option<&str>) -> tungstenite::Result<WebSocket<TcpStream>> {
        let mut request = format!("ws://{}/socket?token={token}", self.host).into_client_request()?;
        if let Some(origin) = origin {
            request.headers_mut().insert("Origin", origin.parse().unwrap());
        }
        let stream = TcpStream::connect(&self.host)?;
        stream.set_read_timeout(Some(Duration::from_secs(100)))?;
        let connected = tungstenite::client(request, stream).map(|(socket, _)| socket);
        connected.map_err(|error| match error {
            tungstenite::HandshakeError::Failure(error) => error,
            tungstenite::HandshakeError::Interrupted(_) => tungstenite::Error::ConnectionClosed,
        })
    }

    fn socket(&self, token: &str) -> WebSocket<TcpStream> {
        self.try_socket(token, Some(&format!("http://{}", self.host))).unwrap()
    }
}

/// The next frame that has this key.
fn hear(socket: &mut WebSocket<TcpStream>, key: &str) -> Value {
    loop {
        let Message::Text(text) = socket.read().unwrap() else { continue };
        let frame: Value = serde_json::from_str(&text).unwrap();
        if frame.get(key).is_some() {
            return frame[key].clone();
        }
    }
}

/// The answer to a request.
fn ask(socket: &mut WebSocket<TcpStream>, request: &Value) -> Value {
    socket.send(Message::text(request.to_string())).unwrap();
    hear(socket, "answer")
}

#[test]
fn only_the_own_page_with_the_token_gets_in() {
    let live = Live::start("nominal", &[]);
    let (host, page) = (format!("Host: {}\r\n", live.host), format!("/?token={}", live.pilot));
    let status = |path: &str, headers: &str| live.get(path, headers).lines().next().unwrap_or_default().to_owned();
    let (well, forbidden) = ("HTTP/1.1 200 OK", "HTTP/1.1 403 Forbidden");
    assert_eq!(status(&page, &host), well);
    assert_eq!(status(&format!("/?token={}", live.viewer), &host), well);
    assert_eq!(status(&page, &format!("Host: localhost:{}\r\n", live.host.rsplit(':').next().unwrap())), well);
    // Another name for the same address, as by DNS rebinding; none; two.
    assert_eq!(status(&page, "Host: evil.example\r\n"), forbidden);
    assert_eq!(status(&page, &format!("{host}Host: evil.example\r\n")), forbidden);
    assert_ne!(status(&page, ""), well);
    // Another site's page; a request of the own one; a wrong token.
    assert_eq!(status(&page, &format!("{host}Origin: http://evil.example\r\n")), forbidden);
    assert_eq!(status("/main.js", &format!("{host}Origin: null\r\n")), forbidden);
    assert_eq!(status(&page, &format!("{host}Origin: http://{}\r\n", live.host)), well);
    assert_eq!(status("/", &host), forbidden);
    assert_eq!(status("/?token=", &host), forbidden);
    assert_eq!(status(&format!("{page}0"), &host), forbidden);
    let answer = live.get(&page, &host);
    let policy = answer.lines().find(|line| line.starts_with("content-security-policy: ")).unwrap();
    assert!(policy.contains("script-src 'self';") && policy.contains("default-src 'none'"), "{policy}");

    let origin = format!("http://{}", live.host);
    assert!(live.try_socket(&live.viewer, Some(&origin)).is_ok());
    for (token, origin) in [
        ("", Some(origin.as_str())),
        ("0123456789abcdef0123456789abcdef", Some(origin.as_str())),
        (&live.pilot, None),
        (&live.pilot, Some("http://evil.example")),
        (&live.pilot, Some("null")),
    ] {
        assert!(matches!(live.try_socket(token, origin), Err(tungstenite::Error::Http(_))), "{token} {origin:?}");
    }
}

#[test]
fn one_pilot_steers_and_what_is_no_request_is_refused() {
    let live = Live::start("nominal", &["--seed", "3"]);
    let mut pilot = live.socket(&live.pilot);
    assert_eq!(hear(&mut pilot, "greeting")["seed"], 3);
    assert_eq!(hear(&mut pilot, "pilot"), true);
    let mut second = live.socket(&live.pilot);
    assert_eq!(hear(&mut second, "pilot"), false);
    let mut viewer = live.socket(&live.viewer);
    assert_eq!(hear(&mut viewer, "pilot"), false);
    for onlooker in [&mut second, &mut viewer] {
        onlooker.send(Message::text(r#"{"do":"pause"}"#)).unwrap();
        assert_eq!(hear(onlooker, "refused"), "somebody else steers this run");
    }
    for (request, reason) in [
        ("", "EOF"),
        ("[]", "do"),
        (r#"{"do":"fly"}"#, "unknown variant `fly`"),
        (r#"{"do":"act","fault":{"kind":"fly"}}"#, "cannot be `fly`"),
        (r#"{"do":"act","fault":{"kind":"battery_level","level_pct":180}}"#, "between 0 and 100"),
        (r#"{"do":"act","fault":{"kind":"kidnap","to":[900,900,0]}}"#, ""),
        (r#"{"do":"act","fault":{"kind":"wrong_map","map":"maps/house_shifted.yaml"}}"#, "lasts for the whole run"),
    ] {
        pilot.send(Message::text(request)).unwrap();
        let said = loop {
            let Message::Text(text) = pilot.read().unwrap() else { continue };
            let frame: Value = serde_json::from_str(&text).unwrap();
            if frame.get("refused").is_some() || frame.get("answer").is_some() {
                break frame;
            }
        };
        let refused = said.get("refused").or_else(|| said["answer"].get("refused")).unwrap_or(&Value::Null);
        assert!(refused.as_str().is_some_and(|words| words.contains(reason)), "{request}: {said}");
    }
    // What is too long ends the connection, and not the run: the next one steers.
    let _ = pilot.send(Message::text("x".repeat(20_000)));
    while pilot.read().is_ok() {}
    assert_eq!(hear(&mut second, "pilot"), true);
    assert_eq!(ask(&mut second, &json!({ "do": "pause" })), Value::Null);
}

#[test]
fn a_session_by_hand_is_a_scenario_that_gives_the_same_run() {
    let live = Live::start("nominal", &["--set", "battery.initial_pct=60"]);
    let mut pilot = live.socket(&live.pilot);
    ask(&mut pilot, &json!({ "do": "pause" }));
    ask(&mut pilot, &json!({ "do": "speed", "times": null }));
    // Tick by tick, so that the run cannot end before what is done next.
    let after = |pilot: &mut WebSocket<TcpStream>, time: f64| {
        while hear(pilot, "time").as_f64().unwrap() < time {
            ask(pilot, &json!({ "do": "tick" }));
        }
    };
    let fault = |fault: Value, name: &str| json!({ "do": "act", "fault": fault, "name": name });
    after(&mut pilot, 5.0);
    ask(&mut pilot, &fault(json!({ "kind": "joypad", "linear_mps": -0.2 }), "pad"));
    after(&mut pilot, 7.0);
    ask(&mut pilot, &json!({ "do": "release", "name": "pad" }));
    ask(&mut pilot, &fault(json!({ "kind": "battery_level", "level_pct": 12 }), ""));
    after(&mut pilot, 20.0);
    let end = ask(&mut pilot, &json!({ "do": "end" }));
    let saved = ask(&mut pilot, &json!({ "do": "save" }));
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("session.toml");
    std::fs::write(&file, saved["scenario"].as_str().unwrap()).unwrap();
    let replayed = report(file.to_str().unwrap(), &folder.path().join("out"), &[]);
    assert_eq!(replayed["trace_hash"], end["trace_hash"], "{}", saved["scenario"]);
    assert_eq!(replayed["outcome"], "as_expected");
}

#[test]
fn a_port_that_is_taken_and_a_wrong_scenario_are_refused() {
    let live = Live::start("pick", &[]);
    let port = live.host.rsplit(':').next().unwrap();
    let said = refusal(&["live", "pick", "--no-open", "--port", port]);
    assert!(said.contains("choose another port"), "{said}");
    let said = refusal(&["live", "nominal", "--no-open", "--set", "battery.initial_pct=300"]);
    assert!(said.contains("battery.initial_pct=300"), "{said}");
}
