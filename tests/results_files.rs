//! Files with results for CI systems: `--results FILE`. `ci_results.py` reads them with programs of others.

use std::path::Path;
use std::process::{Command, Stdio};

use serde_json::{Value, json};
use tempfile::tempdir;

use crate::steward::{binary, refusal};

/// Runs a command in a folder. Returns its exit status, the SARIF file's run, and the Markdown file.
fn results(folder: &Path, arguments: &[&str]) -> (Option<i32>, Value, String) {
    let to = ["--results", "to/ci.sarif", "--results", "to/ci.md", "--results", "to/ci.XML"];
    let done = Command::new(binary()).args(arguments).args(to).current_dir(folder).output().expect("it starts");
    let read = |name: &str| std::fs::read_to_string(folder.join("to").join(name)).expect("it was written");
    assert!(read("ci.XML").starts_with("<?xml"));
    let sarif: Value = serde_json::from_str(&read("ci.sarif")).expect("SARIF is JSON");
    (done.status.code(), sarif["runs"][0].clone(), read("ci.md"))
}

#[test]
fn results_of_a_run_that_is_not_as_expected_are_in_all_formats() {
    let folder = tempdir().expect("a folder");
    let run = ["run", "battery_fault", "--no-snapshots", "--quiet"];
    let (status, sarif, summary) = results(folder.path(), &run);
    assert_eq!((status, &sarif["results"]), (Some(0), &json!([])));
    assert!(summary.contains("| battery\\_fault | phi1 | violated | passed |"), "{summary}");
    assert!(summary.contains("### phi1: violated") && summary.contains("1. Required: "), "{summary}");
    assert!(summary.contains("[report](../out/battery_fault/report.html)"), "{summary}");

    let (status, sarif, summary) = results(folder.path(), &[&run[..], &["--set", "expect.phi1=satisfied"]].concat());
    let message = "phi1 was expected to be satisfied and is violated";
    let of_phi1 = |result: &&Value| result["ruleId"] == "property/phi1";
    let found = sarif["results"].as_array().expect("results").iter().find(of_phi1).expect("one about phi1");
    assert_eq!((status, &found["level"]), (Some(1), &json!("error")));
    assert!(found["message"]["text"].as_str().is_some_and(|text| text.contains(message)), "{found}");
    let place = &found["locations"][0]["physicalLocation"];
    assert_eq!(place["artifactLocation"], json!({ "uri": "properties/phi1.scope", "uriBaseId": "STEWARD" }));
    let steps = found["codeFlows"][0]["threadFlows"][0]["locations"].as_array().expect("steps");
    let last = &steps.last().expect("a step")["location"]["message"]["text"];
    assert!(steps.len() > 1 && last.as_str().is_some_and(|text| text.starts_with("phi1 is violated")), "{steps:?}");
    assert!(summary.contains(&format!("| violated | **failed**: {message} |")), "{summary}");
}

/// The place of the first result about a property, and those of the steps that led to it: file and line.
fn places(sarif: &Value, property: &str) -> (String, Vec<String>) {
    let place = |location: &Value| {
        let physical = &location["physicalLocation"];
        let uri = physical["artifactLocation"]["uri"].as_str().expect("an address");
        format!("{uri}:{}", physical["region"]["startLine"])
    };
    let is_about = |result: &&Value| result["ruleId"] == format!("property/{property}");
    let found = sarif["results"].as_array().expect("results").iter().find(is_about).expect("one about the property");
    let steps = found["codeFlows"][0]["threadFlows"][0]["locations"].as_array();
    let steps = steps.into_iter().flatten().map(|step| place(&step["location"])).collect();
    (place(&found["locations"][0]), steps)
}

/// Runs the binary in a folder, where it is to end with this status.
fn call(folder: &Path, status: i32, arguments: &[&str]) {
    let done = Command::new(binary()).args(arguments).current_dir(folder).output().expect("it starts");
    assert_eq!(done.status.code(), Some(status), "{arguments:?}: {}", String::from_utf8_lossy(&done.stderr));
}

