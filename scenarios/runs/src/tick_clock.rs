//! When ticks are generated.

use std::time::Duration;

/// The first tick time after the start of a run.
pub(crate) const AFTER_THE_START: Duration = Duration::from_nanos(1);

/// A periodic timer, which faults may disturb.
#[derive(Clone, Debug)]
pub(crate) struct TickClock {
    period: Duration,
    /// When the timer is due next, apart from faults.
    next: Duration,
    /// Delayed ticks, with their times.
    late: Vec<Duration>,
}

impl TickClock {
    /// The timer that is due for the first time at `first`.
    pub(crate) fn new(period: Duration, first: Duration) -> Self {
        Self { period, next: first, late: Vec::new() }
    }

    /// When the timer is due next, or may be.
    pub(crate) fn next(&self) -> Duration {
        self.late.iter().copied().fold(self.next, Duration::min)
    }

    /// Whether a tick must be generated in this step. `delay` returns the delay of a tick that is due, or `None` if it
    /// is missed.
    pub(crate) fn is_due(&mut self, now: Duration, delay: impl FnOnce() -> Option<Duration>) -> bool {
        if now >= self.next {
            self.late.extend(delay().map(|delay| self.next + delay));
            self.next += self.period;
        }
        let due = self.late.iter().position(|at| now >= *at);
        due.map(|index| self.late.swap_remove(index)).is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first 200 steps of 20 ms at which ticks are generated, with the given delay of the n-th tick.
    fn ticks(delay: impl Fn(usize) -> Option<Duration>) -> Vec<u64> {
        let mut clock = TickClock::new(Duration::from_secs(1), AFTER_THE_START);
        let mut number = 0;
        let mut is_due = |step: u64| {
            clock.is_due(Duration::from_millis(20 * step), || {
                number += 1;
                delay(number - 1)
            })
        };
        (1..=200).filter(|step| is_due(*step)).collect()
    }

    #[test]
    fn an_undisturbed_clock_ticks_once_per_period() {
        assert_eq!(ticks(|_| Some(Duration::ZERO)), [1, 51, 101, 151]);
    }

    #[test]
    fn missed_and_late_ticks_do_not_shift_the_others() {
        assert_eq!(ticks(|n| (n != 1).then_some(Duration::ZERO)), [1, 101, 151]);
        assert_eq!(ticks(|n| Some(Duration::from_millis(if n == 1 { 1500 } else { 0 }))), [1, 101, 126, 151]);
    }

    #[test]
    fn no_step_has_two_ticks() {
        assert_eq!(ticks(|n| Some(Duration::from_secs(if n == 0 { 1 } else { 0 }))), [51, 52, 101, 151]);
    }
}
