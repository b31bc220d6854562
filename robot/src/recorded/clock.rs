//! The clocks of a log's lines, which are not always in order.
//!
//! The lines of real logs come from several programs, so clocks jump back and forth by a second, and lines added by
//! other programs may have no clock at all. The file lists events in the order in which they happened, so lines are
//! used in that order.

use std::time::Duration;

use super::complaint::{Complaints, Flaw};
use super::lines::{Lines, LogLine};

/// If clocks go back by at most this many seconds, lines were written out of order.
const JITTER_S: f64 = 2.0;

/// The number of lines ahead that help to distinguish a wrong clock from one that was set.
const AHEAD: usize = 6;

/// A clock that jumps ahead by this much, in seconds, was set: no log has a gap of a day.
const DAY_S: f64 = 86_400.0;

/// The time of each line since the first, never earlier than that of the previous line; `None` for odometry whose clock
/// is so far off that the line may belong elsewhere.
pub(super) fn settled(lines: &[LogLine], complaints: &mut Complaints) -> Vec<Option<Duration>> {
    let start_s = lines.first().map_or(0.0, |line| line.clock_s);
    let mut clock = LogClock { start_s, latest_s: start_s, set_back_s: 0.0 };
    let following = |index: usize| &lines[index + 1..lines.len().min(index + 1 + AHEAD)];
    lines.iter().enumerate().map(|(index, line)| clock.time_of(line, following(index), complaints)).collect()
}

/// The clock of a log, line by line.
struct LogClock {
    start_s: f64,
    /// The time of the previous line.
    latest_s: f64,
    /// What is added to the clocks of lines, because the clock was set.
    set_back_s: f64,
}

impl LogClock {
    /// The time of a line, judged by some of those that follow.
    fn time_of(&mut self, line: &LogLine, following: &[LogLine], complaints: &mut Complaints) -> Option<Duration> {
        let behind_s = self.behind_s(line);
        if behind_s > JITTER_S {
            // A clock that was set back stays behind; one that is 0 belongs to a line without a clock.
            let is_set = following.len() == AHEAD
                && line.clock_s > 0.0
                && following.iter().all(|line| self.behind_s(line) > JITTER_S);
            if is_set {
                complaints.add(line.number, Flaw::ClockSetBack { by_s: behind_s });
                self.set_back_s += behind_s;
            } else if line.scan.is_none() {
                complaints.add(line.number, Flaw::ClockElsewhere { by_s: behind_s });
                return None;
            }
        }
        let ahead_of = |other: &&LogLine| line.clock_s - other.clock_s > JITTER_S;
        if behind_s < -JITTER_S && 2 * following.iter().filter(ahead_of).count() > following.len() {
            complaints.add(line.number, Flaw::ClockAhead { by_s: -behind_s });
            return Some(self.since_start());
        }
        if behind_s < -DAY_S {
            complaints.add(line.number, Flaw::ClockSetForward { by_s: -behind_s });
            self.set_back_s += behind_s;
        }
        let clock_s = line.clock_s + self.set_back_s;
        if clock_s < self.latest_s {
            complaints.add(line.number, Flaw::ClockBack { by_s: self.latest_s - clock_s });
        }
        // A clock that is ahead of those that follow is wrong.
        let soon_s =
            following.iter().map(|line| line.clock_s + self.set_back_s).filter(|soon_s| *soon_s > self.latest_s);
        self.latest_s = soon_s.fold(clock_s, f64::min).max(self.latest_s);
        Some(self.since_start())
    }

    fn behind_s(&self, line: &LogLine) -> f64 {
        self.latest_s - (line.clock_s + self.set_back_s)
    }

    fn since_start(&self) -> Duration {
        Duration::from_secs_f64(self.latest_s - self.start_s)
    }
}

/// The usual time between a laser's scans.
pub(super) fn period(lines: &Lines, laser: usize) -> Duration {
    let is_scan = |line: &&LogLine| line.scan.as_ref().is_some_and(|scan| scan.laser == laser);
    let clocks_s: Vec<f64> = lines.lines.iter().filter(is_scan).map(|line| line.clock_s).collect();
    let mut periods_s: Vec<f64> = clocks_s.windows(2).map(|pair| (pair[1] - pair[0]).clamp(0.0, 1e6)).collect();
    periods_s.sort_unstable_by(f64::total_cmp);
    Duration::from_secs_f64(periods_s.get(periods_s.len() / 2).copied().unwrap_or_default())
}
