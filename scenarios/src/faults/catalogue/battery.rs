//! Faults of the battery, its sensor and the charging station.

use crate::faults::kind::{FaultKind, Subsystem};
use crate::faults::{ArgumentDomain, Effect, Parameter};

const PERCENT: ArgumentDomain = ArgumentDomain::Numbers(0.0, 100.0);

pub(super) const LEVEL: FaultKind = FaultKind {
    name: "battery_level",
    subsystem: Subsystem::Battery,
    about: "the battery's charge is set to a level",
    parameters: &[Parameter::required("level_pct", "the charge, in percent", PERCENT)],
    example: "at_s = 20.5\nlevel_pct = 10",
    effect: |with| Effect::Charge(with.number("level_pct")),
    words: |with| format!("battery level set to {} %", with.number("level_pct")),
};

pub(super) const DRAIN: FaultKind = FaultKind {
    name: "battery_drain",
    subsystem: Subsystem::Battery,
    about: "the battery drains faster",
    parameters: &[Parameter::required("factor", "how much faster", ArgumentDomain::Numbers(0.0, 1e6))],
    example: "at_s = 10\nfactor = 5\nlasts_s = 60",
    effect: |with| {
        let factor = with.number("factor");
        Effect::world(move |faults| faults.battery.drain_factor *= factor)
    },
    words: |with| format!("the battery drains {} times as fast", with.number("factor")),
};

pub(super) const FADE: FaultKind = FaultKind {
    name: "battery_fade",
    subsystem: Subsystem::Battery,
    about: "the battery has aged: it holds only a share of its charge, and drains and charges faster in proportion",
    parameters: &[Parameter::required("capacity", "the share that remains", ArgumentDomain::Numbers(0.01, 1.0))],
    example: "at_s = 0\ncapacity = 0.5",
    effect: |with| {
        let capacity = with.number("capacity");
        Effect::world(move |faults| faults.battery.capacity_factor *= capacity)
    },
    words: |with| format!("the battery holds only {} % of its charge", 100.0 * with.number("capacity")),
};

pub(super) const SENSOR_STUCK: FaultKind = FaultKind {
    name: "battery_sensor_stuck",
    subsystem: Subsystem::Battery,
    about: "the battery's sensor keeps reporting its last reading",
    parameters: &[],
    example: "at_s = 10",
    effect: |_| Effect::world(|faults| faults.battery.reported.stuck = true),
    words: |_| "the battery's sensor is stuck".to_owned(),
};

pub(super) const SENSOR_OFFSET: FaultKind = FaultKind {
    name: "battery_sensor_offset",
    subsystem: Subsystem::Battery,
    about: "the battery's sensor reads too much or too little",
    parameters: &[Parameter::required(
        "offset_pct",
        "the error that it adds, in percent",
        ArgumentDomain::Numbers(-100.0, 100.0),
    )],
    example: "at_s = 0\noffset_pct = 15",
    effect: |with| {
        let offset = with.number("offset_pct");
        Effect::world(move |faults| faults.battery.reported.offset_pct += offset)
    },
    words: |with| format!("the battery's sensor reads {:+} %", with.number("offset_pct")),
};

pub(super) const SENSOR_NOISE: FaultKind = FaultKind {
    name: "battery_sensor_noise",
    subsystem: Subsystem::Battery,
    about: "the battery's sensor is noisy",
    parameters: &[Parameter::required("sigma_pct", "standard deviation of a reading, in percent", PERCENT)],
    example: "at_s = 0\nsigma_pct = 3",
    effect: |with| {
        let sigma = with.number("sigma_pct");
        Effect::world(move |faults| faults.battery.reported.sigma_pct = sigma)
    },
    words: |with| format!("the battery's sensor is noisy, σ = {} %", with.number("sigma_pct")),
};

pub(super) const SENSOR_DROPOUT: FaultKind = FaultKind {
    name: "battery_sensor_dropout",
    subsystem: Subsystem::Battery,
    about: "the battery's sensor gives no readings; BatteryReader keeps reporting the last one",
    parameters: &[],
    example: "at_s = 10\nlasts_s = 60",
    effect: |_| Effect::world(|faults| faults.battery.reported.missing = true),
    words: |_| "the battery's sensor gives no readings".to_owned(),
};

pub(super) const CHARGING_STATUS: FaultKind = FaultKind {
    name: "charging_status_wrong",
    subsystem: Subsystem::Battery,
    about: "the battery reports that it is charging, or that it is not, regardless of the truth",
    parameters: &[Parameter::flag("charging", "the reported state")],
    example: "at_s = 10\ncharging = false",
    effect: |with| {
        let charging = with.flag("charging");
        Effect::world(move |faults| faults.battery.reported.charging = Some(charging))
    },
    words: |with| match with.flag("charging") {
        true => "the battery reports that it is charging".to_owned(),
        false => "the battery reports that it is not charging".to_owned(),
    },
};

pub(super) const STATION_DEAD: FaultKind = FaultKind {
    name: "station_dead",
    subsystem: Subsystem::Battery,
    about: "the charging station supplies no current",
    parameters: &[],
    example: "at_s = 0",
    effect: |_| Effect::world(|faults| faults.battery.charger_factor = 0.0),
    words: |_| "the charging station is dead".to_owned(),
};

pub(super) const STATION_SLOW: FaultKind = FaultKind {
    name: "station_slow",
    subsystem: Subsystem::Battery,
    about: "the charging station charges slowly",
    parameters: &[Parameter::number("factor", "the share of its current that remains", 0.0, 1.0, 0.2)],
    example: "at_s = 0\nfactor = 0.2",
    effect: |with| {
        let factor = with.number("factor");
        Effect::world(move |faults| faults.battery.charger_factor *= factor)
    },
    words: |with| format!("the charging station supplies {} % of its current", 100.0 * with.number("factor")),
};
