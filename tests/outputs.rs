//! An output file is complete or does not exist, and has its own name.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::{Value, json};
use tempfile::tempdir;

use crate::steward::{binary, refusal, steward};

/// All files in a folder and its subfolders, with their contents.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                files.insert(path.strip_prefix(folder).unwrap().display().to_string(), std::fs::read(&path).unwrap());
            }
        }
    }
    files
}

/// Runs the binary in `folder`, where it cannot write a file larger than `limit` blocks of 512 bytes.
#[cfg(target_os = "linux")]
fn on_a_small_disk(folder: &Path, limit: u32, arguments: &[&str]) -> Output {
    let script = format!("ulimit -f {limit}; exec \"$@\"");
    Command::new("sh").args(["-c", &script, "sh"]).arg(binary()).args(arguments).current_dir(folder).output().unwrap()
}

/// A robot that drives straight ahead between two walls.
fn log(steps: u32) -> String {
    let ranges = "30.0 ".to_owned() + &"2.0 ".repeat(179);
    let line = |step: u32| {
        let x_m = f64::from(step) * 0.1;
        format!("ODOM {x_m} 0 0 0 0 0 {step} host {step}\nFLASER 180 {ranges}{x_m} 0 0 {x_m} 0 0 {step} host {step}\n")
    };
    (0..steps).map(line).collect()
}

#[cfg(target_os = "linux")]
#[test]
#[ignore = "long: .ci/run runs it"]
fn a_full_disk_leaves_existing_outputs_unchanged() {
    let folder = tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("drive.log"), log(100)).unwrap();
    std::fs::write(at("some.toml"), "scenario = \"errand\"\nruns = 3\nset = [\"execution.max_time_s=0.1\"]\n").unwrap();
    let run = ["--scenario", "battery_fault", "--set", "stop.after_s=0"];
    let quick = [&run[..], &["--no-snapshots"]].concat();
    let with = |more: &[&'static str]| [&quick[..], more].concat();
    // Each has room for some of its files, but not for all.
    let commands: [(&str, u32, Vec<&str>); 8] = [
        ("pictures", 100, [&run[..], &["--out", "pictures"]].concat()),
        ("report", 16, with(&["--out", "report"])),
        ("log", 16, with(&["--out", "out", "--record", "log/log.jsonl"])),
        ("gif", 400, with(&["--out", "out", "--gif", "gif/run.gif"])),
        ("map", 4, vec!["map", "--log", "drive.log", "--out", "map/m.yaml", "--force"]),
        ("trips", 4, vec!["navigate", "--goals", "2", "--pictures", "all", "--out", "trips", "--quiet"]),
        ("runs", 8, vec!["campaign", "some.toml", "--out", "runs", "--quiet"]),
        ("copy", 8, vec!["init", "copy"]),
    ];
    for (name, limit, arguments) in &commands {
        // `init` needs an empty folder.
        let whole = Command::new(binary()).args(arguments).current_dir(folder.path()).output();
        assert!(whole.unwrap().status.success(), "{arguments:?}");
        if *name == "copy" {
            std::fs::remove_dir_all(at(name)).unwrap();
            std::fs::create_dir(at(name)).unwrap();
        }
        let before = files(&at(name));
        let output = on_a_small_disk(folder.path(), *limit, arguments);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(3), "{arguments:?}: {said}");
        assert!(said.contains("cannot write") && said.contains("File too large"), "{said}");
        let after = files(&at(name));
        assert_eq!(after.keys().collect::<Vec<_>>(), before.keys().collect::<Vec<_>>(), "{arguments:?}");
        assert!(after == before, "{arguments:?} has changed a file");
    }
}

