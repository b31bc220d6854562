//! The command line as a user sees it.

mod help;

use std::path::Path;
use std::process::{Command, Stdio};

use image::AnimationDecoder;
use image::codecs::gif::GifDecoder;
use serde_json::Value;
use tempfile::tempdir;

use crate::programs::has_python;
use crate::steward::{binary, picture_size, refusal, report, steward};

#[test]
fn a_run_ends_with_a_summary_a_report_and_pictures() {
    let out = tempdir().unwrap();
    let output = steward(&["--scenario", "battery_fault", "--out", out.path().to_str().unwrap()]);
    let said = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    for part in ["battery_fault", "as expected", "phi1", "violated", "phi2", "satisfied", "report.json"] {
        assert!(said.contains(part), "does not say {part}: {said}");
    }
    let report: Value = serde_json::from_slice(&std::fs::read(out.path().join("report.json")).unwrap()).unwrap();
    let snapshots = report["snapshots"].as_array().unwrap();
    assert!(snapshots.len() >= 5, "{snapshots:?}");
    for snapshot in snapshots {
        let picture = out.path().join(snapshot["file"].as_str().unwrap());
        assert_eq!(picture_size(&picture), (1600, 900));
    }
}

#[test]
fn the_report_has_the_promised_keys() {
    let out = tempdir().unwrap();
    let report = report("battery_fault", out.path(), &["--no-snapshots"]);
    for key in [
        "scenario",
        "seed",
        "version",
        "outcome",
        "sim_time_s",
        "ticks",
        "overruns",
        "steps",
        "trace_hash",
        "monitors",
        "faults",
        "battery",
        "robot",
        "places",
        "snapshots",
        "timing",
    ] {
        assert!(!report[key].is_null(), "no {key}");
    }
    for key in ["name", "property", "verdict", "state", "tick", "time_s", "witness"] {
        assert!(report["monitors"][0].get(key).is_some(), "no monitors[].{key}");
    }
    for key in ["final_pose", "distance_m", "collisions", "localization"] {
        assert!(!report["robot"][key].is_null(), "no robot.{key}");
    }
    assert_eq!(report["faults"][0]["kind"], "battery_level");
}

#[test]
fn a_run_that_is_not_as_expected_says_what_differs_and_exits_with_one() {
    let out = tempdir().unwrap();
    let arguments = [
        "--scenario",
        "battery_fault",
        "--no-snapshots",
        "--out",
        out.path().to_str().unwrap(),
        "--set",
        "expect.phi1=satisfied",
    ];
    let output = steward(&arguments);
    assert_eq!(output.status.code(), Some(1));
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(said.contains("phi1 was expected to be satisfied and is violated"), "{said}");
}

#[test]
fn quiet_prints_nothing() {
    let out = tempdir().unwrap();
    let output =
        steward(&["--scenario", "battery_fault", "--no-snapshots", "--quiet", "--out", out.path().to_str().unwrap()]);
    assert_eq!((output.status.code(), output.stdout.len(), output.stderr.len()), (Some(0), 0, 0));
}

#[test]
fn a_failure_is_reported_even_with_quiet() {
    let out = tempdir().unwrap();
    let arguments = ["--scenario", "battery_fault", "--no-snapshots", "-q", "--set", "expect.phi1=satisfied", "--out"];
    let output = steward(&[&arguments[..], &[out.path().to_str().unwrap()]].concat());
    assert_eq!((output.status.code(), output.stdout.len()), (Some(1), 0));
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("battery_fault, seed 1: NOT as expected"), "{said}");
    assert!(said.contains("phi1 was expected to be satisfied and is violated"), "{said}");
}

