//! What the paper says must happen, claim by claim, with where it says so.

use crate::report::{MonitorReport, Report};

/// An experiment of the paper and the scenario that repeats it.
#[derive(Debug)]
pub(super) struct Experiment {
    /// The scenario's name.
    pub(super) scenario: &'static str,
    /// What the paper calls it.
    pub(super) title: &'static str,
    pub(super) claims: &'static [Claim],
}

/// Something that must be so in every run.
#[derive(Debug)]
pub(super) struct Claim {
    /// What, in words.
    pub(super) says: &'static str,
    /// Where the paper says so.
    pub(super) source: &'static str,
    /// `None` if it is so in that run, else what was found instead.
    pub(super) differs: fn(&Report) -> Option<String>,
}

const STATION: &str = "RechargingStation";
const DESTINATION: &str = "Destination";
/// θ of φ2, in ticks: the paper names it, and the value is that of its published code.
const THETA_TICKS: u64 = 10;

/// The paper's experiments, and the scenario that they disturb.
pub(super) const EXPERIMENTS: [Experiment; 4] = [
    Experiment {
        scenario: "nominal",
        title: "The scenario, undisturbed",
        claims: &[
            Claim {
                says: "below 30 % the robot breaks off and reaches the charging station",
                source: "Section II",
                differs: |run| {
                    let Some(station) = reached(run, STATION) else { return Some("it did not get there".to_owned()) };
                    let before = reached(run, DESTINATION).is_some_and(|destination| destination < station);
                    before.then(|| "it went to the destination first".to_owned())
                },
            },
            Claim {
                says: "it waits there until the battery is fully charged",
                source: "Section II",
                differs: |run| {
                    let (end_pct, least_pct) = (run.battery.r#final, run.battery.minimum);
                    // What is left after the rest of the way: 1 % is 20 s of driving.
                    (end_pct < 97.0 || least_pct >= 30.0)
                        .then(|| format!("the charge was {least_pct:.1} % at least and {end_pct:.1} % at the end"))
                },
            },
            Claim {
                says: "then it resumes the navigation task and arrives",
                source: "Section II",
                differs: |run| reached(run, DESTINATION).is_none().then(|| "it did not arrive".to_owned()),
            },
            Claim {
                says: "the level read is never below 20 %: φ1 holds",
                source: "Section II, Figure 4",
                differs: |run| verdict(run, "phi1", "satisfied"),
            },
            Claim {
                says: "it starts for the station in time: φ2 holds",
                source: "Section II, Figure 4",
                differs: |run| holds_with_reason(run, "phi2"),
            },
        ],
    },
    Experiment {
        scenario: "battery_fault",
        title: "Experiment 1: a runtime monitor for a safety property",
        claims: &[
            Claim {
                says: "the level is imposed to be 10 % and φ1 is violated",
                source: "Experiment 1, Figure 6 (b)",
                differs: |run| verdict(run, "phi1", "violated"),
            },
            Claim {
                says: "φ1's monitor goes to the state failure",
                source: "Experiment 1, Figure 6 (e)",
                differs: |run| {
                    let state = monitor(run, "phi1").map_or("nothing", |monitor| monitor.state.as_str());
                    (state != "failure").then(|| format!("it is in {state}"))
                },
            },
            Claim {
                says: "it does so at the first level that is read after the fault",
                source: "Experiment 1",
                differs: |run| at_tick_after_fault(run, "phi1", 0),
            },
            Claim {
                says: "the robot goes to the charging station",
                source: "Figure 6 (b)",
                differs: |run| reached(run, STATION).is_none().then(|| "it did not get there".to_owned()),
            },
        ],
    },
    Experiment {
        scenario: "skill_bug",
        title: "Experiment 2: a runtime monitor for a responsive property",
        claims: &[
            Claim {
                says: "BatteryLevel says success above 20 %, and φ2 is violated",
                source: "Experiment 2",
                differs: |run| verdict(run, "phi2", "violated"),
            },
            Claim {
                says: "it is violated θ = 10 ticks after the first level below 30 % is read",
                source: "Figure 5 (b), θ of the published code",
                differs: |run| at_tick_after_fault(run, "phi2", THETA_TICKS),
            },
            Claim {
                says: "the robot does not go to the charging station",
                source: "Experiment 2",
                differs: |run| reached(run, STATION).map(|at| format!("it was there at {at:.1} s")),
            },
            Claim {
                says: "no level below 20 % is read: φ1 holds",
                source: "Experiment 2",
                differs: |run| verdict(run, "phi1", "satisfied"),
            },
        ],
    },
    Experiment {
        scenario: "joypad",
        title: "Experiment 3: a monitor on a real robot",
        claims: &[
            Claim {
                says: "the battery is at 35 % at the start",
                source: "Figure 8 (a)",
                differs: |run| {
                    let start_pct = run.battery.initial;
                    (start_pct != 35.0).then(|| format!("it is at {start_pct:.1} %"))
                },
            },
            Claim {
                says: "below 30 % the robot sets out for the charging station: φ2 holds",
                source: "Experiment 3, Figure 7 (a)",
                differs: |run| holds_with_reason(run, "phi2"),
            },
            Claim {
                says: "somebody with a joypad drives it away, and again when it has resumed",
                source: "Experiment 3, Figure 7 (b) to (d)",
                differs: |run| {
                    let until_s = monitor(run, "phi1").and_then(|monitor| monitor.time_s).unwrap_or(0.0);
                    let times =
                        run.faults.iter().filter(|fault| fault.kind == "joypad" && fault.time_s < until_s).count();
                    (times < 2).then(|| format!("that happened {times} times before φ1 was violated"))
                },
            },
            Claim {
                says: "it is kept from reaching the charging station",
                source: "Experiment 3",
                differs: |run| reached(run, STATION).map(|at| format!("it was there at {at:.1} s")),
            },
            Claim {
                says: "the level gets below 20 % and φ1 is violated, at 19 %",
                source: "Experiment 3, Figure 8 (b)",
                differs: |run| {
                    let level = monitor(run, "phi1").and_then(level_that_decided);
                    let Some(level_pct) = level else { return Some("φ1 is not violated".to_owned()) };
                    (!(19.0..20.0).contains(&level_pct)).then(|| format!("the level read was {level_pct:.2} %"))
                },
            },
        ],
    },
];

fn monitor<'r>(run: &'r Report, name: &str) -> Option<&'r MonitorReport> {
    run.monitors.iter().find(|monitor| monitor.name == name)
}

