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
    use channels::EventKind;
    use scenarios::scenario::{Scenario, find};

    use super::*;
    use crate::run::Run;

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

    #[test]
    fn up_to_100_ticks_come_per_second_with_a_robot_and_without() {
        for scenario in ["nominal", "takes_turns"] {
            for (tick_s, ticks) in [(0.01, 200), (0.015, 134), (0.02, 100), (0.05, 40), (0.1, 20)] {
                let set = [format!("execution.tick_s={tick_s}"), "execution.tree='nodes'".to_owned()];
                let loaded = Scenario::load(&find::find(scenario).expect("it is shipped"), &set).expect("it is right");
                let mut run = Run::new(loaded.into(), 1, false).expect("it can be set up");
                let mut count = 0;
                while run.time() < Duration::from_secs(2) {
                    run.step().expect("it goes on");
                    count += run.events().iter().filter(|event| event.kind == EventKind::Tick).count();
                }
                assert_eq!(count, ticks, "{scenario}, every {tick_s} s");
            }
        }
    }
}
