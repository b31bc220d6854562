//! Nothing that a command reads is overwritten by it: every option that writes, against every kind of input.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use tempfile::{TempDir, tempdir};

use crate::steward::binary;

/// Which options read and which write files. A test of the program compares them with its command line.
const OPTIONS: &str = include_str!("overwriting/options.txt");

/// Options that write, but are not tried, and why.
const NOT_TRIED: &[(&str, &str)] = &[
    ("man DIR", "it reads no file"),
    ("sim --gif", NEEDS_DDS),
    ("sim --junit", NEEDS_DDS),
    ("sim --out", NEEDS_DDS),
    ("sim --record", NEEDS_DDS),
    ("sim --results", NEEDS_DDS),
    ("watch --out", NEEDS_DDS),
    ("watch --record", NEEDS_DDS),
];
const NEEDS_DDS: &str = "not in every program; it begins its outputs as `run` does";

/// How an option that writes is tried.
struct Trial {
    option: &'static str,
    /// The command, in which `OUT` stands for the value of the option.
    command: &'static str,
    /// What it writes into the folder `OUT`; the file `OUT` itself if it is empty.
    files: &'static [&'static str],
    /// What it reads.
    inputs: &'static [&'static str],
}

const fn trial(
    option: &'static str,
    command: &'static str,
    files: &'static [&'static str],
    inputs: &'static [&'static str],
) -> Trial {
    Trial { option, command, files, inputs }
}

const SHARD: &[&str] = &["shard/journal.jsonl"];
const RUN: &[&str] = &["report.json", "report.html", "01-start.png"];
const PROOF: &[&str] = &[
    "proof.toml",
    "tree.xml",
    "skills/AnnounceArrival.scxml",
    "parts/Speaker.scxml",
    "parts/speaker.toml",
    "said.scope",
];
const VERIFIED: &[&str] = &["said.scope", "run.jsonl", "scenario.toml", "tree.xml"];

const TRIALS: &[Trial] = &[
    trial("run --out", "run scenario.toml -q --out OUT", RUN, INPUTS),
    trial("run --gif", "run scenario.toml -q --gif OUT", &[], INPUTS),
    trial("run --record", "run scenario.toml -q --record OUT", &[], INPUTS),
    trial("run --results", "run scenario.toml -q --results OUT.xml", &[], INPUTS),
    trial("run --junit", "run scenario.toml -q --junit OUT", &[], INPUTS),
    trial("check --results", "check scenario.toml --results OUT.md", &[], INPUTS),
    trial("check --junit", "check scenario.toml --junit OUT", &[], INPUTS),
    trial("init DIR", "init --scenario scenario.toml OUT", &["tree.xml"], INPUTS),
    trial("live --record", "live --groot 127.0.0.1:1 --property said.scope --record OUT", &[], &["said.scope"]),
    trial(
        "campaign --out",
        "campaign camp.toml -q --out OUT",
        &["summary.json", "report.html", "journal.jsonl", "timing.csv", "dataset.parquet"],
        INPUTS,
    ),
    trial("campaign --results", "campaign camp.toml -q --results OUT.sarif", &[], INPUTS),
    trial("campaign --junit", "campaign camp.toml -q --junit OUT", &[], INPUTS),
    trial(
        "campaign merge --out",
        "campaign merge shard --out OUT",
        &["summary.json", "report.html", "journal.jsonl", "timing.csv"],
        SHARD,
    ),
    trial("campaign merge --results", "campaign merge shard --out new --results OUT.xml", &[], SHARD),
    trial("campaign merge --junit", "campaign merge shard --out new --junit OUT", &[], SHARD),
    trial(
        "matrix --out",
        "matrix scenario.toml --fault-free proof.toml --runs 1 -q --out OUT",
        &["matrix.json", "index.html"],
        INPUTS,
    ),
    trial("matrix --results", "matrix scenario.toml --fault-free proof.toml -q --results OUT.xml", &[], INPUTS),
    trial("matrix --junit", "matrix scenario.toml --fault-free proof.toml -q --junit OUT", &[], INPUTS),
    // It would take months.
    trial(
        "reproduce --out",
        "reproduce --seeds 100000 -q --map floor.yaml --places floor.places.toml --out OUT",
        &["reproduce.json", "index.html"],
        &["floor.yaml", "house.pgm", "floor.places.toml"],
    ),
    trial(
        "prove --out",
        "prove proof.toml -q --out OUT",
        &[
            "said/schedule.toml",
            "said/counterexample.toml",
            "said/physics.toml",
            "said/report.json",
            "said/report.html",
            "said/sequence-said.svg",
            "said/sequence-said.png",
        ],
        PROOF,
    ),
    trial("prove --promela", "prove proof.toml -q --promela OUT", &["proof-said.pml"], PROOF),
    trial("prove --results", "prove proof.toml -q --results OUT.xml", &[], PROOF),
    trial("prove --junit", "prove proof.toml -q --junit OUT", &[], PROOF),
    trial("report --out", "report run.rec -q --out OUT", RUN, &["run.rec"]),
    trial("report --gif", "report run.rec -q --gif OUT", &[], &["run.rec"]),
    trial("report --record", "report run.rec -q --record OUT.jsonl", &[], &["run.rec"]),
    trial(
        "verify --out",
        "verify run.jsonl --scenario scenario.toml --property said.scope --out OUT",
        &["report.json", "report.html"],
        VERIFIED,
    ),
    trial(
        "verify --results",
        "verify run.jsonl --scenario scenario.toml --property said.scope --results OUT.xml",
        &[],
        VERIFIED,
    ),
    trial(
        "verify --junit",
        "verify run.jsonl --scenario scenario.toml --property said.scope --junit OUT",
        &[],
        VERIFIED,
    ),
    trial(
        "monitor export --out",
        "monitor export said.scope --scenario scenario.toml --out OUT",
        &["said.txt"],
        INPUTS,
    ),
    // It would take days.
    trial(
        "navigate --out",
        "navigate --map floor.yaml --goals 100000 --pictures all -q --out OUT",
        &["navigate.json", "floor_1.png", "floor_17.png"],
        &["floor.yaml", "house.pgm"],
    ),
    trial(
        "localize --out",
        "localize --map floor.yaml --log empty.log --out OUT",
        &["trajectories.csv", "trajectories.png"],
        &["floor.yaml", "house.pgm", "empty.log"],
    ),
    trial("map --out", "map --log empty.log --force --out OUT/m.yaml", &["m.yaml", "m.pgm"], &["empty.log"]),
];

