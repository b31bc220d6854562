//! `steward live`: who may see a run, and what is done by hand is a scenario that gives the same run.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use serde_json::{Value, json};
use tungstenite::client::IntoClientRequest;
use tungstenite::{Message, WebSocket};

use crate::steward::{refusal, report, steward};

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
    ask(&mut pilot, &fault(json!({ "kind": "obstacle_appears", "at": [-3.0, 6.6, 0] }), "box"));
    after(&mut pilot, 7.0);
    ask(&mut pilot, &json!({ "do": "release", "name": "pad" }));
    // What takes the place of something else under the same name has moved it.
    ask(&mut pilot, &fault(json!({ "kind": "obstacle_appears", "at": [-4.5, 7.0, 0] }), "box"));
    ask(&mut pilot, &fault(json!({ "kind": "operator_goal", "to": [-2.0, 5.0, 90] }), ""));
    let moved = json!([{
        "name": "box",
        "words": "a box stands at (-4.50, 7.00) m",
        "fault": { "kind": "obstacle_appears", "at": [-4.5, 7.0, 0.0], "length_m": 0.6, "width_m": 0.4 },
        "bodies": ["box at (-4.50, 7.00) m"],
    }]);
    while hear(&mut pilot, "lasting") != moved {}
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

/// A name that would be an element of the page if the page took it for one.
const EVIL: &str = "<img src=x onerror=alert(1)>";

/// Makes an application in which places, people, a leaf with its machine, a component and a property have that name.
fn write_evil(folder: &Path) -> PathBuf {
    assert!(steward(&["init", folder.to_str().unwrap()]).status.success());
    let escaped = EVIL.replace('<', "&lt;").replace('>', "&gt;");
    let rewrite = |file: &str, to: &str, edit: &dyn Fn(&str) -> String| {
        let text = std::fs::read_to_string(folder.join(file)).unwrap();
        let edited = edit(&text);
        assert_ne!(edited, text, "{file}");
        std::fs::write(folder.join(to), edited).unwrap();
    };
    let places = "maps/house.places.toml";
    rewrite(places, places, &|text| text.replace("[Destination]", &format!("[{EVIL:?}]")));
    for skill in ["skills/AtDestination.scxml", "skills/GoToDestination.scxml"] {
        rewrite(skill, skill, &|text| text.replace("'Destination'", &format!("'{escaped}'")));
    }
    let tree = "trees/recharge.xml";
    rewrite(tree, tree, &|text| text.replace("<WaitForUser/>", &format!("<Action ID=\"{escaped}\"/>")));
    rewrite("skills/WaitForUser.scxml", &format!("skills/{EVIL}.scxml"), &|text| {
        text.replace("name=\"WaitForUser\"", &format!("name=\"{escaped}\""))
    });
    let property = "properties/phi1.scope";
    rewrite(property, property, &|text| format!("// {EVIL}\n{text}"));
    let file = format!("{EVIL}.toml");
    rewrite("battery_fault.toml", &file, &|text| {
        let text = text.replace("\"Destination\"", &format!("{EVIL:?}"));
        format!("{text}\n[[people]]\nname = {EVIL:?}\nat = [2.0, 0.5]\n")
    });
    folder.join(file)
}

/// Whether a text has the name as markup, and whether it has it at all.
fn has_evil(drawn: &str) -> (bool, bool) {
    (drawn.contains("<img"), drawn.contains("&lt;img"))
}

#[test]
fn names_are_text_in_everything_that_the_server_draws() {
    let folder = tempfile::tempdir().unwrap();
    let live = Live::start(write_evil(&folder.path().join("robot")).to_str().unwrap(), &[]);
    let mut pilot = live.socket(&live.pilot);
    let greeting = hear(&mut pilot, "greeting");
    let machines = greeting["machines"].as_array().unwrap().iter();
    let named = machines.filter(|machine| machine["process"] == EVIL).map(|machine| &machine["svg"]);
    let drawn = named.chain([&greeting["floor"]["svg"]]).map(|svg| svg.as_str().unwrap()).collect::<Vec<_>>();
    assert_eq!(drawn.iter().map(|svg| has_evil(svg)).collect::<Vec<_>>(), [(false, true); 2]);
    assert_eq!(greeting["scenario"], EVIL);
    assert_eq!(has_evil(hear(&mut pilot, "tree").as_str().unwrap()), (false, true));
    // The next tick violates a property, and how that came about is told.
    ask(&mut pilot, &json!({ "do": "act", "fault": { "kind": "battery_level", "level_pct": 10 } }));
    while hear(&mut pilot, "stories") == "" {}
    for part in ["stories", "verdicts", "course"] {
        assert_eq!(has_evil(hear(&mut pilot, part).as_str().unwrap()), (false, true), "{part}");
    }
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
