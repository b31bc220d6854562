//! Monitors that a scenario attaches ready-made: SCXML machines, and those of the paper's figure.

use std::path::{Path, PathBuf};

use recording::Detail;
use reports::Outputs;
use serde_json::{Value, json};
use tempfile::{TempDir, tempdir};

use crate::{monitor, problems, report, report_of, start};

/// Machines of the form that the paper's authors published, with the messages that become their events.
pub(crate) const MACHINES: &str = r#"
[[monitors]]
name = "charge"
machine = "ChargeWatch.scxml"
violated_in = "tooLow"
events = [{ event = "chargeChanged", when = "(BatteryReader, BatteryLevel, m[1] = <ok>)", data = { charge = "m[2]" } }]

[[monitors]]
name = "trip"
machine = "TripWatch.scxml"
violated_in = ["tooLate"]
pending_in = "alarm"
events = [
  { event = "tick", when = "(TickGenerator, BT, true)" },
  { event = "chargeChanged", when = "(BatteryReader, BatteryLevel, m[1] = <ok>)", data = { charge = "m[2]" } },
  { event = "goalChanged", when = "(Navigation, GoToDestination, m[2] = <running>)", data = { goal = "kitchen" } },
  { event = "goalChanged", when = "(Navigation, GotoRechargingStation, m[2] = <running>)", data = { goal = "dock" } },
]
"#;

/// A folder with the machines and a scenario that has these lines in addition to those of its base.
fn folder(base: &str, lines: &str) -> (TempDir, PathBuf) {
    let folder = tempdir().unwrap();
    let published = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/published");
    for machine in ["ChargeWatch.scxml", "TripWatch.scxml"] {
        std::fs::copy(published.join(machine), folder.path().join(machine)).unwrap();
    }
    let scenario = folder.path().join("watched.toml");
    std::fs::write(&scenario, format!("base = \"scenarios/{base}.toml\"\n{lines}")).unwrap();
    (folder, scenario)
}

fn run(base: &str, lines: &str) -> Value {
    let (_folder, scenario) = folder(base, lines);
    report(&scenario, &[])
}

#[test]
fn the_message_that_violates_a_machine_is_reported() {
    let watched = run("battery_fault", MACHINES);
    let (machine, property) = (monitor(&watched, "charge"), monitor(&watched, "phi1"));
    assert_eq!(machine["verdict"], "violated", "{machine}");
    assert_eq!(machine["state"], "tooLow");
    for key in ["tick", "time_s"] {
        assert_eq!(machine[key], property[key]);
    }
    assert_eq!(machine["witness"]["message"], property["witness"]["message"]);
    assert_eq!(monitor(&watched, "trip")["verdict"], "satisfied");
    assert_eq!(monitor(&watched, "trip")["state"], "resting");
    let alone = run("battery_fault", "");
    assert_eq!(watched["trace_hash"], alone["trace_hash"], "monitors never change a run");
}

#[test]
fn the_published_response_monitors_fail_one_tick_after_the_formula() {
    let figures = "[[monitors]]\nfigure = \"5 (a)\"\n[[monitors]]\nfigure = \"5 (b)\"\n";
    let watched = run("skill_bug", &format!("{MACHINES}{figures}"));
    assert_eq!(monitor(&watched, "phi2")["tick"], 31);
    assert_eq!(monitor(&watched, "figure_5b")["tick"], 32);
    assert_eq!(monitor(&watched, "trip")["tick"], 32);
    assert_eq!(monitor(&watched, "figure_5a")["verdict"], "satisfied");
    assert_eq!(monitor(&watched, "charge")["verdict"], "satisfied");
}

#[test]
fn a_run_that_ends_while_a_machine_waits_leaves_it_inconclusive() {
    let short = format!("{MACHINES}[execution]\nmax_time_s = 25\n[stop]\n[expect]\ntrip = \"inconclusive\"\n");
    let watched = run("skill_bug", &short);
    assert_eq!(monitor(&watched, "trip")["verdict"], "inconclusive");
    assert!(
        watched["differences"].as_array().unwrap().iter().all(|difference| !difference.to_string().contains("trip"))
    );
}

#[test]
fn the_page_and_the_pictures_show_a_machine_with_its_state() {
    let (folder, scenario) = folder("battery_fault", MACHINES);
    let out = folder.path().join("out");
    let outputs = Outputs { folder: Some(out.clone()), snapshots: true, ..Outputs::default() };
    let run = json!(report_of(start(&scenario, &[]), Detail::Full, &outputs, None).unwrap());
    assert!(
        run["snapshots"].as_array().unwrap().iter().any(|shot| shot["file"].to_string().contains("charge-violated"))
    );
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains(">charge</h3>") && page.contains("tooLow"));
}

#[test]
fn errors_in_a_monitor_machine_are_reported_and_change_nothing() {
    let (folder, scenario) = folder("battery_fault", MACHINES);
    let broken = std::fs::read_to_string(folder.path().join("ChargeWatch.scxml")).unwrap();
    let broken = broken.replace("_event.data.charge", "_event.data.none.charge");
    std::fs::write(folder.path().join("ChargeWatch.scxml"), broken).unwrap();
    let run = report(&scenario, &[]);
    let errors = monitor(&run, "charge")["errors"].to_string();
    assert!(errors.contains("error.execution") && errors.contains("first at tick 0"), "{errors}");
    assert_eq!(monitor(&run, "phi1")["verdict"], "violated");
}

#[test]
fn errors_in_a_ready_made_monitor_are_reported_with_their_locations() {
    let said = |from: &str, to: &str| {
        let (_folder, scenario) = folder("battery_fault", &MACHINES.replace(from, to));
        problems(&scenario, &[]).concat()
    };
    for (from, to, words) in [
        ("tooLow", "tooLoud", "did you mean `tooLow`?"),
        ("event = \"tick\"", "event = \"tock\"", "did you mean `tick`?"),
        ("(TickGenerator, BT, true)", "(TickGenerator, BTs, true)", "BTs"),
        ("ChargeWatch.scxml", "ChargeWatcher.scxml", "cannot read"),
        ("charge = \"m[2]\"", "charge = \"m[0]\"", "for a field of the message"),
        ("name = \"trip\"", "name = \"charge\"", "there is already a property `charge`"),
        ("violated_in = \"tooLow\"", "", "`violated_in`"),
        ("machine = \"ChargeWatch.scxml\"", "figure = \"5 (c)\"", "5 (c)"),
    ] {
        let said = said(from, to);
        assert!(said.contains(words), "{words} is not in\n{said}");
    }
}
