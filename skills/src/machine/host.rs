//! The environment of a machine.

use std::ops::Range;
use std::sync::Arc;

use super::{Machine, Outgoing};

/// The environment that runs a machine: receives the events it sends and the notes it makes.
pub trait Host {
    /// Delivers an event that the machine sends through an event I/O processor other than its own.
    ///
    /// # Errors
    /// [`Undelivered`] if that is impossible: the machine gets `error.communication`.
    fn send(&mut self, outgoing: &Outgoing) -> Result<(), Undelivered>;

    /// Receives a log line or an error.
    fn note(&mut self, note: Note) {
        let _ = note;
    }

    /// Called whenever the machine has entered a configuration; not for machines that it invokes.
    fn entered(&mut self, machine: &Machine) {
        let _ = machine;
    }
}

/// Why an event could not be delivered.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Undelivered {
    /// A mistake: there is no such receiver, or the event does not fit.
    #[error("{0}")]
    Unfit(String),
    /// A mistake: a field cannot have this value.
    #[error("{refusal}, and {value}")]
    Value {
        /// The message and the field, and what it can have, in words: the same for all such values.
        refusal: String,
        /// The value, and why it is not among them, in words.
        value: String,
    },
    /// It is no longer awaited, as happens to answers that come late.
    #[error("{0}")]
    Late(String),
}

/// A message from a machine to people.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Note {
    /// A `<log>` was executed.
    Log {
        /// Its label; empty if it has none.
        label: Arc<str>,
        /// The value of its expression as text.
        text: String,
    },
    /// Something went wrong and became an error event.
    Error {
        /// `error.execution` or `error.communication`.
        event: &'static str,
        /// What went wrong.
        reason: String,
        /// Whether it happens to correct machines, too, such as to one that answers late.
        is_harmless: bool,
        /// The position: bytes of the machine's file.
        span: Range<usize>,
    },
    /// No transition handled an error event.
    UnhandledError {
        /// The event's name.
        event: Arc<str>,
    },
    /// The machine has sent itself an event that none of its transitions handles.
    Unheard {
        /// The event's name.
        event: Arc<str>,
    },
    /// A note of an invoked machine.
    Invoked {
        /// The id of the invoked machine.
        id: Arc<str>,
        /// Its note; positions are in its own file.
        note: Box<Note>,
    },
    /// The machine did not come to rest and was stopped.
    Stuck {
        /// The number of microsteps that it took.
        microsteps: u32,
    },
}

/// A host that records the events and notes of a machine that runs alone.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Transcript {
    /// The events sent, in order.
    pub sent: Vec<Outgoing>,
    /// The notes, in order.
    pub notes: Vec<Note>,
}

impl Transcript {
    /// The log lines, `label: text` or just the text.
    pub fn log_lines(&self) -> impl Iterator<Item = String> + '_ {
        self.notes.iter().filter_map(|note| match note {
            Note::Log { label, text } if label.is_empty() => Some(text.clone()),
            Note::Log { label, text } => Some(format!("{label}: {text}")),
            _ => None,
        })
    }
}

impl Host for Transcript {
    fn send(&mut self, outgoing: &Outgoing) -> Result<(), Undelivered> {
        self.sent.push(outgoing.clone());
        Ok(())
    }

    fn note(&mut self, note: Note) {
        self.notes.push(note);
    }
}

/// A host that ignores everything.
pub(crate) struct Silence;

impl Host for Silence {
    fn send(&mut self, _: &Outgoing) -> Result<(), Undelivered> {
        Ok(())
    }
}
