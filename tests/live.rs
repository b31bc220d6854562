//! `steward live`: who may see a run, and sessions saved as scenarios that give the same run.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use serde_json::{Value, json};
use tungstenite::client::IntoClientRequest;
use tungstenite::{Message, WebSocket};

use crate::steward::{binary, refusal, report, steward};

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
    fn start(run: &str, arguments: &[&str]) -> Self {
        let mut child = Command::new(binary())
            .args(["live", run, "--no-open"])
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

/// Merges frames until the known state of the run fits.
fn until(socket: &mut WebSocket<TcpStream>, fits: impl Fn(&Value) -> bool) -> Value {
    let mut known = json!({});
    while !fits(&known) {
        let Message::Text(text) = socket.read().unwrap() else { continue };
        let frame: Value = serde_json::from_str(&text).unwrap();
        known.as_object_mut().unwrap().extend(frame.as_object().unwrap().clone());
    }
    known
}

/// Whether a value is a time.
fn is_at(value: &Value, time: f64) -> bool {
    value.as_f64().is_some_and(|at| (at - time).abs() < 1e-6)
}

/// Goes to a time; returns what is shown there.
fn seek(socket: &mut WebSocket<TcpStream>, time: f64) -> Value {
    ask(socket, &json!({ "do": "seek", "time": time }));
    until(socket, |known| is_at(&known["at"], time) && known["anew"] == true && known["verdicts"].is_string())
}

/// Records a run of the first experiment that ends at 24 s; returns its report.
fn record(path: &Path, arguments: &[&str]) -> Value {
    let all = ["--set", "execution.max_time_s=24", "--no-snapshots", "--record", path.to_str().unwrap()];
    let out = path.with_extension("out");
    report("battery_fault", &out, &[&all, arguments].concat())
}

/// The answer to a request.
fn ask(socket: &mut WebSocket<TcpStream>, request: &Value) -> Value {
    socket.send(Message::text(request.to_string())).unwrap();
    hear(socket, "answer")
}

#[test]
fn only_our_own_page_with_the_token_gets_in() {
    let live = Live::start("nominal", &[]);
    let (host, page) = (format!("Host: {}\r\n", live.host), format!("/?token={}", live.pilot));
    let status = |path: &str, headers: &str| live.get(path, headers).lines().next().unwrap_or_default().to_owned();
    let (well, forbidden) = ("HTTP/1.1 200 OK", "HTTP/1.1 403 Forbidden");
    assert_eq!(status(&page, &host), well);
    assert_eq!(status(&format!("/?token={}", live.viewer), &host), well);
    assert_eq!(status(&page, &format!("Host: localhost:{}\r\n", live.host.rsplit(':').next().unwrap())), well);
    // Another name for the same address, as in DNS rebinding; no name; two names.
    assert_eq!(status(&page, "Host: evil.example\r\n"), forbidden);
    assert_eq!(status(&page, &format!("{host}Host: evil.example\r\n")), forbidden);
    assert_ne!(status(&page, ""), well);
    // Another site's page; a request from our own page; a wrong token.
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
fn one_pilot_steers_and_invalid_requests_are_refused() {
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
        assert_eq!(hear(onlooker, "refused"), "somebody else is controlling this run");
    }
    for (request, reason) in [
        ("", "EOF"),
        ("[]", "do"),
        (r#"{"do":"fly"}"#, "unknown variant `fly`"),
        (r#"{"do":"act","fault":{"kind":"fly"}}"#, "cannot be `fly`"),
        (r#"{"do":"act","fault":{"kind":"battery_level","level_pct":180}}"#, "between 0 and 100"),
        (r#"{"do":"act","fault":{"kind":"kidnap","to":[900,900,0]}}"#, ""),
        (r#"{"do":"act","fault":{"kind":"wrong_map","map":"maps/house_shifted.yaml"}}"#, " run"),
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
    // A message that is too long ends the connection, but not the run: the next pilot steers.
    let _ = pilot.send(Message::text("x".repeat(20_000)));
    while pilot.read().is_ok() {}
    assert_eq!(hear(&mut second, "pilot"), true);
    assert_eq!(ask(&mut second, &json!({ "do": "pause" })), Value::Null);
}

#[test]
fn a_saved_session_is_a_scenario_that_gives_the_same_run() {
    let live = Live::start("nominal", &["--set", "battery.initial_pct=60"]);
    let mut pilot = live.socket(&live.pilot);
    ask(&mut pilot, &json!({ "do": "pause" }));
    ask(&mut pilot, &json!({ "do": "speed", "times": null }));
    // Tick by tick, so that the run cannot end before the next act.
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
    // A second fault of the same name moves what the first one has put there.
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
    // A folder with the name of the base does not hide it.
    std::fs::create_dir(folder.path().join("nominal")).unwrap();
    let replayed = report(file.to_str().unwrap(), &folder.path().join("out"), &[]);
    assert_eq!(replayed["trace_hash"], end["trace_hash"], "{}", saved["scenario"]);
    assert_eq!(replayed["outcome"], "as_expected");
}

/// A name that would become an element if the page treated it as markup.
const EVIL: &str = "<img src=x onerror=alert(1)>";

/// Writes an application in which places, people, a leaf with its machine, a component and a property have that name.
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

/// Whether a text contains the name as markup, and whether it contains it at all.
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
    // The next tick violates a property, and the page explains how that happened.
    ask(&mut pilot, &json!({ "do": "act", "fault": { "kind": "battery_level", "level_pct": 10 } }));
    let parts = ["stories", "verdicts", "course"];
    let drawn = |known: &Value| parts.map(|part| has_evil(known[part].as_str().unwrap_or_default()));
    let known = until(&mut pilot, |known| drawn(known).iter().all(|(_, names)| *names));
    assert_eq!(drawn(&known), [(false, true); 3]);
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

#[test]
fn the_past_is_shown_while_a_session_goes_on() {
    let live = Live::start("nominal", &[]);
    let mut pilot = live.socket(&live.pilot);
    ask(&mut pilot, &json!({ "do": "pause" }));
    while hear(&mut pilot, "ticks").as_u64().unwrap() < 9 {
        ask(&mut pilot, &json!({ "do": "tick" }));
    }
    ask(&mut pilot, &json!({ "do": "pause" }));
    let was = seek(&mut pilot, 3.0);
    assert_eq!((&was["time"], &was["past"]), (&json!(3.0), &json!(true)));
    let now = was["to"].as_f64().unwrap();
    assert!(now > 7.0, "{now}");
    let fault = json!({ "do": "act", "fault": { "kind": "battery_level", "level_pct": 12 } });
    assert_eq!(ask(&mut pilot, &fault)["refused"], "the past cannot be changed; go back to now");
    // Steps and ticks move through the past; the session stays where it is.
    ask(&mut pilot, &json!({ "do": "step" }));
    assert!(is_at(&until(&mut pilot, |known| is_at(&known["time"], 3.02))["to"], now));
    ask(&mut pilot, &json!({ "do": "tick" }));
    let later = until(&mut pilot, |known| known["ticks"] != was["ticks"] && known["ticks"].is_number());
    assert!(later["past"] == true && is_at(&later["to"], now), "{later}");
    ask(&mut pilot, &json!({ "do": "now" }));
    let back = until(&mut pilot, |known| known["past"] == false && known["pose"].is_array());
    assert!(is_at(&back["time"], now) && back["pose"] != was["pose"], "{back}");
    assert!(ask(&mut pilot, &fault)["act"].is_number());
    let end = ask(&mut pilot, &json!({ "do": "end" }));
    let saved = ask(&mut pilot, &json!({ "do": "save" }));
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("session.toml");
    std::fs::write(&file, saved["scenario"].as_str().unwrap()).unwrap();
    let replayed = report(file.to_str().unwrap(), &folder.path().join("out"), &[]);
    assert_eq!(replayed["trace_hash"], end["trace_hash"]);
}

#[test]
fn a_recording_shows_what_the_run_was_like_at_any_time() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let report = record(&path, &[]);
    let live = Live::start(path.to_str().unwrap(), &[]);
    let mut pilot = live.socket(&live.pilot);
    let greeting = hear(&mut pilot, "greeting");
    assert_eq!((&greeting["scenario"], &greeting["file"]), (&json!("battery_fault"), &json!("run.mcap")));
    ask(&mut pilot, &json!({ "do": "pause" }));
    let end = report["sim_time_s"].as_f64().unwrap();
    until(&mut pilot, |known| known["to"] == end && known["grows"] == false);
    let phi1 = report["monitors"].as_array().unwrap().iter().find(|monitor| monitor["name"] == "phi1").unwrap();
    let violated = phi1["time_s"].as_f64().unwrap();
    let happened = |shown: &Value| shown["happenings"].as_array().unwrap().iter().any(|it| it["kind"] == "violated");
    let card = |shown: &Value| shown["verdicts"].as_str().unwrap().contains("pill violated");
    for (time, is_violated) in [(violated, true), (violated - 0.02, false), (1.0, false), (violated + 1.0, true)] {
        let shown = seek(&mut pilot, time);
        assert!(is_at(&shown["time"], time), "{} instead of {time}", shown["time"]);
        assert_eq!((happened(&shown), card(&shown)), (is_violated, is_violated), "at {time} s");
        assert!(shown["end"].is_null());
    }
    let shown = seek(&mut pilot, end);
    assert_eq!(shown["end"]["trace_hash"], report["trace_hash"]);
    let act = json!({ "do": "act", "fault": { "kind": "joypad" } });
    for request in [act, json!({ "do": "save" }), json!({ "do": "end" })] {
        assert_eq!(ask(&mut pilot, &request)["refused"], "a recording cannot be changed");
    }
    for time in [-1.0, 1e300] {
        assert!(ask(&mut pilot, &json!({ "do": "seek", "time": time }))["refused"].is_string());
    }
    // Playing on at the end starts over.
    ask(&mut pilot, &json!({ "do": "resume" }));
    until(&mut pilot, |known| known["at"].as_f64().is_some_and(|at| at < end));
}

#[test]
fn a_recording_is_followed_while_it_grows() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["run.rec", "run.mcap"] {
        let whole = folder.path().join(name);
        let report = record(&whole, &[]);
        let bytes = std::fs::read(&whole).unwrap();
        // Like a program that is still recording, and gives the file its final name at the end.
        let path = folder.path().join(format!("growing-{name}"));
        let mut file = diagnostics::Unfinished::create(&path).unwrap();
        let (begun, rest) = bytes.split_at(bytes.len() * 3 / 5);
        file.write_all(begun).unwrap();
        let live = Live::start(path.to_str().unwrap(), &[]);
        let mut pilot = live.socket(&live.pilot);
        let known = until(&mut pilot, |known| known["past"] == false && known["time"].is_number());
        assert_eq!((&known["grows"], &known["at"], &known["end"]), (&json!(true), &known["to"], &Value::Null));
        assert!((1.0..24.0).contains(&known["to"].as_f64().unwrap()), "{name}: {}", known["to"]);
        file.write_all(rest).unwrap();
        file.finish().unwrap();
        let known = until(&mut pilot, |known| known["end"].is_object());
        assert_eq!((&known["end"]["trace_hash"], &known["grows"]), (&report["trace_hash"], &json!(false)));
    }
}

#[test]
fn two_recordings_are_shown_side_by_side() {
    let folder = tempfile::tempdir().unwrap();
    let paths = [folder.path().join("with.rec"), folder.path().join("without.rec")];
    let first = record(&paths[0], &[]);
    let second = record(&paths[1], &["--seed", "2", "--set", "faults=[]"]);
    let live = Live::start(paths[0].to_str().unwrap(), &[paths[1].to_str().unwrap()]);
    let mut pilot = live.socket(&live.pilot);
    assert_eq!(hear(&mut pilot, "greeting")["sides"], 2);
    ask(&mut pilot, &json!({ "do": "pause" }));
    until(&mut pilot, |known| known["to"] == 24.0 && known["grows"] == false);
    // The sides show the runs; nobody steers from there.
    let mut sides = [0, 1].map(|side| live.socket(&format!("{}&side={side}", live.pilot)));
    for (side, report) in sides.iter_mut().zip([&first, &second]) {
        assert_eq!(hear(side, "greeting")["seed"], report["seed"]);
        assert_eq!(hear(side, "pilot"), false);
    }
    ask(&mut pilot, &json!({ "do": "seek", "time": 22.0 }));
    let shown = |side: &mut _| until(side, |known| known["time"] == 22.0 && known["verdicts"].is_string());
    let is_violated = |shown: Value| shown["verdicts"].as_str().unwrap().contains("pill violated");
    assert_eq!(sides.each_mut().map(|side| is_violated(shown(side))), [true, false]);
    let third = live.try_socket(&format!("{}&side=2", live.viewer), Some(&format!("http://{}", live.host)));
    assert!(matches!(third, Err(tungstenite::Error::Http(_))));
    let said = refusal(&["live", paths[0].to_str().unwrap(), "nominal", "--no-open"]);
    assert!(said.contains("only recordings can be shown side by side"), "{said}");
    let said = refusal(&["live", paths[0].to_str().unwrap(), "--no-open", "--seed", "3"]);
    assert!(said.contains("a recording cannot be changed"), "{said}");
}

#[cfg(unix)]
#[test]
fn a_campaign_shows_its_progress() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("many.toml");
    let text = "scenario = \"errand\"\nsampling = \"sobol\"\nruns = 100000\nset = [\"execution.max_time_s=1\"]\n\
                [[parameters]]\nkey = \"battery.initial_pct\"\nfrom = 31\nto = 80\n";
    std::fs::write(&file, text).unwrap();
    let mut child = Command::new(binary())
        .args(["campaign", file.to_str().unwrap(), "--live", "--no-open", "--out"])
        .arg(folder.path().join("out"))
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let said = BufReader::new(child.stderr.take().unwrap()).lines().next().unwrap().unwrap();
    let (host, viewer) = said.split_once("http://").unwrap().1.split_once("/?token=").unwrap();
    let (host, viewer) = (host.to_owned(), viewer.to_owned());
    let live = Live { child, host, pilot: String::new(), viewer };
    let mut socket = live.socket(&live.viewer);
    assert!(hear(&mut socket, "greeting")["title"].as_str().unwrap().ends_with("many.toml"));
    let known = until(&mut socket, |known| known["done"].as_u64().is_some_and(|done| done > 0));
    assert_eq!((&known["all"], &known["over"]), (&json!(100_000), &Value::Null));
    let tallies = known["tallies"].as_array().unwrap();
    assert!(tallies.iter().any(|tally| tally["name"] == "phi1 violated"), "{tallies:?}");
    Command::new("kill").args(["-INT", &live.child.id().to_string()]).status().unwrap();
    until(&mut socket, |known| known["over"] == true);
}
