//! What happened, in the words that people read on the page of a run, on the live page, and in the log of an MCAP file.

use channels::Verdict;

use crate::{Happening, RunView};

/// An arrival at a place, in words.
#[must_use]
pub fn arrival(place: &str) -> String {
    format!("at {place}")
}

/// The text of a speaker, in words.
#[must_use]
pub fn speech(text: &str) -> String {
    format!("“{text}”")
}

impl Happening {
    /// What happened, in words. `view` is the run in which it happened.
    #[must_use]
    pub fn words(&self, view: &RunView) -> String {
        let header = view.header();
        let fault = |index: usize| header.faults[index].words.as_str();
        match self {
            Self::FaultAdded(fault) => format!("manually: {}", fault.words),
            Self::FaultBegan { fault: index, .. } => fault(*index).to_owned(),
            Self::FaultEnded { fault: index, .. } => format!("ended: {}", fault(*index)),
            Self::FaultLeftUndone { fault: index, reason, .. } => {
                format!("could not be done: {}: {reason}", fault(*index))
            }
            Self::TreeError { message, .. } => message.clone(),
            Self::GivenUp { reason } => format!("navigation gave up: {reason}"),
            Self::Verdict { monitor, decision } => {
                let verdict = if decision.verdict == Verdict::False { "violated" } else { "satisfied" };
                format!("{} is {verdict}", view.monitor(*monitor).name())
            }
            Self::Said { text, .. } => speech(text),
            Self::Moved { words } => words.clone(),
            Self::Lost(gap) => gap.why.clone(),
            Self::Resumed(channel) => {
                let (from, to) = view.topology().ends(*channel);
                format!("messages from {from} to {to} are complete again")
            }
            Self::Arrival { place } => arrival(&header.places()[*place].name),
        }
    }
}