#[test]
fn a_violation_in_a_log_is_at_its_property_and_its_steps_are_at_leaves() {
    let folder = tempdir().expect("a folder");
    call(folder.path(), 0, &["init", "robot"]);
    let (scenario, phi1) = ("robot/battery_fault.toml", "robot/properties/phi1.scope");
    for log in ["run.mcap", "run.jsonl"] {
        call(folder.path(), 0, &["run", scenario, "--no-snapshots", "--quiet", "--record", log]);
    }
    // A recording brings its properties and names its scenario; of an event log, the arguments do.
    let of_event_log = ["verify", "run.jsonl", "--scenario", scenario, "--property", phi1];
    for arguments in [&["verify", "run.mcap"][..], &of_event_log] {
        let (status, sarif, summary) = results(folder.path(), arguments);
        assert!(summary.contains("1. Required: The level read is never below 20 %."), "{summary}");
        let (place, steps) = places(&sarif, "phi1");
        let property = format!("{phi1}:3");
        assert_eq!((status, &place), (Some(1), &property), "{arguments:?}");
        assert_eq!(steps, ["robot/trees/recharge.xml:13".to_owned(), property], "{arguments:?}");
    }
    // A tree or a property that has changed since is not where it was; and a scenario that has, nowhere.
    let tree = folder.path().join("robot/trees/recharge.xml");
    let text = std::fs::read_to_string(&tree).expect("it is there");
    for (changed, is_same) in [
        (text.replacen("<root", "<!-- only a comment -->\n<root", 1), true),
        (text.replacen("<ReactiveFallback>", "<ReactiveFallback name=\"or\">", 1), false),
    ] {
        assert_ne!(changed, text);
        std::fs::write(&tree, changed).expect("room for a file");
        let (_, sarif, summary) = results(folder.path(), &["verify", "run.mcap"]);
        let leaf = if is_same { "robot/trees/recharge.xml:14" } else { "run.mcap:1" };
        assert_eq!(places(&sarif, "phi1"), (format!("{phi1}:3"), vec![leaf.to_owned(), format!("{phi1}:3")]));
        assert_eq!(summary.contains("trees/recharge.xml has changed since"), !is_same, "{summary}");
    }
    std::fs::write(&tree, text).expect("room for a file");
    let before = std::fs::read(folder.path().join(phi1)).expect("it is there");
    std::fs::write(folder.path().join(phi1), "property phi1 := always (BatteryReader, BatteryLevel, m[2] > 1)\n")
        .expect("room for a file");
    let (_, sarif, summary) = results(folder.path(), &["verify", "run.mcap"]);
    assert_eq!(places(&sarif, "phi1").0, "run.mcap:1");
    assert!(summary.contains("phi1 has changed since"), "{summary}");
    std::fs::write(folder.path().join(phi1), before).expect("room for a file");
    let text = std::fs::read_to_string(folder.path().join(scenario)).expect("it is there");
    std::fs::write(folder.path().join(scenario), text + "# changed\n").expect("room for a file");
    let (_, sarif, summary) = results(folder.path(), &["verify", "run.mcap"]);
    assert_eq!(places(&sarif, "phi1"), ("run.mcap:1".to_owned(), vec!["run.mcap:1".to_owned(); 2]));
    assert!(summary.contains("has changed since"), "{summary}");
    // A property that comes with steward is not the file of the same name beside the scenario.
    let of_scenario = ["verify", "run.jsonl", "--scenario", scenario, "--property", "phi1"];
    for arguments in [&["verify", "run.mcap", "--property", "phi1"][..], &of_scenario] {
        let (_, sarif, _) = results(folder.path(), arguments);
        let place = &sarif["results"][0]["locations"][0]["physicalLocation"];
        assert_eq!(place["artifactLocation"]["uriBaseId"], "STEWARD", "{arguments:?}");
    }
    // No scenario says where the processes of a bag are written.
    call(folder.path(), 0, &["init", "real", "--template", "recording"]);
    let mapping = ["--property", "real/nav2.scope", "--map-channels", "real/mapping.toml"];
    let (_, sarif, summary) = results(folder.path(), &[&["verify", "real/nav2.mcap"][..], &mapping].concat());
    assert!(summary.contains("1. Required: When the battery is low, it drives slowly."), "{summary}");
    let (place, mut steps) = places(&sarif, "slow_when_low");
    assert!(place.starts_with("real/nav2.scope:") && steps.pop() == Some(place), "{sarif}");
    assert_eq!(steps, ["real/nav2.mcap:1"; 2]);
}

