//! What a proof assumes, in words.

use channels::{ChannelSystem, EventKind, FieldKind, Value};
use components::{BATTERY_READER, BatteryReader, LOCALIZATION, Localization, NAVIGATION, Navigation};
use diagnostics::counted;
use explorer::{Path, PathStep, Replay};
use recording::decimals;
use runs::Switched;
use scenarios::scenario::schedule::process_of;
use scenarios::scenario::{
    BatteryAssumption, ComponentEntry, Conduct, Drained, MessageAssumption, Passes, Premises, ProveEntry, RunsEntry,
    Scenario, StandIn, TripAssumption,
};

use super::environment::{Changed, WorldState};
use super::faults::{self, without_faults};

/// Something that a proof assumes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Assumption {
    /// In words: a sentence.
    pub words: String,
    about: About,
}

#[derive(Clone, Debug, PartialEq, Eq)]
enum About {
    Battery,
    Trips,
    Messages,
    Faults,
    /// What is given for all runs.
    Always,
    /// The conduct of this component.
    Component(String),
}

impl Assumption {
    fn new(about: About, words: String) -> Self {
        Self { words, about }
    }
}

/// The assumptions of a proof of the scenario's properties.
pub(super) fn all(scenario: &Scenario, system: &ChannelSystem, faults: &[Switched]) -> Vec<Assumption> {
    let ProveEntry { battery, trips, messages, drivers_anywhere, components, faults: allowed, .. } =
        &scenario.file.prove;
    let mut all = Vec::new();
    let mut add = |about: About, words: String| all.push(Assumption::new(about, words));
    if let (Some(premises), Some(_)) = (&scenario.premises, process_of::<BatteryReader>(system, BATTERY_READER)) {
        self::battery(battery, premises).into_iter().for_each(|words| add(About::Battery, words));
    }
    if process_of::<Navigation>(system, NAVIGATION).is_some() {
        add(About::Trips, self::trips(trips));
    } else if process_of::<Localization>(system, LOCALIZATION).is_some() {
        add(About::Trips, "The robot may be anywhere at any time.".to_owned());
    }
    if let Some(words) = self::messages(messages) {
        add(About::Messages, words);
    }
    if !faults.is_empty() {
        let count = counted(allowed.count, "fault");
        add(About::Faults, format!("At any time, {count} may begin, and end again: {}.", faults::in_words(faults)));
    }
    if scenario.premises.is_some() {
        let when = if *drivers_anywhere { "at any time" } else { "between steps" };
        add(About::Always, format!("Drivers exchange data with their components {when}."));
    }
    for StandIn { component, conduct } in components {
        if let Conduct::Machine(machine) = conduct {
            let words = format!("{} behaves as {} allows.", component.value, machine.value.display());
            add(About::Component(component.value.clone()), words);
        }
    }
    for ComponentEntry { name, runs, .. } in &scenario.file.components {
        if let RunsEntry::Anything { .. } = runs {
            let interface = &scenario.components[&name.value].interface;
            let has = [!interface.services.is_empty(), !interface.topics.is_empty(), !interface.actions.is_empty()];
            let words = anything(&name.value, has);
            add(About::Component(name.value.clone()), words);
            for ((_, field), values) in scenario.samples.tried.iter().filter(|((of, _), _)| *of == name.value) {
                let others = scenario.samples.others.get(&(name.value.clone(), field.clone())).copied();
                add(About::Always, tried(&name.value, field, values, others));
            }
        }
    }
    match scenario.file.faults.len() {
        0 => {}
        1 => add(About::Always, "The scenario's fault does not occur.".to_owned()),
        faults => add(About::Always, format!("The scenario's {faults} faults do not occur.")),
    }
    all
}

/// That the true level and place are those that the components receive.
pub(super) fn received() -> Assumption {
    let words = "The true level and place of the robot are those that the components receive.".to_owned();
    Assumption::new(About::Always, words)
}

/// That some properties are not proved, with the reasons; `None` if there are none.
pub(super) fn left_out(properties: &[(String, String)]) -> Option<Assumption> {
    let each: Vec<String> = properties.iter().map(|(name, why)| format!("{name} ({why})")).collect();
    (!each.is_empty()).then(|| Assumption::new(About::Always, format!("Not proved: {}.", each.join(", "))))
}

/// The assumptions of which a run makes use: what they allow happens in it.
pub(super) fn used(all: &[Assumption], run: &Path, replay: &Replay, faults: &[Switched]) -> Vec<Assumption> {
    let moves = run.steps().iter().filter_map(|step| match step {
        PathStep::Environment { state, .. } => without_faults(state).get::<WorldState>(),
        _ => None,
    });
    // What the drivers report first is the start.
    let moves: Vec<Changed> = moves.skip(1).map(|state| state.changed).collect();
    let topology = replay.system.topology();
    let sends = |name: &str| {
        let is_from = |channel| topology.ends(channel).0 == name;
        replay
            .events
            .iter()
            .any(|(_, event)| matches!(event.kind, EventKind::Received { channel, .. } if is_from(channel)))
    };
    let is_used = |assumption: &&Assumption| match &assumption.about {
        About::Battery => moves.iter().any(|changed| changed.battery),
        About::Trips => moves.iter().any(|changed| changed.trip),
        About::Messages => !replay.damaged.is_empty(),
        About::Faults => faults::changes(run, faults).iter().any(Option::is_some),
        About::Component(name) => sends(name),
        About::Always => false,
    };
    all.iter().filter(is_used).cloned().collect()
}

