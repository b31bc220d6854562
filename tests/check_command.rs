//! `steward check`, and places with which no scenario loads.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;
use tempfile::{TempDir, tempdir};

use crate::programs::has_python;
use crate::steward::{refusal, steward};

/// The command's output as JSON, and its exit status.
fn checked(files: &[&str]) -> (Option<i32>, Value) {
    let output = steward(&[&["check", "--json"], files].concat());
    let report = serde_json::from_slice(&output.stdout);
    (output.status.code(), report.unwrap_or_else(|_| panic!("{}", String::from_utf8_lossy(&output.stderr))))
}

/// The files with that extension in a folder of the project.
fn files_in(folder: &str, ending: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let paths = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let is_manifest = |path: &Path| path.file_name().is_some_and(|name| name == "Cargo.toml");
    let mut paths: Vec<PathBuf> =
        paths.filter(|path| path.to_string_lossy().ends_with(ending) && !is_manifest(path)).collect();
    paths.sort();
    assert!(!paths.is_empty());
    paths
}

#[test]
fn the_shipped_files_have_no_errors() {
    let names = |folder: &str, before: &str| -> Vec<String> {
        let name = |path: PathBuf| format!("{before}{}", path.file_stem().unwrap().to_str().unwrap());
        files_in(folder, ".toml").into_iter().map(name).collect()
    };
    let mut all = names("scenarios", "");
    all.extend(names("scenarios/faults", "faults/"));
    all.extend(names("scenarios/guide", "guide/"));
    all.extend(names("scenarios/campaigns", ""));
    let folders = [
        ("maps", ".yaml"),
        ("maps", ".places.toml"),
        ("bt/trees", ".xml"),
        ("skills/machines", ".scxml"),
        ("skills/machines/original", ".scxml"),
        ("monitors/properties", ".scope"),
    ];
    for (folder, ending) in folders {
        all.extend(files_in(folder, ending).iter().map(|path| path.to_str().unwrap().to_owned()));
    }
    // The authors' files, which this scenario and its properties mention, do not come with the program. The properties
    // of `pick`, `parcel` and `takes_turns` are checked with those scenarios: they are about other systems.
    all.retain(|name| Path::new(name).file_stem().is_none_or(|stem| stem != "published"));
    all.retain(|name| !["pick.scope", "parcel.scope", "original.scope"].iter().any(|own| name.ends_with(own)));
    // One component of the guide is a Python program.
    let python = has_python();
    all.retain(|name| python || !name.starts_with("guide"));
    let (status, report) = checked(&all.iter().map(String::as_str).collect::<Vec<_>>());
    for file in report.as_array().unwrap() {
        assert_eq!(file["problems"], Value::Array(Vec::new()), "{file}");
        assert_eq!(file["warnings"], Value::Array(Vec::new()), "{file}");
    }
    assert_eq!((status, report.as_array().unwrap().len()), (Some(0), all.len()));
}

/// A scenario on a map of two rooms with a wall between them, and these places.
fn two_rooms(places: &str) -> (TempDir, PathBuf) {
    let folder = tempdir().unwrap();
    let cells = (0..40).flat_map(|row| (0..120).map(move |column| (row, column)));
    let cell = |(row, column): (usize, usize)| {
        let wall = !(2..38).contains(&row) || !(2..118).contains(&column) || column == 60;
        if wall { "0 " } else { "254 " }
    };
    let pixels: String = cells.map(cell).collect();
    fs::write(folder.path().join("rooms.pgm"), format!("P2\n120 40\n255\n{pixels}\n")).unwrap();
    let map =
        "image: rooms.pgm\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.25\n";
    fs::write(folder.path().join("rooms.yaml"), map).unwrap();
    fs::write(folder.path().join("rooms.places.toml"), places).unwrap();
    let scenario = folder.path().join("rooms.toml");
    let text = "base = \"errand\"\nmap = \"rooms.yaml\"\nplaces = \"rooms.places.toml\"\n";
    fs::write(&scenario, text).unwrap();
    (folder, scenario)
}

const START: &str = "[start]\nposition_m = [0.6, 1.0]\nheading_deg = 0\n";
const STATION: &str = "[RechargingStation]\nposition_m = [2.4, 1.0]\nheading_deg = 0\n";
const DESTINATION: &str = "[Destination]\nposition_m = [1.2, 1.4]\nheading_deg = 0\n";

/// The messages about places that keep the scenario from running.
fn refused(places: &str) -> String {
    let (_folder, scenario) = two_rooms(places);
    refused_by_all(&scenario)
}

/// The messages that both `check` and a run print about a scenario.
fn refused_by_all(scenario: &Path) -> String {
    let out = scenario.with_file_name("out");
    let said = refusal(&["--scenario", scenario.to_str().unwrap(), "--out", out.to_str().unwrap()]);
    assert!(!out.exists(), "nothing is run");
    assert_eq!(said, refusal(&["check", scenario.to_str().unwrap()]));
    said.split_whitespace().filter(|word| *word != "|").collect::<Vec<_>>().join(" ")
}

