//! Wrong files and arguments give one clear message each and exit status 2; output that cannot be written gives exit
//! status 3.

use std::path::{Path, PathBuf};
use std::process::Command;

use tempfile::tempdir;

use crate::steward::{binary, refusal, steward};

/// Makes a copy of `battery_fault` with all its files, to be broken; returns the path of its scenario file.
pub(crate) fn copy_of_battery_fault(folder: &Path) -> PathBuf {
    let copy = folder.join("scenario");
    let output = steward(&["init", copy.to_str().unwrap(), "--scenario", "battery_fault"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    copy.join("battery_fault.toml")
}

/// The binary's message in that folder when it refuses its input, like `refusal`. Messages name files as given, so they
/// are the same in every folder.
fn refusal_in(folder: &Path, arguments: &[&str]) -> String {
    let output = Command::new(binary()).args(arguments).current_dir(folder).output().expect("it starts");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
    assert!(!said.contains("panicked"), "{said}");
    said
}

/// Each of these calls, with the message that it prints.
fn refusals_of(calls: &[&[&str]]) -> String {
    let folder = tempdir().unwrap();
    let said = |call: &&[&str]| format!("$ steward {}\n{}", call.join(" "), refusal_in(folder.path(), call));
    calls.iter().map(said).collect::<Vec<_>>().join("\n")
}

/// The messages about a copy of `battery_fault` with each of these mistakes, one at a time: `new` replaces the first
/// `old` in `file`.
fn refusals(mistakes: &[(&str, &str, &str)]) -> String {
    let folder = tempdir().unwrap();
    let scenario = copy_of_battery_fault(folder.path());
    let said = |(file, old, new): &(&str, &str, &str)| {
        let path = scenario.with_file_name(file);
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.contains(old), "{file} has no {old}: {text}");
        std::fs::write(&path, text.replacen(old, new, 1)).unwrap();
        let said = refusal_in(scenario.parent().unwrap(), &["run", "battery_fault.toml", "--no-snapshots"]);
        std::fs::write(&path, text).unwrap();
        format!("{file}: {old} → {new}\n{said}")
    };
    mistakes.iter().map(said).collect::<Vec<_>>().join("\n")
}

/// Asserts that the message contains all of these.
fn says(said: &str, parts: &[&str]) {
    // The graphical report may break lines anywhere between words.
    let flat = said.split_whitespace().filter(|word| *word != "|").collect::<Vec<_>>().join(" ");
    for part in parts {
        assert!(flat.contains(part), "does not say `{part}`:\n{said}");
    }
}

#[test]
fn a_wrong_argument_has_one_message() {
    let said = refusals_of(&[
        &["run", "batery_fault"],
        &["run", "faults/batery_level"],
        &["run", "nowhere/mine.toml"],
        &["rn", "nominal"],
        &["run", "nominal", "--sed", "3"],
        &["run", "nominal", "--seed", "three"],
        &["run", "nominal", "--set", "batery.initial_pct=3"],
        &["run", "nominal", "--set", "battery.intial_pct=3"],
        &["run", "nominal", "--set", "battery.initial_pct"],
        &["run", "nominal", "--set", "battery.initial_pct=300"],
        &["run", "nominal", "--set", "faults.0.at_s=3"],
        &["run", "nominal", "--set", "execution.starve=Bt"],
        &["run", "nominal", "--set", "properties=[\"phi9\"]"],
        &["run", "nominal", "--set", "expect.phi9=violated"],
        &["run", "nominal", "--set", "map=office.yaml"],
        &["campaign", "noice"],
        &["faults", "batery_level"],
        &["tree", "show", "recharg"],
        &["skill", "check", "GoToDestinatoin"],
        &["monitor", "check", "phi9"],
        &["report", "run.mcap"],
        &["init", "--template", "recharg", "robot"],
    ]);
    insta::assert_snapshot!(said);
}

#[test]
fn a_mistake_in_a_scenario_has_one_message() {
    let file = "battery_fault.toml";
    let said = refusals(&[
        (file, "[sites]", "[sites"),
        (file, "map = ", "map: "),
        (file, "\"trees/recharge.xml\"", "trees/recharge.xml"),
        (file, "initial_pct = 80", "inital_pct = 80\ndrain_pct_per_s = \"fast\""),
        (file, "station = \"RechargingStation\"", "station = \"RechargeStation\""),
        (file, "kind = \"battery_level\"", "kind = \"battery_levl\""),
        (file, "level_pct = 10", "level_pct = 110"),
        (file, "at_s = 20.5\n", ""),
        (file, "\"arrival\"", "\"arival\""),
        (file, "phi1 = \"violated\"", "phi1 = \"broken\""),
        (file, "maps/house.yaml", "maps/hose.yaml"),
        (file, "maps/house.places.toml", "maps/hose.places.toml"),
        (file, "trees/recharge.xml", "trees/mine.xml"),
        (file, "properties/phi1.scope", "properties/mine.scope"),
        (file, "at_s = 20.5", "when = \"(BT, Navigation\""),
    ]);
    insta::assert_snapshot!(said);
}

#[test]
fn a_mistake_in_a_map_or_its_places_has_one_message() {
    let (map, places) = ("maps/house.yaml", "maps/house.places.toml");
    let said = refusals(&[
        (map, "resolution: 0.05", "resolution: -1"),
        (map, "resolution: 0.05", "resolution 0.05"),
        (map, "house.pgm", "hose.pgm"),
        (places, "[start]", "[start]\nheight = 2"),
        (places, "[start]", "[begin]"),
        (places, "heading_deg = 0\n", ""),
        // The wall between the kitchen and the bedroom.
        (places, "position_m = [0.0, 0.0]", "position_m = [-9.2, 14.0]"),
        (places, "position_m = [-7.5, 9.0]", "position_m = [-75, 9.0]"),
    ]);
    insta::assert_snapshot!(said);
}

#[test]
fn a_broken_image_of_a_map_is_refused() {
    let folder = tempdir().unwrap();
    let scenario = copy_of_battery_fault(folder.path());
    let picture = scenario.parent().unwrap().join("maps/house.pgm");
    let bytes = std::fs::read(&picture).unwrap();
    std::fs::write(&picture, &bytes[..bytes.len() / 2]).unwrap();
    insta::assert_snapshot!(refusal_in(scenario.parent().unwrap(), &["run", "battery_fault.toml"]), @r"
      x the image maps/house.pgm cannot be used: it ends early: 143992 of 288000 pixels
       ,-[maps/house.yaml:1:8]
     1 | image: house.pgm
       :        ^^^^|^^^^
       :            `-- this image
     2 | mode: trinary
       `----
    ");
}

#[test]
fn a_mistake_in_a_tree_has_one_message() {
    let tree = "trees/recharge.xml";
    let said = refusals(&[
        (tree, "<ReactiveSequence>", "<ReactivSequence>"),
        (tree, "<BatteryLevel/>", "<BatteryLvl/>"),
        (tree, "<WaitForUser/>", "<WaitForUser seconds=\"3\"/>"),
        (tree, "<AtDestination/>\n", "<Inverter/>\n"),
        (tree, "main_tree_to_execute=\"Recharge\"", "main_tree_to_execute=\"Recharg\""),
        (tree, "<BatteryNotCharging/>", "<SubTree ID=\"Charge\"/>"),
    ]);
    insta::assert_snapshot!(said);
}

#[test]
fn a_mistake_in_a_skill_has_one_message() {
    let skill = "skills/BatteryLevel.scxml";
    let said = refusals(&[
        (skill, "<onentry>", "<onenter>"),
        (skill, "target=\"BatteryReader\"", "target=\"BateryReader\""),
        (skill, "target=\"success\"", "target=\"succes\""),
        (skill, "event=\"get_level\"", "event=\"get_levl\""),
        (skill, "_event.data.level > threshold", "_event.data.level >"),
        (skill, "level > threshold", "level > treshold"),
        (skill, "event=\"BatteryReader.error\"", "event=\"BatteryReader.eror\""),
        (skill, "datamodel=\"ecmascript\"", "datamodel=\"python\""),
        (skill, "delayexpr=\"timeout\"", "delay=\"soon\""),
    ]);
    insta::assert_snapshot!(said);
}

#[test]
fn a_mistake_in_a_property_has_one_message() {
    let (property, condition) = ("properties/phi1.scope", "m[1] = <ok> implies m[2] >= 20)");
    let said = refusals(&[
        (property, "property phi1", "proprty phi1"),
        (property, ":=", "="),
        (property, "always", "alway"),
        (property, "BatteryReader, BatteryLevel,", "BatteryReader BatteryLevel,"),
        (property, "(BatteryReader, BatteryLevel,", "(BatteryReadr, BatteryLevel,"),
        (property, "<ok>", "<okay>"),
        (property, "m[2]", "m[3]"),
        (property, condition, ""),
        (property, condition, "m[1]"),
        (property, condition, "m[1] ="),
        (property, condition, "m[1] = <ok>"),
        (property, condition, "m[1] = <ok>) and"),
        (property, condition, "m[1] = <ok>) implies time_until (BatteryReader, BatteryLevel, m[2] > 20)"),
    ]);
    insta::assert_snapshot!(said);
}

/// One-line files, each checked on its own.
#[test]
fn a_mistake_in_another_file_has_one_message() {
    let folder = tempdir().unwrap();
    let said = |(name, text): &(&str, &str)| {
        std::fs::write(folder.path().join(name), text).unwrap();
        format!("{name}: {text}\n{}", refusal_in(folder.path(), &["check", name]))
    };
    let files = [
        ("campaign.toml", "scenario = \"nominl\"\nruns = 20\n"),
        ("campaign.toml", "scenario = \"nominal\"\nruns = 0\n[goal]\nnever = \"phi9\"\n"),
        ("campaign.toml", "scenario = \"nominal\"\n[[parameters]]\nkey = \"batery.initial_pct\"\nvalues = [50, 90]\n"),
        ("speaker.toml", "[services.say]\nrequest = { text = \"txt\" }\n"),
        ("model.xml", "<convince_mc_tc><mc_parameters/></convince_mc_tc>\n"),
        ("notes.txt", "what is this?\n"),
    ];
    let said = files.iter().map(said).collect::<Vec<_>>().join("\n");
    insta::assert_snapshot!(said);
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
fn a_property_with_the_name_of_another_expectation_is_refused() {
    let folder = tempdir().unwrap();
    let scenario = folder.path().join("own.toml");
    std::fs::write(folder.path().join("own.scope"), "property reached := always true\n").unwrap();
    for (lines, name, place) in [
        ("properties = [\"own.scope\"]\n[expect]\n", "reached", "own.scope:1:"),
        ("[[monitors]]\nfigure = \"5 (a)\"\nname = \"max_collisions\"\n", "max_collisions", "own.toml:"),
    ] {
        std::fs::write(&scenario, format!("base = \"errand\"\n{lines}")).unwrap();
        let said = refusal(&["check", scenario.to_str().unwrap()]);
        let refused = format!("a property cannot be called `{name}`");
        let help = format!("`expect.{name}` means something else; choose another name");
        says(&said, &[&refused, &help, place]);
    }
}

/// A copy of another leaf's machine drives to the same place, whatever the name of its file.
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

/// Several mistakes in the tree and in four skills, none of which lies in a single file.
#[test]
fn mismatches_of_tree_skills_and_components_are_reported_once_with_their_locations() {
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
    let said = refusal_in(scenario.parent().unwrap(), &["run", "battery_fault.toml"]);
    insta::assert_snapshot!(said);
    // Each once; that the process with the misspelled name does not answer under its right name either is not reported.
    assert_eq!(said.matches("\n  x ").count(), 9, "{said}");
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

/// `/dev/full` is a full disk.
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

/// Each problem that is shown costs a pass through its file, so only the first are shown.
#[test]
fn the_first_hundred_of_five_thousand_bad_properties_are_shown() {
    let folder = tempdir().unwrap();
    let file = folder.path().join("bad.scope");
    let text: String =
        (0..5000).map(|n| format!("property p{n} := sometimes (BatteryReader, BatteryLevel, true)\n")).collect();
    std::fs::write(&file, text).unwrap();
    let said = refusal(&["monitor", "check", file.to_str().unwrap()]);
    assert_eq!(said.matches("found `sometimes`").count(), 100);
    says(&said, &["and 4,900 more"]);
}
