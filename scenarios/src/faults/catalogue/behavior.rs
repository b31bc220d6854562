//! Faults of skills and tree.

use diagnostics::Spanned;
use diagnostics::document::Referent;
use skills::{Mutation, TransitionPlace};

use crate::faults::effect::{Damage, Effect, MachineChange, Which};
use crate::faults::kind::{FaultKind, Subsystem};
use crate::faults::{ArgumentDomain, Arguments, Parameter};
use crate::files::named;

const SKILL: Parameter = Parameter::required("skill", "the skill", ArgumentDomain::Name(Referent::Leaf));
const LEAF: Parameter = Parameter::required("leaf", "the leaf's skill", ArgumentDomain::Name(Referent::Leaf));
const STATE: Parameter = Parameter::required("state", "the state that the transition leaves", ArgumentDomain::Text);
const EVENT: Parameter =
    Parameter::text("event", "the transition's event; empty for a transition without an event", "");
const NTH: Parameter =
    Parameter::whole("nth", "the number among the transitions with that event, counted from 1", 1, 1000, 1);

fn mutated(with: &Arguments, mutation: Mutation) -> Effect {
    Effect::Machine { skill: with.name("skill"), change: MachineChange::Mutated(mutation) }
}

fn transition(with: &Arguments) -> TransitionPlace {
    TransitionPlace {
        state: with.text("state").to_owned(),
        event: with.text("event").to_owned(),
        nth: with.whole("nth"),
    }
}

/// The transition that a fault changes, in words.
fn transition_words(with: &Arguments) -> String {
    let event = match with.text("event") {
        "" => "the transition without an event".to_owned(),
        event => format!("the transition on {event}"),
    };
    let nth = match with.whole("nth") {
        1 => String::new(),
        nth => format!(", number {nth},"),
    };
    format!("{event}{nth} from {} of {}", with.text("state"), with.text("skill"))
}

/// The effect on messages between tree and leaf.
fn damaged(with: &Arguments, from: &str, to: &str, condition: &str, damage: Damage) -> Effect {
    let spanned = |text: &str| Spanned { value: text.to_owned(), span: with.name("leaf").span };
    let channels = Which::Between(spanned(from), spanned(to));
    Effect::Channels { channels, condition: spanned(condition), damage, probability: 1.0 }
}

pub(super) const MACHINE_REPLACED: FaultKind = FaultKind {
    name: "skill_replaced",
    subsystem: Subsystem::Behavior,
    about: "a skill runs another machine",
    parameters: &[
        SKILL,
        Parameter::required("machine", "its SCXML file", ArgumentDomain::Name(Referent::File(&["scxml"]))),
    ],
    example: "at_s = 0\nskill = \"AtDestination\"\nmachine = \"skills/AtRechargingStation.scxml\"",
    effect: |with| {
        let Spanned { value, span } = with.name("machine");
        let change = MachineChange::Replaced(Spanned { value: named(value, &span), span });
        Effect::Machine { skill: with.name("skill"), change }
    },
    words: |with| format!("{} runs the machine {}", with.text("skill"), with.text("machine")),
};

pub(super) const DATA_CHANGED: FaultKind = FaultKind {
    name: "skill_threshold",
    subsystem: Subsystem::Behavior,
    about: "a skill's machine has a wrong constant: a threshold has moved",
    parameters: &[
        SKILL,
        Parameter::text("data", "the id of the `<data>` element", "threshold"),
        Parameter::required("value", "its new expression", ArgumentDomain::Text),
    ],
    example: "at_s = 0\nskill = \"BatteryLevel\"\nvalue = \"20\"",
    effect: |with| {
        let (id, expr) = (with.text("data").to_owned(), with.text("value").to_owned());
        mutated(with, Mutation::Data { id, expr })
    },
    words: |with| format!("the machine {} has {} = {}", with.text("skill"), with.text("data"), with.text("value")),
};

pub(super) const GUARD_NEGATED: FaultKind = FaultKind {
    name: "skill_guard_negated",
    subsystem: Subsystem::Behavior,
    about: "a transition of a skill's machine has its condition negated",
    parameters: &[SKILL, STATE, EVENT, NTH],
    example: "at_s = 0\nskill = \"BatteryLevel\"\nstate = \"get\"\nevent = \"BatteryReader.ok\"",
    effect: |with| mutated(with, Mutation::NegateGuard { transition: transition(with) }),
    words: |with| format!("the guard of {} is negated", transition_words(with)),
};

