//! The inputs of a machine: its start, events, and timers that are due.

use std::sync::Arc;
use std::time::Duration;

use super::host::Silence;
use super::macrostep::Macrostep;
use super::{Event, Host, Machine, Status};
use crate::datum::Memory;
use crate::steps::Steps;

impl Machine {
    /// Initializes the data, enters the initial states and runs until the machine comes to rest. Does nothing if the
    /// machine has been started before.
    pub fn start(&mut self, now: Duration, host: &mut dyn Host) {
        if self.status == Status::Ready {
            let chart = Arc::clone(&self.chart);
            Macrostep::new(&chart, self, now, host, &Steps::default()).start();
        }
    }

    /// Gives the machine an external event and runs until it comes to rest. A machine that is not running drops it.
    pub fn handle(&mut self, event: Event, now: Duration, host: &mut dyn Host) {
        if self.status == Status::Running {
            self.enqueue(event);
            let chart = Arc::clone(&self.chart);
            Macrostep::new(&chart, self, now, host, &Steps::default()).until_rest();
        }
    }

    /// When the next delayed event is due, here or in an invoked machine.
    #[must_use]
    pub fn next_timer(&self) -> Option<Duration> {
        let own = self.events.timers.first().map(|timer| timer.due);
        self.invoked.iter().fold(own, |first, invoked| earlier(first, invoked.machine.next_timer()))
    }

    /// Delivers the delayed events that are due at `now`, in order of their times; the machine comes to rest after
    /// each.
    pub fn fire_timers(&mut self, now: Duration, host: &mut dyn Host) {
        let chart = Arc::clone(&self.chart);
        while self.status == Status::Running && self.next_timer().is_some_and(|due| due <= now) {
            Macrostep::new(&chart, self, now, host, &Steps::default()).fire_next();
        }
    }

    /// The initial values of all data, with nothing else executed.
    pub(crate) fn first_values(&self) -> Memory {
        let mut machine = self.clone();
        let chart = Arc::clone(&self.chart);
        Macrostep::new(&chart, &mut machine, Duration::ZERO, &mut Silence, &Steps::default()).initialise_all();
        machine.data
    }
}

/// The earlier of two optional times.
fn earlier(one: Option<Duration>, other: Option<Duration>) -> Option<Duration> {
    match (one, other) {
        (Some(one), Some(other)) => Some(one.min(other)),
        (one, other) => one.or(other),
    }
}
