//! `steward prove`: every schedule and everything that may happen around tree, skills and components.

use serde_json::Value;
use tempfile::tempdir;

use crate::steward::{refusal, steward};

/// The results of a proof, which must end with this status.
fn proof(status: i32, arguments: &[&str]) -> Value {
    let output = steward(&[&["prove", "--json"], arguments].concat());
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(status), "{arguments:?}: {said}");
    serde_json::from_slice(&output.stdout).expect("the results are JSON")
}

fn results(proof: &Value) -> Vec<(&str, &str)> {
    let properties = proof["properties"].as_array().expect("there are properties");
    properties.iter().filter_map(|it| Some((it["property"].as_str()?, it["result"].as_str()?))).collect()
}

#[test]
fn the_papers_system_is_as_its_scenario_says() {
    for tree in ["execution.tree=whole", "execution.tree=nodes"] {
        let proof = proof(0, &["nominal", "--set", tree]);
        assert_eq!(results(&proof), [("phi1", "proved"), ("phi2", "violated"), ("phi3", "proved")]);
        let run = &proof["properties"][1]["run"];
        assert_eq!(run["replayed"], true, "{run:#}");
        assert!(run["steps"].as_array().is_some_and(|steps| steps.len() > 10), "{run:#}");
    }
}

#[test]
fn trips_may_take_9_ticks_where_the_battery_loses_1_percent_per_tick() {
    let long = ["nominal", "--property", "phi1", "--set", "prove.trips.ticks=10"];
    let violated = proof(1, &long);
    assert_eq!(results(&violated), [("phi1", "violated")]);
    assert_eq!(violated["properties"][0]["as_expected"], false);
    proof(0, &[&long[..], &["--set", "prove.expect.phi1=violated"]].concat());
    // Twice the drain.
    let twice = ["nominal", "--property", "phi1", "--set", "prove.battery.drain_pct_per_tick=2"];
    proof(0, &[&twice[..], &["--set", "prove.trips.ticks=4"]].concat());
    proof(1, &[&twice[..], &["--set", "prove.trips.ticks=5"]].concat());
}

const OR_THERE: [&str; 7] = [
    "nominal",
    "--set",
    "properties=['properties/phi2_or_there.scope']",
    "--set",
    "prove={}",
    "--set",
    "prove.trips.passes='any'",
];

#[test]
fn being_there_is_an_answer_whatever_the_battery_and_the_route() {
    for tree in ["execution.tree=whole", "execution.tree=nodes"] {
        assert_eq!(results(&proof(0, &[&OR_THERE[..], &["--set", tree]].concat())), [("phi2_or_there", "proved")]);
    }
}

#[test]
fn the_result_is_the_same_on_any_number_of_threads() {
    let of = |threads: &str| {
        let mut proof = proof(0, &["nominal", "--threads", threads]);
        for property in proof["properties"].as_array_mut().expect("there are properties") {
            property["time_s"] = Value::Null;
            property["memory_bytes"] = Value::Null;
        }
        proof
    };
    assert_eq!(of("1"), of("3"));
}

#[test]
fn without_enough_memory_nothing_is_decided() {
    let tight = ["nominal", "--property", "phi1", "--memory", "1", "--set", "execution.tree=nodes"];
    assert_eq!(results(&proof(1, &tight)), [("phi1", "not decided")]);
    let output = steward(&[&["prove"], &tight[..]].concat());
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(said.contains("! phi1 is not decided: explored "), "{said}");
}

