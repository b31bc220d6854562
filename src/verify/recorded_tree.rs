//! The tree of a recording, with the outcomes of its nodes, for the records of the events that are judged.

use std::cell::RefCell;
use std::path::Path;

use recording::{Header, Recording, RunView, Step};

/// The tree of a recording, with the outcomes of its nodes up to the last event that was judged.
pub(super) struct RecordedTree(RefCell<RecordingPosition>);

/// A position in a recording.
struct RecordingPosition {
    recording: Recording,
    view: RunView,
    /// The number of the last event.
    event: u64,
}

impl RecordedTree {
    /// The tree of a recording; none if it has no tree, or cannot be read.
    pub(super) fn of(path: &Path) -> Option<Self> {
        let mut recording = Recording::open(path).ok()?;
        let view = recording.begin().ok().filter(|view| !view.header().tree.is_empty())?;
        Some(Self(RefCell::new(RecordingPosition { recording, view, event: 0 })))
    }

    /// Adds the tree to a header.
    pub(super) fn describe(&self, header: &mut Header) {
        header.tree.clone_from(&self.0.borrow().view.header().tree);
    }

    /// Adds the outcomes up to an event to the record of the event.
    pub(super) fn add(&self, event: u64, step: &mut Step) {
        let mut position = self.0.borrow_mut();
        let RecordingPosition { recording, view, event: last } = &mut *position;
        while *last < event {
            // If the recording ends or cannot be read any further, no more events follow either.
            if view.end().is_some() || recording.advance(view).is_err() {
                return;
            }
            let Some(details) = &view.step().details else { continue };
            *last = details.events.last().map_or(*last, |event| event.step);
            step.details.get_or_insert_default().outcomes.extend_from_slice(&details.outcomes);
        }
    }
}