pub(super) const TARGET_SWAPPED: FaultKind = FaultKind {
    name: "skill_target_swapped",
    subsystem: Subsystem::Behavior,
    about: "a transition of a skill's machine leads to another state",
    parameters: &[SKILL, STATE, EVENT, NTH, Parameter::required("target", "its new target", ArgumentDomain::Text)],
    example: "at_s = 0\nskill = \"BatteryLevel\"\nstate = \"get\"\nevent = \"BatteryReader.ok\"\nnth = 2\ntarget = \"success\"",
    effect: |with| {
        let target = with.text("target").to_owned();
        mutated(with, Mutation::SwapTarget { transition: transition(with), target })
    },
    words: |with| format!("{} leads to {}", transition_words(with), with.text("target")),
};

pub(super) const TRANSITION_DROPPED: FaultKind = FaultKind {
    name: "skill_transition_dropped",
    subsystem: Subsystem::Behavior,
    about: "a transition of a skill's machine is missing",
    parameters: &[SKILL, STATE, EVENT, NTH],
    example: "at_s = 0\nskill = \"GoToDestination\"\nstate = \"trip\"\nevent = \"BT.halt\"",
    effect: |with| mutated(with, Mutation::DropTransition { transition: transition(with) }),
    words: |with| format!("{} is missing", transition_words(with)),
};

pub(super) const STATE_STUCK: FaultKind = FaultKind {
    name: "skill_state_stuck",
    subsystem: Subsystem::Behavior,
    about: "a skill's machine gets stuck in a state: no transition leaves it",
    parameters: &[SKILL, Parameter::required("state", "the state", ArgumentDomain::Text)],
    example: "at_s = 0\nskill = \"BatteryLevel\"\nstate = \"get\"",
    effect: |with| mutated(with, Mutation::StuckState { state: with.text("state").to_owned() }),
    words: |with| format!("nothing leaves the state {} of {}", with.text("state"), with.text("skill")),
};

pub(super) const MUTATED: FaultKind = FaultKind {
    name: "skill_mutant",
    subsystem: Subsystem::Behavior,
    about: "a skill's machine has one of the mistakes that `steward skill mutants` lists",
    parameters: &[Parameter::required(
        "mutant",
        "the skill and the mistake, as listed",
        ArgumentDomain::Name(Referent::Mutant),
    )],
    example: "at_s = 0\nmutant = \"BatteryLevel: no transition leaves `get`\"",
    effect: |with| {
        let Spanned { value, span } = with.name("mutant");
        let (skill, mistake) = value.split_once(": ").unwrap_or((&value, ""));
        let spanned = |text: &str| Spanned { value: text.to_owned(), span: span.clone() };
        Effect::Machine { skill: spanned(skill), change: MachineChange::MutatedAs(spanned(mistake)) }
    },
    words: |with| with.text("mutant").to_owned(),
};

pub(super) const LEAF_INVERTED: FaultKind = FaultKind {
    name: "leaf_inverted",
    subsystem: Subsystem::Behavior,
    about: "the tree receives a leaf's success as failure, and its failure as success",
    parameters: &[LEAF],
    example: "at_s = 0\nleaf = \"BatteryLevel\"",
    effect: |with| {
        let decided = "m[1] = <success> or m[1] = <failure>";
        damaged(with, with.text("leaf"), "BT", decided, Damage::Opposite)
    },
    words: |with| format!("the tree receives success of {0} as failure, and failure as success", with.text("leaf")),
};

pub(super) const HALT_LOST: FaultKind = FaultKind {
    name: "halt_lost",
    subsystem: Subsystem::Behavior,
    about: "a leaf is halted, but its skill goes on: the tree takes it as stopped",
    parameters: &[LEAF],
    example: "at_s = 0\nleaf = \"GoToDestination\"",
    effect: |with| damaged(with, "BT", with.text("leaf"), "m[1] = <halt>", Damage::Pretence("halted")),
    words: |with| format!("{} does not receive its halt", with.text("leaf")),
};
