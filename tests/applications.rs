//! Applications of one's own: which files are theirs, and at whose file a mistake is shown.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;
use tempfile::{TempDir, tempdir};

use crate::steward::binary;

fn call(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(binary()).args(arguments).current_dir(folder).output().expect("it starts")
}

fn stderr(done: &Output) -> String {
    // Messages may be wrapped.
    String::from_utf8_lossy(&done.stderr).split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Two equal applications, of which `b` is then changed.
fn two(change: impl FnOnce(&Path)) -> TempDir {
    let folder = tempdir().expect("a folder");
    for name in ["a", "b"] {
        assert!(call(folder.path(), &["init", name, "--template", "empty"]).status.success());
    }
    fs::rename(folder.path().join("b/scenario.toml"), folder.path().join("b/robot.toml")).expect("it is there");
    change(&folder.path().join("b"));
    folder
}

fn replace(file: &Path, from: &str, to: &str) {
    let text = fs::read_to_string(file).expect("it is there");
    assert!(text.contains(from), "{from} is not in {}", file.display());
    fs::write(file, text.replace(from, to)).expect("room for a file");
}

#[test]
fn a_mistake_in_one_of_several_applications_is_shown_at_its_own_file() {
    let mistakes: [(&str, &str, &str); 4] = [
        ("tree.xml", "<Greet", "<Gret"),
        ("skills/Greet.scxml", "<state", "<stade"),
        ("properties.scope", ":=", "="),
        ("robot.toml", "tree =", "treee ="),
    ];
    for (file, from, to) in mistakes {
        let folder = two(|b| replace(&b.join(file), from, to));
        for (command, more) in [
            ("run", &["--no-snapshots"][..]),
            ("check", &[]),
            ("prove", &[]),
            ("matrix", &["--fault-free", "a/scenario.toml"]),
        ] {
            let results = ["--results", "r.md", "--results", "r.sarif", "--results", "r.xml"];
            let arguments = [&[command, "a/scenario.toml", "b/robot.toml"][..], more, &results].concat();
            let done = call(folder.path(), &arguments);
            let told = stderr(&done) + &String::from_utf8_lossy(&done.stdout);
            assert_eq!(done.status.code(), Some(2), "{arguments:?} {told}");
            assert!(told.contains("b/robot.toml"), "{arguments:?} {told}");
            let read = |name: &str| fs::read_to_string(folder.path().join(name)).expect("it was written");
            let [markdown, sarif, junit] = ["r.md", "r.sarif", "r.xml"].map(read);
            let (right, wrong) = (format!("b/{file}"), format!("a/{file}"));
            for text in [&markdown, &junit] {
                assert!(text.contains(&right), "{arguments:?} {text}");
                assert!(!text.contains(&format!("{wrong}:")), "{arguments:?} {text}");
            }
            let sarif: Value = serde_json::from_str(&sarif).expect("SARIF is JSON");
            let found = sarif["runs"][0]["results"].as_array().expect("results");
            let uris: Vec<&str> = found
                .iter()
                .filter_map(|result| result["locations"][0]["physicalLocation"]["artifactLocation"]["uri"].as_str())
                .collect();
            assert!(!uris.is_empty() && uris.iter().all(|uri| *uri == right), "{arguments:?} {uris:?}");
        }
    }
}

#[test]
fn files_that_come_with_the_program_are_named_if_an_application_has_none() {
    let folder = tempdir().expect("a folder");
    let path = folder.path();
    assert!(call(path, &["init", "robot"]).status.success());
    let own = call(path, &["check", "robot/battery_fault.toml"]);
    let text = String::from_utf8_lossy(&own.stdout).into_owned();
    assert!(own.status.success() && !text.contains("with steward"), "{text}");
    let missing = ["maps/house.pgm", "trees/recharge.xml", "skills/BatteryLevel.scxml", "properties/phi1.scope"];
    missing.iter().for_each(|file| fs::remove_file(path.join("robot").join(file)).expect("it is there"));
    let checked = call(path, &["check", "robot/battery_fault.toml", "--results", "r.xml"]);
    let text = String::from_utf8_lossy(&checked.stdout).split_whitespace().collect::<Vec<_>>().join(" ");
    let junit = fs::read_to_string(path.join("r.xml")).expect("it was written");
    for arguments in [
        &["run", "robot/battery_fault.toml", "--no-snapshots", "--quiet"][..],
        &["prove", "robot/battery_fault.toml", "--property", "phi1", "--states", "10"],
    ] {
        let done = call(path, arguments);
        let told = stderr(&done);
        for file in missing {
            assert!(told.contains(file) && told.contains("come with steward"), "{arguments:?} {told}");
        }
    }
    for file in missing {
        assert!(text.contains(file) && text.contains("come with steward"), "{text}");
        assert!(junit.contains(file), "{junit}");
    }
    let json = call(path, &["check", "robot/battery_fault.toml", "--json"]);
    let json: Value = serde_json::from_slice(&json.stdout).expect("JSON");
    assert!(json[0]["elsewhere"][0].as_str().is_some_and(|words| words.contains(missing[0])), "{json}");
    // A base that comes with the program has its own files.
    fs::write(path.join("based.toml"), "base = \"battery_fault\"\n").expect("room for a file");
    let based = call(path, &["check", "based.toml"]);
    assert!(based.status.success() && !String::from_utf8_lossy(&based.stdout).contains("with steward"));
}

#[test]
fn a_path_on_the_command_line_is_relative_to_the_current_folder() {
    let folder = two(|b| replace(&b.join("tree.xml"), "<Greet", "<Gret"));
    let at = |name: &str| folder.path().join(name);
    // As a teacher judges what a student has handed in.
    let judge = |here: &str, set: &str| {
        call(&at(here), &["run", "../a/scenario.toml", "--no-snapshots", "--quiet", "--set", set])
    };
    let wrong = judge("b", "tree=tree.xml");
    assert_eq!(wrong.status.code(), Some(2), "{}", stderr(&wrong));
    assert!(stderr(&wrong).contains("Gret"), "{}", stderr(&wrong));
    replace(&at("b/tree.xml"), "<Gret", "<Greet");
    let right = judge("b", "tree=tree.xml");
    assert!(right.status.success(), "{}", stderr(&right));
    assert!(stderr(&right).contains("tree.xml is ./tree.xml, not beside the scenario"), "{}", stderr(&right));
    // Where there is none, that of the scenario does not take its place.
    fs::remove_file(at("b/tree.xml")).expect("it is there");
    let missing = judge("b", "tree=tree.xml");
    assert_eq!(missing.status.code(), Some(2));
    assert!(stderr(&missing).replace(' ', "").contains("../a/tree.xml"), "{}", stderr(&missing));
    // Beside the scenario, nothing is to be said.
    let beside = call(&at("a"), &["run", "scenario.toml", "--no-snapshots", "--quiet", "--set", "tree=tree.xml"]);
    assert!(beside.status.success() && !stderr(&beside).contains("not beside"), "{}", stderr(&beside));
}

#[test]
fn a_property_file_without_a_property_is_refused() {
    for text in ["", "// Nothing yet.\n", "const theta := 10\n"] {
        let folder = two(|b| fs::write(b.join("properties.scope"), text).expect("room for a file"));
        let done =
            call(folder.path(), &["run", "a/scenario.toml", "--no-snapshots", "--quiet", "--record", "log.jsonl"]);
        assert!(done.status.success(), "{}", stderr(&done));
        for arguments in [
            &["check", "b/properties.scope", "--scenario", "a/scenario.toml"][..],
            &["check", "b/robot.toml"],
            &["run", "b/robot.toml", "--no-snapshots"],
            &[
                "verify",
                "log.jsonl",
                "--property",
                "b/properties.scope",
                "--scenario",
                "a/scenario.toml",
                "--results",
                "r.xml",
            ],
        ] {
            let done = call(folder.path(), arguments);
            assert_eq!(done.status.code(), Some(2), "{arguments:?} {}", stderr(&done));
            assert!(stderr(&done).contains("there is no property"), "{arguments:?} {}", stderr(&done));
        }
        let junit = fs::read_to_string(folder.path().join("r.xml")).expect("it was written");
        assert!(junit.contains("errors=\"1\""), "{junit}");
    }
}

#[test]
fn a_misspelled_place_is_shown_where_it_is_given_and_not_in_the_machine() {
    let folder = tempdir().expect("a folder");
    let path = folder.path();
    assert!(call(path, &["init", "robot", "--template", "guide"]).status.success());
    replace(&path.join("robot/trees/guide.xml"), "place=\"Entrance\"", "place=\"Entrence\"");
    let done = call(path, &["check", "robot/guide.toml"]);
    let told = stderr(&done);
    assert_eq!(done.status.code(), Some(2), "{told}");
    assert!(told.contains("there is no place `Entrence`") && told.contains("did you mean `Entrance`?"), "{told}");
    assert!(told.contains("trees/guide.xml:") && !told.contains("GoTo.scxml:"), "{told}");
}

#[test]
fn a_scenario_shows_the_warnings_of_its_components_machines() {
    let folder = tempdir().expect("a folder");
    let path = folder.path();
    assert!(call(path, &["init", "robot", "--template", "guide"]).status.success());
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("skills/examples");
    let machine = fs::read_to_string(root.join("Speaker.scxml")).expect("it is there");
    let wrong = machine.replacen("<transition ", "<transition cond=\"entries = pages\" ", 1);
    assert_ne!(wrong, machine);
    fs::write(path.join("Speaker.scxml"), wrong).expect("room for a file");
    let alone = call(path, &["check", "Speaker.scxml"]);
    fs::copy(root.join("speaker.toml"), path.join("speaker.toml")).expect("a copy");
    fs::copy(root.join("AnnounceArrival.scxml"), path.join("AnnounceArrival.scxml")).expect("a copy");
    let tree = r#"<root BTCPP_format="4" main_tree_to_execute="T"><BehaviorTree ID="T"><AnnounceArrival/></BehaviorTree>
<TreeNodesModel><Action ID="AnnounceArrival"/></TreeNodesModel></root>"#;
    fs::write(path.join("tree.xml"), tree).expect("room for a file");
    let scenario = "tree = \"tree.xml\"\nskills = \".\"\ncomponents.Speaker = { machine = \"Speaker.scxml\", interface = \"speaker.toml\" }\n";
    fs::write(path.join("scenario.toml"), scenario).expect("room for a file");
    let checked = call(path, &["check", "scenario.toml"]);
    assert!(stderr(&alone).contains("Speaker.scxml:"), "{}", stderr(&alone));
    assert!(stderr(&checked).contains("Speaker.scxml:"), "{} {}", stderr(&alone), stderr(&checked));
}

#[test]
fn results_say_what_they_were_made_from() {
    let folder = two(|_| {});
    let path = folder.path();
    let run = |record: &str| {
        let set = ["--set", "execution.max_time_s=9", "--set", "tree=a/tree.xml", "--record", record];
        let done = call(path, &[&["run", "a/scenario.toml", "--no-snapshots", "--json"][..], &set].concat());
        assert!(done.status.success(), "{}", stderr(&done));
        let mut report: Value = serde_json::from_slice(&done.stdout).expect("JSON");
        report.as_object_mut().expect("an object").remove("timing");
        report
    };
    let (first, again) = (run("log.jsonl"), run("run.rec"));
    assert_eq!(first, again, "nothing but the timing differs");
    let made = &first["provenance"];
    assert_eq!(made["scenario"], "a/scenario.toml");
    assert_eq!(made["set"], serde_json::json!(["execution.max_time_s=9", "tree=a/tree.xml"]));
    let inputs = |made: &Value| {
        let inputs = made["inputs"].as_array().expect("inputs").clone();
        inputs
            .iter()
            .map(|it| (it["path"].as_str().expect("a path").to_owned(), it["blake3"].clone()))
            .collect::<Vec<_>>()
    };
    let names: Vec<String> = inputs(made).into_iter().map(|(path, _)| path).collect();
    assert_eq!(names, ["./a/tree.xml", "a/scenario.toml", "properties.scope", "skills/Greet.scxml"]);
    // The event log and the recording have the same.
    let log = fs::read_to_string(path.join("log.jsonl")).expect("it was written");
    let line: Value = serde_json::from_str(log.lines().next().expect("a line")).expect("JSON");
    assert_eq!(&line["provenance"], made);
    assert!(call(path, &["report", "run.rec", "--no-snapshots", "--quiet", "--out", "again"]).status.success());
    let report = fs::read_to_string(path.join("again/report.json")).expect("it was written");
    let report: Value = serde_json::from_str(&report).expect("JSON");
    assert_eq!(&report["provenance"], made);
    // A file that has changed has another hash, and only that one.
    replace(&path.join("a/properties.scope"), "property", "// Later.\nproperty");
    let changed = run("log.jsonl");
    let differ: Vec<_> =
        inputs(made).into_iter().zip(inputs(&changed["provenance"])).filter(|(one, other)| one != other).collect();
    assert_eq!(differ.len(), 1, "{differ:?}");
    assert_eq!(differ[0].0.0, "properties.scope");
    // A campaign's results.
    fs::write(path.join("c.toml"), "scenario = \"a/scenario.toml\"\nruns = 1\nset = [\"execution.max_time_s=8\"]\n")
        .expect("room");
    assert!(call(path, &["campaign", "c.toml", "--quiet"]).status.success());
    let summary = fs::read_to_string(path.join("out/c/summary.json")).expect("it was written");
    let summary: Value = serde_json::from_str(&summary).expect("JSON");
    assert_eq!(summary["provenance"]["set"], serde_json::json!(["execution.max_time_s=8"]));
    assert_eq!(inputs(&summary["provenance"]).len(), 4);
    let dataset = fs::read(path.join("out/c/dataset.parquet")).expect("it was written");
    assert!(String::from_utf8_lossy(&dataset).contains("steward.provenance"));
    // What judges a recording, in every form.
    let forms = ["r.xml", "r.sarif"].map(|file| ["--results", file]).concat();
    let judge = ["verify", "run.rec", "--property", "a/properties.scope", "--json"];
    let judged = call(path, &[&judge[..], &forms].concat());
    let judged: Value = serde_json::from_slice(&judged.stdout).expect("JSON");
    let found = inputs(&judged["provenance"]);
    let names: Vec<&str> = found.iter().map(|(path, _)| path.as_str()).collect();
    assert_eq!((names, &judged["provenance"]["commit"]), (vec!["a/properties.scope", "run.rec"], &made["commit"]));
    let read = |file: &str| fs::read_to_string(path.join(file)).expect("it was written");
    let sarif: Value = serde_json::from_str(&read("r.sarif")).expect("JSON");
    for (index, (file, hash)) in found.iter().enumerate() {
        let hash = hash.as_str().expect("a hash");
        assert!(read("r.xml").contains(&format!("<property name=\"blake3 of {file}\" value=\"{hash}\"/>")));
        let artifact = &sarif["runs"][0]["artifacts"][index];
        let named = (&artifact["location"]["uri"], &artifact["hashes"]["blake3"]);
        assert_eq!(named, (&Value::from(file.as_str()), &Value::from(hash)));
    }
    // The version names the commit, as results do.
    let version = String::from_utf8_lossy(&call(path, &["--version"]).stdout).into_owned();
    let commit =
        made["commit"].as_str().map_or_else(|| "commit unknown".to_owned(), |commit| format!("commit {commit}"));
    assert!(version.contains(&commit), "{version}");
}

#[test]
fn a_name_means_the_shipped_file_whatever_the_current_folder_has() {
    let folder = tempdir().expect("a folder");
    let path = folder.path();
    for file in ["properties/phi1.scope", "trees/recharge.xml", "skills/BatteryLevel.scxml", "maps/house.yaml"] {
        fs::create_dir_all(path.join(file).parent().expect("a folder")).expect("a folder");
        fs::write(path.join(file), "not one").expect("room for a file");
    }
    fs::create_dir(path.join("battery_fault")).expect("a folder");
    for command in [
        "monitor check phi1",
        "tree check recharge",
        "skill check BatteryLevel",
        "check battery_fault",
        "run battery_fault -q --no-snapshots",
    ] {
        let done = call(path, &command.split(' ').collect::<Vec<_>>());
        assert!(done.status.success(), "{command}: {}", stderr(&done));
    }
    // A path means the file.
    assert!(!call(path, &["monitor", "check", "properties/phi1.scope"]).status.success());
}

#[test]
fn what_is_wrong_with_each_of_several_scenarios_is_shown_and_written() {
    let folder = two(|b| replace(&b.join("robot.toml"), "tree", "treee"));
    let path = folder.path();
    let forms = ["r.xml", "r.sarif", "r.md"];
    let results = forms.map(|file| ["--results", file]).concat();
    for command in ["run", "prove"] {
        for scenarios in
            [["b/robot.toml", "missing.toml"], ["missing.toml", "b/robot.toml"], ["missing.toml", "nominall"]]
        {
            let done = call(path, &[&[command], &scenarios[..], &results].concat());
            let told = stderr(&done);
            assert_eq!(done.status.code(), Some(2), "{told}");
            let wrong = scenarios.map(|name| match name {
                "b/robot.toml" => "unknown key `treee`",
                "nominall" => "`nominall`",
                _ => "missing.toml",
            });
            let texts = forms.map(|file| fs::read_to_string(path.join(file)).expect("it was written"));
            for wrong in wrong {
                assert!(told.contains(wrong), "{command} {scenarios:?}: {wrong} is not in {told}");
                assert!(texts.iter().all(|text| text.contains(wrong)), "{command} {scenarios:?}: {wrong} {texts:?}");
            }
        }
    }
}

#[test]
fn a_log_of_an_application_is_not_judged_by_a_shipped_scenario_of_its_name() {
    let folder = tempdir().expect("a folder");
    let path = folder.path();
    assert!(call(path, &["init", "robot"]).status.success());
    let own = "robot/battery_fault.toml";
    for (scenario, log) in [(own, "own.jsonl"), ("battery_fault", "shipped.jsonl")] {
        let done = call(path, &["run", scenario, "-q", "--no-snapshots", "--record", log]);
        assert!(done.status.success(), "{}", stderr(&done));
    }
    let judge = |log: &str, more: &[&str]| call(path, &[&["verify", log, "--property", "phi1"], more].concat());
    let refused = judge("own.jsonl", &[]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(stderr(&refused).contains("name the scenario's file: `--scenario FILE`"), "{}", stderr(&refused));
    let verdicts = [judge("own.jsonl", &["--scenario", own]), judge("shipped.jsonl", &[])];
    assert_eq!(verdicts.map(|done| done.status.code()), [Some(1), Some(1)]);
}
