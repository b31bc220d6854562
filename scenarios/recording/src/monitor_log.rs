//! What has been recorded of monitors, so that everything is recorded once.

use channels::{Event, Monitor, Verdict};
use monitors::{ScopeMonitor, scope_monitor};

use crate::{Decision, Happening, MonitorState};

/// The states and verdicts of monitors that were recorded last.
#[derive(Debug, Default)]
pub struct MonitorLog {
    /// `None` before the first record.
    states: Vec<Option<MonitorState>>,
    decided: Vec<bool>,
}

impl MonitorLog {
    /// Nothing has been recorded of this many monitors.
    #[must_use]
    pub fn new(monitors: usize) -> Self {
        Self { states: vec![None; monitors], decided: vec![false; monitors] }
    }

    /// Whether there are no monitors.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.states.is_empty()
    }

    /// The state of the monitor with this index, if it is not the one that was recorded last.
    pub fn change(&mut self, index: usize, state: MonitorState) -> Option<(usize, MonitorState)> {
        let recorded = &mut self.states[index];
        (recorded.as_ref() != Some(&state)).then(|| (index, recorded.insert(state).clone()))
    }

    /// The verdict of a monitor no longer counts.
    pub fn withdraw(&mut self, index: usize) {
        self.decided[index] = false;
    }

    /// The verdict that a monitor has reached with this event, unless it has been recorded.
    pub fn verdict(&mut self, index: usize, monitor: &dyn Monitor, event: &Event) -> Option<Happening> {
        if std::mem::replace(&mut self.decided[index], true) {
            return None;
        }
        let verdict = monitor.verdict();
        let witness = scope_monitor(monitor).and_then(ScopeMonitor::witness).filter(|_| verdict == Verdict::False);
        let decision = Decision { verdict, event: event.clone(), witness: witness.cloned() };
        Some(Happening::Verdict { monitor: index, decision })
    }
}
