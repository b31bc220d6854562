//! The world in properties: what was true, not what a process was told.

use std::path::Path;

use robot::Streams;
use scenarios::scenario::{Scenario, find};
use serde_json::{Value, json};
use tempfile::{TempDir, tempdir};

use crate::steward::{refusal, steward};

/// A folder with a scenario and its properties.
fn folder(scenario: &str, properties: &str) -> TempDir {
    let folder = tempdir().unwrap();
    std::fs::write(folder.path().join("world.scope"), properties).unwrap();
    let scenario = format!("properties = [\"world.scope\"]\n{scenario}");
    std::fs::write(folder.path().join("own.toml"), scenario).unwrap();
    folder
}

/// The report of a run of the folder's scenario.
fn run(folder: &TempDir, arguments: &[&str]) -> Value {
    let (file, out) = (folder.path().join("own.toml"), folder.path().join("out"));
    let common = ["run", file.to_str().unwrap(), "--no-snapshots", "--quiet", "--out", out.to_str().unwrap()];
    let said = steward(&[&common, arguments].concat());
    assert!(matches!(said.status.code(), Some(0 | 1)), "{}", String::from_utf8_lossy(&said.stderr));
    serde_json::from_slice(&std::fs::read(out.join("report.json")).unwrap()).unwrap()
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
fn properties_of_the_world_change_no_run_and_no_process_hears_of_it() {
    let text = "base = \"parcel\"\n[expect]\n[execution]\nmax_time_s = 20\n";
    let own = folder(text, "property level := always (World, Monitors, level_pct > 0 and clearance_m >= 0)");
    let without = run(&own, &["--set", "properties=[]"]);
    let with = run(&own, &[]);
    assert_eq!(verdicts(&with), [("level", "satisfied")]);
    for same in ["trace_hash", "messages", "robot", "places"] {
        assert_eq!(with[same], without[same], "{same}");
    }
    let found = find::find(own.path().join("own.toml").to_str().unwrap()).unwrap();
    let scenario = Scenario::load(&found, &[]).unwrap();
    let wired = runs::wire(&scenario, &Streams::new(1)).unwrap();
    let topology = wired.system.topology();
    let ends = topology.channels().map(|channel| topology.ends(channel));
    let of_world: Vec<_> = ends.filter(|(from, to)| [*from, *to].contains(&"World")).collect();
    assert_eq!(of_world, [("World", "Monitors")]);
    // Only the fields that are asked for, in the order of the documentation.
    let channel = topology.find_channel("World", "Monitors").unwrap();
    let [shape] = topology.get(channel).domain.shapes() else { panic!("one message") };
    assert_eq!(shape.fields().iter().map(|(name, _)| &**name).collect::<Vec<_>>(), ["level_pct", "clearance_m"]);
}

#[test]
fn nothing_may_send_to_the_world_or_have_its_name() {
    let send = "<scxml xmlns=\"http://www.w3.org/2005/07/scxml\" version=\"1.0\" datamodel=\"ecmascript\" name=\"A\">\
                <state id=\"a\"><transition event=\"BT.tick\"><send type=\"channel\" target=\"World\" event=\"x\"/>\
                </transition></state></scxml>";
    let own = folder("base = \"pick\"\n[expect]", "property p := true");
    let machine = own.path().join("A.scxml");
    std::fs::write(&machine, send).unwrap();
    let machine = format!("leaves.PickUp.machine='{}'", machine.display());
    let said = refusal(&["run", own.path().join("own.toml").to_str().unwrap(), "--set", &machine]);
    assert!(said.contains("World"), "{said}");
    let component = "base = \"nominal\"\n[components.World]\nbuiltin = \"speaker\"\n[expect]";
    let own = folder(component, "property p := true");
    let said = refusal(&["run", own.path().join("own.toml").to_str().unwrap()]);
    assert!(said.contains("a component cannot be named `World`"), "{said}");
}

#[test]
fn every_fact_is_true() {
    let text = "base = \"guide\"\n[expect]\n[[boxes]]\nat = [3, 0.4, 0]\nlength_m = 0.2\nwidth_m = 0.2\n";
    let report = run(&folder(text, EVERYTHING), &[]);
    let expected = ["robot", "places", "bodies"].map(|name| (name, "satisfied"));
    assert_eq!(verdicts(&report), expected, "{report}");
}

#[test]
fn the_true_level_violates_where_nobody_reads_it() {
    // The reader reports 90 % whatever is true.
    let text = "base = \"nominal\"\n[expect]\n[execution]\nmax_time_s = 300\n[stop]\nat = []\n
                [[faults]]\nkind = \"battery_sensor_stuck\"\nat_s = 0\n[battery]\ndrain_pct_per_s = 0.2\n";
    let own = folder(
        text,
        "property told := always (BatteryReader, BatteryLevel, m[1] = <ok> implies level >= 20)
         property was := always (World, Monitors, level_pct >= 20)",
    );
    let report = run(&own, &[]);
    let lowest = report["battery"]["minimum"].as_f64().unwrap();
    assert!(lowest < 20.0, "{report}");
    assert_eq!(verdicts(&report), [("told", "satisfied"), ("was", "violated")]);
}

#[test]
fn a_place_that_the_robot_crosses_is_caught_without_a_leaf_that_asks() {
    let text = "base = \"nominal\"\n[expect]\n";
    let crossed = "property away := always (World, Monitors, at_RechargingStation = false)";
    assert_eq!(verdicts(&run(&folder(text, crossed), &[])), [("away", "violated")]);
    // The same place by the same robot with a full battery: it passes elsewhere.
    let full = ["--set", "battery.initial_pct=100"];
    assert_eq!(verdicts(&run(&folder(text, crossed), &full)), [("away", "satisfied")]);
}

#[test]
fn a_fault_can_wait_for_what_is_true() {
    let text = "base = \"nominal\"\n[expect]\n[execution]\nmax_time_s = 60\n
                [[faults]]\nkind = \"component_crash\"\ncomponent = \"Localization\"\n
                when = \"(World, Monitors, level_pct < 30.5)\"\n";
    let own = folder(text, "property p := always (World, Monitors, level_pct >= 30.5)");
    let report = run(&own, &[]);
    let (began, violated) = (&report["faults"][0]["time_s"], &report["monitors"][0]["time_s"]);
    let [began, violated] = [began, violated].map(|time| time.as_f64().unwrap_or_else(|| panic!("{report}")));
    assert!((began - violated).abs() <= 0.021, "{began} s and {violated} s");
}

/// What it is told for the second time violates it.
const TWICE: &str = r#"<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0" datamodel="ecmascript">
  <state id="never"><transition event="told" target="once"/></state>
  <state id="once"><transition event="told" target="again"/></state>
  <state id="again"/>
</scxml>"#;

/// The robot drives, so `x_m` changes at each step of the physics; `charging` never does.
#[test]
fn a_fault_and_a_machine_see_only_changes_of_their_own_fields() {
    let event = "when = \"(World, Monitors, charging = false)\"";
    let fault = format!("[[faults]]\nkind = \"battery_level\"\nlevel_pct = 80\ntimes = 100\n{event}\n");
    let machine = "[[monitors]]\nname = \"told\"\nmachine = \"Twice.scxml\"\nviolated_in = \"again\"\n";
    let events = format!("events = [{{ event = \"told\", {event} }}]\n");
    let text = format!("base = \"nominal\"\n[expect]\n[execution]\nmax_time_s = 10\n{fault}{machine}{events}");
    let still = "property still := always (World, Monitors, charging = false)\n";
    let drives = "property drives := always (World, Monitors, x_m > -100)\n";
    let [alone, beside] = [still.to_owned(), format!("{still}{drives}")].map(|properties| {
        let own = folder(&text, &properties);
        std::fs::write(own.path().join("Twice.scxml"), TWICE).unwrap();
        run(&own, &[])
    });
    assert_eq!(verdicts(&alone), [("still", "satisfied"), ("told", "satisfied")]);
    assert_eq!(verdicts(&beside), [("still", "satisfied"), ("drives", "satisfied"), ("told", "satisfied")]);
    assert_eq!(alone["faults"].as_array().map(Vec::len), Some(1), "{alone}");
    assert_eq!(beside["faults"], alone["faults"]);
    assert!(beside["robot"]["distance_m"].as_f64().unwrap() > 0.1, "{beside}");
}

#[test]
fn a_recording_gives_the_same_verdicts_of_the_world() {
    let own = folder(
        "base = \"nominal\"\n[expect]\n[execution]\nmax_time_s = 40\n",
        "property level := always (World, Monitors, level_pct >= 31)\nproperty alone := always (World, Monitors, person_m > 1)",
    );
    for name in ["run.rec", "run.mcap", "run.jsonl"] {
        let file = own.path().join(name);
        let report = run(&own, &["--record", file.to_str().unwrap()]);
        assert_eq!(verdicts(&report), [("level", "violated"), ("alone", "satisfied")]);
        let property = own.path().join("world.scope");
        let scenario = own.path().join("own.toml");
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
fn a_scenario_can_expect_what_is_true_without_a_file_of_properties() {
    let text = "base = \"nominal\"\nproperties = []\n[expect]\nreached = [\"Destination\"]\n[expect.satisfied]\n\
                slow = 'always (World, Monitors, speed_mps < 0.46)'\n\
                still = 'always (World, Monitors, speed_mps < 0.1)'\n";
    let own = folder("", "");
    let scenario = own.path().join("own.toml");
    std::fs::write(&scenario, text).unwrap();
    let report = run(&own, &[]);
    assert_eq!(verdicts(&report), [("slow", "satisfied"), ("still", "violated")]);
    assert_eq!(report["differences"], json!(["still was expected to be satisfied and is violated"]));
    let report = run(&own, &["--set", "expect.still=violated"]);
    assert_eq!(report["differences"], json!([]));
    let two = text.replace("speed_mps < 0.1)'", "speed_mps < 0.1) property other := always false'");
    std::fs::write(&scenario, two).unwrap();
    assert!(refusal(&["check", scenario.to_str().unwrap()]).contains("`still` is more than one formula"));
    let named = text.replace("still = ", "'stands still' = ");
    std::fs::write(&scenario, named).unwrap();
    assert_eq!(verdicts(&run(&own, &[])), [("slow", "satisfied"), ("stands still", "violated")]);
    let wrong = text.replace("always (World, Monitors, speed_mps < 0.1)", "always (World, Monitors, sped_mps < 0.1)");
    std::fs::write(&scenario, wrong).unwrap();
    let said = refusal(&["check", scenario.to_str().unwrap()]);
    assert!(said.contains("expect.satisfied.still") && said.contains("speed_mps"), "{said}");
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

/// What a proof says of these properties of `nominal`, and what it prints.
fn proved(properties: &str, more: &[&str]) -> (Vec<(String, String)>, Value) {
    let own = folder("base = \"nominal\"\n[expect]\n[prove]\nexpect = {}", properties);
    let output = steward(&[&["prove", own.path().join("own.toml").to_str().unwrap(), "--json"], more].concat());
    let said = String::from_utf8_lossy(&output.stderr);
    assert_ne!(output.status.code(), Some(2), "{said}");
    let results: Value = serde_json::from_slice(&output.stdout).unwrap();
    let text = |it: &Value, key: &str| it[key].as_str().unwrap().to_owned();
    let all = results["properties"].as_array().unwrap();
    (all.iter().map(|it| (text(it, "property"), text(it, "result"))).collect(), results)
}

/// The told level is one of the true ones: whatever is proved of the true level holds of the told one, too.
#[test]
fn a_proof_knows_the_true_level() {
    for level in ["0", "19", "20", "20.5", "31"] {
        let text = format!(
            "property truly := always (World, Monitors, level_pct >= {level})
            property told := always (BatteryReader, BatteryLevel, level >= {level})"
        );
        let (found, results) = proved(&text, &["--property", "truly", "--property", "told"]);
        let [truly, told] = [&found[0].1, &found[1].1];
        assert!(truly == "violated" || told == "proved", "{level}: {found:?}");
        assert_eq!(truly == "proved", matches!(level, "0" | "19" | "20"), "{level}: {found:?}");
        let run = &results["properties"][0]["run"];
        assert!(truly == "proved" || run["replayed"] == true, "{level}: {run:#}");
    }
}

#[test]
fn a_proof_knows_the_true_place_where_nobody_asks() {
    let text = "property once := always (World, Monitors, at_Destination = true implies at_RechargingStation = false)
        property never := always (World, Monitors, at_Destination = false)
        property charged_there := always (World, Monitors, charging = true implies at_RechargingStation = true)";
    let (found, results) = proved(text, &[]);
    let outcomes: Vec<&str> = found.iter().map(|(_, result)| result.as_str()).collect();
    assert_eq!(outcomes, ["proved", "violated", "proved", "proved"], "{found:?}");
    let said = results["assumptions"].to_string();
    assert!(said.contains("The true level and place of the robot are those that the components are told."), "{said}");
}

#[test]
fn what_a_proof_does_not_know_of_the_world_is_left_out_or_refused() {
    let text = "property fast := always (World, Monitors, speed_mps < 1)
        property soon := always ((World, Monitors, level_pct < 50) implies time_until (World, Monitors, charging = true) < 9)
        property level := always (World, Monitors, level_pct >= 0)
        property rests := eventually (BatteryReader, BatteryLevel, true)
        timed property prompt := always ((BatteryLevel, BatteryReader, true) implies time_until (BatteryReader, BatteryLevel, true) < 1 s)";
    let (found, results) = proved(text, &[]);
    assert_eq!(found.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>(), ["level", "progress"]);
    let said = results["assumptions"].to_string();
    let expected = "Not proved: fast (speaks of more than the level and the place), soon (counts messages or measures \
                    time, and speaks of the world), rests (requires something without a time limit, and no search can \
                    wait forever), prompt (cannot be explored: `prompt` is a timed property, and a proof has no notion \
                    of time between ticks).";
    assert!(said.contains(expected), "{said}");
    let own = folder("base = \"nominal\"\n[expect]\n[prove]\nexpect = {}", text);
    let said = refusal(&["prove", own.path().join("own.toml").to_str().unwrap(), "--property", "fast"]);
    assert!(said.contains("the property fast speaks of more than the level and the place"), "{said}");
    let own = folder("base = \"nominal\"\n[expect]\n[prove]\nexpect = { fast = \"proved\" }", text);
    let said = refusal(&["prove", own.path().join("own.toml").to_str().unwrap()]);
    assert!(said.contains("the property fast speaks of more") && !said.contains("the property soon"), "{said}");
}
