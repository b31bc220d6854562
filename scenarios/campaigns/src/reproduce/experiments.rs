//! The paper's claims with their sources, and the claims that this project adds.

use monitors::Outcome;
use reports::report::{MonitorReport, Report};
use scenarios::scenario::Figure;

use super::observed::{Observed, SafetyPath};

/// A completed run: its report, and what was observed during it.
#[derive(Clone, Debug)]
pub(super) struct ExperimentRun {
    pub(super) report: Report,
    pub(super) observed: Observed,
}

/// An experiment of the paper and the scenario that repeats it.
#[derive(Debug)]
pub(super) struct Experiment {
    /// The scenario's name.
    pub(super) scenario: &'static str,
    /// The paper's name for it.
    pub(super) title: &'static str,
    /// How it is carried out here.
    pub(super) here: &'static str,
    /// What the paper says.
    pub(super) claims: &'static [Claim],
    /// Claims that the paper does not make but that should be true as well.
    pub(super) ours: &'static [Claim],
}

/// Something that must be true of every run.
#[derive(Debug)]
pub(super) struct Claim {
    /// The claim, in words.
    pub(super) says: &'static str,
    /// Where the paper makes it, or what it follows from if it is ours.
    pub(super) source: &'static str,
    /// `None` if it is true of a run, otherwise what was found instead.
    pub(super) differs: fn(&ExperimentRun) -> Option<String>,
}

const STATION: &str = "RechargingStation";
const DESTINATION: &str = "Destination";
/// θ of φ2, in ticks: the paper gives it no value, and its published code has this one.
const THETA_TICKS: u64 = 10;
/// Below this level the robot sets out for the station, in percent.
const LOW_PCT: f64 = 30.0;
/// From this level on, the published code considers the battery full, in percent.
const FULL_PCT: f64 = 99.7;