#[test]
fn every_option_that_writes_is_tried() {
    let writes = OPTIONS.lines().filter_map(|line| Some(line.strip_prefix("writes")?.trim()));
    let known = TRIALS.iter().map(|trial| trial.option).chain(NOT_TRIED.iter().map(|(option, _)| *option));
    assert_eq!(known.collect::<BTreeSet<_>>(), writes.collect::<BTreeSet<_>>());
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

/// A scenario that can be proved.
const PROVABLE: &str = r#"tree = "tree.xml"
skills = "skills"
properties = ["said.scope"]
components.Speaker = { machine = "parts/Speaker.scxml", interface = "parts/speaker.toml" }
"#;

/// A log in which no beam hits anything: there is nothing to make a map from.
const LOG: &str = "PARAM robot_front_laser_max 30.0 0 sim 0
ODOM 0 0 0 0 0 0 0.5 sim 0.5
FLASER 3 81.9 81.9 81.9 0 0 0 0 0 0 1.0 sim 1.0
";

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
        ("clerk.sh", ": > ran\nwhile read line; do echo '{}'; done\n"),
        ("proof.toml", PROVABLE),
        ("camp.toml", "scenario = \"scenario.toml\"\nruns = 1\n"),
        ("empty.log", LOG),
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
    let is_refused = done.status.code() == Some(2)
        && ["overwrit", "contains no results of steward"].iter().any(|why| message.contains(why));
    let mut found: Vec<String> = Vec::new();
    // A check runs nothing, and says of each file what it found.
    let has_run = !done.stdout.is_empty() && arguments[0] != "check";
    if !is_refused || has_run {
        let said = String::from_utf8_lossy(&done.stdout);
        found.push(format!("{arguments:?}: status {:?}, {said}{message}", done.status.code()));
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
fn a_run_replaces_what_it_has_written_itself_and_nothing_that_it_reads() {
    let folder = application();
    let path = folder.path();
    let checked = call(path, &["check", "scenario.toml"]);
    assert!(checked.status.success(), "{}", String::from_utf8_lossy(&checked.stderr));
    let found = damage(path, INPUTS, &["run", "scenario.toml", "--quiet", "--record", "tree.xml"]);
    assert_eq!(found, [""; 0]);
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

/// A value of `OUT` for which a trial's command would write to an input.
struct Way {
    out: String,
    /// The link to the input, which is to be removed again.
    link: PathBuf,
}

impl Trial {
    /// Makes a file that the command writes a link to an input.
    fn way(&self, folder: &Path, file: &str, input: &str, is_hard: bool) -> Way {
        let suffix = self.command.split("OUT").nth(1).unwrap_or_default().split(' ').next().unwrap_or_default();
        let out = "o/new".to_owned();
        let link = folder.join(match file {
            "" => format!("{out}{suffix}"),
            file => format!("{out}/{file}"),
        });
        fs::create_dir_all(link.parent().expect("a folder")).expect("a folder");
        if cfg!(unix) && !is_hard {
            #[cfg(unix)]
            std::os::unix::fs::symlink(folder.join(input), &link).expect("a link");
        } else {
            fs::hard_link(folder.join(input), &link).expect("a link");
        }
        Way { out, link }
    }

    /// Tries each input at the place of the first file, and the first input at those of the others. Returns what was
    /// not refused before anything ran.
    fn found(&self, folder: &Path) -> Vec<String> {
        let files = if self.files.is_empty() { &[""] } else { self.files };
        let (first, others) = files.split_first().expect("there is one");
        let pairs = self.inputs.iter().map(|input| (first, input));
        let pairs = pairs.chain(others.iter().map(|file| (file, &self.inputs[0])));
        let mut found = Vec::new();
        for (number, (file, input)) in pairs.enumerate() {
            let Way { out, link } = self.way(folder, file, input, number % 2 == 1);
            let command = self.command.replace("OUT", &out);
            let arguments: Vec<&str> = command.split(' ').collect();
            let damage = damage(folder, self.inputs, &arguments);
            let ran = [("ran", "has started a program"), ("out", "has written results")];
            let ran = ran.into_iter().filter(|(trace, _)| folder.join(trace).exists()).map(|(_, what)| what.to_owned());
            found.extend(damage.into_iter().chain(ran).map(|what| format!("{file} is {input}: {what}")));
            for trace in ["ran", "out", "new"] {
                let _ = fs::remove_file(folder.join(trace)).or_else(|_| fs::remove_dir_all(folder.join(trace)));
            }
            let _ = fs::remove_file(link);
            let _ = fs::remove_dir_all(folder.join("o"));
        }
        found
    }
}

#[test]
fn no_option_that_writes_overwrites_an_input_and_nothing_runs_before_that_is_refused() {
    let folder = application();
    let path = folder.path();
    for command in ["run scenario.toml -q --no-snapshots --record run.jsonl", "run scenario.toml -q --record run.rec"] {
        let done = call(path, &command.split(' ').collect::<Vec<_>>());
        assert!(done.status.success(), "{command}: {}", String::from_utf8_lossy(&done.stderr));
    }
    let done = call(path, &["campaign", "camp.toml", "-q", "--out", "shard"]);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    assert!(path.join("ran").exists(), "a run leaves a trace");
    fs::remove_file(path.join("ran")).expect("it is there");
    fs::remove_dir_all(path.join("out")).expect("it is there");
    let found: Vec<String> = TRIALS.iter().flat_map(|trial| trial.found(path)).collect();
    assert!(found.is_empty(), "{}", found.join("\n"));
}

/// Whether there is a file at a path or below it.
fn is_written(path: &Path) -> bool {
    let mut below = fs::read_dir(path).into_iter().flatten().flatten();
    path.is_file() || below.any(|entry| is_written(&entry.path()))
}

/// An option's file in the folder of the report, where this is written as well.
#[test]
fn no_two_outputs_are_written_to_one_path() {
    let folder = application();
    let path = folder.path();
    let recorded =
        call(path, &["run", "scenario.toml", "-q", "--no-snapshots", "--record", "run.rec", "--out", "first"]);
    assert!(recorded.status.success(), "{}", String::from_utf8_lossy(&recorded.stderr));
    fs::remove_file(path.join("ran")).expect("it is there");
    let of_report = |file: &str| [format!("--record o/{file}"), format!("--gif ./o/../o/{file}")];
    let options = [of_report("report.json"), of_report("report.html"), of_report("01-start.png")].concat();
    let runs = ["run scenario.toml -q --out o", "report run.rec -q --out o"];
    let commands = runs.iter().flat_map(|command| options.iter().map(move |option| format!("{command} {option}")));
    let others = [
        "run scenario.toml -q --record out/scenario/report.json",
        "report run.rec -q --gif out/run/report.html",
        "campaign camp.toml -q --out o --junit o/summary.json",
        "matrix scenario.toml --fault-free nominal -q --out o --junit o/matrix.json",
        "prove proof.toml -q --out o --junit o/said/report.json",
        "verify run.rec --property said.scope --scenario scenario.toml --out o --junit o/report.json",
    ];
    for command in commands.chain(others.map(str::to_owned)) {
        let done = call(path, &command.split(' ').collect::<Vec<_>>());
        let message = String::from_utf8_lossy(&done.stderr);
        assert!(done.status.code() == Some(2) && message.contains("overwritten"), "{command}: {message}");
        // Results for CI systems have the refusal itself.
        let (_, option) = command.rsplit_once(' ').expect("it has words");
        assert_eq!(fs::remove_file(path.join(option)).is_ok(), command.contains("--junit"), "{command}");
        let written = ["ran", "o", "out"].into_iter().find(|written| is_written(&path.join(written)));
        assert_eq!(written, None, "{command}");
    }
    let beside = call(path, &["run", "scenario.toml", "-q", "--no-snapshots", "--out", "o", "--record", "o/run.rec"]);
    assert!(beside.status.success(), "{}", String::from_utf8_lossy(&beside.stderr));
}
