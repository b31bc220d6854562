//! Simulated time.

use std::time::Duration;

use bevy_ecs::prelude::*;

/// Time since the start of the run.
#[derive(Resource, Clone, Copy, Debug)]
pub(crate) struct Clock {
    pub(crate) now: Duration,
    pub(crate) dt: Duration,
}

impl Clock {
    /// The length of a step in seconds.
    pub(crate) fn dt_s(&self) -> f64 {
        self.dt.as_secs_f64()
    }
}

/// Begins a step: the clock shows the time at its end.
pub(crate) fn advance_clock(mut clock: ResMut<Clock>) {
    let dt = clock.dt;
    clock.now += dt;
}

/// An event at 0, one period, two periods, …: each at the first step that is not earlier.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Periodic {
    period: Duration,
    next: Duration,
}

impl Periodic {
    /// First due at 0; `period` is not zero.
    pub(crate) fn new(period: Duration) -> Self {
        Self { period, next: Duration::ZERO }
    }

    /// Whether it is due; if so, sets the next time.
    pub(crate) fn is_due(&mut self, now: Duration) -> bool {
        if now < self.next {
            return false;
        }
        let periods_gone = (now - self.next).as_nanos() / self.period.as_nanos() + 1;
        let wait = periods_gone * self.period.as_nanos();
        self.next += Duration::from_nanos(u64::try_from(wait).unwrap_or(u64::MAX));
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_period_that_is_not_a_multiple_of_the_step_keeps_its_rate() {
        let mut periodic = Periodic::new(Duration::from_millis(50));
        let due: Vec<u64> = (0..=10).map(|n| n * 20).filter(|t| periodic.is_due(Duration::from_millis(*t))).collect();
        assert_eq!(due, [0, 60, 100, 160, 200]);
    }

    #[test]
    fn a_period_shorter_than_a_step_is_due_at_every_step() {
        let mut periodic = Periodic::new(Duration::from_nanos(3));
        assert!((0..5).all(|n| periodic.is_due(Duration::from_millis(20 * n))));
    }
}
