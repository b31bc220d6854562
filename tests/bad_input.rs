//! Wrong files and arguments: one clear message each, exit status 2; what cannot be written: exit status 3.

use std::path::{Path, PathBuf};

use tempfile::tempdir;

use crate::steward::{refusal, steward};

/// A copy of `battery_fault` with all its files, for spoiling; the path of its scenario file.
pub(crate) fn copy_of_battery_fault(folder: &Path) -> PathBuf {
    let copy = folder.join("scenario");
    let output = steward(&["init", copy.to_str().unwrap(), "--scenario", "battery_fault"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    copy.join("battery_fault.toml")
}

/// What is said of a copy of `battery_fault` in which `old` was replaced by `new` in `file`.
fn refusal_of(file: &str, old: &str, new: &str) -> String {
    let folder = tempdir().unwrap();
    let scenario = copy_of_battery_fault(folder.path());
    let path = scenario.parent().unwrap().join(file);
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(text.contains(old), "{file} has no {old}: {text}");
    std::fs::write(&path, text.replacen(old, new, 1)).unwrap();
    refusal(&["--scenario", scenario.to_str().unwrap(), "--no-snapshots", "--out", folder.path().to_str().unwrap()])
}

/// What is said of a copy of `battery_fault` in which `file` holds these bytes, or is missing.
fn refusal_with(file: &str, bytes: Option<&[u8]>) -> String {
    let folder = tempdir().unwrap();
    let scenario = copy_of_battery_fault(folder.path());
    let path = scenario.parent().unwrap().join(file);
    let renamed = format!("mine-{}", path.file_name().unwrap().to_str().unwrap());
    let own = path.with_file_name(&renamed);
    if let Some(bytes) = bytes {
        std::fs::write(&own, bytes).unwrap();
    }
    // Under its own name, so that the file that comes with the program does not take its place.
    let text = std::fs::read_to_string(&scenario).unwrap();
    let renamed_path = Path::new(file).with_file_name(renamed);
    std::fs::write(&scenario, text.replace(file, renamed_path.to_str().unwrap())).unwrap();
    refusal(&["--scenario", scenario.to_str().unwrap(), "--no-snapshots", "--out", folder.path().to_str().unwrap()])
}

/// Says every one of these.
fn says(said: &str, parts: &[&str]) {
    // The graphical report may break lines anywhere between words.
    let flat = said.split_whitespace().filter(|word| *word != "|").collect::<Vec<_>>().join(" ");
    for part in parts {
        assert!(flat.contains(part), "does not say `{part}`:\n{said}");
    }
}

#[test]
fn an_unknown_scenario_is_refused_with_the_most_similar_name() {
    says(
        &refusal(&["--scenario", "batery_fault"]),
        &["unknown scenario `batery_fault`", "did you mean `battery_fault`?"],
    );
    says(
        &refusal(&["run", "faults/batery_level"]),
        &["cannot read the scenario faults/batery_level", "did you mean `faults/battery_level`?"],
    );
}

#[test]
fn a_missing_scenario_file_is_named() {
    says(&refusal(&["--scenario", "nowhere/mine.toml"]), &["nowhere/mine.toml", "there is no such file"]);
}

#[test]
fn all_errors_in_a_scenario_are_shown_at_their_places() {
    let said = refusal_of("battery_fault.toml", "initial_pct = 80", "inital_pct = 80\ndrain_pct_per_s = \"fast\"");
    says(
        &said,
        &[
            "battery_fault.toml",
            "unknown key `inital_pct`",
            "did you mean `initial_pct`?",
            "`drain_pct_per_s` must be a number",
        ],
    );
}

#[test]
fn a_scenario_that_is_not_toml_is_refused() {
    says(&refusal_of("battery_fault.toml", "[sites]", "[sites"), &["battery_fault.toml"]);
}

#[test]
fn an_unknown_key_on_the_command_line_is_refused() {
    for (set, parts) in [
        ("batery.initial_pct=3", ["unknown key `batery`", "did you mean `battery`?"]),
        ("battery.intial_pct=3", ["unknown key `intial_pct`", "did you mean `initial_pct`?"]),
        ("faults.0.at_s=3", ["there are no `faults`, so none can be changed", "`faults=[{…}]` sets all of them"]),
    ] {
        says(&refusal(&["run", "nominal", "--set", set]), &parts);
    }
    says(&refusal(&["--scenario", "nominal", "--set", "battery.initial_pct"]), &["no `=` in the assignment"]);
    says(&refusal(&["--scenario", "nominal", "--set", "battery.initial_pct=300"]), &["between 0 and 100"]);
}

#[test]
fn a_base_is_a_file_or_a_name_and_can_be_set() {
    let folder = tempdir().unwrap();
    let mine = folder.path().join("mine.toml");
    let out = folder.path().join("out");
    let of = |text: &str, set: &[&str]| {
        std::fs::write(&mine, text).unwrap();
        let arguments =
            ["--scenario", mine.to_str().unwrap(), "--no-snapshots", "--json", "--out", out.to_str().unwrap()];
        let short = ["--set", "execution.max_time_s=2", "--set", "expect={}", "--set", "expect.max_collisions=0"];
        steward(&[&arguments[..], &short, set].concat())
    };
    let hash = |text: &str, set: &[&str]| {
        let output = of(text, set);
        let report: serde_json::Value = serde_json::from_slice(&output.stdout)
            .unwrap_or_else(|_| panic!("{}", String::from_utf8_lossy(&output.stderr)));
        report["trace_hash"].clone()
    };
    let errand = hash("base = \"errand\"\n", &[]);
    assert_eq!(errand, hash("base = \"scenarios/errand.toml\"\n", &[]));
    let corridor = hash("base = \"corridor\"\n", &[]);
    assert_ne!(errand, corridor);
    assert_eq!(corridor, hash("base = \"errand\"\n", &["--set", "base=corridor"]));
    for (text, set) in
        [("base = \"errand\"\n", "base=nope"), ("base = 3\n", "seed=1"), ("base = \"errand\"\n", "base=3")]
    {
        let output = of(text, &["--set", set]);
        assert_eq!(output.status.code(), Some(2), "{text} {set}");
        says(&String::from_utf8_lossy(&output.stderr), &["base"]);
    }
}

#[test]
fn a_missing_file_of_each_kind_is_named() {
    for file in ["maps/house.yaml", "maps/house.places.toml", "trees/recharge.xml"] {
        let own = file.rsplit('/').next().unwrap();
        says(&refusal_with(file, None), &[&format!("mine-{own}")]);
    }
}

#[test]
fn a_broken_map_is_refused_with_its_place() {
    let said = refusal_of("maps/house.yaml", "resolution: 0.05", "resolution: -1");
    says(&said, &["house.yaml", "resolution"]);
}

#[test]
fn a_broken_picture_of_a_map_is_refused() {
    let folder = tempdir().unwrap();
    let scenario = copy_of_battery_fault(folder.path());
    let picture = scenario.parent().unwrap().join("maps/house.pgm");
    let bytes = std::fs::read(&picture).unwrap();
    std::fs::write(&picture, &bytes[..bytes.len() / 2]).unwrap();
    says(&refusal(&["--scenario", scenario.to_str().unwrap()]), &["house.pgm"]);
}

#[test]
fn broken_places_are_refused_with_their_place() {
    says(&refusal_of("maps/house.places.toml", "[start]", "[start]\nheight = 2"), &["house.places.toml", "height"]);
}

#[test]
fn an_unknown_place_is_refused() {
    let said = refusal_of("battery_fault.toml", "station = \"RechargingStation\"", "station = \"RechargeStation\"");
    says(&said, &["RechargeStation", "did you mean `RechargingStation`?"]);
}

#[test]
fn a_broken_tree_is_refused_with_its_place() {
    let said = refusal_of("trees/recharge.xml", "<ReactiveSequence", "<ReactivSequence");
    says(&said, &["recharge.xml", "ReactivSequence"]);
}

#[test]
fn a_leaf_without_a_skill_is_refused() {
    let said = refusal_of("trees/recharge.xml", "<Condition ID=\"BatteryLevel\"", "<Condition ID=\"BatteryLvl\"");
    says(&said, &["recharge.xml", "BatteryLvl"]);
}

/// A copy of another leaf's machine drives where that one does, whatever its file is called.
#[test]
fn a_machine_may_have_a_name_other_than_its_leaf() {
    let folder = tempdir().unwrap();
    let scenario = copy_of_battery_fault(folder.path());
    let beside = scenario.parent().unwrap();
    let tree = beside.join("trees/recharge.xml");
    let text = std::fs::read_to_string(&tree).unwrap();
    std::fs::write(&tree, text.replace("GoToDestination", "GoToLobby")).unwrap();
    std::fs::copy(beside.join("skills/GoToDestination.scxml"), beside.join("skills/GoToLobby.scxml")).unwrap();
    let text = std::fs::read_to_string(&scenario).unwrap() + "\n[execution]\nmax_time_s = 2\n";
    std::fs::write(&scenario, text.replace("properties = [", "properties = [] # [").replace("phi", "# phi")).unwrap();
    let said = refusal(&["check", scenario.to_str().unwrap()]);
    says(&said, &["skills/GoToLobby.scxml, has the name `GoToDestination`", "[leaves.GoToLobby] machine ="]);
    let meant = ["--set", "leaves.GoToLobby.machine=GoToLobby.scxml", "--no-snapshots", "--out"];
    let output = steward(
        &[&["--scenario", scenario.to_str().unwrap()], &meant[..], &[folder.path().join("out").to_str().unwrap()]]
            .concat(),
    );
    assert!(matches!(output.status.code(), Some(0 | 1)), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn a_broken_skill_is_refused_with_its_place() {
    let said = refusal_of("skills/BatteryLevel.scxml", "<onentry>", "<onenter>");
    says(&said, &["BatteryLevel.scxml"]);
}

#[test]
fn a_skill_that_sends_to_an_unknown_process_is_refused() {
    let said = refusal_of("skills/BatteryLevel.scxml", "target=\"BatteryReader\"", "target=\"BateryReader\"");
    says(&said, &["BatteryLevel.scxml", "BateryReader", "BatteryReader"]);
}

/// Several mistakes in the tree and in four skills, none of which is one of a file alone.
#[test]
fn mismatches_of_tree_skills_and_components_are_reported_once_at_their_places() {
    let folder = tempdir().unwrap();
    let scenario = copy_of_battery_fault(folder.path());
    let spoil = |file: &str, old: &str, new: &str| {
        let path = scenario.parent().unwrap().join(file);
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.contains(old), "{file} has no {old}: {text}");
        std::fs::write(&path, text.replace(old, new)).unwrap();
    };
    spoil("trees/recharge.xml", "AtDestination", "AtTheDestination");
    spoil("skills/BatteryLevel.scxml", "target=\"BatteryReader\"", "target=\"BateryReader\"");
    spoil("skills/BatteryNotCharging.scxml", "\"get_charging\"", "\"get_charge\"");
    spoil("skills/WaitForUser.scxml", "<send type=\"channel\" target=\"BT\" event=\"running\"/>", "");
    spoil("skills/WaitForUser.scxml", "<send type=\"channel\" target=\"BT\" event=\"halted\"/>", "");
    spoil("skills/AtRechargingStation.scxml", "event=\"Localization.", "event=\"Location.");
    let said = refusal(&["--scenario", scenario.to_str().unwrap()]);
    let complaints = [
        ("no machine for this leaf", "recharge.xml:25:9"),
        ("there is no process BateryReader", "BatteryLevel.scxml:24:38"),
        ("carries no <get_charge>", "BatteryNotCharging.scxml:22:60"),
        ("WaitForUser never answers BT", "WaitForUser.scxml:5:2"),
        ("no transition reads `Localization.ok`", "AtRechargingStation.scxml:6:2"),
        ("no transition reads `Localization.error`", "AtRechargingStation.scxml:6:2"),
        ("the event `Location.ok` never occurs", "AtRechargingStation.scxml:31:26"),
        ("the event `Location.error` never occurs", "AtRechargingStation.scxml:33:26"),
    ];
    for (complaint, place) in complaints {
        says(&said, &[complaint, place]);
    }
    // Each once; that a process which is misspelt does not answer by its right name either is not worth saying.
    assert_eq!(said.matches("\n  x ").count(), 9, "{said}");
}

#[test]
fn an_unknown_process_to_starve_is_refused() {
    says(&refusal(&["--scenario", "nominal", "--set", "execution.starve=Bt"]), &["Bt", "BT"]);
}

#[test]
fn an_unknown_property_is_refused() {
    says(&refusal(&["--scenario", "nominal", "--set", "properties=[\"phi9\"]"]), &["phi9"]);
    says(&refusal(&["--scenario", "nominal", "--set", "expect.phi9=violated"]), &["phi9"]);
}

#[test]
fn a_start_inside_a_wall_is_refused() {
    let folder = tempdir().unwrap();
    let scenario = copy_of_battery_fault(folder.path());
    let places = scenario.parent().unwrap().join("maps/house.places.toml");
    let text = std::fs::read_to_string(&places).unwrap();
    let at_start = "[start]\nposition_m = [0.0, 0.0]";
    assert!(text.contains(at_start), "{text}");
    // The wall between the kitchen and the bedroom.
    std::fs::write(&places, text.replacen(at_start, "[start]\nposition_m = [-9.2, 14.0]", 1)).unwrap();
    let said = refusal(&["--scenario", scenario.to_str().unwrap()]);
    says(&said, &["the start (-9.20, 14.00)", "wall", "house.places.toml:4:14"]);
}

#[test]
fn a_folder_that_cannot_be_written_to_is_exit_status_three() {
    let folder = tempdir().unwrap();
    let file = folder.path().join("occupied");
    std::fs::write(&file, "not a folder").unwrap();
    let output = steward(&["--scenario", "battery_fault", "--out", file.join("run").to_str().unwrap()]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{said}");
    assert!(said.contains("occupied"), "{said}");
}

/// `/dev/full` is a disk without room.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_exit_status_three() {
    for output in ["--record", "--gif", "--junit"] {
        let out = tempdir().unwrap();
        let out = out.path().to_str().unwrap();
        let all = ["--scenario", "battery_fault", "--no-snapshots", "--out", out, output, "/dev/full"];
        let done = steward(&all);
        let said = String::from_utf8_lossy(&done.stderr);
        assert_eq!(done.status.code(), Some(3), "{output}: {said}");
        assert!(said.contains("No space left") && !said.contains("panicked"), "{said}");
    }
}

#[test]
fn init_overwrites_nothing() {
    let folder = tempdir().unwrap();
    std::fs::write(folder.path().join("precious.txt"), "mine").unwrap();
    says(&refusal(&["init", folder.path().to_str().unwrap()]), &["is not empty"]);
}

/// A device that never ends, a pipe that nobody writes to, and a file that is too long.
#[cfg(target_os = "linux")]
#[test]
fn endless_files_are_not_read() {
    let folder = tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (pipe, long) = (at("pipe"), at("long.xml"));
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    std::fs::File::create(&long).unwrap().set_len(1 << 31).unwrap();
    let image = at("map.yaml");
    let skill = at("skill.scxml");
    for (endless, why) in [("/dev/zero", "device"), (&pipe, "device"), (&long, "MiB")] {
        let yaml = "resolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n";
        std::fs::write(&image, format!("image: {endless}\n{yaml}")).unwrap();
        let script = format!("<script src=\"{endless}\"/><state id=\"a\"/></scxml>");
        let head = "<scxml xmlns=\"http://www.w3.org/2005/07/scxml\" version=\"1.0\" datamodel=\"ecmascript\">";
        std::fs::write(&skill, format!("{head}{script}")).unwrap();
        let set = |key: &str| format!("{key}={endless}");
        for arguments in [
            vec!["--scenario", endless],
            vec!["--scenario", "nominal", "--set", &set("map")],
            vec!["--scenario", "nominal", "--set", &set("places")],
            vec!["--scenario", "nominal", "--set", &set("tree")],
            vec!["campaign", endless],
            vec!["tree", "check", endless],
            vec!["skill", "check", endless],
            vec!["skill", "check", &skill],
            vec!["monitor", "check", endless],
            vec!["navigate", "--map", endless],
            vec!["navigate", "--map", &image],
        ] {
            says(&refusal(&arguments), &[why]);
        }
    }
}

/// Each shown problem costs a look through its file: of very many, the first are shown.
#[test]
fn a_hundred_of_five_thousand_bad_properties_are_shown() {
    let folder = tempdir().unwrap();
    let file = folder.path().join("bad.scope");
    let text: String =
        (0..5000).map(|n| format!("property p{n} := once (BatteryReader, BatteryLevel, true)\n")).collect();
    std::fs::write(&file, text).unwrap();
    let said = refusal(&["monitor", "check", file.to_str().unwrap()]);
    assert_eq!(said.matches("found `once`").count(), 100);
    says(&said, &["and 4,900 more"]);
}
