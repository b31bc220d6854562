//! How fast a run is shown, by the clock on the wall.

use std::time::{Duration, Instant};

use crate::command::Command;

/// Time between frames.
pub(crate) const FRAME: Duration = Duration::from_millis(40);
/// What "as fast as possible" means for what is recorded.
const FASTEST: f64 = 1000.0;
/// What is further behind goes on from where it is instead of running after the clock.
const BEHIND: Duration = Duration::from_millis(200);

/// How a run goes on.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Pace {
    Paused,
    /// To the next step.
    Step,
    /// To the tick with this number.
    Tick(u64),
    Running,
}

/// The pace of a run.
pub(crate) struct Clock {
    pace: Pace,
    /// How many times faster than time passes; none as fast as possible.
    speed: Option<f64>,
    /// When the run was where it was.
    since: (Instant, Duration),
}

impl Clock {
    /// The clock of a run that goes on from `time` as time passes.
    pub(crate) fn running(time: Duration) -> Self {
        Self { pace: Pace::Running, speed: Some(1.0), since: (now(), time) }
    }

    /// The same clock for a run that is held at `time`.
    pub(crate) fn held(&self, time: Duration) -> Self {
        Self { pace: Pace::Paused, since: (now(), time), ..*self }
    }

    /// The same clock for a run that is at `time`.
    pub(crate) fn at(&self, time: Duration) -> Self {
        Self { since: (now(), time), ..*self }
    }

    /// Does what is asked for, if it is about the pace of a run that is here; says whether it is.
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

    /// Whether a run with so many ticks may go on to its next step, which is at `next`.
    pub(crate) fn allows(&self, next: Duration, ticks: u64) -> bool {
        match self.pace {
            Pace::Paused => false,
            Pace::Step => true,
            Pace::Tick(tick) => ticks < tick,
            Pace::Running => self.speed.is_none() || next <= self.target(),
        }
    }

    /// Takes in that a step has been made, and so many ticks have been generated.
    pub(crate) fn stepped(&mut self, ticks: u64) {
        if self.pace == Pace::Step || matches!(self.pace, Pace::Tick(tick) if ticks >= tick) {
            self.pace = Pace::Paused;
        }
    }

    /// Takes in where the run has come to.
    pub(crate) fn arrive(&mut self, time: Duration) {
        if self.target() > time + BEHIND {
            self.since = (now(), time);
        }
    }

    /// Where a run that goes on ought to be now.
    pub(crate) fn target(&self) -> Duration {
        let (at, time) = self.since;
        time + at.elapsed().mul_f64(self.speed.unwrap_or(FASTEST))
    }

    /// How long it takes until a step at `next` is due; at most `most`.
    pub(crate) fn wait(&self, next: Duration, most: Duration) -> Duration {
        match (self.pace, self.speed) {
            (Pace::Paused, _) => most,
            (Pace::Running, Some(speed)) => next.saturating_sub(self.target()).div_f64(speed).min(most),
            _ => Duration::ZERO,
        }
    }
}

/// The time on the clock, which paces what is shown and enters no run.
#[expect(clippy::disallowed_methods, reason = "what is shown to a person keeps pace with the clock")]
pub(crate) fn now() -> Instant {
    Instant::now()
}
