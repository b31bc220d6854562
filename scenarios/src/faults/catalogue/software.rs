//! Faults of localization, navigation and the other components.

use diagnostics::Spanned;
use diagnostics::document::Referent;

use crate::faults::effect::{Damage, Effect, Which};
use crate::faults::kind::{FaultKind, Subsystem};
use crate::faults::{ArgumentDefault, ArgumentDomain, Arguments, Parameter};
use crate::files::named;

const COMPONENT: Parameter =
    Parameter::required("component", "which component", ArgumentDomain::Name(Referent::Component));

fn component(with: &Arguments) -> Spanned<String> {
    with.name("component")
}

/// Affects every message, without a probability.
fn every_message(with: &Arguments, channels: Which, damage: Damage) -> Effect {
    let condition = Spanned { value: "true".to_owned(), span: with.span().clone() };
    Effect::Channels { channels, condition, damage, probability: 1.0 }
}

pub(super) const KIDNAP: FaultKind = FaultKind {
    name: "kidnap",
    subsystem: Subsystem::Software,
    about: "the robot is lifted and put down elsewhere; odometry does not register it",
    parameters: &[Parameter::required("to", "its new pose", ArgumentDomain::Pose)],
    example: "at_s = 10\nto = [3.0, 4.0, 90]",
    effect: |with| Effect::Kidnap(with.spanned_pose("to")),
    words: |with| {
        let to = with.pose("to").translation;
        format!("the robot is lifted and put down at ({:.2}, {:.2}) m", to.x, to.y)
    },
};

pub(super) const WRONG_POSE: FaultKind = FaultKind {
    name: "wrong_initial_pose",
    subsystem: Subsystem::Software,
    about: "localization is given a wrong pose",
    parameters: &[Parameter::required("to", "the pose that it is given", ArgumentDomain::Pose)],
    example: "at_s = 0\nto = [3.0, 4.0, 90]",
    effect: |with| Effect::Belief(with.pose("to")),
    words: |with| {
        let to = with.pose("to").translation;
        format!("localization is given the pose ({:.2}, {:.2}) m", to.x, to.y)
    },
};

pub(super) const GOAL: FaultKind = FaultKind {
    name: "operator_goal",
    subsystem: Subsystem::Software,
    about: "another client sends Navigation a goal: it replaces the current trip, which fails",
    parameters: &[Parameter::required("to", "the pose to drive to", ArgumentDomain::Pose)],
    example: "at_s = 10\nto = [3.0, 4.0, 90]",
    effect: |with| Effect::Goal(with.spanned_pose("to")),
    words: |with| {
        let to = with.pose("to").translation;
        format!("another client sends Navigation to ({:.2}, {:.2}) m", to.x, to.y)
    },
};

pub(in crate::faults) const WRONG_MAP: FaultKind = FaultKind {
    name: "wrong_map",
    subsystem: Subsystem::Software,
    about: "the software's map differs from the world; possible only from the start of the run",
    parameters: &[Parameter::required(
        "map",
        "the map's YAML file",
        ArgumentDomain::Name(Referent::File(&["yaml", "yml"])),
    )],
    example: "at_s = 0\nmap = \"maps/house_moved.yaml\"",
    effect: |with| {
        let Spanned { value, span } = with.name("map");
        Effect::Map(Spanned { value: named(value, &span), span })
    },
    words: |with| format!("the software's map is {}", with.text("map")),
};

pub(super) const ZONE_IGNORED: FaultKind = FaultKind {
    name: "zone_ignored",
    subsystem: Subsystem::Software,
    about: "navigation drives as if a zone of the places file did not exist",
    parameters: &[Parameter {
        name: "zone",
        about: "which zone; all of them if not given",
        domain: ArgumentDomain::Name(Referent::Zone),
        default: ArgumentDefault::Absent,
    }],
    example: "at_s = 10",
    effect: |with| Effect::Zones(with.has("zone").then(|| with.name("zone"))),
    words: |with| match with.has("zone") {
        true => format!("navigation ignores the zone {}", with.text("zone")),
        false => "navigation ignores all zones".to_owned(),
    },
};

pub(super) const FROZEN: FaultKind = FaultKind {
    name: "component_frozen",
    subsystem: Subsystem::Software,
    about: "a component hangs: it answers nothing and does nothing, and continues when the fault ends",
    parameters: &[COMPONENT],
    example: "at_s = 10\ncomponent = \"Navigation\"\nlasts_s = 10",
    effect: |with| Effect::Outage { component: component(with), crashed: false },
    words: |with| format!("{} hangs", with.text("component")),
};

pub(super) const CRASH: FaultKind = FaultKind {
    name: "component_crash",
    subsystem: Subsystem::Software,
    about: "a component crashes; when the fault ends, it restarts and has forgotten everything",
    parameters: &[COMPONENT],
    example: "at_s = 10\ncomponent = \"Navigation\"\nlasts_s = 5",
    effect: |with| Effect::Outage { component: component(with), crashed: true },
    words: |with| format!("{} crashes", with.text("component")),
};

pub(super) const SLOW: FaultKind = FaultKind {
    name: "component_slow",
    subsystem: Subsystem::Software,
    about: "a component's answers come late",
    parameters: &[COMPONENT, Parameter::number("delay_s", "the delay, in seconds", 0.0, 1e3, 1.0)],
    example: "at_s = 10\ncomponent = \"BatteryReader\"\ndelay_s = 0.3",
    effect: |with| every_message(with, Which::From(component(with)), Damage::Delay(with.seconds("delay_s"))),
    words: |with| format!("{} answers {} s late", with.text("component"), with.number("delay_s")),
};

pub(super) const WRONG_REPLY: FaultKind = FaultKind {
    name: "component_wrong_reply",
    subsystem: Subsystem::Software,
    about: "a component reports the opposite: true for false, 100 − level for a level, failure for running and success",
    parameters: &[COMPONENT],
    example: "at_s = 10\ncomponent = \"Localization\"\nlasts_s = 5",
    effect: |with| every_message(with, Which::From(component(with)), Damage::Opposite),
    words: |with| format!("{} reports the opposite of the truth", with.text("component")),
};

pub(super) const NO_REPLY: FaultKind = FaultKind {
    name: "component_no_reply",
    subsystem: Subsystem::Software,
    about: "a component never receives its requests",
    parameters: &[COMPONENT],
    example: "at_s = 10\ncomponent = \"BatteryReader\"\nlasts_s = 5",
    effect: |with| every_message(with, Which::To(component(with)), Damage::Loss),
    words: |with| format!("{} does not receive its requests", with.text("component")),
};