#[test]
fn words_fit_80_columns_and_say_what_is_assumed_and_what_happens() {
    let output = steward(&["prove", "nominal"]);
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    let table: Vec<&str> = said.lines().skip_while(|line| !line.starts_with("  property")).take(3).collect();
    assert!(table.len() == 3 && table.iter().all(|line| line.chars().count() <= 80), "{said}");
    for words in [
        "The battery starts with 31 to 100 % and loses at most 1 % per tick.",
        "Trips take at most 9 ticks, never fail, and may pass RechargingStation.",
        "phi2 is violated:",
        "the robot comes to RechargingStation",
        "replayed in the channel system: violated at tick",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
}

#[test]
fn junit_has_a_case_per_property() {
    let folder = tempdir().expect("a folder");
    let file = folder.path().join("proofs.xml");
    let path = file.to_str().expect("a path in UTF-8");
    proof(1, &["nominal", "--junit", path, "--set", "prove.expect.phi1=violated"]);
    let xml = std::fs::read_to_string(&file).expect("it was written");
    assert!(xml.contains("<testsuite name=\"nominal\" tests=\"3\" failures=\"1\""), "{xml}");
    assert!(xml.contains("phi1 was expected to be violated, and is proved"), "{xml}");
}

/// What is said of `nominal` with these settings, which are refused.
fn refused(set: &[&str]) -> String {
    let set: Vec<&str> = set.iter().flat_map(|set| ["--set", set]).collect();
    refusal(&[&["prove", "nominal"], &set[..]].concat())
}

#[test]
fn assumptions_that_contradict_each_other_are_refused() {
    for (set, said) in [
        (
            &["prove.battery={charge_pct_per_tick=1}"][..],
            "`charge_pct_per_tick` contradicts a battery whose level may jump",
        ),
        (&["prove.battery={start_pct=50}"], "add `drain_pct_per_tick`"),
        (
            &["prove.battery={drain_pct_per_tick=1, start_pct=[60, 50]}"],
            "`start_pct` must be a number from 0 to 100, or",
        ),
        (&["prove.battery.drain_pct_per_tick=0.00000001"], "has more than six decimals"),
        (&["prove.battery.drain_pct_per_tick=0.0001"], "too many classes of levels"),
        (&["prove.trips.passes='Kitchn'"], "unknown place `Kitchn`"),
        (&["prove.messages={delay_s=2}"], "`delay_s` says nothing where no message may be delayed"),
        (&["prove.messages={lose=1, on=[['BT', 'Navigation']]}"], "there is no channel from BT to Navigation"),
        (&["prove.messages={lose=1, on=[['BTT', 'Navigation']]}"], "unknown process `BTT`"),
        (&["prove.properties='phi1'", "prove.expect={phi3='proved'}"], "`phi3` is not among `prove.properties`"),
        (&["prove.properties='phi4'"], "unknown property `phi4`"),
        (&["prove.components.Arm.machine='a.scxml'"], "unknown component `Arm`"),
    ] {
        let found = refused(set);
        assert!(found.contains(said), "{set:?}: {found}");
    }
    let unknown = refusal(&["prove", "nominal", "--property", "phi9"]);
    assert!(unknown.contains("there is no property `phi9`") && !unknown.contains("has no property"), "{unknown}");
    let without_map = refusal(&["prove", "pick", "--set", "prove.battery={}"]);
    assert!(without_map.contains("`prove.battery` needs a map"), "{without_map}");
}

#[test]
fn what_cannot_be_proved_is_said_with_a_way_out() {
    let pick = refusal(&["prove", "pick"]);
    assert!(pick.contains("the property delivered demands something without a bound"), "{pick}");
    let guide = refusal(&["prove", "guide", "--set", "prove.components={}"]);
    assert!(guide.contains("TourPlanner cannot be proved: it is a program"), "{guide}");
    assert!(guide.contains("Door cannot be proved: it senses and changes"), "{guide}");
    assert!(guide.contains("[prove.components.TourPlanner]"), "{guide}");
    let folder = tempdir().expect("a folder");
    let machine = folder.path().join("BatteryLevel.scxml");
    let text = std::fs::read_to_string("skills/machines/BatteryLevel.scxml").expect("it is shipped");
    std::fs::write(&machine, text.replace("_event.data.level >", "2 * _event.data.level >"))
        .expect("room for a machine");
    let said = refused(&[&format!("leaves.BatteryLevel.machine='{}'", machine.display())]);
    assert!(said.contains("the machine computes with a level, which a proof cannot follow"), "{said}");
    assert!(said.contains("BatteryLevel.scxml"), "{said}");
}

#[test]
fn the_published_protocol_takes_turns_but_not_in_time() {
    for tree in ["execution.tree=whole", "execution.tree=nodes"] {
        let proof = proof(0, &["takes_turns", "--set", tree]);
        assert_eq!(results(&proof), [("takes_turns", "proved"), ("stops_first", "violated")]);
    }
}

#[test]
fn a_guide_that_cannot_reach_a_stop_leaves_it_out_and_does_nothing_worse() {
    let whole = proof(0, &["guide"]);
    let expected = ["shows_once", "opens_first", "locks_nobody_in", "plans_promptly"].map(|name| (name, "proved"));
    assert_eq!(results(&whole), [&[("shows_all", "violated")], &expected[..]].concat());
    let fewer = ["execution.tree=nodes", "prove.trips.fail=false", "prove.messages={}", "prove.expect={}"];
    let fewer: Vec<&str> = fewer.iter().flat_map(|set| ["--set", set]).collect();
    let nodes = proof(0, &[&["guide", "--property", "opens_first"], &fewer[..]].concat());
    assert_eq!(results(&nodes), [("opens_first", "proved")]);
}
