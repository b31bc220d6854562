//! When a run beside nodes of ROS 2 goes on.

use std::time::{Duration, Instant};

use crate::moment::moment;

/// The topic of simulated time.
pub(super) const CLOCK: &str = "/clock";

/// How long a clock may say nothing before time goes on without it.
const SILENT: Duration = Duration::from_secs(10);

/// How far a run may fall behind before it gives that up: in real time, and in that of a clock, in nanoseconds.
const BEHIND: Duration = Duration::from_millis(200);
const LATE_NS: i64 = 2_000_000_000;

/// How long to wait for a clock before asking it again.
const AGAIN: Duration = Duration::from_millis(10);

/// What says how late it is.
#[derive(Debug)]
pub(super) enum Time {
    /// Since the start of the run, real time; later than at first if it has fallen behind.
    Steady(Option<Instant>),
    /// The clock of a simulation: when the run began, what it said last, and when; and whether it may stand still while
    /// somebody publishes it, and come later.
    Clock { begun_ns: Option<i64>, now_ns: i64, heard: Instant, may_pause: bool },
}

impl Time {
    /// A clock that has said nothing yet.
    pub(super) fn of_clock(may_pause: bool) -> Self {
        Self::Clock { begun_ns: None, now_ns: 0, heard: moment(), may_pause }
    }

    /// How much time is left until `now` is due; none, and why, if the run has fallen behind.
    pub(super) fn left(&mut self, now: Duration) -> Result<Duration, String> {
        match self {
            Self::Steady(begun) => {
                let begun = begun.get_or_insert_with(|| moment().checked_sub(now).unwrap_or_else(moment));
                let elapsed = begun.elapsed();
                if elapsed <= now.saturating_add(BEHIND) {
                    return Ok(now.saturating_sub(elapsed));
                }
                // What was missed is not made up for: nobody could react.
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

    /// Goes on after a pause of the run at a time: what has passed meanwhile does not count.
    pub(super) fn resume(&mut self, at: Duration) {
        match self {
            Self::Steady(begun) => *begun = None,
            Self::Clock { begun_ns, now_ns, heard, .. } => {
                *heard = moment();
                *begun_ns = begun_ns.map(|_| now_ns.saturating_sub(nanoseconds(at)));
            }
        }
    }

    /// Goes on without a clock that has fallen silent, and says so. `is_there` says whether somebody publishes it.
    pub(super) fn mind_silence(&mut self, is_there: bool) -> Option<String> {
        let Self::Clock { begun_ns, heard, may_pause, .. } = self else { return None };
        if heard.elapsed() <= SILENT || *may_pause && (is_there || begun_ns.is_none()) {
            return None;
        }
        *self = Self::Steady(None);
        let seconds = SILENT.as_secs();
        Some(format!("{CLOCK} has said nothing for {seconds} s: from here on, time is real time"))
    }

    /// What the clock says now. Returns what is odd about it.
    pub(super) fn hear(&mut self, said_ns: i64) -> Option<String> {
        let Self::Clock { begun_ns, now_ns, heard, .. } = self else { return None };
        *heard = moment();
        let before_ns = std::mem::replace(now_ns, said_ns);
        let begun_ns = begun_ns.get_or_insert(said_ns);
        if said_ns >= before_ns {
            return None;
        }
        *begun_ns = said_ns.saturating_sub(before_ns.saturating_sub(*begun_ns));
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
        let ago = |ms_ago: u64| Time::Steady(moment().checked_sub(ms(ms_ago)));
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
            assert_eq!(time.left(ms(20)), Ok(AGAIN), "it has said nothing");
            assert_eq!((time.hear(7_000_000_000), time.left(ms(20))), (None, Ok(AGAIN)));
            assert_eq!((time.hear(7_020_000_000), time.left(ms(20))), (None, Ok(Duration::ZERO)));
            assert_eq!(time.hear(67_020_000_000), None);
            time
        };
        assert!(begun().left(ms(40)).is_err());
        let mut time = begun();
        time.resume(ms(20));
        assert_eq!((time.left(ms(20)), time.left(ms(40))), (Ok(Duration::ZERO), Ok(AGAIN)));
        assert_eq!((time.hear(67_040_000_000), time.left(ms(40))), (None, Ok(Duration::ZERO)));
    }

    #[test]
    fn a_clock_is_silent_only_while_somebody_listens() {
        let long_ago = moment().checked_sub(ms(60_000)).unwrap();
        let silent = |may_pause| Time::Clock { begun_ns: Some(0), now_ns: 0, heard: long_ago, may_pause };
        assert!(silent(false).mind_silence(true).is_some() && silent(true).mind_silence(true).is_none());
        let mut time = silent(false);
        time.resume(ms(20));
        assert_eq!(time.mind_silence(true), None);
    }
}