#[test]
fn a_killed_run_leaves_the_previous_report_with_its_pictures() {
    let folder = tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let run = ["--scenario", "battery_fault", "--quiet", "--out", out];
    assert!(steward(&run).status.success());
    let before = files(folder.path());
    let mut child = Command::new(binary())
        .args([&run[..], &["--seed", "2", "--set", "snapshots.every_s=0.1"]].concat())
        .spawn()
        .unwrap();
    let hidden = || files(folder.path()).keys().filter(|name| name.ends_with(".png") && name.contains(".part")).count();
    while hidden() < 3 {
        assert!(child.try_wait().unwrap().is_none(), "it ends before it is killed");
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let mut after = files(folder.path());
    after.retain(|name, _| !name.contains(".part"));
    assert!(after == before, "{:?}", after.keys());
    // The next run tidies up.
    assert!(steward(&run).status.success());
    assert_eq!(files(folder.path()).keys().collect::<Vec<_>>(), before.keys().collect::<Vec<_>>());
}

#[test]
fn a_new_report_removes_the_old_pictures_and_no_other_files() {
    let folder = tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let run = ["run", "battery_fault", "--quiet", "--out", out];
    assert!(steward(&run).status.success());
    let pictures = || files(folder.path()).keys().filter(|name| name.ends_with(".png")).cloned().collect::<Vec<_>>();
    assert_eq!(pictures().len(), 6);
    std::fs::write(folder.path().join("99-mine.png"), "").unwrap();
    assert!(steward(&[&run[..], &["--no-snapshots"]].concat()).status.success());
    assert_eq!(pictures(), ["99-mine.png"]);
}

#[test]
fn a_map_is_not_overwritten_silently() {
    let folder = tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    std::fs::write(at("drive.log"), log(20)).unwrap();
    let map = |more: &[&str]| [&["map", "--log", &at("drive.log")], more].concat().join("\n");
    let call = |more: &[&str]| steward(&map(more).split('\n').collect::<Vec<_>>());
    assert!(call(&["--out", &at("m.yaml")]).status.success());
    let before = files(folder.path());
    for name in ["m.yaml", "m"] {
        let said = refusal(&map(&["--out", &at(name)]).split('\n').collect::<Vec<_>>());
        assert!(said.contains("is there already") && said.contains("--force"), "{said}");
    }
    assert!(files(folder.path()) == before);
    assert!(call(&["--out", &at("m.yaml"), "--force", "--resolution", "0.1"]).status.success());
    assert!(files(folder.path())["m.pgm"] != before["m.pgm"]);
    // A map is written into a folder, not beside it.
    std::fs::create_dir(at("maps")).unwrap();
    assert!(call(&["--out", &at("maps")]).status.success());
    assert!(call(&["--out", &at("new/")]).status.success());
    let names = files(folder.path());
    for name in ["maps/drive.yaml", "maps/drive.pgm", "new/drive.yaml", "new/drive.pgm"] {
        assert!(names.contains_key(name), "{:?}", names.keys());
    }
}

/// Runs a scenario with that file name and a property with this name; returns the files that it writes to `out`.
fn outputs_of(file: &str, property: &str) -> Vec<String> {
    let folder = tempdir().unwrap();
    let shipped = ["phi1", "phi2", "phi3"].map(|name| format!("\"properties/{name}.scope\"")).join(", ");
    let text = format!(
        "base = \"scenarios/errand.toml\"\nproperties = [{shipped}, \"own.scope\"]\n[snapshots]\nat = [\"verdict\"]\n\
         [execution]\nmax_time_s = 3\n"
    );
    std::fs::write(folder.path().join(file), text).unwrap();
    let formula = "always (BatteryReader, BatteryLevel, m[2] < 0)";
    std::fs::write(folder.path().join("own.scope"), format!("property {property} := {formula}\n")).unwrap();
    let output = Command::new(binary())
        .args(["--scenario", &format!("./{file}"), "--quiet"])
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert!(matches!(output.status.code(), Some(0 | 1)), "{}", String::from_utf8_lossy(&output.stderr));
    files(folder.path()).into_keys().filter(|name| name != file && name != "own.scope").collect()
}

#[test]
fn names_become_portable_file_names() {
    let names = outputs_of("some.toml", &"p".repeat(245));
    assert!(names.iter().any(|name| name.starts_with("out/some/01-ppp") && name.ends_with(".png")), "{names:?}");
    for file in ["...toml", ".toml"] {
        let names = outputs_of(file, "own");
        assert!(names.iter().all(|name| name.split('/').count() == 3 && name.starts_with("out/")), "{names:?}");
    }
}

#[test]
fn a_run_and_a_campaign_do_not_share_a_folder() {
    let folder = tempdir().unwrap();
    let campaign = folder.path().join("some.toml");
    std::fs::write(&campaign, "scenario = \"errand\"\nruns = 1\nset = [\"execution.max_time_s=0.1\"]\n").unwrap();
    let (run, runs) = (folder.path().join("run"), folder.path().join("runs"));
    let scenario = |out: &Path| {
        ["--scenario", "battery_fault", "--no-snapshots", "--out", out.to_str().unwrap()].map(str::to_owned)
    };
    let campaign =
        |out: &Path| ["campaign", campaign.to_str().unwrap(), "--out", out.to_str().unwrap()].map(str::to_owned);
    fn call(arguments: &[String]) -> Vec<&str> {
        arguments.iter().map(String::as_str).collect()
    }
    for _ in 0..2 {
        assert!(steward(&call(&scenario(&run))).status.success());
        assert!(steward(&call(&campaign(&runs))).status.success());
    }
    let before = files(folder.path());
    assert!(refusal(&call(&scenario(&runs))).contains("contains the results of a campaign"));
    assert!(refusal(&call(&campaign(&run))).contains("contains the report of a run"));
    assert!(files(folder.path()) == before);
}

/// A property is about messages; a reader of its verdict wants to know what is true.
#[test]
fn a_satisfied_property_that_heard_no_level_says_how_low_the_true_one_was() {
    let folder = tempdir().unwrap();
    let property = "property reserve := always not (BatteryReader, BatteryLevel, level < 25)";
    std::fs::write(folder.path().join("own.scope"), property).unwrap();
    let scenario = folder.path().join("own.toml");
    let of = |more: &str| {
        let text = format!(
            "base = \"errand\"\nproperties = [\"own.scope\"]\nexecution.max_time_s = 20\nexpect = {{}}\n{more}"
        );
        std::fs::write(&scenario, text).unwrap();
        let out = folder.path().join("out");
        let output = steward(&["run", scenario.to_str().unwrap(), "--no-snapshots", "--out", out.to_str().unwrap()]);
        let read = |name: &str| std::fs::read_to_string(out.join(name)).unwrap();
        let report: serde_json::Value = serde_json::from_str(&read("report.json")).unwrap();
        assert_eq!(report["monitors"][0]["verdict"], "satisfied", "{report:#}");
        let unheard = report["monitors"][0]["unheard"].as_str().map(str::to_owned);
        (String::from_utf8_lossy(&output.stdout).into_owned(), unheard, read("report.html"))
    };
    let (_, unheard, _) = of("battery.initial_pct = 80\n");
    assert_eq!(unheard, None);
    // Nobody asks the reader after 10 s.
    let (summary, unheard, page) =
        of("battery.initial_pct = 80\n[[faults]]\nkind = \"battery_level\"\nat_s = 12\nlevel_pct = 12\n\
         [[faults]]\nkind = \"component_frozen\"\ncomponent = \"BatteryReader\"\nat_s = 10\n");
    let unheard = unheard.expect("it was not heard");
    assert!(unheard.starts_with("no message carries a level below 25 %, and none after 9."), "{unheard}");
    assert!(unheard.contains("; the true level fell to 1"), "{unheard}");
    assert!(summary.contains(&unheard) && page.contains(&unheard.replace(" %", "\u{a0}%")), "{summary}");
    // The recording of the run knows the true level, too.
    let record = folder.path().join("run.mcap");
    let [scenario, record] = [&scenario, &record].map(|path| path.to_str().unwrap());
    steward(&["run", scenario, "--no-snapshots", "--record", record]);
    let verified = steward(&["verify", record]);
    let verified = String::from_utf8_lossy(&verified.stdout);
    assert!(verified.contains(&format!("satisfied\n  {unheard}")), "{verified}");
    let verified = steward(&["verify", record, "--json"]);
    let verified: serde_json::Value = serde_json::from_slice(&verified.stdout).unwrap();
    assert_eq!(verified["monitors"][0]["unheard"], unheard);
}

#[test]
fn facts_that_are_unknown_without_a_map_are_left_out_of_every_output() {
    let out = tempdir().unwrap();
    let gif = out.path().join("run.gif");
    let arguments = ["run", "pick", "--out", out.path().to_str().unwrap(), "--gif", gif.to_str().unwrap()];
    let output = steward(&arguments);
    let summary = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success(), "{summary}");
    assert!(summary.contains("delivered  satisfied"), "{summary}");
    let read = |name: &str| std::fs::read_to_string(out.path().join(name)).unwrap();
    let report: Value = serde_json::from_str(&read("report.json")).unwrap();
    assert_eq!(report["battery"], Value::Null);
    assert_eq!(report["robot"], Value::Null);
    assert_eq!(report["places"], json!([]));
    assert!(report["snapshots"].as_array().unwrap().len() >= 3, "{report}");
    let page = read("report.html");
    for words in ["battery", "robot", "driven", "collision", "localiz", "reached", "navigation", "Navigation"] {
        assert!(!summary.contains(words), "the summary mentions {words}: {summary}");
        assert!(!page.contains(words), "the page mentions {words}");
    }
    assert!(std::fs::read(gif).unwrap().starts_with(b"GIF89a"));
}
