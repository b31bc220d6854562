//! The pace of a simulated robot, and the command of each step.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use robot::VelocityCommand;
use scenarios::Error;

use super::commands::Command;
use super::config::PaceConfig;

/// The base stops if no command has come for this long. A command is too old if its stamp is older.
pub(super) const STALE: Duration = Duration::from_millis(500);

/// The most commands that wait for their periods.
const MOST_WAITING: usize = 1000;

/// How far a simulation may fall behind real time and still catch up.
const BEHIND: Duration = Duration::from_millis(200);

/// How time passes.
#[derive(Clone, Debug)]
pub(super) enum Pace {
    /// `speed` simulated seconds per second, since a moment. That moment is moved if the simulation falls behind.
    Steady { speed: f64, since: Option<Instant>, is_late: bool },
    /// One command per period, or none after a deadline.
    LockStep { period: Duration, deadline: Duration },
}

impl Pace {
    /// The pace of a simulation whose steps take this long.
    ///
    /// # Errors
    /// If a period is no multiple of the step.
    pub(super) fn of(config: PaceConfig, step: Duration) -> Result<Self, Error> {
        // A span longer than any run counts as infinite.
        let span = |seconds: f64| Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX);
        match config {
            PaceConfig::Steady { speed } => Ok(Self::Steady { speed, since: None, is_late: false }),
            PaceConfig::LockStep { period_s, deadline_s } => {
                let period = span(period_s);
                if period.is_zero() || !period.as_nanos().is_multiple_of(step.as_nanos()) {
                    let message = format!("a period of {period_s} s is no multiple of the step");
                    return Err(Error::refused(message, format!("a step takes {} s", step.as_secs_f64())));
                }
                Ok(Self::LockStep { period, deadline: span(deadline_s) })
            }
        }
    }

    /// The time left until the simulated time `now` is due.
    pub(super) fn left(&mut self, now: Duration) -> Duration {
        let Self::Steady { speed, since, is_late } = self else { return Duration::ZERO };
        if speed.is_infinite() {
            return Duration::ZERO;
        }
        let passed = Duration::try_from_secs_f64(now.as_secs_f64() / *speed).unwrap_or(Duration::MAX);
        let begun = since.get_or_insert_with(|| network::now().checked_sub(passed).unwrap_or_else(network::now));
        let elapsed = begun.elapsed();
        if elapsed > passed.saturating_add(BEHIND) {
            // The simulation does not catch up: the nodes that drive could not react in time.
            *is_late = true;
            *begun += elapsed.saturating_sub(passed);
        }
        passed.saturating_sub(elapsed)
    }

    /// Continues after a pause, whose time does not count.
    pub(super) fn resume(&mut self) {
        if let Self::Steady { since, .. } = self {
            *since = None;
        }
    }

    /// Whether it has fallen behind.
    pub(super) fn is_late(&self) -> bool {
        matches!(self, Self::Steady { is_late: true, .. })
    }

    /// Whether the time `now` is published.
    pub(super) fn publishes(&self, now: Duration) -> bool {
        matches!(self, Self::Steady { .. }) || self.awaits(now)
    }

    /// Whether a period begins at the simulated time `now`, which needs a command.
    pub(super) fn awaits(&self, now: Duration) -> bool {
        matches!(self, Self::LockStep { period, .. } if now.as_nanos().is_multiple_of(period.as_nanos()))
    }
}

/// The commands that have come.
#[derive(Debug, Default)]
pub(super) struct Commands {
    waiting: VecDeque<Command>,
    /// The last command, and when it came, in simulated time.
    last: Option<(VelocityCommand, Duration)>,
}

/// An irregularity of the commands, which is noted once.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Oddity {
    /// A message cannot be read.
    Unreadable,
    /// A command has velocities that the base ignores: it only drives forwards and turns.
    Sideways,
    /// The stamp is too old.
    Old,
    /// The stamp is too far in the future.
    Ahead,
    /// There are more commands than periods.
    TooMany,
    /// The simulation is too slow.
    Behind,
    /// The topic has no publisher.
    Missing,
}

impl Commands {
    /// Takes a command that has come at a simulated time. Without lock step, it takes effect at once.
    pub(super) fn take(&mut self, command: Command, now: Duration, is_in_step: bool) -> Result<(), Oddity> {
        if is_in_step {
            self.waiting.push_back(command);
            return match self.waiting.len() > MOST_WAITING {
                true => self.waiting.pop_front().map_or(Ok(()), |_| Err(Oddity::TooMany)),
                false => Ok(()),
            };
        }
        match command.stamp.filter(|stamp| *stamp > Duration::ZERO) {
            Some(stamp) if stamp + STALE < now => return Err(Oddity::Old),
            Some(stamp) if stamp > now + STALE => return Err(Oddity::Ahead),
            _ => self.last = Some((command.velocity, now)),
        }
        Ok(())
    }

