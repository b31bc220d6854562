//! Faults of the channels and of the ticks.

use crate::faults::effect::{Damage, Effect, TickTrouble, Which};
use crate::faults::kind::{FaultKind, Subsystem};
use crate::faults::{ArgumentDomain, Arguments, Parameter};
use diagnostics::document::Referent;

const FROM: Parameter = Parameter::required("from", "the sender", ArgumentDomain::Name(Referent::Process));
const TO: Parameter = Parameter::required("to", "the receiver", ArgumentDomain::Name(Referent::Process));
const CONDITION: Parameter =
    Parameter::text("condition", "the affected messages: a condition in the SCOPE language", "true");
const SHARE: Parameter = Parameter::number("share", "the share of these messages that is affected", 0.0, 1.0, 1.0);

fn damage(with: &Arguments, damage: Damage) -> Effect {
    Effect::Channels {
        channels: Which::Between(with.name("from"), with.name("to")),
        condition: with.name("condition"),
        damage,
        probability: with.number("share"),
    }
}

/// The messages that a fault affects, as the subject of a sentence.
fn messages(with: &Arguments) -> String {
    let (from, to) = (with.text("from"), with.text("to"));
    let share = match with.number("share") {
        1.0 => String::new(),
        share => format!("{} % of the ", 100.0 * share),
    };
    let condition = match with.text("condition") {
        "true" => String::new(),
        condition => format!(" with {condition}"),
    };
    format!("{share}messages from {from} to {to}{condition}")
}

pub(super) const LOST: FaultKind = FaultKind {
    name: "message_lost",
    subsystem: Subsystem::Channels,
    about: "messages on a channel are lost",
    parameters: &[FROM, TO, CONDITION, SHARE],
    example: "at_s = 10\nfrom = \"BatteryReader\"\nto = \"BatteryLevel\"\nlasts_s = 5",
    effect: |with| damage(with, Damage::Loss),
    words: |with| format!("{} are lost", messages(with)),
};

pub(super) const DELAYED: FaultKind = FaultKind {
    name: "message_delayed",
    subsystem: Subsystem::Channels,
    about: "messages on a channel arrive late",
    parameters: &[
        FROM,
        TO,
        CONDITION,
        SHARE,
        Parameter::required("delay_s", "the delay, in seconds", ArgumentDomain::Numbers(0.0, 1e3)),
    ],
    example: "at_s = 10\nfrom = \"BatteryReader\"\nto = \"BatteryLevel\"\ndelay_s = 0.3",
    effect: |with| damage(with, Damage::Delay(with.seconds("delay_s"))),
    words: |with| format!("{} come {} s late", messages(with), with.number("delay_s")),
};

pub(super) const DUPLICATED: FaultKind = FaultKind {
    name: "message_duplicated",
    subsystem: Subsystem::Channels,
    about: "messages on a channel arrive twice",
    parameters: &[FROM, TO, CONDITION, SHARE],
    example: "at_s = 10\nfrom = \"GoToDestination\"\nto = \"Navigation\"",
    effect: |with| damage(with, Damage::Duplicate),
    words: |with| format!("{} come twice", messages(with)),
};

pub(super) const CORRUPTED: FaultKind = FaultKind {
    name: "message_corrupted",
    subsystem: Subsystem::Channels,
    about: "a field of the messages on a channel has another value",
    parameters: &[
        FROM,
        TO,
        CONDITION,
        SHARE,
        Parameter::whole("field", "the number of the field, counted from 1", 1, 100, 2),
        Parameter::required("value", "its new value in the SCOPE language: 15, true, <failure>", ArgumentDomain::Text),
    ],
    example: "at_s = 10\nfrom = \"BatteryReader\"\nto = \"BatteryLevel\"\nvalue = \"15\"",
    effect: |with| damage(with, Damage::Corruption(with.name("value"), with.whole("field"))),
    words: |with| format!("m[{}] of {} is {}", with.whole("field"), messages(with), with.text("value")),
};

pub(super) const TICK_MISSED: FaultKind = FaultKind {
    name: "tick_missed",
    subsystem: Subsystem::Channels,
    about: "ticks are not generated",
    parameters: &[Parameter::number("share", "the share of missing ticks", 0.0, 1.0, 1.0)],
    example: "at_s = 10\nlasts_s = 5",
    effect: |with| Effect::Ticks(TickTrouble::Missed(with.number("share"))),
    words: |with| format!("{} % of the ticks are missing", 100.0 * with.number("share")),
};

pub(super) const TICK_LATE: FaultKind = FaultKind {
    name: "tick_late",
    subsystem: Subsystem::Channels,
    about: "ticks come late",
    parameters: &[Parameter::required("delay_s", "the delay, in seconds", ArgumentDomain::Numbers(0.0, 60.0))],
    example: "at_s = 10\ndelay_s = 0.4",
    effect: |with| Effect::Ticks(TickTrouble::Late(with.seconds("delay_s"))),
    words: |with| format!("ticks come {} s late", with.number("delay_s")),
};

pub(super) const TICK_JITTER: FaultKind = FaultKind {
    name: "tick_jitter",
    subsystem: Subsystem::Channels,
    about: "ticks come late by a varying delay",
    parameters: &[Parameter::required(
        "sigma_s",
        "standard deviation of the delay, in seconds",
        ArgumentDomain::Numbers(0.0, 60.0),
    )],
    example: "at_s = 0\nsigma_s = 0.2",
    effect: |with| Effect::Ticks(TickTrouble::Jitter(with.seconds("sigma_s"))),
    words: |with| format!("ticks jitter, σ = {} s", with.number("sigma_s")),
};
