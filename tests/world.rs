//! The world in properties of recordings and counterexamples, and with a program: what was true, not what a process was
//! told.

use std::path::Path;

use serde_json::Value;
use tempfile::{TempDir, tempdir};

use crate::steward::{refusal, report, steward};

/// A folder with a scenario and its properties.
fn folder(scenario: &str, properties: &str) -> TempDir {
    let folder = tempdir().unwrap();
    std::fs::write(folder.path().join("world.scope"), properties).unwrap();
    let scenario = format!("properties = [\"world.scope\"]\n{scenario}");
    std::fs::write(folder.path().join("own.toml"), scenario).unwrap();
    folder
}

fn verdicts(report: &Value) -> Vec<(&str, &str)> {
    let monitors = report["monitors"].as_array().unwrap();
    monitors.iter().map(|it| (it["name"].as_str().unwrap(), it["verdict"].as_str().unwrap())).collect()
}

/// Everything that each scenario knows, with people, doors and a box.
const EVERYTHING: &str = "
property robot := always (World, Monitors,
    level_pct <= 100 and (charging = true or charging = false) and x_m > -100 and y_m > -100 and yaw_rad <= 3.15
    and speed_mps < 0.46 and turn_radps < 1.01 and touching = false and clearance_m > 0 and person_m > 0)
property places := eventually (World, Monitors, at_Desk = true)
property bodies := always (World, Monitors, Vera_x_m > 0 and Vera_y_m > 0
    and treasury_door_open >= 0 and treasury_door_open <= 1 and box_1_carried = false and box_1_x_m > 2.99 and box_1_x_m < 3.01)
";

#[test]
fn every_fact_is_true() {
    let text = "base = \"guide\"\n[expect]\n[[boxes]]\nat = [3, 0.4, 0]\nlength_m = 0.2\nwidth_m = 0.2\n";
    let own = folder(text, EVERYTHING);
    let scenario = own.path().join("own.toml");
    let report = report(scenario.to_str().unwrap(), &own.path().join("out"), &["--no-snapshots"]);
    let expected = ["robot", "places", "bodies"].map(|name| (name, "satisfied"));
    assert_eq!(verdicts(&report), expected, "{report}");
}

#[test]
fn a_recording_gives_the_same_verdicts_of_the_world() {
    let own = folder(
        "base = \"nominal\"\n[expect]\n[execution]\nmax_time_s = 40\n",
        "property level := always (World, Monitors, level_pct >= 31)\nproperty alone := always (World, Monitors, person_m > 1)",
    );
    for name in ["run.rec", "run.mcap", "run.jsonl"] {
        let file = own.path().join(name);
        let scenario = own.path().join("own.toml");
        let record = ["--no-snapshots", "--record", file.to_str().unwrap()];
        let report = report(scenario.to_str().unwrap(), &own.path().join("out"), &record);
        assert_eq!(verdicts(&report), [("level", "violated"), ("alone", "satisfied")]);
        let property = own.path().join("world.scope");
        let mut arguments = vec!["verify", file.to_str().unwrap(), "--property", property.to_str().unwrap()];
        if name.ends_with("jsonl") {
            arguments.extend(["--scenario", scenario.to_str().unwrap()]);
        }
        let said = steward(&arguments);
        let text = String::from_utf8_lossy(&said.stdout);
        assert!(text.contains("level        violated") && text.contains("alone        satisfied"), "{name}: {text}");
    }
}

#[test]
fn where_nothing_shows_what_is_true_the_property_is_refused() {
    let property = "property level := always (World, Monitors, level_pct >= 31)";
    let why = "nothing shows here what is true in the world";
    let own = folder("base = \"pick\"\n[expect]", property);
    let at = |path: &Path| path.to_str().unwrap().to_owned();
    assert!(refusal(&["run", &at(&own.path().join("own.toml"))]).contains(why), "without a map");
    // A run whose own properties do not ask.
    let record = at(&own.path().join("run.rec"));
    assert!(
        steward(&[
            "run",
            "nominal",
            "--set",
            "execution.max_time_s=5",
            "--quiet",
            "--no-snapshots",
            "--record",
            &record,
            "--out",
            &at(own.path())
        ])
        .status
        .code()
            < Some(2)
    );
    assert!(
        refusal(&["verify", &record, "--property", &at(&own.path().join("world.scope"))]).contains(why),
        "a recording"
    );
    // Names are suggested, of all fields.
    let own = folder("base = \"nominal\"\n[expect]", "property p := always (World, Monitors, levle_pct >= 31)");
    let said = refusal(&["run", &at(&own.path().join("own.toml"))]);
    assert!(said.contains("did you mean `level_pct`?"), "{said}");
}

#[test]
fn a_counterexample_leaves_out_what_speaks_of_the_world() {
    let text = "base = \"nominal\"\n[[monitors]]\nzone = \"Wet\"\n[expect.satisfied]\n\
                slow = 'always (World, Monitors, speed_mps < 0.46)'\n[expect]\nslow = \"satisfied\"\n\
                [stop]\non_violation = \"slow\"\n";
    let own = folder("", "");
    let places = std::fs::read_to_string("maps/house.places.toml").expect("it is shipped");
    let wet = places + "\n[Wet]\ncorners_m = [[1.4, 4.0], [3.7, 4.0], [3.7, 5.9], [1.4, 5.9]]\nspeed_mps = 0.2\n";
    std::fs::write(own.path().join("wet.places.toml"), wet).unwrap();
    let scenario = own.path().join("own.toml");
    std::fs::write(&scenario, format!("places = \"wet.places.toml\"\n{text}")).unwrap();
    let out = own.path().join("out").display().to_string();
    let proof = steward(&["prove", scenario.to_str().unwrap(), "--property", "phi2", "--out", &out, "--quiet"]);
    assert_eq!(proof.status.code(), Some(0), "{}", String::from_utf8_lossy(&proof.stderr));
    let run = steward(&["run", &format!("{out}/phi2/counterexample.toml"), "--no-snapshots", "--out", &out]);
    let said = String::from_utf8_lossy(&run.stdout);
    assert!(run.status.success() && said.contains("phi2") && !said.contains("slow"), "{said}");
}
