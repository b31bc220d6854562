//! The levels of a battery in the runs that a proof finds.

use channels::{EventKind, Value};
use explorer::{Order, Outcome};
use proofs::{Answer, Proof};
use scenarios::scenario::ProofOutcome;
use tempfile::tempdir;

use crate::followed::written;
use crate::{answer, load};

/// The first answer of a proof.
fn first(proof: &Proof) -> Answer {
    answer(proof, &proof.questions()[0], Order::Breadth)
}

/// The levels that are read in the run that violates the first property. It can be written and followed.
fn levels(proof: &Proof, answer: &Answer) -> Vec<f64> {
    let Outcome::Violated(run) = &answer.exploration.outcome else { panic!("{answer:#?}") };
    let question = &proof.questions()[0];
    drop(written(proof, question, answer, run));
    let replay = run.replay(&answer.model, proof.monitor(question)).unwrap();
    let topology = replay.system.topology();
    let level = |kind: &EventKind| match kind {
        EventKind::Received { channel, message } if topology.ends(*channel) == ("BatteryReader", "BatteryLevel") => {
            message.fields().iter().find_map(|field| if let Value::Real(level) = field { Some(*level) } else { None })
        }
        _ => None,
    };
    replay.events.iter().filter_map(|(_, event)| level(&event.kind)).collect()
}

/// No level of at most 30 % is read before tick 5.
const SLOW: &str = "property slow := not (time_until (BatteryReader, BatteryLevel, m[2] <= 30) < 5)\n";

#[test]
fn impossible_levels_are_divided_more_finely() {
    let folder = tempdir().unwrap();
    let file = folder.path().join("slow.scope");
    std::fs::write(&file, SLOW).unwrap();
    let properties = format!("properties=['{}']", file.display());
    let of = |start: &str, rates: &str| {
        let battery = format!("prove.battery={{start_pct={start}, {rates}}}");
        let proof = load("nominal", &[], &[&properties, "prove.properties=[]", "prove.expect={}", &battery]).unwrap();
        let answer = first(&proof);
        (proof, answer)
    };
    let result = |start: &str, rates: &str| of(start, rates).1.outcome().map(ProofOutcome::name);
    // Above 30 %, all levels are equivalent at first: 30 % may follow any of them.
    assert_eq!(result("100", "drain_pct_per_tick=1"), Some("proved"));
    assert_eq!(result("34.5", "drain_pct_per_tick=1"), Some("proved"));
    // These rates have no sufficiently large common divisor.
    assert!(of("100", "drain_pct_per_tick=0.9999, charge_pct_per_tick=1").1.is_spurious);
    let (proof, violated) = of("33.5", "drain_pct_per_tick=1");
    let levels = levels(&proof, &violated);
    assert_eq!(violated.outcome().map(ProofOutcome::name), Some("violated"));
    assert!(levels.len() > 3 && levels.windows(2).all(|pair| pair[0] - pair[1] <= 1.0 + 1e-9), "{levels:?}");
}

#[test]
fn a_battery_can_have_the_levels_of_a_run_with_a_fault() {
    let set =
        ["prove.trips.ticks=10", "prove.expect.phi1=violated", "prove.faults={component_wrong_reply='Localization'}"];
    let proof = load("nominal", &["phi1"], &set).unwrap();
    let levels = levels(&proof, &first(&proof));
    assert!(levels.len() > 10 && levels.windows(2).all(|pair| pair[0] - pair[1] <= 1.0 + 1e-9), "{levels:?}");
}