#[test]
fn the_rates_of_merged_shards_are_at_their_properties() {
    let folder = tempdir().expect("a folder");
    call(folder.path(), 0, &["init", "robot"]);
    let campaign = "scenario = \"robot/battery_fault.toml\"\nruns = 2\n";
    std::fs::write(folder.path().join("camp.toml"), campaign).expect("room for a file");
    for shard in ["0/2", "1/2"] {
        call(folder.path(), 0, &["campaign", "camp.toml", "--quiet", "--shard", shard]);
    }
    let (status, sarif, summary) = results(folder.path(), &["campaign", "merge", "out/camp", "--out", "merged"]);
    let rate = &sarif["results"][0];
    assert_eq!((status, &rate["ruleId"]), (Some(0), &json!("violation-rate")), "{sarif}");
    let place = &rate["locations"][0]["physicalLocation"];
    let expected = json!({ "uri": "robot/properties/phi1.scope", "uriBaseId": "%SRCROOT%" });
    assert_eq!((&place["artifactLocation"], &place["region"]["startLine"]), (&expected, &json!(3)));
    assert!(summary.contains("robot/properties/phi1.scope:3:10"), "{summary}");
    // Where the campaign's file is not, the rate has no place.
    std::fs::remove_file(folder.path().join("camp.toml")).expect("it is there");
    let (status, sarif, _) = results(folder.path(), &["campaign", "merge", "out/camp", "--out", "again"]);
    assert_eq!((status, &sarif["results"]), (Some(0), &json!([])), "{sarif}");
    assert!(sarif["invocations"].to_string().contains("phi1: violated"), "{sarif}");
}

#[test]
fn failures_of_a_matrix_are_at_their_properties_with_what_led_to_them() {
    let folder = tempdir().expect("a folder");
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("room for a file");
    write("strict.scope", "property strict := always (BatteryReader, BatteryLevel, m[1] = <ok> implies m[2] >= 45)\n");
    write("sound.toml", "base = \"nominal\"\nproperties = [\"strict.scope\"]\n[expect]\n");
    write("faulty.toml", "base = \"sound.toml\"\n[[faults]]\nkind = \"battery_level\"\nat_s = 5000\nlevel_pct = 10\n");
    let matrix = ["matrix", "faulty.toml", "--fault-free", "sound.toml", "--runs", "1", "--quiet"];
    let (status, sarif, summary) = results(folder.path(), &matrix);
    // Before the fault, and without one: each once, and no result repeats them.
    let results = sarif["results"].as_array().expect("results");
    assert!(results.iter().all(|result| result["ruleId"] == "property/strict"), "{sarif}");
    assert_eq!((status, results.len()), (Some(1), 2), "{sarif}");
    let (place, mut steps) = places(&sarif, "strict");
    assert_eq!((place.as_str(), steps.pop().as_deref()), ("strict.scope:1", Some("strict.scope:1")));
    assert_eq!(steps, ["trees/recharge.xml:13"]);
    assert!(summary.contains("strict is violated without a fault, with seed 1"), "{summary}");
    // A story of each.
    for title in ["strict is violated without a fault, with seed 1", "strict is violated although no fault took effect"]
    {
        assert!(summary.contains(&format!("### {title}\n\n1. Required: ")), "{summary}");
    }
}

#[test]
fn the_properties_of_a_model_are_at_their_places() {
    let folder = tempdir().expect("a folder");
    let model = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/roaml/tests/models/lift");
    std::fs::create_dir(folder.path().join("lift")).expect("room for a folder");
    for file in std::fs::read_dir(model).expect("a folder").map(|file| file.expect("a file")) {
        std::fs::copy(file.path(), folder.path().join("lift").join(file.file_name())).expect("room for a file");
    }
    let run = ["run", "lift/main.xml", "--no-snapshots", "--quiet", "--set", "expect.never_above_three=violated"];
    let (status, sarif, _) = results(folder.path(), &run);
    assert_eq!((status, places(&sarif, "never_above_three").0.as_str()), (Some(1), "lift/properties.jani:15"));
    let junit = std::fs::read_to_string(folder.path().join("to/ci.XML")).expect("it was written");
    assert!(junit.contains("name=\"never_above_three\" file=\"lift/properties.jani\" line=\"15\">"), "{junit}");
    // Its recording has no formula for it.
    call(folder.path(), 0, &["run", "lift/main.xml", "--no-snapshots", "--quiet", "--record", "lift.mcap"]);
    let (status, _, summary) = results(folder.path(), &["verify", "lift.mcap"]);
    let line = line(&summary, "| lift.mcap | never\\_above\\_three |");
    assert!(status == Some(0) && line.contains("skipped: not judged: no formula describes it"), "{line}");
    // Nobody has written the scenario that runs a model.
    let (_, sarif, _) = results(folder.path(), &["prove", "lift/main.xml", "--quiet"]);
    let place = &sarif["results"][0]["locations"][0]["physicalLocation"];
    let whole = json!({ "uri": "lift/main.xml", "uriBaseId": "%SRCROOT%" });
    assert_eq!((&place["artifactLocation"], &place["region"]), (&whole, &json!({ "startLine": 1 })), "{sarif}");
}

