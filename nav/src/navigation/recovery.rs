//! The recovery behaviors of Nav2's trees.

use std::time::Duration;

use maps::{Point, heading, wrap_angle};
use robot::VelocityCommand;

use super::now::Now;

/// How far the robot backs up, in meters, as in Nav2's trees, farther by this much each time, and how fast, in m/s. In
/// a narrow place it blocks the people for whom it waits, until it has left.
const BACK_UP_M: f64 = 0.3;
const BACK_UP_MPS: f64 = 0.12;

/// How fast the robot spins, in rad/s.
const SPIN_RADPS: f64 = 0.8;

/// Time for the lasers to see the remaining obstacles again after the costmap has been cleared.
const SEE_AGAIN: Duration = Duration::from_millis(300);

/// How long the robot waits, as in Nav2's trees.
const WAIT: Duration = Duration::from_secs(5);

/// The time limit of a behavior that moves the robot.
const LONGEST: Duration = Duration::from_secs(10);

/// A behavior by which a navigator without a path tries to find one; names as in Nav2.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Recovery {
    /// Forgets the obstacles that the lasers have seen, some of them perhaps long ago, and observes again.
    ClearCostmap,
    /// Waits: people walk on, doors open.
    Wait,
    /// Drives back a little, as far as the lasers see free space.
    BackUp,
    /// Turns once around.
    Spin,
}

impl Recovery {
    /// The order in which they are performed, repeatedly.
    const ORDER: [Self; 6] = [Self::ClearCostmap, Self::Wait, Self::BackUp, Self::ClearCostmap, Self::Spin, Self::Wait];

    /// The name, for example `back_up`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::ClearCostmap => "clear_costmap",
            Self::Wait => "wait",
            Self::BackUp => "back_up",
            Self::Spin => "spin",
        }
    }

    /// The behavior with this number, counted from 0.
    pub(super) fn nth(number: usize) -> Self {
        Self::ORDER[number % Self::ORDER.len()]
    }

    /// The index of the first behavior that moves the robot.
    pub(super) const FIRST_THAT_MOVES: usize = 2;
}

/// A recovery behavior in progress.
#[derive(Clone, Copy, Debug)]
pub(super) struct Attempt {
    pub(super) recovery: Recovery,
    since: Duration,
    from: Point,
    back_up_m: f64,
    /// The heading at the last step, and how far the robot has turned, in radians.
    heading_rad: f64,
    turned_rad: f64,
}

impl Attempt {
    pub(super) fn begin(number: usize, now: &Now<'_>) -> Self {
        Self {
            recovery: Recovery::nth(number),
            since: now.time,
            from: now.position(),
            back_up_m: BACK_UP_M * (1 + number / Recovery::ORDER.len()) as f64,
            heading_rad: heading(now.at),
            turned_rad: 0.0,
        }
    }

    /// The velocity to drive at, or `None` if it is finished.
    pub(super) fn step(&mut self, now: &Now<'_>, free_behind: impl Fn() -> bool) -> Option<VelocityCommand> {
        let lasted = now.time.saturating_sub(self.since);
        match self.recovery {
            Recovery::ClearCostmap => (lasted < SEE_AGAIN).then_some(VelocityCommand::STOP),
            Recovery::Wait => (lasted < WAIT).then_some(VelocityCommand::STOP),
            Recovery::BackUp => {
                let near = (now.position() - self.from).norm() < self.back_up_m;
                let goes_on = lasted < LONGEST && near && free_behind();
                goes_on.then_some(VelocityCommand { linear_mps: -BACK_UP_MPS, angular_radps: 0.0 })
            }
            Recovery::Spin => {
                self.turned_rad += wrap_angle(heading(now.at) - self.heading_rad);
                self.heading_rad = heading(now.at);
                let goes_on = lasted < LONGEST && self.turned_rad < std::f64::consts::TAU;
                goes_on.then_some(VelocityCommand { linear_mps: 0.0, angular_radps: SPIN_RADPS })
            }
        }
    }
}
