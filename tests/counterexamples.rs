//! The files of runs that `steward prove` finds, and schedules that runs follow.

use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Command, Stdio};

use serde_json::Value;
use tempfile::tempdir;

use crate::steward::{binary, picture_size, refusal, report, steward};

fn path(path: &Path) -> &str {
    path.to_str().expect("a path in UTF-8")
}

/// The results of a proof that writes its runs to a folder.
fn proved(out: &Path, arguments: &[&str]) -> Value {
    let output = steward(&[&["prove", "--json", "--out", path(out)], arguments].concat());
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(matches!(output.status.code(), Some(0 | 1)), "{arguments:?}: {said}");
    serde_json::from_slice(&output.stdout).expect("the results are JSON")
}

#[test]
fn a_counterexample_has_a_scenario_a_schedule_and_a_chart() {
    let folder = tempdir().expect("a folder");
    let proof = proved(folder.path(), &["nominal", "--property", "phi2", "--set", "execution.tree=nodes"]);
    let found = folder.path().join("phi2");
    assert_eq!(picture_size(&found.join("sequence-phi2.png")).0, 960);
    let svg = fs::read_to_string(found.join("sequence-phi2.svg")).expect("a chart");
    for words in
        ["the robot comes to RechargingStation, the level is 30 %", "phi2 is violated", "missing until tick 10"]
    {
        assert!(svg.contains(words), "{words}");
    }
    let again = folder.path().join("again");
    let report = report(path(&found.join("counterexample.toml")), &again, &[]);
    assert_eq!((&report["outcome"], &report["ended"]), (&"as_expected".into(), &"schedule".into()));
    let verdict = &report["monitors"][1];
    assert_eq!((&verdict["name"], &verdict["verdict"]), (&"phi2".into(), &"violated".into()));
    assert_eq!(verdict["tick"], proof["properties"][0]["run"]["decided_at_tick"]);
    let pages = [&found, &again].map(|folder| fs::read_to_string(folder.join("report.html")).expect("a page"));
    assert!(pages.iter().all(|page| page.contains("the robot comes to RechargingStation, the level is 30 %")));
}

/// The files of an application and of its runs can be moved together.
#[test]
fn a_counterexample_names_files_from_its_own_folder() {
    let folder = tempdir().expect("a folder");
    let [mine, moved] = ["mine", "moved"].map(|name| folder.path().join(name));
    fs::create_dir(&mine).expect("a new folder");
    let (scenario, machine) = (mine.join("own.toml"), mine.join("FollowPath.scxml"));
    fs::write(&scenario, "base = \"nav2/halted_early\"\n").expect("room for a scenario");
    fs::copy("skills/machines/nav2/FollowPath.scxml", &machine).expect("it is shipped");
    let set = format!("leaves.FollowPath.machine='{}'", machine.display());
    let proof = proved(&mine.join("out"), &[path(&scenario), "--property", "stands_still", "--set", &set]);
    assert_eq!(proof["properties"][0]["result"], "violated", "{proof:#}");
    let file = "out/stands_still/counterexample.toml";
    let text = fs::read_to_string(mine.join(file)).expect("a scenario");
    assert!(text.contains("base = \"../../own.toml\"") && text.contains("\"FollowPath.scxml\""), "{text}");
    assert!(!text.contains("\"/") && !text.contains("'/") && !text.contains(path(folder.path())), "{text}");
    fs::rename(&mine, &moved).expect("the new name is free");
    let out = folder.path().join("again");
    let run = steward(&["run", path(&moved.join(file)), "--no-snapshots", "--out", path(&out)]);
    assert_eq!(run.status.code(), Some(0), "{}", String::from_utf8_lossy(&run.stderr));
}

#[test]
fn the_runs_of_several_proofs_are_written_and_followed() {
    let folder = tempdir().expect("a folder");
    // The command fails if the files do not lead to the same verdict.
    let proofs = proved(folder.path(), &["nominal", "nav2/*"]);
    let name = |it: &Value, key: &str| it[key].as_str().expect("a name").to_owned();
    let mut found = Vec::new();
    for proof in proofs.as_array().expect("a list") {
        let all = proof["properties"].as_array().expect("properties").iter();
        for property in all.filter(|property| property["result"] == "violated") {
            assert_eq!(property["run"]["replayed"], true, "{property:#}");
            found.push(name(proof, "scenario") + "/" + &name(property, "property"));
        }
    }
    found.sort_unstable();
    assert_eq!(found, ["nav2/canceled_goal/new_goal", "nav2/halted_early/stands_still", "nominal/phi2"]);
    for run in found {
        for file in ["counterexample.toml", "schedule.toml", "report.html"] {
            assert!(folder.path().join(&run).join(file).is_file(), "{run}: {file}");
        }
    }
}

