//! The latest events, for when one of them turns out to matter.

use std::collections::VecDeque;

use channels::Event;
use maps::Point;
use recording::RunView;

/// How many events are remembered: about a thousand ticks of the shipped tree.
const CAPACITY: usize = 16_384;

/// A violation, with the events that led to it.
#[derive(Clone, Debug, PartialEq)]
pub struct Episode {
    /// The index of the violated property in the scenario.
    pub property: usize,
    /// The event that decided the verdict.
    pub decided: Event,
    /// Where the robot was then, if there is one.
    pub position: Option<Point>,
    /// Its battery's charge then, in percent, if it has one. A [`Course`](super::Course) is not exact.
    pub charge_pct: Option<f64>,
    /// The remembered events up to the end of that step, oldest first.
    pub events: Vec<Event>,
}

/// The latest events of a run.
#[derive(Clone, Debug, Default)]
pub(super) struct Recent {
    events: VecDeque<Event>,
}

impl Recent {
    /// Records the latest events.
    pub(super) fn see(&mut self, events: &[Event]) {
        self.events.extend(events.iter().cloned());
        let surplus = self.events.len().saturating_sub(CAPACITY);
        self.events.drain(..surplus);
    }

    /// The events that led to a violation that has just been found in what `view` shows.
    pub(super) fn episode(&self, property: usize, decided: Event, view: &RunView) -> Episode {
        let charge_pct = view.robot().battery.map(|battery| battery.charge_pct);
        let events = self.events.iter().cloned().collect();
        Episode { property, decided, position: view.position(), charge_pct, events }
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use channels::EventKind;

    use super::*;

    #[test]
    fn memory_is_bounded_and_the_oldest_events_are_dropped_first() {
        let mut recent = Recent::default();
        for tick in 0..50_000 {
            recent.see(&[Event { step: 0, tick, time: Duration::ZERO, kind: EventKind::Tick }]);
        }
        assert_eq!(recent.events.len(), CAPACITY);
        assert_eq!(recent.events.back().map(|event| event.tick), Some(49_999));
        assert_eq!(recent.events.front().map(|event| event.tick), Some(50_000 - CAPACITY as u64));
    }
}
