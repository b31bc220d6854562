//! Faults: what can go wrong on purpose.
//!
//! A fault is an entry of a scenario's `[[faults]]`: its `kind`, with that kind's parameters; one trigger (`at_s`,
//! `at_tick`, `near`, `when`, `in_state`), perhaps with a `probability`; and how long (`lasts_s`) and how often (`times`,
//! `every_s`) it holds. The catalogue ([`KINDS`]) has every kind with its parameters, and where it acts. No fault touches
//! code, and one that is taken out of the file gives back the unfaulted run bit for bit: each draws its random numbers from
//! streams of its own, and what is wrong at the moment is computed anew from the faults that hold.
//!
//! So faults combine. A component stands still as long as one of them wants it to. A skill runs the machine with the
//! mistakes of all that hold, put into the last of its replacements in the scenario if there is one; combinations that
//! contradict one another are refused when the scenario is loaded. A message meets the faults of its channel in the order
//! in which they began.
//!
//! The `Timetable` says when faults begin and end; the `Injector` makes them take hold.

mod argument;
mod catalogue;
mod effect;
mod injector;
mod kind;
mod timetable;
mod trigger;

use std::sync::Arc;

use diagnostics::document::Table;

pub use argument::{ArgumentDefault, ArgumentDomain, ArgumentValue, Arguments, Parameter};
pub use catalogue::{KINDS, kind};
pub(crate) use effect::{Effect, MachineChange, TickTrouble};
pub(crate) use injector::{Happening, Injector, SystemUnderTest};
pub use kind::{FaultKind, Place};
pub(crate) use timetable::{Change, Observation, Timetable};
pub use trigger::{Timing, Trigger};

/// Something that goes wrong, as a scenario says it.
#[derive(Clone, Debug)]
pub struct Fault {
    kind: &'static FaultKind,
    arguments: Arguments,
    /// When it holds.
    pub timing: Timing,
}

impl Fault {
    /// Reads an entry of `[[faults]]`. `None` if something is wrong with it, which has been recorded.
    pub(crate) fn read(table: Table<'_>) -> Option<Self> {
        let choices: Vec<(&str, &'static FaultKind)> = KINDS.iter().map(|kind| (kind.name, *kind)).collect();
        let Some(kind) = table.one_of("kind", &choices).required() else {
            // What else the entry says, nobody can judge.
            table.allow_other_keys();
            return None;
        };
        let timing = Timing::read(table, kind.momentary);
        let arguments = Arguments::read(table, kind.parameters);
        Some(Self { kind, arguments: arguments?, timing: timing? })
    }

    /// What kind of fault it is.
    #[must_use]
    pub fn kind(&self) -> &'static FaultKind {
        self.kind
    }

    /// The values of its parameters.
    #[must_use]
    pub fn arguments(&self) -> &Arguments {
        &self.arguments
    }

    /// What it does, in words.
    #[must_use]
    pub fn words(&self) -> String {
        (self.kind.words)(&self.arguments)
    }

    /// What records tell of it.
    pub(crate) fn told(&self) -> recording::Fault {
        recording::Fault {
            kind: self.kind.name.to_owned(),
            momentary: self.kind.momentary,
            words: self.words(),
            arguments: self.arguments.iter().map(|(name, value)| (name.to_owned(), value.told())).collect(),
        }
    }

    pub(crate) fn effect(&self) -> Effect {
        (self.kind.effect)(&self.arguments)
    }
}

/// The name of a fault's stream of random numbers: its kind and its place among the faults of that kind, so that another
/// kind of fault that is added or taken out changes nothing.
fn stream_name(faults: &[Arc<Fault>], index: usize) -> String {
    let kind = faults[index].kind().name;
    let number = faults[..index].iter().filter(|other| other.kind().name == kind).count();
    format!("{kind}/{number}")
}

#[cfg(test)]
mod tests;
