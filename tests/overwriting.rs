//! Nothing that a command reads is overwritten by it: every option that writes, against every kind of input.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use tempfile::{TempDir, tempdir};

use crate::steward::binary;

/// The options whose values are files or folders that a command reads; `COMMAND` alone has all its arguments.
const READ: &[&str] = &[
    "localize --map",
    "reproduce --map",
    "reproduce --places",
    "navigate --map",
    "tree run --leaves",
    "skill run --events",
    "fmt --stdin-name",
    "live --property",
    "verify --property",
    "verify --map-channels",
    "verify --tree",
    "report --tree",
    "live --tree",
    "watch --property",
    "watch --map-channels",
    "watch --scenario",
    "verify --scenario",
    "check --scenario",
    "run --scenario",
    "monitor check --scenario",
    "monitor explain --scenario",
    "monitor export --scenario",
    "skill check --scenario",
    "monitor new --scenario",
    "matrix --fault-free",
    "init --scenario",
    "skill show --scenario",
];

/// The options that write files or folders.
const WRITE: &[&str] = &[
    "run --out",
    "run --gif",
    "run --record",
    "run --results",
    "check --results",
    "live --record",
    "campaign --out",
    "campaign --results",
    "campaign merge --out",
    "campaign merge --results",
    "matrix --out",
    "matrix --results",
    "reproduce --out",
    "prove --out",
    "prove --promela",
    "prove --results",
    "report --out",
    "report --gif",
    "report --record",
    "verify --out",
    "verify --results",
    "watch --out",
    "watch --record",
    "sim --out",
    "sim --gif",
    "sim --record",
    "sim --results",
    "monitor export --out",
    "navigate --out",
    "localize --out",
    "map --out",
];

/// The options in the reference whose values are files or folders: `COMMAND --OPTION`.
fn options_with_files() -> BTreeSet<String> {
    let reference = include_str!("../docs/src/reference/commands.md");
    let (mut command, mut found) = (String::new(), BTreeSet::new());
    for line in reference.lines() {
        if let Some(usage) = line.strip_prefix("Usage: steward ") {
            let words = usage.split(' ').take_while(|word| word.chars().all(|c| c.is_ascii_lowercase() || c == '-'));
            command = words.collect::<Vec<_>>().join(" ");
            // Without a command, it is `run`.
            if command.is_empty() {
                command = "run".to_owned();
            }
        }
        let Some((_, option)) = line.split_once("--").filter(|(before, _)| before.trim().len() <= 3) else { continue };
        let Some((name, value)) = option.split_once(" <") else { continue };
        let value = value.split('>').next().unwrap_or_default();
        if ["FILE", "DIR", "FOLDER", "MAP"].iter().any(|kind| value.contains(kind)) && !name.contains(' ') {
            found.insert(format!("{command} --{name}"));
        }
    }
    found
}

#[test]
fn every_option_with_a_file_is_known_to_read_or_to_write_it() {
    let known = READ.iter().chain(WRITE).map(ToString::to_string).collect::<BTreeSet<_>>();
    let unknown: Vec<String> = options_with_files().into_iter().filter(|option| !known.contains(option)).collect();
    assert!(unknown.is_empty(), "does it read or write? {unknown:?}");
}

const TREE: &str = r#"<root BTCPP_format="4" main_tree_to_execute="Tour">
  <BehaviorTree ID="Tour"><AnnounceArrival/></BehaviorTree>
  <TreeNodesModel><Action ID="AnnounceArrival"/></TreeNodesModel>
</root>
"#;
const SCENARIO: &str = r#"base = "base.toml"
tree = "tree.xml"
properties = ["said.scope"]
expect = {}
components.Speaker = { machine = "parts/Speaker.scxml", interface = "parts/speaker.toml" }
components.Clerk = { program = ["sh", "clerk.sh"], interface = "parts/clerk.toml" }
[[monitors]]
machine = "watch.scxml"
violated_in = "bad"
events = [{ event = "said", when = "(Speaker, AnnounceArrival, m[1] = <error>)" }]
[[faults]]
kind = "wrong_map"
map = "other.yaml"
at_s = 0
"#;
const BASE: &str = r#"map = "floor.yaml"
places = "floor.places.toml"
skills = "skills"
sites = { start = "start", station = "RechargingStation" }
execution.max_time_s = 3
"#;
const WATCH: &str = r#"<scxml xmlns="http://www.w3.org/2005/07/scxml" name="watch" datamodel="ecmascript" version="1.0" initial="on">
  <state id="on"><transition event="said" target="bad"/></state><state id="bad"/></scxml>