#[test]
fn results_show_where_a_file_is_wrong() {
    let folder = tempdir().expect("a folder");
    let text = "// grün\nproperty p := always (BatteryReader, BatteryLevl, m[2] > 1)\n";
    std::fs::write(folder.path().join("wrong.scope"), text).expect("room for a file");
    let scenario = "skill.toml";
    std::fs::write(folder.path().join(scenario), "base = \"nominal\"\nproperties = [\"wrong.scope\"]\n")
        .expect("room for a file");
    // The check of a file, and a run that loads it.
    for arguments in [["check", "wrong.scope"], ["run", scenario]] {
        let (status, sarif, summary) = results(folder.path(), &arguments);
        let result = &sarif["results"][0];
        assert_eq!((status, &result["ruleId"]), (Some(2), &json!("file-error")), "{sarif}");
        let place = &result["locations"][0]["physicalLocation"];
        assert_eq!(place["artifactLocation"], json!({ "uri": "wrong.scope", "uriBaseId": "%SRCROOT%" }));
        assert_eq!(place["region"]["startLine"], 2);
        let offset = place["region"]["charOffset"].as_u64().and_then(|at| usize::try_from(at).ok()).expect("an offset");
        let marked: String = text.chars().skip(offset).collect();
        assert!(marked.starts_with("BatteryLevl") || marked.starts_with("(BatteryReader"), "{marked}");
        assert!(summary.contains("wrong.scope:2:"), "{summary}");
    }
}

#[test]
fn results_show_where_a_file_is_wrong_by_which_a_log_is_judged() {
    let folder = tempdir().expect("a folder");
    let log = ["run", "battery_fault", "--no-snapshots", "--quiet", "--record", "run.jsonl"];
    call(folder.path(), 0, &log);
    std::fs::write(folder.path().join("foo.scope"), "property p := always (foo, BatteryLevel, m[2] > 1)\n")
        .expect("room for a file");
    let (status, sarif, summary) = results(folder.path(), &["verify", "run.jsonl", "--property", "foo.scope"]);
    assert_eq!((status, &sarif["results"][0]["ruleId"]), (Some(2), &json!("file-error")), "{sarif}");
    assert!(line(&summary, "| run.jsonl | run.jsonl |").contains("foo.scope:1:"), "{summary}");
    // A file that is missing is no place, and nothing was judged.
    let verify = ["verify", "nosuch.btlog", "--property", "phi1"];
    for (arguments, said) in
        [(&verify[..], "cannot read the log nosuch.btlog"), (&["check", "nosuch.toml"], "nosuch.toml")]
    {
        let (status, sarif, _) = results(folder.path(), arguments);
        assert_eq!((status, &sarif["results"]), (Some(2), &json!([])), "{sarif}");
        let invocation = &sarif["invocations"][0];
        let notification = &invocation["toolExecutionNotifications"][0];
        assert_eq!((&invocation["executionSuccessful"], &notification["level"]), (&json!(false), &json!("error")));
        assert!(notification["message"]["text"].as_str().is_some_and(|text| text.contains(said)), "{sarif}");
    }
}

/// The line of the summary's table that begins like this.
fn line<'s>(summary: &'s str, start: &str) -> &'s str {
    let line = summary.lines().find(|line| line.starts_with(start));
    line.unwrap_or_else(|| panic!("no line begins with {start:?}: {summary}"))
}

