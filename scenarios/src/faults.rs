//! Faults: things that go wrong on purpose.
//!
//! A fault is an entry of a scenario's `[[faults]]`: its `kind`, with that kind's parameters; one trigger (`at_s`,
//! `at_tick`, `near`, `when`, `in_state`), optionally with a `probability`; and its duration (`lasts_s`) and
//! repetitions (`times`, `every_s`). The catalogue ([`KINDS`]) lists every kind with its parameters and with the part
//! that it affects. No fault modifies code. A scenario whose faults are removed gives exactly the run without faults,
//! bit for bit: each fault draws its random numbers from its own streams, and the current effects are recomputed from
//! the active faults.
//!
//! So faults combine. A component is frozen as long as any active fault freezes it. A skill runs its machine, or the
//! last active replacement in the order of the scenario, with the mistakes of all active faults; contradicting
//! combinations are refused when the scenario is loaded. The faults of a channel act on a message in the order in which
//! they began.
//!
//! In a run, the timetable determines when faults begin and end, and the injector applies them (crate `runs`).

mod argument;
mod catalogue;
mod effect;
mod kind;
mod schema;
mod trigger;

use std::sync::Arc;

use diagnostics::Spanned;
use diagnostics::document::{Key, Table};

pub use argument::{ArgumentDefault, ArgumentDomain, ArgumentValue, Arguments, Parameter, sentence};
pub use catalogue::{KINDS, kind};
pub use effect::{Damage, DeviceTrouble, Effect, MachineChange, TickTrouble, Which};
pub use kind::{FaultKind, Subsystem};
pub use trigger::{Timing, Trigger};

/// A fault of a scenario.
#[derive(Clone, Debug)]
pub struct Fault {
    kind: &'static FaultKind,
    arguments: Arguments,
    /// When it is active.
    pub timing: Timing,
}

impl Fault {
    pub(crate) fn read_all(root: Table<'_>) -> Vec<Arc<Self>> {
        let about = "Something that goes wrong: its kind with the parameters of that kind, and one trigger.";
        let faults = root.tables("faults").about(about).rules(|| schema::rules(&Key::all(Self::read)));
        faults.each(|table| Self::read(table).map(Arc::new)).or(Vec::new())
    }

    /// Reads an entry of `[[faults]]`. `None` after recording its problems.
    fn read(table: Table<'_>) -> Option<Self> {
        let choices: Vec<(&str, &'static FaultKind)> = KINDS.iter().map(|kind| (kind.name, *kind)).collect();
        let kind = table.one_of("kind", &choices).words("the name of a kind").about(
            "What goes wrong. `steward faults` lists the kinds, and `steward faults KIND` the parameters of one.",
        );
        let kind = kind.required();
        // Without a kind, the other keys cannot be checked.
        let timing = table.form(kind.is_some());
        let timing = timing.and_then(|table| Timing::read(table, kind.is_some_and(FaultKind::is_momentary)));
        let Some(kind) = kind else {
            table.allow_other_keys();
            return None;
        };
        let arguments = Arguments::read(table, kind.parameters);
        Some(Self { kind, arguments: arguments?, timing: timing? })
    }

    /// The kind of the fault.
    #[must_use]
    pub fn kind(&self) -> &'static FaultKind {
        self.kind
    }

    /// The values of its parameters.
    #[must_use]
    pub fn arguments(&self) -> &Arguments {
        &self.arguments
    }

    /// Its effect, in words.
    #[must_use]
    pub fn words(&self) -> String {
        (self.kind.words)(&self.arguments)
    }

    /// The names of the objects that it puts on the floor.
    #[must_use]
    pub fn bodies(&self) -> Vec<String> {
        let mut wrong = sim::Faults::default();
        if let Effect::World(apply) = self.effect() {
            apply(&mut wrong);
        }
        wrong.bodies.into_iter().map(|body| body.name).collect()
    }

    /// Its record.
    #[must_use]
    pub fn record(&self) -> recording::Fault {
        recording::Fault {
            kind: self.kind.name.to_owned(),
            momentary: self.kind.is_momentary(),
            words: self.words(),
            arguments: self.arguments.iter().map(|(name, value)| (name.to_owned(), value.record())).collect(),
        }
    }

    /// Whether it acts on a robot or its surroundings.
    #[must_use]
    pub fn needs_robot(&self) -> bool {
        self.effect().needs_robot()
    }

    /// The laser that it affects, if it affects only one.
    pub(crate) fn laser(&self) -> Option<Spanned<String>> {
        self.named("laser").filter(|laser| laser.value != "all")
    }

    /// The door that it affects, if it affects one.
    pub(crate) fn door(&self) -> Option<Spanned<String>> {
        self.named("door")
    }

    fn named(&self, parameter: &str) -> Option<Spanned<String>> {
        let is_there = self.kind.parameters.iter().any(|known| known.name == parameter);
        is_there.then(|| self.arguments.name(parameter))
    }

    /// What it does.
    #[must_use]
    pub fn effect(&self) -> Effect {
        (self.kind.effect)(&self.arguments)
    }
}

#[cfg(test)]
mod tests;