"#;

/// Everything that the scenario reads.
const INPUTS: &[&str] = &[
    "scenario.toml",
    "base.toml",
    "tree.xml",
    "skills/AnnounceArrival.scxml",
    "parts/Speaker.scxml",
    "parts/speaker.toml",
    "parts/clerk.toml",
    "parts/Ask.srv",
    "clerk.sh",
    "watch.scxml",
    "said.scope",
    "floor.yaml",
    "house.pgm",
    "floor.places.toml",
    "other.yaml",
];

/// An application with an input of every kind.
fn application() -> TempDir {
    let folder = tempdir().expect("a folder");
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for made in ["skills", "parts"] {
        fs::create_dir(folder.path().join(made)).expect("a folder");
    }
    for (from, to) in [
        ("maps/house.yaml", "floor.yaml"),
        ("maps/house.yaml", "other.yaml"),
        ("maps/house.pgm", "house.pgm"),
        ("maps/house.places.toml", "floor.places.toml"),
        ("skills/examples/AnnounceArrival.scxml", "skills/AnnounceArrival.scxml"),
        ("skills/examples/Speaker.scxml", "parts/Speaker.scxml"),
        ("skills/examples/speaker.toml", "parts/speaker.toml"),
    ] {
        fs::copy(root.join(from), folder.path().join(to)).expect("a copy");
    }
    for (path, text) in [
        ("scenario.toml", SCENARIO),
        ("base.toml", BASE),
        ("tree.xml", TREE),
        ("parts/clerk.toml", "[services.ask]\nros = \"Ask.srv\"\n"),
        ("parts/Ask.srv", "string text\n---\nbool ok\n"),
        ("clerk.sh", "while read line; do echo '{}'; done\n"),
        ("watch.scxml", WATCH),
        ("said.scope", "property said := always not (Speaker, AnnounceArrival, m[1] = <error>)\n"),
    ] {
        fs::write(folder.path().join(path), text).expect("room for a file");
    }
    folder
}

fn call(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(binary()).args(arguments).current_dir(folder).output().expect("it starts")
}

/// The files that a call changes or removes, and its message if its exit status is not 2.
fn damage(folder: &Path, inputs: &[&str], arguments: &[&str]) -> Vec<String> {
    let contents = || inputs.iter().map(|input| fs::read(folder.join(input)).ok()).collect::<Vec<_>>();
    let before = contents();
    let done = call(folder, arguments);
    let message = String::from_utf8_lossy(&done.stderr).into_owned();
    let is_refused = done.status.code() == Some(2) && message.contains("overwrit");
    let mut found: Vec<String> = Vec::new();
    if !is_refused {
        found.push(format!("{arguments:?}: status {:?}, {message}", done.status.code()));
    }
    for ((input, before), now) in inputs.iter().zip(before).zip(contents()) {
        if before != now {
            found.push(format!("{arguments:?} changes {input}"));
            // So that what follows is tried on the same files.
            fs::write(folder.join(input), before.unwrap_or_default()).expect("room for a file");
        }
    }
    found
}