#[test]
fn what_says_nothing_is_not_shown_as_passed() {
    let folder = tempdir().expect("a folder");
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("room for a file");
    // Runs that are not as expected, and a goal that two runs do not decide.
    write(
        "camp.toml",
        "scenario = \"battery_fault\"\nruns = 2\nset = ['expect.phi1=\"satisfied\"']\n[goal]\ntest = \"phi1\"\n\
         bound = 0.5\nindifference = 0.05\nerror = 0.01\n",
    );
    let (status, _, summary) = results(folder.path(), &["campaign", "camp.toml", "--quiet"]);
    let runs = line(&summary, "| camp.toml | 2 runs of ");
    assert!(status == Some(0) && runs.contains("0 as expected, 2 not") && runs.contains("| skipped: "), "{runs}");
    assert!(line(&summary, "| camp.toml | goal |").contains("| skipped: not reached"), "{summary}");
    // A fault that never comes.
    let never = "base = \"battery_fault\"\n[expect]\nphi1 = \"satisfied\"\n[[faults]]\nkind = \"battery_level\"\n\
                 at_s = 5000\nlevel_pct = 10\n";
    write("never.toml", never);
    let matrix = ["matrix", "never.toml", "--fault-free", "nominal", "--runs", "1", "--quiet"];
    let (_, sarif, summary) = results(folder.path(), &matrix);
    assert!(line(&summary, "| never | phi1 |").contains("| skipped: "), "{summary}");
    assert!(sarif["invocations"].to_string().contains("no property detects the fault of never"), "{sarif}");
    // Monitors that are off.
    let run = ["run", "battery_fault", "--no-snapshots", "--quiet", "--no-monitors"];
    let (_, sarif, summary) = results(folder.path(), &run);
    assert!(
        line(&summary, "| battery\\_fault | phi1 |").contains("skipped: not judged: monitors were off"),
        "{summary}"
    );
    assert!(sarif["invocations"].to_string().contains("no property was judged"), "{sarif}");
    // A condition that never occurs, in a run and in its log; and a log in which nothing happens.
    write("never.scope", "property never := always ((BatteryReader, BatteryLevel, m[2] < 0) implies next false)\n");
    let run = ["run", "battery_fault", "--no-snapshots", "--quiet", "--record", "run.jsonl"];
    let set = ["--set", "properties=[\"never.scope\"]", "--set", "expect={}"];
    let (_, _, summary) = results(folder.path(), &[&run[..], &set].concat());
    assert!(line(&summary, "| battery\\_fault | never |").contains("| satisfied | skipped: "), "{summary}");
    // What no message told.
    let unheard = "base = \"errand\"\nproperties = [\"reserve.scope\"]\nexecution.max_time_s = 20\nexpect = {}\n\
                   battery.initial_pct = 80\n\
                   [[faults]]\nkind = \"battery_level\"\nat_s = 12\nlevel_pct = 12\n\
                   [[faults]]\nkind = \"component_frozen\"\ncomponent = \"BatteryReader\"\nat_s = 10\n";
    write("reserve.scope", "property reserve := always not (BatteryReader, BatteryLevel, level < 25)\n");
    write("unheard.toml", unheard);
    let run = ["run", "unheard.toml", "--no-snapshots", "--quiet", "--record", "unheard.mcap"];
    for (arguments, of) in [(&run[..], "unheard"), (&["verify", "unheard.mcap"], "unheard.mcap")] {
        let (_, sarif, summary) = results(folder.path(), arguments);
        let line = line(&summary, &format!("| {of} | reserve |"));
        assert!(line.contains("| satisfied | skipped: no message carries a level below 25 %"), "{line}");
        assert!(sarif["invocations"].to_string().contains("reserve: no message carries"), "{sarif}");
    }
    // What a proof assumes.
    let (_, sarif, summary) = results(folder.path(), &["prove", "nominal", "--property", "phi1", "--quiet"]);
    let assumed = "Trips take at most";
    assert!(summary.contains(assumed) && sarif["invocations"].to_string().contains(assumed), "{summary}");
}