#[test]
fn unreachable_places_are_refused_before_a_run() {
    let with = |station: &str, destination: &str| {
        let station = STATION.replace("[2.4, 1.0]", station);
        refused(&format!("{START}{station}{}", DESTINATION.replace("[1.2, 1.4]", destination)))
    };
    let fine = ("[2.4, 1.0]", "[1.2, 1.4]");
    for (station, destination, wanted) in [
        ("[9.0, 1.0]", fine.1, "`RechargingStation` is outside the map, at (9.00, 1.00)"),
        ("[9.0, 1.0]", fine.1, "the map extends from (0.00, 0.00) to (6.00, 2.00)"),
        ("[9.0, 1.0]", fine.1, "rooms.places.toml:5:14"),
        ("[9.0, 1.0]", fine.1, "the scenario requires it as `sites.station`"),
        ("[3.02, 1.0]", fine.1, "the robot cannot stand at `RechargingStation`: (3.02, 1.00) is in a wall"),
        ("[2.8, 1.0]", fine.1, "(2.80, 1.00) is 0.225 m from a wall, but it needs 0.325 m"),
        ("[2.8, 1.0]", fine.1, "the nearest reachable place is (2.68, 1.03)"),
        (fine.0, "[4.0, 1.0]", "there is no path from the start (0.60, 1.00) to `Destination` at (4.00, 1.00)"),
        (fine.0, "[4.0, 1.0]", "rooms.places.toml:8:14"),
        ("[9.0, 1.0]", "[4.0, 1.0]", "there is no path from the start"),
    ] {
        let said = with(station, destination);
        assert!(said.contains(wanted), "{wanted} is missing: {said}");
    }
    let area = "[Destination]\ncorners_m = [[2.9, 0.5], [3.1, 0.5], [3.1, 1.5], [2.9, 1.5]]\n";
    assert!(refused(&format!("{START}{STATION}{area}")).contains("there is no room for the robot in `Destination`"));
    let start = START.replace("[0.6, 1.0]", "[3.02, 1.0]");
    let said = refused(&format!("{start}{STATION}{DESTINATION}"));
    assert!(said.contains("the robot cannot drive away from the start (3.02, 1.00)"), "{said}");
    assert!(said.contains("rooms.places.toml:2:14"), "{said}");
}

#[test]
fn places_to_which_a_skill_always_drives_are_required() {
    let vault = "[Vault]\nposition_m = [4.0, 1.0]\nheading_deg = 0\n";
    let (_folder, scenario) = two_rooms(&format!("{START}{STATION}{DESTINATION}{vault}"));
    let text = fs::read_to_string(&scenario).unwrap();
    fs::write(&scenario, format!("{text}leaves.GoToDestination.data.place = \"Vault\"\n")).unwrap();
    let said = refused_by_all(&scenario);
    for words in ["to `Vault` at (4.00, 1.00)", "rooms.places.toml:11:14", "the skill GoToDestination drives there"] {
        assert!(said.contains(words), "{words} is missing: {said}");
    }
}

#[test]
fn places_that_a_scenario_does_not_need_are_worth_a_warning() {
    let vault = "[Vault]\nposition_m = [4.0, 1.0]\nheading_deg = 0\n";
    let wide = STATION.replace("[2.4, 1.0]\n", "[2.4, 1.0]\nposition_tolerance_m = 0.8\n");
    let (_folder, scenario) = two_rooms(&format!("{START}{wide}{DESTINATION}{vault}"));
    let (status, report) = checked(&[scenario.to_str().unwrap()]);
    assert_eq!(status, Some(0));
    let said: Vec<&str> =
        report[0]["warnings"].as_array().unwrap().iter().map(|one| one["message"].as_str().unwrap()).collect();
    assert_eq!(said.len(), 2, "{said:?}");
    assert!(said[0].contains("counts as at `RechargingStation` within 0.8 m"), "{said:?}");
    assert!(said[1].contains("to `Vault` at (4.00, 1.00)"), "{said:?}");
    assert_eq!(report[0]["warnings"][1]["line"], 12, "{report}");
}

#[test]
fn headings_that_look_like_radians_are_worth_a_warning() {
    let turned = STATION.replace("heading_deg = 0", "heading_deg = 1.5708");
    let (_folder, scenario) = two_rooms(&format!("{START}{turned}{DESTINATION}"));
    let text = fs::read_to_string(&scenario).unwrap();
    fs::write(&scenario, format!("{text}[sites]\nstart = [0.6, 1.0, 3.14]\n[[boxes]]\nat = [1.8, 1.6, -0.785]\n"))
        .unwrap();
    let (status, report) = checked(&[scenario.to_str().unwrap()]);
    let said = report[0]["warnings"].as_array().unwrap().iter().map(|one| one["message"].as_str().unwrap());
    let wanted = ["1.5708", "3.14", "-0.785"].map(|heading| format!("a heading of {heading}° looks like radians"));
    assert_eq!((status, said.collect::<Vec<_>>()), (Some(0), wanted.iter().map(String::as_str).collect()));
    let (_, report) = checked(&[scenario.with_file_name("rooms.places.toml").to_str().unwrap()]);
    assert_eq!(report[0]["warnings"][0]["line"], 6, "{report}");
}

