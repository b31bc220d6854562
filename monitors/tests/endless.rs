//! While a run continues, only endless continuations count, and only ticks advance time.

use std::time::Duration;

use channels::Monitor;
use channels::{Event, EventKind, Message, Value, Verdict};
use monitors::{Outcome, ScopeMonitor, load, scope_monitor};

use crate::robot::topology;

const Q: &str = "(BatteryReader, BatteryLevel, m[2] < 20)";
const P: &str = "(Localization, AtRechargingStation, m[2] = true)";

/// The verdict before the first state and after each letter of a run: `t` is a tick, `q` and `p` are the events Q and
/// P.
fn verdicts(formula: &str, run: &str) -> (Vec<Verdict>, ScopeMonitor) {
    let topology = topology();
    let file = load("p", &format!("property p := {formula}"), &topology, Duration::from_secs(1)).expect("it loads");
    let mut monitor = scope_monitor(file.properties[0].monitor.as_ref()).expect("made from text").clone();
    let mut reported = vec![monitor.verdict()];
    let mut ticks = 0;
    for (step, letter) in run.chars().enumerate() {
        let received = |source, target, value: Value| EventKind::Received {
            channel: topology.find_channel(source, target).expect("a channel of the robot"),
            message: Message::new([Value::symbol("ok"), value]),
        };
        let kind = match letter {
            't' => EventKind::Tick,
            'q' => received("BatteryReader", "BatteryLevel", 10.0.into()),
            _ => received("Localization", "AtRechargingStation", true.into()),
        };
        ticks += u64::from(kind == EventKind::Tick);
        let (step, tick) = (step as u64, ticks.max(1) - 1);
        monitor.observe(&Event { step, tick, time: Duration::from_secs(tick), kind });
        reported.push(monitor.verdict());
    }
    (reported, monitor)
}

#[test]
fn a_recurrence_is_open_while_the_run_continues() {
    for formula in [
        format!("always ({Q} implies time_until {Q} > 0)"),
        format!("always ({Q} implies next {Q})"),
        format!("always ({Q} implies eventually next {Q})"),
        format!("always time_until {Q} > 0"),
        format!("always eventually {Q}"),
        format!("always ({Q} implies next {Q}) and always eventually {P}"),
        format!("not eventually always not {Q}"),
        "always next true".to_owned(),
    ] {
        let (reported, monitor) = verdicts(&formula, "tqtqtq");
        assert_eq!(reported, vec![Verdict::Inconclusive; 7], "{formula}");
        let (denied, _) = verdicts(&format!("not ({formula})"), "tqtqtq");
        assert_eq!(denied, vec![Verdict::Inconclusive; 7], "not {formula}");
        // At the end of the run, whatever is open counts as false.
        if !formula.contains("eventually") {
            assert_eq!(monitor.outcome(), Outcome::Inconclusive, "{formula}");
            assert!(!monitor.open_obligations().is_empty(), "{formula}");
        }
    }
}

#[test]
fn a_property_that_no_endless_run_satisfies_is_violated_at_once() {
    for (formula, run) in [
        // A forbidden recurrence: always, from the first tick on, or after the first Q.
        (format!("always eventually {Q} and eventually always not {Q}"), ""),
        (format!("always time_until {Q} >= 2 and always not {Q}"), "t"),
        (format!("always ({Q} implies next {Q}) and always ({Q} implies not next {Q})"), "q"),
        (format!("always ({Q} implies time_until {P} < 3) and always not {P}"), "tq"),
        (
            format!(
                "always ({Q} implies time_until {P} > 3) and always ({Q} implies eventually always not {P}) and always next {Q}"
            ),
            "t",
        ),
        // Only ticks advance time: without another one, nothing comes later.
        (format!("time_until {Q} > 0 and not next true"), ""),
    ] {
        let (reported, _) = verdicts(&formula, run);
        assert_eq!(reported.last(), Some(&Verdict::False), "{formula}");
        let (denied, _) = verdicts(&format!("not ({formula})"), run);
        assert_eq!(denied.last(), Some(&Verdict::True), "not ({formula})");
        if let Some(before) = reported.len().checked_sub(2) {
            assert_eq!(reported[before], Verdict::Inconclusive, "{formula}");
        }
    }
}
