//! Proofs about the world: what was true, not what a process received.

use explorer::Order;
use proofs::Proof;
use scenarios::Error;
use tempfile::tempdir;

use crate::{assumptions, load, prove, results};

/// The proof of some of these properties of `nominal`, of which this is expected.
fn proof_of(properties: &str, expected: &str, only: &[&str]) -> Result<Proof, Error> {
    let folder = tempdir().unwrap();
    std::fs::write(folder.path().join("world.scope"), properties).unwrap();
    let scenario = folder.path().join("own.toml");
    let base = "properties = [\"world.scope\"]\nbase = \"nominal\"\n[expect]\n[prove]\n";
    std::fs::write(&scenario, format!("{base}expect = {{ {expected} }}\n")).unwrap();
    load(scenario.to_str().unwrap(), only, &[])
}

/// The received level is one of the true ones: what is proved of the true level holds of the received one, too.
#[test]
fn a_proof_knows_the_true_level() {
    for level in ["0", "19", "20", "20.5", "31"] {
        let text = format!(
            "property truly := always (World, Monitors, level_pct >= {level})
            property told := always (BatteryReader, BatteryLevel, level >= {level})"
        );
        let found = prove(&proof_of(&text, "", &["truly", "told"]).unwrap(), Order::Breadth);
        let [(_, truly), (_, told)] = results(&found)[..] else { panic!("{:?}", results(&found)) };
        assert!(truly == "violated" || told == "proved", "{level}: {truly}, {told}");
        assert_eq!(truly == "proved", matches!(level, "0" | "19" | "20"), "{level}: {truly}, {told}");
    }
}

#[test]
fn a_proof_knows_the_true_place_where_nobody_asks() {
    let text = "property once := always (World, Monitors, at_Destination = true implies at_RechargingStation = false)
        property never := always (World, Monitors, at_Destination = false)
        property charged_there := always (World, Monitors, charging = true implies at_RechargingStation = true)";
    let proof = proof_of(text, "", &[]).unwrap();
    let found = prove(&proof, Order::Breadth);
    let outcomes: Vec<&str> = results(&found).into_iter().map(|(_, result)| result).collect();
    assert_eq!(outcomes, ["proved", "violated", "proved", "proved"]);
    let said = assumptions(&proof).join(" ");
    assert!(said.contains("The true level and place of the robot are those that the components receive."), "{said}");
}

#[test]
fn what_a_proof_does_not_know_of_the_world_is_left_out_or_refused() {
    let text = "property fast := always (World, Monitors, speed_mps < 1)
        property soon := always ((World, Monitors, level_pct < 50) implies time_until (World, Monitors, charging = true) < 9)
        property level := always (World, Monitors, level_pct >= 0)
        property rests := eventually (BatteryReader, BatteryLevel, true)
        timed property prompt := always ((BatteryLevel, BatteryReader, true) implies time_until (BatteryReader, BatteryLevel, true) < 1 s)";
    let proof = proof_of(text, "", &[]).unwrap();
    let found = prove(&proof, Order::Breadth);
    assert_eq!(results(&found).into_iter().map(|(name, _)| name).collect::<Vec<_>>(), ["level", "progress"]);
    let said = assumptions(&proof).join(" ");
    let expected = "Not proved: fast (is about more than the level and the place), soon (counts messages or measures \
                    time, and is about the world), rests (requires something without a time limit, and no search can \
                    wait forever), prompt (cannot be explored: `prompt` is a timed property, and a proof has no notion \
                    of time between ticks).";
    assert!(said.contains(expected), "{said}");
    let said = proof_of(text, "", &["fast"]).unwrap_err().reasons();
    assert!(said.contains("the property fast is about more than the level and the place"), "{said}");
    let said = proof_of(text, "fast = \"proved\"", &[]).unwrap_err().reasons();
    assert!(said.contains("the property fast is about more") && !said.contains("the property soon"), "{said}");
}
