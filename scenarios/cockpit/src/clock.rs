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

    /// The same clock for a run that goes on from its start.
    pub(crate) fn restarted(&self) -> Self {
        Self { pace: Pace::Running, since: (now(), Duration::ZERO), ..*self }
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

#[cfg(test)]
mod tests {
    use super::*;

    const STEP: Duration = Duration::from_millis(20);

    /// A clock that has obeyed this at the start of a run, after three ticks.
    fn after(command: &Command) -> Clock {
        let mut clock = Clock::running(Duration::ZERO);
        assert!(clock.obey(command, Duration::ZERO, 3));
        clock
    }

    #[test]
    fn a_paused_run_does_not_go_on() {
        let clock = after(&Command::Pause);
        assert!(clock.is_paused() && !clock.allows(Duration::ZERO, 3));
        assert_eq!(clock.wait(STEP, 5 * STEP), 5 * STEP);
    }

    #[test]
    fn a_step_and_a_tick_pause_the_run_when_they_are_done() {
        let mut clock = after(&Command::Step);
        assert!(clock.allows(Duration::MAX, 3));
        clock.stepped(3);
        assert!(clock.is_paused());
        let mut clock = after(&Command::Tick);
        clock.stepped(3);
        assert!(clock.allows(Duration::MAX, 3), "the next tick has not come");
        clock.stepped(4);
        assert!(clock.is_paused());
    }

    #[test]
    fn the_speed_bounds_how_far_a_run_may_be() {
        let slow = after(&Command::Speed { times: Some(0.001) });
        assert_eq!(slow.speed(), Some(0.1));
        let hour = Duration::from_secs(3600);
        assert!(slow.allows(Duration::ZERO, 3) && !slow.allows(hour, 3));
        assert!(after(&Command::Speed { times: None }).allows(hour, 3));
    }

    #[test]
    fn a_run_that_is_far_behind_does_not_catch_up() {
        let mut clock = Clock::running(Duration::ZERO);
        clock.since.1 = Duration::from_secs(10);
        clock.arrive(Duration::from_secs(1));
        assert!(clock.target() < Duration::from_secs(5));
    }
}