#[test]
fn a_schedule_that_does_not_fit_is_refused_at_the_first_such_step() {
    let folder = tempdir().expect("a folder");
    proved(folder.path(), &["nominal", "--property", "phi2"]);
    let found = folder.path().join("phi2");
    let schedule = fs::read_to_string(found.join("schedule.toml")).expect("a schedule");
    let wrong = folder.path().join("wrong.toml");
    let set = format!("execution.schedule='{}'", wrong.display());
    let to_bt = "{ process = \"TickGenerator\", transition = 0, to = \"BT\" }";
    for (from, to, said) in [
        (to_bt, to_bt.replace("TickGenerator", "TickGenerators"), "did you mean `TickGenerator`?"),
        (to_bt, to_bt.replace('0', "7"), "TickGenerator sends to BT (its transition 7) is not possible here"),
        ("{ tick = \"taken\" }", "{ tick = \"lost\" }".to_owned(), "the tree takes the tick here"),
        ("level_pct = 31,", "level_pct = 131,".to_owned(), "`level_pct` must lie between 0 and 100"),
    ] {
        fs::write(&wrong, schedule.replacen(from, &to, 1)).expect("room for a schedule");
        let refused = refusal(&["run", "nominal", "--set", &set]);
        assert!(refused.contains(said) && refused.contains("wrong.toml"), "{said}: {refused}");
        assert_eq!(refused.lines().filter(|line| line.starts_with("  x ")).count(), 1, "{refused}");
    }
    let missing = refusal(&["run", "nominal", "--set", "execution.schedule='nowhere.toml'"]);
    assert!(missing.contains("cannot read the schedule ./nowhere.toml"), "{missing}");
    let faulty = refusal(&["run", "battery_fault", "--set", &set]);
    assert!(faulty.contains("a run that follows a schedule has no faults"), "{faulty}");
}

/// An application whose only leaf answers its first tick with this, or not at all, and succeeds in the second. Returns
/// its scenario, which ends with these lines.
fn application(folder: &Path, first_answer: &str, lines: &str) -> String {
    let says = |event: &str| format!("<send type=\"channel\" target=\"BT\" event=\"{event}\"/>");
    let halts = format!("<transition event=\"BT.halt\">{}</transition>", says("halted"));
    let machine = format!(
        "<scxml xmlns=\"http://www.w3.org/2005/07/scxml\" version=\"1.0\" datamodel=\"null\">\n\
         <state id=\"i\"><transition event=\"BT.tick\" target=\"k\">{first_answer}</transition>{halts}</state>\n\
         <state id=\"k\"><transition event=\"BT.tick\">{}</transition>{halts}</state>\n</scxml>",
        says("success")
    );
    let tree = "<root BTCPP_format=\"4\"><BehaviorTree ID=\"M\"><Action ID=\"A\"/></BehaviorTree></root>";
    let scenario = format!("tree = \"tree.xml\"\nskills = \".\"\n{lines}");
    for (name, text) in [("A.scxml", machine.as_str()), ("tree.xml", tree), ("app.toml", &scenario)] {
        fs::write(folder.join(name), text).expect("room for a file");
    }
    path(&folder.join("app.toml")).to_owned()
}

/// Runs the counterexample to a property in a folder, and returns it. The run must be as expected and follow the whole
/// schedule.
fn followed(found: &Path, property: &str) -> String {
    let (file, again) = (found.join(property).join("counterexample.toml"), found.join("again"));
    let report = report(path(&file), &again, &["--no-snapshots"]);
    assert_eq!((&report["outcome"], &report["ended"]), (&"as_expected".into(), &"schedule".into()), "{report:#}");
    fs::read_to_string(file).expect("a scenario")
}

