//! A moment of a run, as the page shows it.

use std::collections::VecDeque;

use channels::{Event, EventKind};
use recording::{Inconsistent, Record, RunView};

/// How many of the latest messages are shown.
const MESSAGES: usize = 400;

#[derive(Clone)]
pub(crate) struct Moment {
    pub(crate) view: RunView,
    /// The latest messages.
    pub(crate) messages: VecDeque<Event>,
}

impl Moment {
    pub(crate) fn start(view: RunView) -> Self {
        Self { view, messages: VecDeque::new() }
    }

    /// Goes on to the next record.
    ///
    /// # Errors
    /// [`Inconsistent`] if it does not fit.
    pub(crate) fn apply(&mut self, record: Record) -> Result<(), Inconsistent> {
        match record {
            Record::Header(_) => return Err(Inconsistent),
            Record::End(end) => return self.view.finish(*end),
            Record::Step(step) => self.view.apply(step)?,
        }
        let topology = self.view.topology();
        let is_received =
            |event: &&Event| matches!(event.kind, EventKind::Received { .. }) && !event.is_shown(topology);
        let received = self.view.events().iter().filter(is_received);
        self.messages.extend(received.cloned());
        self.messages.drain(..self.messages.len().saturating_sub(MESSAGES));
        Ok(())
    }
}
