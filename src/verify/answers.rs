//! The answers of the nodes of a recorded tree, beside the events that are judged.

use std::cell::RefCell;
use std::path::Path;

use recording::{Header, Recording, RunView, Step};

/// The tree of a recording, and its answers up to the event that was judged last.
pub(super) struct Answers(RefCell<Read>);

struct Read {
    recording: Recording,
    view: RunView,
    /// The number of the last event.
    event: u64,
}

impl Answers {
    /// The answers in a recording; none without a tree, or if it cannot be read.
    pub(super) fn of(path: &Path) -> Option<Self> {
        let mut recording = Recording::open(path).ok()?;
        let view = recording.begin().ok().filter(|view| !view.header().tree.is_empty())?;
        Some(Self(RefCell::new(Read { recording, view, event: 0 })))
    }

    /// Adds the tree to a header.
    pub(super) fn describe(&self, header: &mut Header) {
        header.tree.clone_from(&self.0.borrow().view.header().tree);
    }

    /// Adds the answers up to an event to its record.
    pub(super) fn add(&self, event: u64, step: &mut Step) {
        let mut read = self.0.borrow_mut();
        let Read { recording, view, event: last } = &mut *read;
        while *last < event {
            // Where the recording ends, or cannot be read any further, so do its events.
            if view.end().is_some() || recording.advance(view).is_err() {
                return;
            }
            let Some(details) = &view.step().details else { continue };
            *last = details.events.last().map_or(*last, |event| event.step);
            step.details.get_or_insert_default().outcomes.extend_from_slice(&details.outcomes);
        }
    }
}