const NEVER_SUCCEEDS: &str = "always not (A, BT, m[1] = <success>)";
const NEVER_TICKED: &str = "always not (BT, A, m[1] = <tick>)";

#[test]
fn a_counterexample_expects_the_errors_of_all_its_ticks() {
    let folder = tempdir().expect("a folder");
    let lines = format!(
        "[expect.satisfied]\nt = \"{NEVER_SUCCEEDS}\"\nu = \"{NEVER_TICKED}\"\n\
         [prove.expect]\nt = \"violated\"\nu = \"violated\"\n"
    );
    let scenario = application(folder.path(), "", &lines);
    for form in ["whole", "nodes"] {
        let (out, set) = (folder.path().join(form), format!("execution.tree={form}"));
        let proof = proved(&out, &[&scenario, "--set", &set]);
        assert_eq!(proof["properties"][0]["result"], "violated", "{proof:#}");
        // The leaf's time is up before the last tick, and the tree begins that one without errors.
        assert!(followed(&out, "t").contains("expect.errors = [\"A\"]"), "{form}");
        // This one ends before that.
        assert!(followed(&out, "u").contains("expect.errors = []"), "{form}");
    }
}

#[test]
fn a_counterexample_goes_on_where_the_scenario_stops() {
    let folder = tempdir().expect("a folder");
    let running = "<send type=\"channel\" target=\"BT\" event=\"running\"/>";
    let stops = ["on_violation = true", "on_violation = [\"r\"]", "when_settled = \"r\""];
    for (number, stop) in stops.iter().enumerate() {
        let lines = format!(
            "[stop]\n{stop}\n[expect.satisfied]\nr = \"always not (A, BT, m[1] = <running>)\"\n\
             t = \"{NEVER_SUCCEEDS}\"\n[prove.expect]\nr = \"violated\"\nt = \"violated\"\n"
        );
        let scenario = application(folder.path(), running, &lines);
        let out = folder.path().join(number.to_string());
        proved(&out, &[&scenario]);
        // The other property is violated one tick earlier.
        let text = followed(&out, "t");
        assert!(text.contains("expect.\"r\" = \"violated\"\nexpect.\"t\" = \"violated\""), "{stop}: {text}");
    }
}

