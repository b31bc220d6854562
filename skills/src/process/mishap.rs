//! Errors of a skill's own machine.

use crate::chart::{Chart, range};
use crate::machine::Note;

/// The maximum number of different mishaps; further ones are counted as one. Chosen, not measured.
const MAX_MISHAPS: usize = 100;

/// An error of a skill's machine: an expression or a script failed (`error.execution`), a message could not be sent
/// (`error.communication`) and not just because it was no longer awaited, or the machine did not come to rest
/// and was stopped.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mishap {
    /// The innermost state around the failed element; `None` outside of states, or in an invoked machine.
    pub state: Option<String>,
    /// The error, in words.
    pub message: String,
    /// The number of times that it has happened.
    pub times: u64,
}

impl Mishap {
    /// The skill or component of this name, and the state if it is known: `BatteryLevel, state get`.
    #[must_use]
    pub fn place(&self, process: &str) -> String {
        self.state.as_ref().map_or_else(|| process.to_owned(), |state| format!("{process}, state {state}"))
    }
}

/// All mishaps of a machine, each once, in the order of their first occurrence.
#[derive(Clone, Debug, Default)]
pub(super) struct Mishaps(Vec<Mishap>);

impl Mishaps {
    pub(super) fn note(&mut self, note: &Note, chart: &Chart) {
        let Some((state, message)) = mishap(note, chart) else {
            return;
        };
        let is_known = |known: &&mut Mishap| known.state.as_deref() == state && known.message == message;
        if let Some(known) = self.0.iter_mut().find(is_known) {
            known.times += 1;
        } else if self.0.len() < MAX_MISHAPS {
            self.0.push(Mishap { state: state.map(str::to_owned), message, times: 1 });
        } else if let Some(last) = self.0.last_mut() {
            *last = Mishap { state: None, message: "other errors".to_owned(), times: last.times + 1 };
        }
    }

    pub(super) fn all(&self) -> &[Mishap] {
        &self.0
    }
}

/// The position and description of a mishap, if the note is one.
fn mishap<'c>(note: &Note, chart: &'c Chart) -> Option<(Option<&'c str>, String)> {
    match note {
        Note::Error { reason, span, is_harmless: false, .. } => {
            let around = chart.states().map(|id| chart.state(id)).filter(|state| {
                let whole = range(state.extent);
                state.parent().is_some() && whole.start <= span.start && span.end <= whole.end
            });
            Some((around.last().map(|state| state.id()), reason.clone()))
        }
        Note::Stuck { .. } => Some((None, "the machine did not come to rest and was stopped".to_owned())),
        Note::Invoked { id, note } => mishap(note, chart).map(|(_, message)| (None, format!("in {id}: {message}"))),
        _ => None,
    }
}