    /// The next command for the period that begins at a time, if it has come: one with this stamp, or the next one
    /// without a stamp.
    pub(super) fn of_period(&mut self, now: Duration) -> Option<Result<VelocityCommand, Oddity>> {
        let Command { velocity, stamp, .. } = self.waiting.pop_front()?;
        Some(match stamp {
            Some(stamp) if stamp < now => Err(Oddity::Old),
            Some(stamp) if stamp > now => Err(Oddity::Ahead),
            _ => {
                self.last = Some((velocity, now));
                Ok(velocity)
            }
        })
    }

    /// The velocity that was commanded last; `None` if that is too long ago.
    pub(super) fn last(&mut self, now: Duration) -> Option<VelocityCommand> {
        self.last.filter(|(_, since)| now.saturating_sub(*since) <= STALE).map(|(velocity, _)| velocity)
    }

    /// Forgets the last command. Returns whether it moved the base.
    pub(super) fn forget(&mut self) -> bool {
        self.last.take().is_some_and(|(velocity, _)| velocity != VelocityCommand::STOP)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn command(linear_mps: f64, stamp_ms: Option<u64>) -> Command {
        let velocity = VelocityCommand { linear_mps, angular_radps: 0.0 };
        Command { velocity, stamp: stamp_ms.map(Duration::from_millis), is_partial: false }
    }

    const fn ms(ms: u64) -> Duration {
        Duration::from_millis(ms)
    }

    #[test]
    fn in_lock_step_each_period_has_the_command_with_its_stamp_or_the_next_without_one() {
        let mut commands = Commands::default();
        for one in [command(0.1, Some(100)), command(0.2, Some(300)), command(0.3, Some(200)), command(0.4, None)] {
            assert_eq!(commands.take(one, ms(200), true), Ok(()));
        }
        let mut next = || commands.of_period(ms(200)).map(|found| found.map(|velocity| velocity.linear_mps));
        assert_eq!([next(), next()], [Some(Err(Oddity::Old)), Some(Err(Oddity::Ahead))]);
        assert_eq!([next(), next(), next()], [Some(Ok(0.3)), Some(Ok(0.4)), None]);
        let taken = (0..=MOST_WAITING).map(|_| commands.take(command(0.5, None), ms(200), true)).last();
        assert_eq!(taken, Some(Err(Oddity::TooMany)));
    }

    #[test]
    fn without_lock_step_a_command_takes_effect_at_once_until_it_is_stale() {
        let mut commands = Commands::default();
        assert_eq!(commands.take(command(0.1, Some(400)), ms(1000), false), Err(Oddity::Old));
        assert_eq!(commands.take(command(0.1, Some(1600)), ms(1000), false), Err(Oddity::Ahead));
        assert_eq!(commands.last(ms(1000)), None);
        for stamp in [None, Some(0), Some(900)] {
            assert_eq!(commands.take(command(0.2, stamp), ms(1000), false), Ok(()));
        }
        assert_eq!(commands.last(ms(1500)).map(|velocity| velocity.linear_mps), Some(0.2));
        assert_eq!((commands.last(ms(1501)), commands.forget(), commands.forget()), (None, true, false));
    }

    #[test]
    fn periods_begin_at_their_multiples() {
        let pace = Pace::LockStep { period: ms(100), deadline: ms(1) };
        assert_eq!([20, 100, 120, 200].map(|now| pace.awaits(ms(now))), [false, true, false, true]);
        let steady = |speed| Pace::Steady { speed, since: None, is_late: false };
        let mut pace = steady(f64::INFINITY);
        assert_eq!((pace.left(ms(20)), pace.left(ms(1_000_000)), pace.awaits(ms(100))), (ms(0), ms(0), false));
        // The first call is the beginning.
        assert!(steady(5e-324).left(ms(20)) > Duration::MAX / 2);
        let mut pace = steady(1.0);
        assert!(pace.left(ms(20)) <= ms(20) && pace.left(ms(5000)) > ms(1000) && !pace.is_late());
        let mut pace = Pace::Steady { speed: 1.0, since: network::now().checked_sub(ms(900)), is_late: false };
        assert!(pace.left(ms(20)).is_zero() && pace.is_late() && pace.left(ms(1020)) > ms(500));
    }

    #[test]
    fn the_time_of_a_pause_does_not_count() {
        let mut pace = Pace::Steady { speed: 1.0, since: network::now().checked_sub(ms(5000)), is_late: false };
        pace.resume();
        assert!(pace.left(ms(1020)).is_zero() && !pace.is_late(), "the first step is due at once");
        assert!(pace.left(ms(2020)) > ms(900) && !pace.is_late());
    }
}
