//! The events of a machine.

use std::collections::VecDeque;
use std::sync::{Arc, OnceLock};

use channels::Unobserved;

use super::timer::Timer;
use crate::Datum;
use crate::chart::EventClass;
use crate::event::Event;

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct Queued {
    pub(super) event: Event,
    pub(super) class: EventClass,
}

/// The last event that a machine has taken, and those that wait.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct MachineEvents {
    pub(super) last: Option<Event>,
    /// The same as an object, once that was needed.
    pub(super) last_object: Unobserved<OnceLock<Datum>>,
    pub(super) internal: VecDeque<Queued>,
    pub(super) external: VecDeque<Queued>,
    pub(super) timers: Vec<Timer>,
}

impl MachineEvents {
    pub(super) fn set_last(&mut self, event: Event) {
        self.last = Some(event);
        if self.last_object.get().is_some() {
            self.last_object = Unobserved::default();
        }
    }

    pub(super) fn forget_last(&mut self) {
        (self.last, self.last_object) = (None, Unobserved::default());
    }

    /// How many wait, including delayed ones.
    pub(super) fn waiting(&self) -> usize {
        self.internal.len() + self.external.len() + self.timers.len()
    }

    /// Adds a delayed event, after those that are due at the same time.
    pub(super) fn delay(&mut self, timer: Timer) {
        let position = self.timers.partition_point(|earlier| earlier.due <= timer.due);
        self.timers.insert(position, timer);
    }

    pub(super) fn cancel(&mut self, id: &Arc<str>) {
        self.timers.retain(|timer| timer.send_id.as_ref() != Some(id));
    }

    /// Drops those that wait.
    pub(super) fn clear(&mut self) {
        self.internal.clear();
        self.external.clear();
        self.timers.clear();
    }
}
