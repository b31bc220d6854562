//! What a proof assumes, in words.

use channels::ChannelSystem;
use components::{BATTERY_READER, BatteryReader, NAVIGATION, Navigation};
use recording::decimals;
use runs::Switched;
use scenarios::scenario::schedule::process_of;
use scenarios::scenario::{
    BatteryAssumption, Drained, MessageAssumption, Passes, Premises, ProveEntry, Scenario, TripAssumption,
};

use super::faults;

/// The assumptions of a proof of the scenario's properties, one sentence each.
pub(super) fn in_words(scenario: &Scenario, system: &ChannelSystem, faults: &[Switched]) -> Vec<String> {
    let ProveEntry { battery, trips, messages, drivers_anywhere, components, faults: allowed, .. } =
        &scenario.file.prove;
    let mut words = Vec::new();
    if let (Some(premises), Some(_)) = (&scenario.premises, process_of::<BatteryReader>(system, BATTERY_READER)) {
        words.extend(self::battery(battery, premises));
    }
    if process_of::<Navigation>(system, NAVIGATION).is_some() {
        words.push(self::trips(trips));
    }
    words.extend(self::messages(messages));
    if !faults.is_empty() {
        let may = match allowed.count {
            1 => "1 fault may begin, and end again".to_owned(),
            count => format!("{count} faults may begin, and end again"),
        };
        words.push(format!("At any time, {may}: {}.", faults::in_words(faults)));
    }
    if scenario.premises.is_some() {
        words.push(match drivers_anywhere {
            true => "Drivers exchange data with their components at any time.".to_owned(),
            false => "Drivers exchange data with their components between steps.".to_owned(),
        });
    }
    for stand_in in components {
        words.push(format!("{} behaves as {} allows.", stand_in.component.value, stand_in.machine.value.display()));
    }
    match scenario.file.faults.len() {
        0 => {}
        1 => words.push("The scenario's fault does not occur.".to_owned()),
        faults => words.push(format!("The scenario's {faults} faults do not occur.")),
    }
    words
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