#[test]
fn what_an_error_leaves_out_is_in_results_beside_what_came_before() {
    let folder = tempdir().expect("a folder");
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("room for a file");
    write("file", "");
    let prove = ["prove", "nominal", "errand", "--property", "phi2", "--quiet", "--out", "file/x"];
    let (status, sarif, summary) = results(folder.path(), &prove);
    assert_eq!((status, &sarif["invocations"][0]["executionSuccessful"]), (Some(3), &json!(false)), "{sarif}");
    assert!(line(&summary, "| nominal | runs are written |").contains("**error**: cannot write file/x"), "{summary}");
    assert!(line(&summary, "| errand | phi2 |").contains("not searched | **error**: "), "{summary}");
    // Mutants: the second scenario has more states than can be searched.
    let leaf = "<root BTCPP_format=\"4\" main_tree_to_execute=\"t\"><BehaviorTree ID=\"t\"><Sequence><Action ID=\"Leaf\"/>                </Sequence></BehaviorTree></root>";
    let scenario = "tree = \"tree.xml\"\nskills = \"SKILLS\"\nproperties = []\n[execution]\nmax_time_s = 5\n\
                    [prove]\nproperties = [\"progress\"]\n";
    let machine = "<scxml xmlns=\"http://www.w3.org/2005/07/scxml\" version=\"1.0\" datamodel=\"ecmascript\">\n\
                   <datamodel><data id=\"n\" expr=\"0\"/></datamodel>\n<state id=\"here\">\n\
                   <transition event=\"BT.tick\">COUNT<send type=\"channel\" target=\"BT\" event=\"success\"/></transition>\n\
                   <transition event=\"BT.halt\"><send type=\"channel\" target=\"BT\" event=\"halted\"/></transition>\n\
                   </state>\n</scxml>\n";
    write("tree.xml", leaf);
    for (name, count) in [("fine", ""), ("endless", "<assign location=\"n\" expr=\"n + 1\"/>")] {
        write(&format!("{name}.toml"), &scenario.replace("SKILLS", name));
        std::fs::create_dir(folder.path().join(name)).expect("room for a folder");
        write(&format!("{name}/Leaf.scxml"), &machine.replace("COUNT", count));
    }
    let mutants = ["prove", "fine.toml", "endless.toml", "nominal", "--mutants", "--quiet"];
    let (status, sarif, summary) = results(folder.path(), &mutants);
    assert_eq!((status, &sarif["invocations"][0]["executionSuccessful"]), (Some(2), &json!(false)), "{sarif}");
    assert!(summary.contains("| fine | Leaf: "), "{summary}");
    let unsearched = "| mutants are searched | not searched | **error**: ";
    assert!(summary.contains(&format!("| endless {unsearched}")) && summary.contains("65536 states"), "{summary}");
    assert!(summary.contains(&format!("| nominal {unsearched}an error about another scenario")), "{summary}");
    // A matrix whose page cannot be written.
    let matrix = ["matrix", "battery_fault", "--fault-free", "nominal", "--runs", "1", "--quiet", "--out", "file/x"];
    let (status, sarif, summary) = results(folder.path(), &matrix);
    assert_eq!((status, &sarif["invocations"][0]["executionSuccessful"]), (Some(3), &json!(false)), "{sarif}");
    assert!(line(&summary, "| battery\\_fault | phi1 |").ends_with("| passed |"), "{summary}");
    assert!(line(&summary, "| file/x | file/x |").contains("**error**: cannot write file/x"), "{summary}");
    assert!(!summary.contains("index.html"), "{summary}");
    // A campaign that is not started over where something else is.
    std::fs::create_dir(folder.path().join("camp")).expect("room for a folder");
    write("camp/journal.jsonl", "{}\n");
    write("camp.toml", "scenario = \"nominal\"\nruns = 1\n");
    let (status, _, summary) = results(folder.path(), &["campaign", "camp.toml", "--fresh", "--out", "camp"]);
    let line = line(&summary, "| camp.toml | camp.toml |");
    assert!(status == Some(2) && line.contains("**error**: camp/journal.jsonl is not the journal"), "{summary}");
}

#[test]
fn the_page_of_a_run_that_a_proof_found_is_linked() {
    let folder = tempdir().expect("a folder");
    let prove = ["prove", "nominal", "--property", "phi2", "--quiet", "--out", "runs", "--replay"];
    let (_, sarif, summary) = results(folder.path(), &prove);
    let files = ["report.html", "sequence-phi2.png"].map(|file| format!("runs/phi2/{file}"));
    assert!(summary.contains(&format!("[report](../{}) · [picture](../{})", files[0], files[1])), "{summary}");
    assert!(files.iter().all(|file| folder.path().join(file).is_file()));
    let simulated = "phi2: run in the simulation: ";
    assert!(summary.contains(simulated) && sarif["invocations"].to_string().contains(simulated), "{summary}");
}