/// The paper's experiments, and the scenario that they modify.
pub(super) const EXPERIMENTS: [Experiment; 4] = [
    Experiment {
        scenario: "nominal",
        title: "The scenario of Section II, undisturbed",
        here: "Simulated here. The battery starts at 31.5 %, so that its level falls below 30 % on the way.",
        claims: &[
            Claim {
                says: "the robot sets out for the charging station when the level falls below 30 %, and not before",
                source: "Section II",
                differs: breaks_off_below_thirty,
            },
            Claim {
                says: "it reaches the charging station before the destination",
                source: "Section II",
                differs: |run| {
                    let Some(station) = reached(run, STATION) else { return Some("it did not get there".to_owned()) };
                    let before = reached(run, DESTINATION).is_some_and(|destination| destination < station);
                    before.then(|| "it went to the destination first".to_owned())
                },
            },
            Claim {
                says: "it waits there until the battery is full: it leaves only at 99.7 %",
                source: "Section II; 99.7 % is the published code's",
                differs: |run| match run.observed.charges.as_slice() {
                    [charge] if charge.from_pct < LOW_PCT && charge.to_pct >= FULL_PCT => None,
                    [] => Some("it was never fully charged".to_owned()),
                    charges => {
                        let each =
                            charges.iter().map(|charge| format!("{:.2} to {:.2} %", charge.from_pct, charge.to_pct));
                        Some(format!("it was charged from {}", each.collect::<Vec<_>>().join(", ")))
                    }
                },
            },
            Claim {
                says: "then it resumes the navigation task and arrives",
                source: "Section II",
                differs: |run| match (reached(run, STATION), reached(run, DESTINATION)) {
                    (Some(station), Some(destination)) if station < destination => None,
                    _ => Some("it did not arrive".to_owned()),
                },
            },
            Claim {
                says: "the level read is never below 20 %: φ1 holds",
                source: "Section II, Figure 4",
                differs: |run| verdict(run, "phi1", Outcome::Satisfied),
            },
            Claim {
                says: "the safety monitor goes idle → get → idle with each level that is read",
                source: "Figure 5 (a)",
                differs: |run| path(run, |readings| SafetyPath { get: readings, idle: readings, failure: 0 }),
            },
            Claim {
                says: "it starts for the station in time: φ2 holds",
                source: "Section II, Figure 4",
                differs: |run| holds_with_reason(run, "phi2"),
            },
        ],
        ours: &[],
    },
    Experiment {
        scenario: "battery_fault",
        title: "Experiment 1: a runtime monitor for a safety property",
        here: "Simulated in the paper and here. The level is set to 10 % at 20.5 s, on the way to the destination.",
        claims: &[
            Claim {
                says: "the level is set to 10 % and φ1 is violated",
                source: "Experiment 1, Figure 6 (b)",
                differs: |run| verdict(run, "phi1", Outcome::Violated),
            },
            Claim {
                says: "the safety monitor goes idle → get → idle while the level is above 20 %, \
                       and idle → get → failure with the first one below",
                source: "Experiment 1, Figure 6 (c) to (e)",
                differs: |run| {
                    path(run, |_| {
                        let get = run.observed.safety.get;
                        SafetyPath { get, idle: get.saturating_sub(1), failure: 1 }
                    })
                },
            },
            Claim {
                says: "it does so with the first level that is read after the fault",
                source: "Experiment 1",
                differs: |run| {
                    let figure = at_tick_after_fault(run, Figure::Safety.name(), 0);
                    at_tick_after_fault(run, "phi1", 0).or(figure)
                },
            },
            Claim {
                says: "the robot goes to the charging station",
                source: "Figure 6 (b)",
                differs: |run| reached(run, STATION).is_none().then(|| "it did not get there".to_owned()),
            },
        ],
        ours: &[],
    },
    Experiment {
        scenario: "skill_bug",
        title: "Experiment 2: a runtime monitor for a responsive property",
        here: "Simulated in the paper and here. BatteryLevel answers success above 20 %; the level is set to 25 % at \
               20.5 s, on the way to the destination.",
        claims: &[
            Claim {
                says: "BatteryLevel answers success above 20 %, the level falls below 30 % on the way, and φ2 is \
                       violated",
                source: "Experiment 2",
                differs: |run| verdict(run, "phi2", Outcome::Violated),
            },
            Claim {
                says: "φ2 is violated when θ = 10 ticks have passed: time_until … < θ excludes the tick i + θ",
                source: "Figure 4 and Section V-A; θ is the published code's",
                differs: |run| at_tick_after_fault(run, "phi2", THETA_TICKS),
            },
            Claim {
                says: "the response monitor as published goes to Err one tick later, at θ + 1: its timer starts at θ \
                       and must have reached 0 before",
                source: "Figure 5 (b) and Section V-B; θ is the published code's",
                differs: |run| at_tick_after_fault(run, Figure::Response.name(), THETA_TICKS + 1),
            },
            Claim {
                says: "that happens before the robot reaches the charging station",
                source: "Experiment 2",
                differs: |run| reached(run, STATION).map(|at| format!("it was there at {at:.1} s")),
            },
        ],
        ours: &[Claim {
            says: "no level below 20 % is read: φ1 holds",
            source: "follows from the 25 % of the published code's instructions",
            differs: |run| verdict(run, "phi1", Outcome::Satisfied),
        }],
    },
    Experiment {
        scenario: "joypad",
        title: "Experiment 3: a monitor on a real robot (simulated here)",
        here: "On a real robot in the paper, simulated here without a real robot. The battery drains three times as fast as in \
               the other runs; a simulated joypad drives the robot back at 0.4 m/s for 10 s whenever it comes within 3 m of \
               the station.",
        claims: &[
            Claim {
                says: "at 35 %, which is the initial level here, φ1 is not violated",
                source: "Figure 8 (a)",
                differs: |run| {
                    let start_pct = run.report.battery.map_or(0.0, |battery| battery.initial);
                    let violated = violated_at(run, "phi1");
                    (start_pct != 35.0 || violated.is_some_and(|at_s| at_s < 2.0))
                        .then(|| format!("the level is {start_pct:.1} % at the start, and φ1 is violated immediately"))
                },
            },
            Claim {
                says: "when the level falls below 30 %, the robot moves toward the charging station",
                source: "Experiment 3, Figure 7 (a)",
                differs: breaks_off_below_thirty,
            },
            Claim {
                says: "somebody with a joypad drives it away, it resumes, and is driven away again",
                source: "Experiment 3, Figure 7 (b) to (d)",
                differs: |run| {
                    let until_s = violated_at(run, "phi1").unwrap_or(0.0);
                    let joypad =
                        |fault: &&reports::report::FaultReport| fault.kind == "joypad" && fault.time_s < until_s;
                    let times = run.report.faults.iter().filter(joypad).count();
                    (times < 2).then(|| format!("that happened {times} times before φ1 was violated"))
                },
            },
            Claim {
                says: "it is kept from reaching the charging station",
                source: "Experiment 3",
                differs: |run| reached(run, STATION).map(|at| format!("it was there at {at:.1} s")),
            },
            Claim {
                says: "the level falls below 20 % and φ1 is violated, at 19 %",
                source: "Experiment 3, Figure 8 (b)",
                differs: |run| {
                    let level = monitor(run, "phi1").and_then(level_that_decided);
                    let Some(level_pct) = level else { return Some("φ1 is not violated".to_owned()) };
                    (!(19.0..20.0).contains(&level_pct)).then(|| format!("the level read was {level_pct:.2} %"))
                },
            },
        ],
        ours: &[Claim {
            says: "it sets out in time: φ2 holds",
            source: "Figure 4, which the paper does not watch in this experiment",
            differs: |run| holds_with_reason(run, "phi2"),
        }],
    },
];

