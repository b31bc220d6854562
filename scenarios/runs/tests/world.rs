//! The world in properties: what was true, not what a process received.

use robot::Streams;
use serde_json::json;
use tempfile::{TempDir, tempdir};

use crate::{load, problems, report, verdicts};

/// A folder with a scenario and its properties.
fn folder(scenario: &str, properties: &str) -> TempDir {
    let folder = tempdir().unwrap();
    std::fs::write(folder.path().join("world.scope"), properties).unwrap();
    let scenario = format!("properties = [\"world.scope\"]\n{scenario}");
    std::fs::write(folder.path().join("own.toml"), scenario).unwrap();
    folder
}

#[test]
fn properties_of_the_world_change_no_run_and_no_process_hears_of_it() {
    let text = "base = \"parcel\"\n[expect]\n[execution]\nmax_time_s = 20\n";
    let own = folder(text, "property level := always (World, Monitors, level_pct > 0 and clearance_m >= 0)");
    let without = report(own.path().join("own.toml"), &["properties=[]"]);
    let with = report(own.path().join("own.toml"), &[]);
    assert_eq!(verdicts(&with), [("level", "satisfied")]);
    for same in ["trace_hash", "messages", "robot", "places"] {
        assert_eq!(with[same], without[same], "{same}");
    }
    let scenario = load(own.path().join("own.toml"), &[]).unwrap();
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
    let said = problems(own.path().join("own.toml"), &[&machine]).concat();
    assert!(said.contains("World"), "{said}");
    let component = "base = \"nominal\"\n[components.World]\nbuiltin = \"speaker\"\n[expect]";
    let own = folder(component, "property p := true");
    let said = problems(own.path().join("own.toml"), &[]).concat();
    assert!(said.contains("a component cannot be named `World`"), "{said}");
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
    let report = report(own.path().join("own.toml"), &[]);
    let lowest = report["battery"]["minimum"].as_f64().unwrap();
    assert!(lowest < 20.0, "{report}");
    assert_eq!(verdicts(&report), [("told", "satisfied"), ("was", "violated")]);
}

#[test]
fn a_place_that_the_robot_crosses_is_caught_without_a_leaf_that_asks() {
    let text = "base = \"nominal\"\n[expect]\n";
    let crossed = "property away := always (World, Monitors, at_RechargingStation = false)";
    assert_eq!(verdicts(&report(folder(text, crossed).path().join("own.toml"), &[])), [("away", "violated")]);
    // The same place by the same robot with a full battery: it passes elsewhere.
    let full = ["battery.initial_pct=100"];
    assert_eq!(verdicts(&report(folder(text, crossed).path().join("own.toml"), &full)), [("away", "satisfied")]);
}

#[test]
fn a_fault_can_wait_for_what_is_true() {
    let text = "base = \"nominal\"\n[expect]\n[execution]\nmax_time_s = 60\n
                [[faults]]\nkind = \"component_crash\"\ncomponent = \"Localization\"\n
                when = \"(World, Monitors, level_pct < 30.5)\"\n";
    let own = folder(text, "property p := always (World, Monitors, level_pct >= 30.5)");
    let report = report(own.path().join("own.toml"), &[]);
    let (began, violated) = (&report["faults"][0]["time_s"], &report["monitors"][0]["time_s"]);
    let [began, violated] = [began, violated].map(|time| time.as_f64().unwrap_or_else(|| panic!("{report}")));
    assert!((began - violated).abs() <= 0.021, "{began} s and {violated} s");
}

/// A second event `told` violates it.
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
        report(own.path().join("own.toml"), &[])
    });
    assert_eq!(verdicts(&alone), [("still", "satisfied"), ("told", "satisfied")]);
    assert_eq!(verdicts(&beside), [("still", "satisfied"), ("drives", "satisfied"), ("told", "satisfied")]);
    assert_eq!(alone["faults"].as_array().map(Vec::len), Some(1), "{alone}");
    assert_eq!(beside["faults"], alone["faults"]);
    assert!(beside["robot"]["distance_m"].as_f64().unwrap() > 0.1, "{beside}");
}

#[test]
fn a_scenario_can_expect_what_is_true_without_a_file_of_properties() {
    let text = "base = \"nominal\"\nproperties = []\n[expect]\nreached = [\"Destination\"]\n[expect.satisfied]\n\
                slow = 'always (World, Monitors, speed_mps < 0.46)'\n\
                still = 'always (World, Monitors, speed_mps < 0.1)'\n";
    let own = folder("", "");
    let scenario = own.path().join("own.toml");
    std::fs::write(&scenario, text).unwrap();
    let report = crate::report(&scenario, &[]);
    assert_eq!(verdicts(&report), [("slow", "satisfied"), ("still", "violated")]);
    assert_eq!(report["differences"], json!(["still was expected to be satisfied and is violated"]));
    let report = crate::report(&scenario, &["expect.still=violated"]);
    assert_eq!(report["differences"], json!([]));
    let two = text.replace("speed_mps < 0.1)'", "speed_mps < 0.1) property other := always false'");
    std::fs::write(&scenario, two).unwrap();
    assert!(problems(&scenario, &[]).concat().contains("`still` is more than one formula"));
    let named = text.replace("still = ", "'stands still' = ");
    std::fs::write(&scenario, named).unwrap();
    assert_eq!(verdicts(&crate::report(&scenario, &[])), [("slow", "satisfied"), ("stands still", "violated")]);
    let wrong = text.replace("always (World, Monitors, speed_mps < 0.1)", "always (World, Monitors, sped_mps < 0.1)");
    std::fs::write(&scenario, wrong).unwrap();
    let said = problems(&scenario, &[]).concat();
    assert!(said.contains("expect.satisfied.still") && said.contains("speed_mps"), "{said}");
}