#[test]
fn no_option_of_a_run_overwrites_any_input_by_whichever_name() {
    let folder = application();
    let path = folder.path();
    let checked = call(path, &["check", "scenario.toml"]);
    assert!(checked.status.success(), "{}", String::from_utf8_lossy(&checked.stderr));
    #[cfg(unix)]
    for input in ["parts/Ask.srv", "tree.xml"] {
        std::os::unix::fs::symlink(path.join(input), path.join("link.rec")).expect("a link");
        fs::hard_link(path.join(input), path.join("hard.gif")).expect("a link");
        for option in [["--record", "link.rec"], ["--gif", "hard.gif"]] {
            let found = damage(path, INPUTS, &[&["run", "scenario.toml", "--quiet"][..], &option].concat());
            assert_eq!(found, [""; 0]);
        }
        for link in ["link.rec", "hard.gif"] {
            fs::remove_file(path.join(link)).expect("it is there");
        }
    }
    let mut found = Vec::new();
    for input in INPUTS {
        for option in ["--record", "--gif"] {
            found.extend(damage(path, INPUTS, &["run", "scenario.toml", "--quiet", option, input]));
        }
    }
    assert_eq!(found, [""; 0]);
    assert!(!path.join("out").exists(), "nothing has run");
    // Two options that name one file.
    let twice = ["run", "scenario.toml", "--quiet", "--record", "new", "--gif", "./new"];
    assert_eq!(damage(path, INPUTS, &twice), [""; 0]);
    // What it has written itself may be replaced.
    for _ in 0..2 {
        let done = call(path, &["run", "scenario.toml", "--no-snapshots", "--quiet", "--record", "run.rec"]);
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    }
    let again = ["report", "run.rec", "--no-snapshots", "--record", "run.rec"];
    assert_eq!(damage(path, &["run.rec"], &again), [""; 0]);
    assert_eq!(damage(path, &["run.rec"], &["report", "run.rec", "--gif", "run.rec"]), [""; 0]);
}

/// A results file must be an empty file, or earlier results: these kinds of inputs may be empty.
#[test]
fn no_results_file_overwrites_an_input() {
    let folder = application();
    let path = folder.path();
    fs::write(path.join("empty.xml"), "").expect("room for a file");
    for (command, more) in [("run", &[][..]), ("check", &[]), ("prove", &[]), ("matrix", &["--fault-free", "nominal"])]
    {
        let set = ["scenario.toml", "--results", "empty.xml"];
        let scenario = SCENARIO.replace("\"clerk.sh\"", "\"empty.xml\"");
        fs::write(path.join("scenario.toml"), scenario).expect("room for a file");
        let call = [&[command][..], &set, more].concat();
        assert_eq!(damage(path, &["empty.xml", "scenario.toml"], &call), [""; 0]);
        assert!(path.join("empty.xml").exists());
    }
}

/// The files that a command writes into its folder are inputs of the next call.
#[test]
fn no_folder_that_is_written_overwrites_an_input() {
    let folder = application();
    let path = folder.path();
    let done = call(path, &["run", "scenario.toml", "--no-snapshots", "--quiet", "--record", "run.jsonl"]);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    fs::write(path.join("camp.toml"), "scenario = \"scenario.toml\"\nruns = 1\n").expect("room for a file");
    let property = "property said := always not (Speaker, AnnounceArrival, m[1] = <error>)\n";
    for (arguments, written) in [
        (&["run", "scenario.toml", "--no-snapshots", "--quiet", "--out", "o"][..], &["report.json", "report.html"][..]),
        (
            &["campaign", "camp.toml", "--quiet", "--out", "o"],
            &["dataset.parquet", "summary.json", "report.html", "timing.csv"],
        ),
        (
            &["verify", "run.jsonl", "--scenario", "scenario.toml", "--property", "o/INPUT", "--out", "o"],
            &["report.json"],
        ),
        (&["monitor", "export", "o/INPUT", "--scenario", "scenario.toml", "--out", "o"], &["said.txt"]),
    ] {
        for name in written {
            let _ = fs::remove_dir_all(path.join("o"));
            fs::create_dir(path.join("o")).expect("a folder");
            fs::write(path.join("o").join(name), property).expect("room for a file");
            let scenario = SCENARIO.replace("said.scope", &format!("o/{name}"));
            fs::write(path.join("scenario.toml"), scenario).expect("room for a file");
            let arguments: Vec<String> = arguments.iter().map(|word| word.replace("INPUT", name)).collect();
            let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
            let before = fs::read(path.join("o").join(name)).expect("it is there");
            let done = call(path, &arguments);
            let message = String::from_utf8_lossy(&done.stderr).into_owned();
            assert_eq!(fs::read(path.join("o").join(name)).expect("it is there"), before, "{arguments:?}");
            assert_eq!(done.status.code(), Some(2), "{arguments:?} {message}");
        }
    }
}
