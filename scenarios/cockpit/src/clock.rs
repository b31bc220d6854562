//! How fast a run is shown, by the wall clock.

use std::time::{Duration, Instant};

use crate::command::Command;

/// Time between frames.
pub(crate) const FRAME: Duration = Duration::from_millis(40);
/// What "as fast as possible" means for recordings.
const FASTEST: f64 = 1000.0;
/// A run further behind than this goes on from where it is instead of catching up.
const BEHIND: Duration = Duration::from_millis(200);

/// How a run goes on.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Pace {
    Paused,
    /// Up to the next step.
    Step,
    /// Up to the tick with this number.
    Tick(u64),
    Running,
}

/// The pace of a run.
pub(crate) struct Clock {
    pace: Pace,
    /// A multiple of real time; none for as fast as possible.
    speed: Option<f64>,
    /// A wall-clock time, and where the run was then.
    since: (Instant, Duration),
}

impl Clock {
    /// The clock of a run that goes on from `time` in real time.
    pub(crate) fn running(time: Duration) -> Self {
        Self { pace: Pace::Running, speed: Some(1.0), since: (now(), time) }
    }

    /// The same clock for a run that is paused at `time`.
    pub(crate) fn held(&self, time: Duration) -> Self {
        Self { pace: Pace::Paused, since: (now(), time), ..*self }
    }

    /// The same clock for a run that is at `time`.
    pub(crate) fn at(&self, time: Duration) -> Self {
        Self { since: (now(), time), ..*self }
    }

    /// Obeys the command if it is about the pace, for a run that is at `time`. Returns whether it is.
    pub(crate) fn obey(&mut self, command: &Command, time: Duration, ticks: u64) -> bool {
        match command {
            Command::Pause => self.pace = Pace::Paused,
            Command::Resume => self.pace = Pace::Running,
            Command::Step => self.pace = Pace::Step,
            Command::Tick => self.pace = Pace::Tick(ticks + 1),
            Command::Speed { times } => self.speed = times.map(|times| times.clamp(0.1, FASTEST)),
            _ => return false,
        }
        self.since = (now(), time);
        true
    }

    pub(crate) fn hold(&mut self) {
        self.pace = Pace::Paused;
    }

    pub(crate) fn is_paused(&self) -> bool {
        self.pace == Pace::Paused
    }

    pub(crate) fn is_running(&self) -> bool {
        self.pace == Pace::Running
    }

    pub(crate) fn speed(&self) -> Option<f64> {
        self.speed
    }

    /// Whether a run that has generated `ticks` ticks may go on to its next step, which is at `next`.
    pub(crate) fn allows(&self, next: Duration, ticks: u64) -> bool {
        match self.pace {
            Pace::Paused => false,
            Pace::Step => true,
            Pace::Tick(tick) => ticks < tick,
            Pace::Running => self.speed.is_none() || next <= self.target(),
        }
    }

    /// Records that a step was made, and how many ticks have been generated.
    pub(crate) fn stepped(&mut self, ticks: u64) {
        if self.pace == Pace::Step || matches!(self.pace, Pace::Tick(tick) if ticks >= tick) {
            self.pace = Pace::Paused;
        }
    }

    /// Records how far the run is.
    pub(crate) fn arrive(&mut self, time: Duration) {
        if self.target() > time + BEHIND {
            self.since = (now(), time);
        }
    }

    /// Where the run ought to be now if it goes on.
    pub(crate) fn target(&self) -> Duration {
        let (at, time) = self.since;
        time + at.elapsed().mul_f64(self.speed.unwrap_or(FASTEST))
    }

    /// The time until a step at `next` is due, at most `most`.
    pub(crate) fn wait(&self, next: Duration, most: Duration) -> Duration {
        match (self.pace, self.speed) {
            (Pace::Paused, _) => most,
            (Pace::Running, Some(speed)) => next.saturating_sub(self.target()).div_f64(speed).min(most),
            _ => Duration::ZERO,
        }
    }
}

/// The wall-clock time, which paces what is shown and never enters a run.
#[expect(clippy::disallowed_methods, reason = "what is shown to a person keeps pace with the clock")]
pub(crate) fn now() -> Instant {
    Instant::now()
}