#[test]
fn maps_that_releases_of_nav2_read_differently_are_worth_a_warning() {
    let (_folder, scenario) = two_rooms(&format!("{START}{STATION}{DESTINATION}"));
    let map = scenario.with_file_name("rooms.yaml");
    let text = fs::read_to_string(&map).unwrap();
    // A black pixel lies on this threshold.
    fs::write(&map, text.replace("0.65", "1.0")).unwrap();
    for file in [&map, &scenario] {
        let (status, report) = checked(&[file.to_str().unwrap()]);
        let warning = &report[0]["warnings"][0];
        let said = warning["message"].as_str().unwrap();
        assert_eq!(status, Some(0), "{report}");
        assert!(
            said.contains("unknown in ROS 1 and in Nav2 up to Jazzy 1.3.6, but occupied in later releases"),
            "{report}"
        );
        assert!(warning["file"].as_str().unwrap().ends_with("rooms.yaml"), "{report}");
    }
}

#[test]
fn a_place_cannot_be_expected_to_be_reached_and_not_to_be() {
    let said = refusal(&["--scenario", "errand", "--set", "expect.not_reached=[\"Destination\"]"]);
    assert!(said.contains("is expected both to come to rest at `Destination` and never to be there"), "{said}");
}

/// A scenario in which nothing is charged and no robot is sent anywhere names neither place.
#[test]
fn station_and_destination_are_required_only_where_they_are_used() {
    let folder = tempdir().unwrap();
    let scenario = folder.path().join("short.toml");
    let text = "map = \"maps/house.yaml\"\nplaces = \"maps/house.places.toml\"\ntree = \"trees/recharge.xml\"\n\
                skills = \"skills\"\n[sites]\nstart = \"start\"\n[execution]\nmax_time_s = 3\n";
    fs::write(&scenario, text).unwrap();
    let out = folder.path().join("out");
    let arguments = ["--scenario", scenario.to_str().unwrap(), "-q", "--out", out.to_str().unwrap()];
    let output = steward(&arguments);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    fs::write(&scenario, format!("{text}[[faults]]\nkind = \"station_dead\"\nat_s = 1\n")).unwrap();
    assert!(refusal(&arguments).contains("there is no charging station"));
}

#[test]
fn every_file_is_checked_by_its_kind() {
    let folder = tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        fs::write(&path, text).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let files = [
        write("tree.xml", "<root BTCPP_format=\"4\"><BehaviorTree ID=\"a\"><Nope/></BehaviorTree></root>"),
        write("machine.scxml", "<scxml version=\"1.0\"><state id=\"a\"><transition target=\"b\"/></state></scxml>"),
        write("bad.scope", "property p := always (Nobody, BT, m[1] = <ok>)\n"),
        write("map.yaml", "image: nowhere.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n"),
        write("some.places.toml", "[Here]\nposition_m = [1]\nheading_deg = 0\n"),
        write("campaign.toml", "scenario = \"erand\"\nruns = 3\n"),
        write(
            "scenario.toml",
            "base = \"errand\"\n[[faults]]\nkind = \"joypad\"\nlinear_mps = 1\nwhen = \"(No, BT, true)\"\n",
        ),
        write("picture.jpg", ""),
        folder.path().join("missing.toml").to_str().unwrap().to_owned(),
    ];
    let (status, report) = checked(&files.iter().map(String::as_str).collect::<Vec<_>>());
    assert_eq!(status, Some(2));
    let wanted =
        ["Nope", "b", "Nobody", "nowhere.pgm", "position_m", "erand", "No", "not a kind of file", "missing.toml"];
    for (file, wanted) in report.as_array().unwrap().iter().zip(wanted) {
        assert_eq!((&file["ok"], file["problems"].as_array().map(Vec::is_empty)), (&Value::Bool(false), Some(false)));
        assert!(file["problems"].to_string().contains(wanted), "{wanted}: {file}");
    }
    assert_eq!(report[0]["problems"][0]["line"], 1, "{report}");
    let output = steward(&["check", "nominal", &files[0], "noise"]);
    assert_eq!(output.status.code(), Some(2));
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(
        said.contains("nominal: a scenario with 7 leaves, 3 places, 3 properties, 0 faults; no problems found"),
        "{said}"
    );
    assert!(said.contains("tree.xml: 1 problem\n") && said.contains("noise: a campaign of "), "{said}");
    assert!(said.ends_with("3 files checked, 1 with problems\n"), "{said}");
}