/// What a component that answers anything may do, if it has services, topics and actions.
fn anything(name: &str, [services, topics, actions]: [bool; 3]) -> String {
    let answers = services.then_some("answers every request at once, with anything");
    let publishes = topics.then_some("publishes anything or nothing once per tick, just before the next one");
    let pursues =
        "does anything with one goal of each action at a time, just before a tick, and ends it when it is canceled";
    let conduct: Vec<&str> = [answers, publishes, actions.then_some(pursues)].into_iter().flatten().collect();
    let conduct = if conduct.is_empty() { "does nothing".to_owned() } else { conduct.join(", ") };
    format!("{name} {conduct}.")
}

/// Which values of a field are tried. Of texts, the last `others` stand for all that nothing mentions.
fn tried(name: &str, field: &str, values: &[Value], others: Option<usize>) -> String {
    let is_missing = values.iter().any(|value| value.is_symbol(FieldKind::NONE));
    let values: Vec<&Value> = values.iter().filter(|value| !value.is_symbol(FieldKind::NONE)).collect();
    let known = values.len() - others.unwrap_or_default();
    let mut list: Vec<String> = values[..known].iter().map(|value| value.to_string()).collect();
    list.extend(others.map(|others| match others {
        1 => "another text".to_owned(),
        others => format!("one of {others} other texts"),
    }));
    list.extend(is_missing.then(|| "missing".to_owned()));
    let last = list.pop().unwrap_or_default();
    let list = if list.is_empty() { last } else { format!("{} or {last}", list.join(", ")) };
    format!("{name}'s `{field}` is {list}: no more values are distinguished.")
}

fn percent(number: f64) -> String {
    format!("{} %", decimals(number, 6))
}

fn battery(battery: &BatteryAssumption, premises: &Premises) -> Vec<String> {
    let has_station = premises.station.is_some();
    let BatteryAssumption::Drained(Drained { drain_pct, charge_pct, start_pct, .. }) = battery else {
        let level = "The battery's level may jump to any value at any time.".to_owned();
        let charging = has_station.then(|| "At the charging station, it may or may not be charged.".to_owned());
        return [Some(level), charging].into_iter().flatten().collect();
    };
    let sim = &premises.entry.sim.battery;
    let start = match start_pct {
        Some(start) if start.start() < start.end() => {
            format!("with {} to {}", decimals(*start.start(), 6), percent(*start.end()))
        }
        Some(start) => format!("with {}", percent(*start.start())),
        None => format!("with {}", percent(sim.initial_pct)),
    };
    let drain = format!("The battery starts {start} and loses at most {} per tick.", percent(*drain_pct));
    let charging = has_station.then(|| {
        let gain = match *charge_pct {
            0.0 => String::new(),
            gain => format!(" and gains at least {} per tick", percent(gain)),
        };
        let full = percent(sim.recharge_below_pct);
        format!("At the charging station, unless the robot sets out, it is charged to {full} or more{gain}.")
    });
    [Some(drain), charging].into_iter().flatten().collect()
}

fn trips(TripAssumption { ticks, fail, passes }: &TripAssumption) -> String {
    let time = match ticks {
        None => "take any time".to_owned(),
        Some(1) => "end before the next tick".to_owned(),
        Some(ticks) => format!("take at most {ticks} ticks"),
    };
    let end = if *fail { "may fail" } else { "never fail" };
    let passes = match passes {
        Passes::Any => ", and may pass any place".to_owned(),
        Passes::These(names) if names.is_empty() => ", and pass no other place".to_owned(),
        Passes::These(names) => {
            let names: Vec<&str> = names.iter().map(|name| name.value.as_str()).collect();
            format!(", and may pass {}", names.join(", "))
        }
    };
    format!("Trips {time}, {end}{passes}.")
}

fn messages(MessageAssumption { lose, repeat, delay, hold, on }: &MessageAssumption) -> Option<String> {
    let hold = format!("delayed by {} s", decimals(hold.as_secs_f64(), 6));
    let damages = [(*lose, "lost"), (*repeat, "delivered twice"), (*delay, hold.as_str())];
    let damages: Vec<String> =
        damages.iter().filter(|(count, _)| *count > 0).map(|(count, what)| format!("{count} may be {what}")).collect();
    if damages.is_empty() {
        return None;
    }
    let on: Vec<String> = on.iter().map(|[from, to]| format!("{} → {}", from.value, to.value)).collect();
    let on = if on.is_empty() { String::new() } else { format!(" on {}", on.join(", ")) };
    Some(format!("Of all messages{on}, {}.", damages.join(", ")))
}