fn verdict(run: &Report, name: &str, wanted: &str) -> Option<String> {
    let found = monitor(run, name).map_or("not watched", |monitor| monitor.verdict);
    (found != wanted).then(|| format!("{name} is {found}"))
}

/// That a property holds, and not only because there was no occasion for it to fail.
fn holds_with_reason(run: &Report, name: &str) -> Option<String> {
    let vacuous = monitor(run, name).and_then(|monitor| monitor.vacuous.first().cloned());
    verdict(run, name, "satisfied").or(vacuous)
}

/// That a property is violated so many ticks after the first level that is read once the battery's level has been set; ticks
/// come once a second, the first just after the start.
fn at_tick_after_fault(run: &Report, name: &str, ticks: u64) -> Option<String> {
    let Some(fault) = run.faults.iter().find(|fault| fault.kind == "battery_level") else {
        return Some("the battery's level was never set".to_owned());
    };
    let wanted = fault.time_s.ceil() as u64 + ticks;
    let found = monitor(run, name).and_then(|monitor| monitor.tick);
    (found != Some(wanted)).then(|| match found {
        Some(tick) => format!("{name} was violated at tick {tick}, not at tick {wanted}"),
        None => format!("{name} was not violated"),
    })
}

/// The level, in percent, in the message that decided a property.
fn level_that_decided(monitor: &MonitorReport) -> Option<f64> {
    monitor.witness.as_ref()?["message"][1].as_f64()
}

fn reached(run: &Report, place: &str) -> Option<f64> {
    run.places.iter().find(|visit| visit.name == place)?.reached_at_s
}