#[test]
fn results_of_the_same_name_are_told_apart() {
    let folder = tempdir().expect("a folder");
    for name in ["a", "b"] {
        std::fs::create_dir(folder.path().join(name)).expect("room for a folder");
        let text = "base = \"nominal\"\nexpect = {}\n";
        std::fs::write(folder.path().join(name).join("x.toml"), text).expect("room for a file");
    }
    let prove = ["prove", "a/x.toml", "b/x.toml", "--property", "phi2", "--quiet"];
    for arguments in [&prove[..], &["check", "a/x.toml", "a/x.toml", "nominal"]] {
        let _ = results(folder.path(), arguments);
        let junit = std::fs::read_to_string(folder.path().join("to/ci.XML")).expect("it was written");
        let suites = junit.split("<testsuite name=\"").skip(1).filter_map(|suite| suite.split('"').next());
        let expected = if arguments[0] == "prove" {
            vec!["x (a/x.toml)", "x (b/x.toml)"]
        } else {
            vec!["a/x.toml", "a/x.toml (2)", "nominal"]
        };
        assert_eq!(suites.collect::<Vec<_>>(), expected);
    }
    for option in ["--out", "--promela"] {
        let (status, sarif, summary) = results(folder.path(), &[&prove[..], &[option, "to/x"]].concat());
        assert!(status == Some(2) && summary.contains("would both write to to/x/x"), "{sarif}");
    }
}

#[test]
fn the_name_of_a_file_says_the_format_of_its_results() {
    for name in ["results", "results.json"] {
        let said = refusal(&["run", "battery_fault", "--results", name]);
        assert!(said.contains("ends in .xml (JUnit), .sarif (SARIF) or .md (Markdown)"), "{said}");
    }
}

#[test]
fn results_replace_earlier_results_and_nothing_else() {
    let folder = tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).to_str().expect("a path in UTF-8").to_owned();
    let robot = path("robot");
    call(folder.path(), 0, &["init", &robot]);
    std::fs::write(path("notes.md"), "# steward at our site\n\nWhat we know of it.\n").expect("room for a file");
    std::fs::write(path("other.sarif"), "{ \"version\": \"2.1.0\", \"runs\": [] }").expect("room for a file");
    let comment = "<!-- <testsuites name=\"steward\" --><root/>";
    std::fs::write(path("commented.xml"), comment).expect("room for a file");
    let (tree, scenario) = (format!("{robot}/trees/recharge.xml"), format!("{robot}/battery_fault.toml"));
    for (option, file) in [
        ("--results", &tree),
        ("--junit", &tree),
        ("--results", &path("commented.xml")),
        ("--results", &path("notes.md")),
        ("--results", &path("other.sarif")),
    ] {
        let before = std::fs::read(file).expect("it is there");
        let said = refusal(&["run", &scenario, "--out", &path("out"), option, file]);
        assert!(said.contains("exists and contains no results of steward"), "{said}");
        assert_eq!(std::fs::read(file).expect("it is there"), before, "{option} {file}");
        assert!(!Path::new(&path("out")).exists(), "it is refused before the run");
    }
    // Files for something else, and what can be no file.
    std::fs::write(path("empty.xml"), "").expect("room for a file");
    let (record, empty) = (path("z.md"), path("empty.xml"));
    let twice = "the command line names it twice";
    for arguments in [["run", &scenario, "--record", &record], ["run", &scenario, "--gif", &record]] {
        let said = refusal(&[&arguments[..], &["--results", &record]].concat());
        assert!(said.contains(twice) && !Path::new(&record).exists(), "{said}");
    }
    let said = refusal(&["check", &empty, "--results", &empty]);
    assert!(said.contains(twice) && Path::new(&empty).exists(), "{said}");
    std::fs::create_dir(path("folder.md")).expect("room for a folder");
    for impossible in [path("folder.md"), path("empty.xml/ci.md")] {
        let said = refusal(&["check", &scenario, "--results", &impossible]);
        assert!(said.contains("it is a folder, or below a file"), "{said}");
    }
    std::fs::create_dir(path("to")).expect("room for a folder");
    std::fs::write(path("to/ci.sarif"), "").expect("room for a file");
    // Those of another command, too, and those without any result.
    for arguments in [&["check", &scenario][..], &["run", "no such scenario"], &["check", &scenario]] {
        let (_, sarif, summary) = results(folder.path(), arguments);
        let id = sarif["automationDetails"]["id"].as_str().expect("an id");
        assert!(id.contains(arguments[0]) && summary.starts_with(&format!("# steward {}", arguments[0])), "{id}");
    }
}