#[cfg(unix)]
#[test]
fn an_interrupted_run_leaves_a_report_of_what_happened_until_then() {
    let folder = tempdir().unwrap();
    let (out, log) = (folder.path().join("out"), folder.path().join("log.jsonl"));
    let child = Command::new(binary())
        .args(["run", "nominal", "--set", "stop.at=[]", "--set", "execution.max_time_s=1e8"])
        .args(["--out", out.to_str().unwrap(), "--record", log.to_str().unwrap()])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // From then on, it listens.
    while !out.exists() {
        std::thread::yield_now();
    }
    let signalled = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(signalled.success());
    let ended = child.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&ended.stdout);
    assert_eq!(ended.status.code(), Some(130), "{said}");
    assert!(said.contains("nominal, seed 1: interrupted after ") && said.contains("report.html"), "{said}");
    assert!(out.join("report.html").exists());
    let report: Value = serde_json::from_slice(&std::fs::read(out.join("report.json")).unwrap()).unwrap();
    assert_eq!((&report["ended"], &report["outcome"]), (&"interrupted".into(), &"interrupted".into()));
    assert_eq!((&report["expectations"], &report["monitors"][0]["name"]), (&Value::Array(vec![]), &"phi1".into()));
    let log = std::fs::read_to_string(log).unwrap();
    assert!(log.ends_with('\n'));
    assert!(log.lines().all(|line| serde_json::from_str::<Value>(line).is_ok()), "{log}");
}

