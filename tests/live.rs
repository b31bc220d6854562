//! `steward live` and `--live`: what the program prints, saves and refuses. What the page can do is tested in the crate
//! `cockpit`.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use serde_json::{Value, json};

use crate::steward::{binary, refusal, report, steward};

#[path = "../scenarios/cockpit/tests/browser.rs"]
pub(crate) mod browser;

use browser::{Page, Socket, ask, hear, until};

/// A running `steward live`, which ends with the test.
struct Live {
    child: Child,
    page: Page,
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
        let mut printed = BufReader::new(child.stdout.take().unwrap()).lines().map(Result::unwrap);
        let [pilot, viewer] = [(); 2].map(|()| printed.next().unwrap());
        Self { child, page: Page::new(&pilot, &viewer) }
    }

    fn pilot(&self) -> Socket {
        self.page.socket(&self.page.pilot)
    }
}

#[test]
fn the_printed_addresses_open_the_page() {
    let live = Live::start("pick", &[]);
    let host = format!("Host: {}\r\n", live.page.host);
    for token in [&live.page.pilot, &live.page.viewer] {
        let answer = live.page.get(&format!("/?token={token}"), &host);
        assert!(answer.starts_with("HTTP/1.1 200 OK") && answer.contains("main.js"), "{answer}");
    }
    assert_ne!(live.page.pilot, live.page.viewer);
}

#[test]
fn a_log_that_is_checked_opens_in_the_page_with_its_verdicts() {
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("low.jsonl");
    let lines = [
        json!({ "scenario": "nominal", "tick_s": 0.5 }),
        json!({ "step": 0, "tick": 0, "time_s": 0.5, "generated": "tick" }),
        json!({ "step": 1, "tick": 0, "time_s": 0.5, "from": "BatteryReader", "to": "BatteryLevel",
                "message": [{ "sym": "ok" }, 9.0] }),
    ];
    std::fs::write(&log, lines.map(|line| format!("{line}\n")).concat()).unwrap();
    let mut child = Command::new(binary())
        .args(["verify", log.to_str().unwrap(), "--property", "phi1", "--live", "--no-open"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut notes = BufReader::new(child.stderr.take().unwrap()).lines().map(Result::unwrap);
    let address = notes.find(|line| line.contains("the page is at http://")).unwrap();
    let live = Live { child, page: Page::new(&address, &address) };
    let known = until(&mut live.pilot(), |known| known["verdicts"].as_str().is_some_and(|it| it.contains("violated")));
    assert_eq!(known["greeting"]["scenario"], "low");
    let refused = refusal(&["verify", "a.jsonl", "b.jsonl", "--property", "phi1", "--live"]);
    assert!(refused.contains("several logs cannot be shown at once"), "{refused}");
}

#[test]
fn a_saved_session_is_a_scenario_that_gives_the_same_run() {
    let live = Live::start("nominal", &["--set", "battery.initial_pct=60"]);
    let mut pilot = live.pilot();
    ask(&mut pilot, &json!({ "do": "pause" }));
    ask(&mut pilot, &json!({ "do": "speed", "times": null }));
    // Tick by tick, so that the run cannot end before the next act.
    let after = |pilot: &mut Socket, time: f64| {
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
    let mut pilot = live.pilot();
    let greeting = hear(&mut pilot, "greeting");
    let machines = greeting["machines"].as_array().unwrap().iter();
    let named = machines.filter(|machine| machine["process"] == EVIL).map(|machine| &machine["svg"]);
    let drawn = named.chain([&greeting["floor"]["svg"]]).map(|svg| svg.as_str().unwrap()).collect::<Vec<_>>();
    assert_eq!(drawn.iter().map(|svg| has_evil(svg)).collect::<Vec<_>>(), [(false, true); 2]);
    assert_eq!(greeting["scenario"], EVIL);
    assert_eq!(has_evil(hear(&mut pilot, "tree").as_str().unwrap()), (false, true));
    // The next tick violates a property, and the page explains how that happened.
    ask(&mut pilot, &json!({ "do": "act", "fault": { "kind": "battery_level", "level_pct": 10 } }));
    // The timeline is data, and its script writes texts.
    let parts = ["stories", "verdicts"];
    let drawn = |known: &Value| parts.map(|part| has_evil(known[part].as_str().unwrap_or_default()));
    let known = until(&mut pilot, |known| drawn(known).iter().all(|(_, names)| *names));
    assert_eq!(drawn(&known), [(false, true); 2]);
    assert!(known["course"].is_object());
}

#[test]
fn a_port_that_is_taken_and_a_wrong_scenario_are_refused() {
    let live = Live::start("pick", &[]);
    let port = live.page.host.rsplit(':').next().unwrap();
    let message = refusal(&["live", "pick", "--no-open", "--port", port]);
    assert!(message.contains("choose another port"), "{message}");
    let message = refusal(&["live", "nominal", "--no-open", "--set", "battery.initial_pct=300"]);
    assert!(message.contains("battery.initial_pct=300"), "{message}");
}

#[test]
fn a_driven_robot_on_a_page_has_no_options_of_what_becomes_of_its_run() {
    let file = "never-written";
    for option in ["--out", "--gif", "--record", "--junit"] {
        let message = refusal(&["sim", "nominal", "--live", option, file]);
        assert!(message.contains("cannot be used with") && message.contains(option), "{message}");
    }
    for option in ["--open", "--no-snapshots", "--no-monitors", "--json", "--quiet"] {
        let message = refusal(&["sim", "nominal", "--live", option]);
        assert!(message.contains("cannot be used with") && message.contains(option), "{message}");
    }
    let message = refusal(&["sim", "nominal", "--no-open"]);
    assert!(message.contains("--live"), "{message}");
    assert!(!Path::new(file).exists());
}

#[test]
fn recordings_are_shown_alone_and_as_they_are() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.rec");
    let path = path.to_str().unwrap();
    let set = ["--set", "execution.max_time_s=1", "--no-snapshots", "--record", path];
    report("battery_fault", &folder.path().join("out"), &set);
    let live = Live::start(path, &[path]);
    assert_eq!(hear(&mut live.pilot(), "greeting")["sides"], 2);
    let message = refusal(&["live", path, "nominal", "--no-open"]);
    assert!(message.contains("only recordings can be shown side by side"), "{message}");
    let message = refusal(&["live", path, "--no-open", "--seed", "3"]);
    assert!(message.contains("a recording cannot be changed"), "{message}");
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
    let printed = BufReader::new(child.stderr.take().unwrap()).lines().next().unwrap().unwrap();
    let live = Live { child, page: Page::new(&printed, &printed) };
    let mut socket = live.page.socket(&live.page.viewer);
    assert!(hear(&mut socket, "greeting")["title"].as_str().unwrap().ends_with("many.toml"));
    let known = until(&mut socket, |known| known["done"].as_u64().is_some_and(|done| done > 0));
    assert_eq!((&known["all"], &known["over"]), (&json!(100_000), &Value::Null));
    let tallies = known["tallies"].as_array().unwrap();
    assert!(tallies.iter().any(|tally| tally["name"] == "phi1 violated"), "{tallies:?}");
    Command::new("kill").args(["-INT", &live.child.id().to_string()]).status().unwrap();
    until(&mut socket, |known| known["over"] == true);
}