#[test]
fn a_run_that_cannot_be_written_does_not_keep_the_others_from_it() {
    let folder = tempdir().expect("a folder");
    let lines = format!("[expect.satisfied]\nt = \"{NEVER_SUCCEEDS}\"\nu = \"{NEVER_TICKED}\"\n");
    let scenario = application(folder.path(), "", &lines);
    let out = folder.path().join("out");
    fs::create_dir(&out).expect("a new folder");
    fs::write(out.join("t"), "").expect("room for a file");
    let output = steward(&["prove", &scenario, "--quiet", "--out", path(&out)]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{said}");
    assert!(said.contains("out/t"), "{said}");
    assert!(out.join("u").join("report.html").is_file(), "{said}");
    followed(&out, "u");
}

#[test]
fn a_folder_that_cannot_be_written_gives_one_message() {
    let folder = tempdir().expect("a folder");
    let file = folder.path().join("a file");
    fs::write(&file, "").expect("room for a file");
    let output = steward(&["prove", "nominal", "--property", "phi2", "--out", path(&file)]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{said}");
    assert!(said.contains("a file") && said.lines().count() <= 3, "{said}");
}

/// No level of at most 30 % is read before tick 5.
const SLOW: &str = "property slow := not (time_until (BatteryReader, BatteryLevel, m[2] <= 30) < 5)\n";

#[test]
fn a_run_with_impossible_levels_is_spurious_and_not_written() {
    let folder = tempdir().expect("a folder");
    let (file, out) = (folder.path().join("slow.scope"), folder.path().join("out"));
    fs::write(&file, SLOW).expect("room for a property");
    let of = |start: &str, rates: &str| {
        let sets = [
            format!("properties=['{}']", file.display()),
            "prove.properties=[]".to_owned(),
            "prove.expect={}".to_owned(),
            format!("prove.battery={{start_pct={start}, {rates}}}"),
        ];
        let sets: Vec<&str> = sets.iter().flat_map(|set| ["--set", set]).collect();
        let slow = proved(&out, &[&["nominal"], &sets[..]].concat())["properties"][0].clone();
        assert_eq!(slow["as_expected"], false, "{slow:#}");
        slow
    };
    // These rates have no sufficiently large common divisor.
    assert_eq!(of("100", "drain_pct_per_tick=0.9999, charge_pct_per_tick=1")["result"], "spurious");
    assert!(!out.join("slow").exists());
    let violated = of("33.5", "drain_pct_per_tick=1");
    assert_eq!((&violated["result"], &violated["run"]["replayed"]), (&"violated".into(), &true.into()));
    assert!(out.join("slow/counterexample.toml").is_file());
    let steps = violated["run"]["steps"].as_array().expect("steps").iter();
    let read = steps.filter(|step| step["from"] == "BatteryReader" && step["to"] == "BatteryLevel");
    let levels: Vec<f64> = read.filter_map(|step| step["message"][1].as_f64()).collect();
    assert!(levels.len() > 3 && levels.windows(2).all(|pair| pair[0] - pair[1] <= 1.0 + 1e-9), "{levels:?}");
}

#[test]
fn a_run_that_takes_longer_than_the_scenario_allows_is_followed_to_its_end() {
    let folder = tempdir().expect("a folder");
    let sets = ["prove.trips.ticks=10", "execution.max_time_s=5", "prove.expect.phi1=violated"];
    let sets: Vec<&str> = sets.iter().flat_map(|set| ["--set", set]).collect();
    let all = proved(folder.path(), &[&["nominal", "--property", "phi1", "--replay"], &sets[..]].concat());
    assert_eq!(all["properties"][0]["physics"]["violated_at_tick"], 13, "{all:#}");
    for file in ["counterexample.toml", "physics.toml"] {
        let file = folder.path().join("phi1").join(file);
        let out = folder.path().join("out");
        let run = ["run", file.to_str().expect("a path"), "--no-snapshots", "--out", out.to_str().expect("a path")];
        assert_eq!(steward(&run).status.code(), Some(0), "{}", file.display());
    }
}

#[test]
fn an_interrupted_proof_reports_its_progress() {
    let large = ["execution.tree=nodes", "prove={}", "prove.messages={lose=3, repeat=3}"];
    let large: Vec<&str> = large.iter().flat_map(|set| ["--set", set]).collect();
    let arguments = [&["prove", "nominal", "--property", "phi3", "--memory", "3000"], &large[..]].concat();
    let mut child = Command::new(binary())
        .args(arguments)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the binary starts");
    let mut stdout = BufReader::new(child.stdout.take().expect("a pipe"));
    let mut line = String::new();
    while !line.contains("states") {
        line.clear();
        assert!(stdout.read_line(&mut line).expect("text") > 0, "the table begins");
    }
    let signalled = Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill runs");
    assert!(signalled.success());
    let mut said = String::new();
    stdout.read_to_string(&mut said).expect("text");
    assert_eq!(child.wait().expect("it ends").code(), Some(130), "{said}");
    assert!(
        said.contains("! phi3 is not decided: the search was interrupted. It explored ") && said.contains(" to depth "),
        "{said}"
    );
}

#[test]
fn the_physics_show_the_violation_too_or_the_difference_is_reported() {
    let folder = tempdir().expect("a folder");
    let long = ["nominal", "--replay", "--set", "prove.trips.ticks=10", "--set", "battery.initial_pct=50"];
    let proof = proved(folder.path(), &long);
    let of = |name: &str| {
        let properties = proof["properties"].as_array().expect("properties");
        properties.iter().find(|it| it["property"] == name).expect("it is there")["physics"].clone()
    };
    // The trip from the hall to the station takes longer than 10 s.
    let tick = of("phi1")["violated_at_tick"].as_u64().expect("a tick");
    let physics = folder.path().join("phi1/physics.toml");
    let report = report(path(&physics), &folder.path().join("again"), &[]);
    assert_eq!((&report["outcome"], &report["monitors"][0]["tick"]), (&"as_expected".into(), &tick.into()));
    let difference = of("phi2")["difference"].clone();
    let expected = "at tick 1 the robot is at RechargingStation, and in the simulation it is at no place";
    assert_eq!((&of("phi2")["violated_at_tick"], &difference), (&Value::Null, &expected.into()));
    assert!(!folder.path().join("phi2/physics.toml").exists());
}
