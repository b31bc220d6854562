//! What happens in a run, step by step.

use channels::{Event, Topology};
use recording::{Happening, TraceHash};

/// The last step, and the hash of all steps.
#[derive(Default)]
pub(super) struct StepTrace {
    pub(super) hash: TraceHash,
    /// The communications of the last step, and the truths that monitors were shown.
    pub(super) events: Vec<Event>,
    pub(super) happenings: Vec<Happening>,
    /// Whether a timer or a fault moved a process in it.
    pub(super) stirred: bool,
}

impl StepTrace {
    pub(super) fn enter(&mut self, event: Event, topology: &Topology) {
        self.hash.event(&event, topology);
        self.events.push(event);
    }

    pub(super) fn note_moves(&mut self, words: Vec<String>) {
        self.happenings.extend(words.into_iter().map(|words| Happening::Moved { words }));
    }
}
