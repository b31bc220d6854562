//! When pictures of a run are taken, apart from the moments at which something happens.

use std::time::Duration;

use crate::Snapshots;

/// Time between the frames of an animation while the robot is driving, and while it is charging.
const FRAME_PERIODS: [Duration; 2] = [Duration::from_secs(1), Duration::from_secs(30)];

/// Decides at which steps a picture may be wanted because of the time.
///
/// The writer of a run has one clock for when a [`Scene`](crate::Scene) is needed, and the reader has another for when
/// to take pictures: both come to the same.
#[derive(Clone, Debug)]
pub struct SceneClock {
    frame: Duration,
    /// Latest first.
    named: Vec<Duration>,
    regular: Option<(Duration, Duration)>,
}

impl SceneClock {
    /// The clock of a run with these pictures.
    #[must_use]
    pub fn new(snapshots: &Snapshots) -> Self {
        let mut named = snapshots.at_times.clone();
        named.sort_unstable_by(|a, b| b.cmp(a));
        Self { frame: Duration::ZERO, named, regular: snapshots.every.map(|every| (Duration::ZERO, every)) }
    }

    /// Whether an animation gets a frame now.
    pub fn is_frame(&mut self, now: Duration, charging: bool) -> bool {
        let due = now >= self.frame;
        if due {
            self.frame = now + FRAME_PERIODS[usize::from(charging)];
        }
        due
    }

    /// Whether one of the times listed in the scenario has been reached.
    pub fn is_named(&mut self, now: Duration) -> bool {
        self.named.pop_if(|time| *time <= now).is_some()
    }

    /// Whether it is time for the next regular picture.
    pub fn is_regular(&mut self, now: Duration) -> bool {
        let Some((next, every)) = &mut self.regular else { return false };
        let due = now >= *next;
        if due {
            *next += *every;
        }
        due
    }

    /// Whether it is time for a picture of any kind.
    pub fn is_any(&mut self, now: Duration, charging: bool) -> bool {
        // All three have to be called.
        let due = [self.is_frame(now, charging), self.is_named(now), self.is_regular(now)];
        due.contains(&true)
    }
}
