//! The pace of a run beside nodes of ROS 2.

use std::time::{Duration, Instant};

/// The topic of simulated time.
pub(super) const CLOCK: &str = "/clock";

/// How long a clock may be silent before the run goes on in real time.
const SILENT: Duration = Duration::from_secs(10);

/// How far a run may fall behind real time and still catch up.
const BEHIND: Duration = Duration::from_millis(200);

/// The same for a clock, in nanoseconds.
const LATE_NS: i64 = 2_000_000_000;

/// The interval at which a clock is checked.
const AGAIN: Duration = Duration::from_millis(10);

/// The source of a run's time.
#[derive(Debug)]
pub(super) enum Time {
    /// Real time since the start of the run. The start is moved if the run falls behind.
    Steady(Option<Instant>),
    /// The clock of a simulation.
    Clock {
        /// Its time at the start of the run, once it is known.
        begun_ns: Option<i64>,
        /// Its last time.
        now_ns: i64,
        /// When it was received.
        received: Instant,
        /// Whether the run waits for it: for its first message, and while it has a publisher.
        may_pause: bool,
    },
}

impl Time {
    /// A clock of which no message has been received yet.
    pub(super) fn of_clock(may_pause: bool) -> Self {
        Self::Clock { begun_ns: None, now_ns: 0, received: network::now(), may_pause }
    }

    /// The time left until `now` is due.
    ///
    /// # Errors
    /// That the run has fallen behind, in words. It then goes on from there.
    pub(super) fn left(&mut self, now: Duration) -> Result<Duration, String> {
        match self {
            Self::Steady(begun) => {
                let begun = begun.get_or_insert_with(|| network::now().checked_sub(now).unwrap_or_else(network::now));
                let elapsed = begun.elapsed();
                if elapsed <= now.saturating_add(BEHIND) {
                    return Ok(now.saturating_sub(elapsed));
                }
                // The run does not catch up: nodes could not react in time.
                *begun += elapsed.saturating_sub(now);
                Err("the run is slower than real time: time passes as it can".to_owned())
            }
            Self::Clock { begun_ns: None, .. } => Ok(AGAIN),
            Self::Clock { begun_ns: Some(begun_ns), now_ns, .. } => {
                let late_ns = now_ns.saturating_sub(*begun_ns).saturating_sub(nanoseconds(now));
                if late_ns <= LATE_NS {
                    return Ok(if late_ns < 0 { AGAIN } else { Duration::ZERO });
                }
                *begun_ns = begun_ns.saturating_add(late_ns);
                Err(format!("the run is slower than {CLOCK}, or that has jumped: time passes as it can"))
            }
        }
    }

    /// Continues after a pause of the run at a time. The time of the pause does not count.
    pub(super) fn resume(&mut self, at: Duration) {
        match self {
            Self::Steady(begun) => *begun = None,
            Self::Clock { begun_ns, now_ns, received, .. } => {
                *received = network::now();
                *begun_ns = begun_ns.map(|_| now_ns.saturating_sub(nanoseconds(at)));
            }
        }
    }

    /// Changes to real time if a clock has fallen silent, and returns that in words. `is_there`: whether the clock has
    /// a publisher.
    pub(super) fn check_silence(&mut self, is_there: bool) -> Option<String> {
        let Self::Clock { begun_ns, received, may_pause, .. } = self else { return None };
        if received.elapsed() <= SILENT || *may_pause && (is_there || begun_ns.is_none()) {
            return None;
        }
        *self = Self::Steady(None);
        let seconds = SILENT.as_secs();
        Some(format!("{CLOCK} has been silent for {seconds} s: from here on, time is real time"))
    }

    /// Receives the time of the clock. Returns in words if it is odd.
    pub(super) fn receive_clock(&mut self, clock_ns: i64) -> Option<String> {
        let Self::Clock { begun_ns, now_ns, received, .. } = self else { return None };
        *received = network::now();
        let before_ns = std::mem::replace(now_ns, clock_ns);
        let begun_ns = begun_ns.get_or_insert(clock_ns);
        if clock_ns >= before_ns {
            return None;
        }
        *begun_ns = clock_ns.saturating_sub(before_ns.saturating_sub(*begun_ns));
        Some(format!("{CLOCK} went back, or is published twice: the time of the run goes on"))
    }
}

fn nanoseconds(time: Duration) -> i64 {
    i64::try_from(time.as_nanos()).unwrap_or(i64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn ms(ms: u64) -> Duration {
        Duration::from_millis(ms)
    }

    #[test]
    fn real_time_that_has_passed_during_a_pause_does_not_count() {
        let ago = |ms_ago: u64| Time::Steady(network::now().checked_sub(ms(ms_ago)));
        assert!(ago(5000).left(ms(1020)).is_err(), "it has fallen behind");
        let mut time = ago(5000);
        time.resume(ms(1000));
        assert_eq!(time.left(ms(1020)), Ok(Duration::ZERO), "the first step is due at once");
        let left = time.left(ms(2020)).unwrap();
        assert!(left > ms(900) && left <= ms(1000), "{left:?}");
    }

    #[test]
    fn a_clock_that_has_gone_on_during_a_pause_has_not_jumped() {
        let begun = || {
            let mut time = Time::of_clock(true);
            assert_eq!(time.left(ms(20)), Ok(AGAIN), "no message has come");
            assert_eq!((time.receive_clock(7_000_000_000), time.left(ms(20))), (None, Ok(AGAIN)));
            assert_eq!((time.receive_clock(7_020_000_000), time.left(ms(20))), (None, Ok(Duration::ZERO)));
            assert_eq!(time.receive_clock(67_020_000_000), None);
            time
        };
        assert!(begun().left(ms(40)).is_err());
        let mut time = begun();
        time.resume(ms(20));
        assert_eq!((time.left(ms(20)), time.left(ms(40))), (Ok(Duration::ZERO), Ok(AGAIN)));
        assert_eq!((time.receive_clock(67_040_000_000), time.left(ms(40))), (None, Ok(Duration::ZERO)));
    }

    #[test]
    fn a_pause_of_the_run_does_not_count_as_silence_of_the_clock() {
        let long_ago = network::now().checked_sub(ms(60_000)).unwrap();
        let silent = |may_pause| Time::Clock { begun_ns: Some(0), now_ns: 0, received: long_ago, may_pause };
        assert!(silent(false).check_silence(true).is_some() && silent(true).check_silence(true).is_none());
        let mut time = silent(false);
        time.resume(ms(20));
        assert_eq!(time.check_silence(true), None);
    }
}