/// Runs the binary in its own folder; returns its output and its exit status.
fn said_in(folder: &Path, arguments: &[&str]) -> (String, Option<i32>) {
    let output = Command::new(binary()).args(arguments).current_dir(folder).output().unwrap();
    let said = [output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
    (said.concat(), output.status.code())
}

#[test]
fn several_runs_are_a_table_with_a_summary() {
    let folder = tempdir().unwrap();
    let run = ["run", "battery_fault", "errand", "skill_bug", "--no-snapshots", "--set", "expect.phi1=violated"];
    let (said, status) = said_in(folder.path(), &[&run[..], &["--junit", "all.xml"]].concat());
    assert_eq!(status, Some(1), "{said}");
    let (table, wall) = said.split_once(" simulated seconds in ").unwrap();
    insta::assert_snapshot!(table.to_owned() + " simulated seconds in …" + wall.split_once(" s:").unwrap().1, @r"
           PASS   [   51.1 s]  battery_fault
           FAIL   [  111.9 s]  errand
                               phi1 was expected to be violated and is satisfied
           FAIL   [  150.0 s]  skill_bug
                               phi1 was expected to be violated and is satisfied
         Summary  3 runs, 313 simulated seconds in … 1 passed, 2 failed
         Reports  out/NAME/report.html
    ");
    assert!(folder.path().join("out/errand/report.html").is_file());
    let junit = std::fs::read_to_string(folder.path().join("all.xml")).unwrap();
    assert_eq!((junit.matches("<testsuite ").count(), junit.matches("<failure ").count()), (3, 4), "{junit}");
    // As JSON, and in other folders.
    let seeds = ["run", "battery_fault", "faults/battery_level", "--no-snapshots", "--seed", "7"];
    let (said, status) = said_in(folder.path(), &[&seeds[..], &["--json", "--out", "more"]].concat());
    let reports: Value = serde_json::from_str(&said).unwrap_or_else(|_| panic!("{said}"));
    assert_eq!(
        (status, &reports[0]["seed"], &reports[1]["scenario"]),
        (Some(0), &7.into(), &"faults/battery_level".into())
    );
    assert!(folder.path().join("more/faults/battery_level-seed-7/report.json").is_file());
}

#[test]
fn scenarios_are_chosen_by_folder_pattern_and_part_of_a_name() {
    let folder = tempdir().unwrap();
    std::fs::create_dir(folder.path().join("mine")).unwrap();
    for (name, text) in [
        ("b.toml", "base = \"errand\"\n"),
        ("a.toml", "base = \"corridor\"\n"),
        ("campaign.toml", "scenario = \"errand\"\n"),
        ("some.places.toml", "[here]\nposition_m = [0, 0]\nheading_deg = 0\n"),
        ("pyproject.toml", "[project]\nname = \"mine\"\n"),
    ] {
        std::fs::write(folder.path().join("mine").join(name), text).unwrap();
    }
    // Refused before anything runs.
    for (arguments, count) in [
        (&["mine"][..], 2),
        (&["faults/laser_*"], 7),
        (&["faults/"], 61),
        (&["nominal", "nominal", "mine/a.toml"], 2),
        (&["faults/*", "--filter", "battery_"], 7),
        (&["--filter", "bug", "--filter", "early"], 4),
        (&["--all"], 101),
    ] {
        let (said, status) = said_in(folder.path(), &[&["run"], arguments, &["--gif", "a.gif"]].concat());
        assert_eq!(status, Some(2), "{said}");
        assert!(said.contains(&format!("`--gif` is for a single run, but {count} scenarios are to be run")), "{said}");
    }
    assert!(said_in(folder.path(), &["run", "--all", "--open"]).0.contains("note: published is left out"));
    let said = said_in(folder.path(), &["run", "mine", "--open"]).0;
    assert!(said.contains("note: mine/pyproject.toml is left out: it has no key of a scenario"), "{said}");
    for (arguments, wanted) in [
        (&["nope/*"][..], "no scenario matches `nope/*`"),
        (&["--filter", "nope"], "no scenario has `nope` in its name"),
        (&["nominal", "mine/c.toml"], "cannot read the scenario mine/c.toml: there is no such file"),
        (&["mine", "--set", "batery.x=1"], "did you mean `battery`?"),
        (&["mine/a.toml", "./mine/a.toml"], "would both write to out/a"),
    ] {
        let (said, status) = said_in(folder.path(), &[&["run"], arguments].concat());
        assert_eq!(status, Some(2), "{said}");
        assert!(said.contains(wanted), "{wanted} is missing: {said}");
    }
    assert!(!folder.path().join("out").exists());
}

#[test]
fn an_unknown_command_that_is_nearly_a_scenario_gets_a_tip() {
    for (name, tip) in [
        ("nominal", "to run a scenario: steward run nominal"),
        ("battery_faults", "a similar name exists: steward run battery_fault"),
        ("noise_short", "to run a campaign: steward campaign noise_short"),
        ("checks", "a similar subcommand exists: 'check'"),
    ] {
        let said = refusal(&[name]);
        assert!(said.contains(tip), "{said}");
    }
}

#[cfg(unix)]
#[test]
fn a_report_is_opened_in_the_browser() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempdir().unwrap();
    let (browser, opened) = (folder.path().join("browser"), folder.path().join("opened"));
    std::fs::write(&browser, format!("#!/bin/sh\necho \"$@\" > {}\n", opened.display())).unwrap();
    std::fs::set_permissions(&browser, std::fs::Permissions::from_mode(0o755)).unwrap();
    let run = |browser: &Path| {
        let mut command = Command::new(binary());
        command.args(["run", "battery_fault", "--no-snapshots", "--open"]).current_dir(folder.path());
        command.env("BROWSER", browser).env("PATH", "").output().unwrap()
    };
    let output = run(&browser);
    assert!(output.status.success() && output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
    while !std::fs::read_to_string(&opened).is_ok_and(|text| text.ends_with('\n')) {
        std::thread::yield_now();
    }
    assert!(std::fs::read_to_string(&opened).unwrap().contains("out/battery_fault/report.html"));
    let output = run(Path::new("/nowhere/browser"));
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && said.starts_with("note: cannot open out/battery_fault/report.html"), "{said}");
}

#[test]
fn list_names_the_scenarios() {
    let said = String::from_utf8(steward(&["list"]).stdout).unwrap();
    assert!(said.contains("nominal") && said.contains("battery_fault"), "{said}");
}

#[test]
fn a_closed_pipe_ends_quietly() {
    let mut child = Command::new(binary()).arg("list").stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!((output.status.code(), output.stderr.len()), (Some(0), 0));
}

#[test]
fn the_binary_works_from_any_folder_and_writes_to_out() {
    let folder = tempdir().unwrap();
    let status = Command::new(binary())
        .args(["--scenario", "battery_fault", "--no-snapshots", "--quiet"])
        .current_dir(folder.path())
        .status()
        .unwrap();
    assert!(status.success());
    assert!(folder.path().join("out/battery_fault/report.json").is_file());
}

#[test]
fn an_initialized_copy_runs_like_the_original() {
    let folder = tempdir().unwrap();
    let copy = crate::bad_input::copy_of_battery_fault(folder.path());
    let [original, copied] = [("battery_fault", "a"), (copy.to_str().unwrap(), "b")]
        .map(|(scenario, out)| report(scenario, &folder.path().join(out), &["--no-snapshots"])["trace_hash"].clone());
    assert_eq!(original, copied);
}

/// All files in a folder and its subfolders, in alphabetical order.
fn files_below(folder: &Path) -> Vec<String> {
    let entries = glob::glob(&format!("{}/**/*", folder.display())).unwrap().map(Result::unwrap);
    let files = entries.filter(|path| path.is_file());
    files.map(|path| path.strip_prefix(folder).unwrap().to_str().unwrap().to_owned()).collect()
}

/// A template has what its scenario names and nothing else, and a README that names all files and whose commands work.
#[test]
#[ignore = "long: .ci/run runs it"]
fn every_template_says_what_it_is_and_runs_at_once() {
    for template in ["recharge", "guide", "empty"] {
        if template == "guide" && !has_python() {
            continue;
        }
        let folder = tempdir().unwrap();
        let copy = folder.path().join("copy");
        std::fs::create_dir(&copy).unwrap();
        assert_eq!(said_in(folder.path(), &["init", "copy", "--template", template]).1, Some(0));
        let readme = std::fs::read_to_string(copy.join("README.md")).unwrap();
        for file in files_below(&copy) {
            assert!(file == "README.md" || readme.contains(&format!("| `{file}` | ")), "{template}: {file}");
            assert!(!file.starts_with("scenarios/"), "{template}: {file}");
            let text = std::fs::read_to_string(copy.join(&file)).unwrap_or_default();
            for named in
                text.lines().filter_map(|line| line.strip_prefix("base = ").or(line.strip_prefix("scenario = ")))
            {
                assert!(copy.join(named.trim_matches('"')).is_file(), "{template}: {file} names {named}");
            }
        }
        insta::assert_snapshot!(template, readme);
        let block = readme.split("```").nth(1).unwrap();
        for line in block.lines().filter_map(|line| line.strip_prefix("steward ")) {
            let command = line.split('#').next().unwrap().replace("--open", "--no-snapshots");
            // A few runs suffice.
            let command = command.replace("run .", "run . --filter door_").replace("--runs 8", "--runs 2");
            let (said, status) = said_in(&copy, &command.split_whitespace().collect::<Vec<_>>());
            // With a battery level of 50 %, the run is different.
            let wanted = if command.contains("--set battery") { &[Some(0), Some(1)][..] } else { &[Some(0)] };
            assert!(wanted.contains(&status), "{template}: {command}: {said}");
            assert!(!command.starts_with("check") || said.contains("; no problems found\n"), "{template}: {said}");
        }
    }
}

#[test]
fn a_template_is_not_a_scenario() {
    let said = refusal(&["init", "copy", "--template", "empty", "--scenario", "pick"]);
    assert!(said.contains("'--template <NAME>' cannot be used with '--scenario <NAME|FILE>'"), "{said}");
}

/// A user's own scenario, with the files that it names beside it.
#[test]
fn a_scenario_in_a_file_can_be_copied_too() {
    let folder = tempdir().unwrap();
    let original = crate::bad_input::copy_of_battery_fault(folder.path());
    let (beside, copy) = (original.parent().unwrap(), folder.path().join("copy"));
    std::fs::rename(beside.join("maps/house.places.toml"), beside.join("maps/mine.toml")).unwrap();
    let text = "base = \"battery_fault.toml\"\nplaces = \"maps/mine.toml\"\nabout = \"mine\"\n";
    std::fs::write(beside.join("mine.toml"), text).unwrap();
    let mine = beside.join("mine.toml");
    let output = steward(&["init", copy.to_str().unwrap(), "--scenario", mine.to_str().unwrap()]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    for file in ["mine.toml", "battery_fault.toml", "maps/mine.toml", "trees/recharge.xml"] {
        assert!(copy.join(file).is_file(), "{file}");
    }
    std::fs::remove_dir_all(beside).unwrap();
    let copied = copy.join("mine.toml");
    let output = steward(&[
        "--scenario",
        copied.to_str().unwrap(),
        "-q",
        "--no-snapshots",
        "--out",
        folder.path().to_str().unwrap(),
    ]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn an_initialized_copy_names_its_schema() {
    let folder = tempdir().unwrap();
    let copy = folder.path().join("copy");
    assert!(steward(&["init", copy.to_str().unwrap()]).status.success());
    let text = std::fs::read_to_string(copy.join("battery_fault.toml")).unwrap();
    assert!(text.starts_with("#:schema scenario.schema.json\n"), "{text}");
    let schema = std::fs::read(copy.join("scenario.schema.json")).unwrap();
    assert_eq!(schema, steward(&["schema", "scenario"]).stdout);
}

#[test]
fn every_argument_finds_shipped_files() {
    let folder = tempdir().unwrap();
    let here = |arguments: &[&str]| {
        let mut command = std::process::Command::new(binary());
        let output = command.args(arguments).current_dir(folder.path()).output().unwrap();
        let said = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
        (output.status.code(), said.concat())
    };
    let commands: [&[&str]; 11] = [
        &["tree", "show", "trees/recharge.xml"],
        &["tree", "check", "recharge"],
        &["skill", "show", "skills/BatteryLevel.scxml"],
        &["skill", "mutants", "BatteryLevel"],
        &["skill", "run", "skills/original/BatteryLevel.scxml"],
        &["monitor", "check", "phi1", "properties/phi2.scope"],
        &["check", "trees/recharge.xml", "maps/house.yaml", "maps/house.places.toml", "properties/phi1.scope"],
        &["check", "scenarios/nominal.toml", "scenarios/campaigns/noise_short.toml", "skills/BatteryLevel.scxml"],
        &["run", "scenarios/errand.toml", "--no-snapshots"],
        &["init", "copy", "--scenario", "scenarios/errand.toml"],
        &["campaign", "scenarios/campaigns/noise_short.toml", "--runs", "1"],
    ];
    for arguments in commands {
        let (status, said) = here(arguments);
        assert_eq!(status, Some(0), "{arguments:?}: {said}");
    }
    let refused: [(&[&str], &str); 4] = [
        (&["tree", "show", "rechage"], "cannot read the tree rechage: there is no such file"),
        (&["skill", "run", "BatteryLevl"], "did you mean `BatteryLevel`?"),
        (&["monitor", "check", "phi9"], "did you mean `phi1`?"),
        (&["check", "maps/hose.yaml"], "cannot read the map maps/hose.yaml: there is no such file"),
    ];
    for (arguments, words) in refused {
        let (status, said) = here(arguments);
        assert!(status == Some(2) && said.contains(words), "{arguments:?}: {said}");
    }
}

#[test]
fn an_assignment_names_files_in_the_current_folder() {
    let folder = tempdir().unwrap();
    let own = "property own := always (BatteryReader, BatteryLevel, level >= 0)";
    std::fs::write(folder.path().join("own.scope"), own).unwrap();
    std::fs::create_dir(folder.path().join("properties")).unwrap();
    std::fs::write(folder.path().join("properties/phi1.scope"), own.replace("own", "changed")).unwrap();
    let run = |property: &str| {
        let set = format!("properties=[\"{property}\"]");
        let mut command = std::process::Command::new(binary());
        let command = command.args(["run", "errand", "--no-snapshots", "--set", &set]).current_dir(folder.path());
        let output = command.output().unwrap();
        [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap()).concat()
    };
    for (property, name) in
        [("own.scope", "own"), ("properties/phi1.scope", "changed"), ("properties/phi3.scope", "phi3")]
    {
        let said = run(property);
        assert!(said.contains(&format!("  {name} ")) && said.contains("satisfied"), "{property}: {said}");
    }
    let said = run("none.scope");
    assert!(said.contains("cannot read the property file ./none.scope: there is no such file"), "{said}");
}

/// As in the README, with `--set map=… --set places=…`.
#[test]
fn an_assignment_names_a_map_and_places_in_the_current_folder() {
    let folder = tempdir().unwrap();
    std::fs::create_dir(folder.path().join("floors")).unwrap();
    let maps = Path::new(env!("CARGO_MANIFEST_DIR")).join("maps");
    for (from, to) in [
        ("house.yaml", "floors/own.yaml"),
        ("house.pgm", "floors/house.pgm"),
        ("house.places.toml", "floors/own.places.toml"),
    ] {
        std::fs::copy(maps.join(from), folder.path().join(to)).unwrap();
    }
    let run = |map: &str, places: &str| {
        let set = [format!("map={map}"), format!("places={places}")];
        let short = "execution.max_time_s=1";
        said_in(folder.path(), &["run", "errand", "--no-snapshots", "--set", &set[0], "--set", &set[1], "--set", short])
    };
    let (said, status) = run("floors/own.yaml", "floors/own.places.toml");
    assert!(status == Some(1) && said.contains("the limit of 1 s was reached"), "{said}");
    let (said, status) = run("own.yaml", "own.places.toml");
    assert_eq!(status, Some(2), "{said}");
    for file in ["./own.yaml", "./own.places.toml"] {
        assert!(said.contains(file), "{file}: {said}");
    }
}

#[test]
fn an_event_log_has_one_message_per_line() {
    let out = tempdir().unwrap();
    let log = out.path().join("log.jsonl");
    let report = report("battery_fault", out.path(), &["--no-snapshots", "--record", log.to_str().unwrap()]);
    let text = std::fs::read_to_string(log).unwrap();
    let lines: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(lines[0]["scenario"], "battery_fault");
    let messages = lines.iter().filter(|line| !line["message"].is_null()).count() as u64;
    assert_eq!(report["steps"].as_u64(), Some(messages));
    let ticks = lines.iter().filter(|line| line["generated"] == "tick").count() as u64;
    assert_eq!(report["ticks"].as_u64(), Some(ticks));
    assert!(lines.iter().any(|line| line["tree"].is_object()), "the tree's statuses are in the log");
}

#[test]
fn an_animation_is_a_gif_of_more_than_one_picture() {
    let out = tempdir().unwrap();
    let gif = out.path().join("run.gif");
    let short = ["--set", "execution.max_time_s=5", "--set", "expect={}"];
    report("battery_fault", out.path(), &[&["--no-snapshots", "--gif", gif.to_str().unwrap()], &short[..]].concat());
    let file = std::io::BufReader::new(std::fs::File::open(gif).unwrap());
    assert_eq!(GifDecoder::new(file).unwrap().into_frames().take(3).filter(Result::is_ok).count(), 3);
}

#[test]
fn a_livelocked_run_ends_with_status_2_and_keeps_its_log() {
    let out = tempdir().unwrap();
    let log = out.path().join("log.jsonl");
    let record = ["--no-snapshots", "--record", log.to_str().unwrap(), "--out", out.path().to_str().unwrap()];
    let said = refusal(&[&["--scenario", "errand", "--set", "execution.step_budget=12"], &record[..]].concat());
    assert!(said.contains("12 transitions"), "{said}");
    let log = std::fs::read_to_string(log).unwrap();
    assert!(log.contains("\"generated\":\"tick\"") && log.contains("\"from\""), "{log}");
}

#[test]
fn exit_statuses_agree_with_the_readme() {
    let folder = tempdir().unwrap();
    let out = folder.path().join("out");
    let occupied = folder.path().join("occupied");
    std::fs::write(&occupied, "").unwrap();
    let log = folder.path().join("log.jsonl");
    let [out, log, below] = [out, log, occupied.join("out")].map(|path| path.to_str().unwrap().to_owned());
    let run = ["--scenario", "battery_fault", "--no-snapshots", "--quiet"];
    let statuses: [(i32, Vec<&str>); 14] = [
        (0, [&run[..], &["--out", &out, "--record", &log]].concat()),
        (1, [&run[..], &["--out", &out, "--set", "expect.phi1=satisfied"]].concat()),
        (2, [&run[..], &["--out", &out, "--set", "execution.step_budget=2"]].concat()),
        (2, [&run[..], &["--out", &out, "--set", "batery=1"]].concat()),
        (3, [&run[..], &["--out", &below]].concat()),
        (3, [&run[..], &["--out", &out, "--record", &below]].concat()),
        (0, vec!["verify", &log, "--property", "phi2"]),
        (1, vec!["verify", &log, "--property", "phi1"]),
        (2, vec!["verify", &below, "--property", "phi1"]),
        (1, vec!["verify", &log, &log, "--property", "phi1"]),
        (2, vec!["verify", &below, &log, "--property", "phi1"]),
        (2, vec!["--no-such-argument"]),
        (0, vec!["--version"]),
        (3, vec!["monitor", "export", "phi1", "--out", &below]),
    ];
    for (status, arguments) in statuses {
        let output = steward(&arguments);
        assert_eq!(output.status.code(), Some(status), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    }
}