fn monitor<'r>(run: &'r ExperimentRun, name: &str) -> Option<&'r MonitorReport> {
    run.report.monitors.iter().find(|monitor| monitor.name == name)
}

fn violated_at(run: &ExperimentRun, name: &str) -> Option<f64> {
    monitor(run, name)?.time_s
}

fn verdict(run: &ExperimentRun, name: &str, wanted: Outcome) -> Option<String> {
    let found = monitor(run, name).map(|monitor| monitor.verdict);
    let words = found.map_or("not watched", Outcome::name);
    (found != Some(wanted)).then(|| format!("{name} is {words}"))
}

/// Checks that a property holds, and not vacuously.
fn holds_with_reason(run: &ExperimentRun, name: &str) -> Option<String> {
    let vacuous = monitor(run, name).and_then(|monitor| monitor.vacuous.first().cloned());
    verdict(run, name, Outcome::Satisfied).or(vacuous)
}

/// Checks that the robot sets out for the station at the first level of at most 30 %.
fn breaks_off_below_thirty(run: &ExperimentRun) -> Option<String> {
    let Some(departure) = run.observed.first_departure_for(STATION) else {
        return Some("it never set out for the station".to_owned());
    };
    match (departure.level_before_pct, departure.level_pct) {
        (Some(before_pct), Some(level_pct)) if before_pct > LOW_PCT && level_pct <= LOW_PCT => None,
        (before_pct, level_pct) => {
            let words = |level_pct: Option<f64>| level_pct.map_or("nothing".to_owned(), |pct| format!("{pct:.2} %"));
            Some(format!("it set out when it had read {} and then {}", words(before_pct), words(level_pct)))
        }
    }
}

/// Checks that the safety monitor took the wanted path, given how many levels were read.
fn path(run: &ExperimentRun, wanted: impl Fn(u64) -> SafetyPath) -> Option<String> {
    let (found, wanted) = (run.observed.safety, wanted(run.observed.readings));
    (found != wanted || found.get == 0).then(|| {
        format!("it entered get {} times, idle {} times, failure {} times", found.get, found.idle, found.failure)
    })
}

/// Checks that a property is violated this many ticks after the first level that is read once the battery's level has
/// been set. Ticks come once a second, the first just after the start.
fn at_tick_after_fault(run: &ExperimentRun, name: &str, ticks: u64) -> Option<String> {
    let Some(fault) = run.report.faults.iter().find(|fault| fault.kind == "battery_level") else {
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
    monitor.witness.as_ref()?.communication.as_ref()?.message.fields().get(1)?.as_number()
}

fn reached(run: &ExperimentRun, place: &str) -> Option<f64> {
    run.report.places.iter().find(|visit| visit.name == place)?.reached_at_s
}