#[test]
fn two_results_files_with_one_path_are_refused() {
    let folder = tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).to_str().expect("a path in UTF-8").to_owned();
    std::fs::write(path("empty.xml"), "").expect("room for a file");
    std::fs::hard_link(path("empty.xml"), path("hard.xml")).expect("room for a link");
    let (out, log) = (path("out"), path("run.jsonl"));
    let run = ["run", "nominal", "--out", &out];
    let verify = ["verify", &log, "--scenario", "nominal", "--property", "phi1"];
    for command in [&run[..], &["check", "nominal"], &verify] {
        for [one, other] in [["a.xml", "a.xml"], ["a.xml", "./a.xml"], ["empty.xml", "hard.xml"]] {
            let (one, other) = (path(one), path(other));
            let said = refusal(&[command, &["--results", &one, "--results", &other]].concat());
            let said = said.split_whitespace().filter(|word| *word != "|").collect::<Vec<_>>().join(" ");
            assert!(said.contains("the command line names it twice"), "{command:?} {one} {other}: {said}");
            assert!(!Path::new(&out).exists() && !Path::new(&path("a.xml")).exists(), "{command:?}");
        }
    }
    assert!(Path::new(&path("empty.xml")).exists() && Path::new(&path("hard.xml")).exists());
}

#[cfg(unix)]
#[test]
fn results_of_an_earlier_command_do_not_outlive_the_beginning_of_the_next() {
    let folder = tempdir().expect("a folder");
    let files = ["to/ci.sarif", "to/ci.md", "to/ci.XML"];
    let to: Vec<&str> = files.iter().flat_map(|file| ["--results", file]).collect();
    let _ = results(folder.path(), &["check", "nominal"]);
    let are_there = || files.map(|file| folder.path().join(file).exists());
    call(folder.path(), 2, &[&["check", "nominal", "--no-such-option"][..], &to].concat());
    assert_eq!(are_there(), [true; 3], "the command line was wrong");
    // Not even if nothing can be printed.
    let full = std::fs::File::options().write(true).open("/dev/full").expect("a full device");
    let check =
        Command::new(binary()).args(["check", "nominal"]).args(&to).current_dir(folder.path()).stdout(full).output();
    assert_eq!((check.expect("it starts").status.code(), are_there()), (Some(3), [false; 3]));
    // A link remains one, and a pipe is left alone.
    std::fs::write(folder.path().join("target.md"), "").expect("room for a file");
    std::os::unix::fs::symlink("target.md", folder.path().join("link.md")).expect("room for a link");
    call(folder.path(), 0, &["check", "nominal", "--results", "link.md", "--junit", "/dev/null"]);
    assert!(folder.path().join("link.md").is_symlink() && folder.path().join("target.md").is_file());
    assert!(Path::new("/dev/null").exists());

    let _ = results(folder.path(), &["check", "nominal"]);
    let endless = ["run", "nominal", "--set", "stop.at=[]", "--set", "execution.max_time_s=1e8", "--out", "out"];
    let child = Command::new(binary())
        .args(endless)
        .args(&to)
        .current_dir(folder.path())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("it starts");
    // From then on, it listens.
    while !folder.path().join("out").exists() {
        std::thread::yield_now();
    }
    assert_eq!(are_there(), [false; 3]);
    let signalled = Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill runs");
    assert!(signalled.success());
    let ended = child.wait_with_output().expect("it ends");
    let said = String::from_utf8_lossy(&ended.stderr);
    assert_eq!(ended.status.code(), Some(130), "{said}");
    for file in files {
        assert!(said.contains(&format!("{file} was not written: the run was interrupted\n")), "{said}");
    }
    assert_eq!(are_there(), [false; 3]);
}
