//! The status of a navigator, and why it gave up.

use std::time::Duration;

use crate::PlanError;

/// The status of a navigator; the names are those of the original system.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum NavigationStatus {
    /// Nothing to do.
    #[default]
    Idle,
    /// Turning in place to the direction of the path.
    PreparingBeforeMove,
    /// Driving along the path.
    Moving,
    /// Standing still because of an obstacle, which may go away.
    WaitingObstacle,
    /// At rest at the goal, until the next start or stop.
    GoalReached,
    /// Given up, until the next start or stop, for the [reason](crate::Navigator::reason) of the navigator.
    Aborted,
    /// There is no path: tries to find one with [recovery behaviors](crate::Recovery) for a while.
    Failing,
    /// Searching for a path.
    Thinking,
    /// Cannot navigate at all, until the next start or stop, for the [reason](crate::Navigator::reason) of the
    /// navigator.
    Error,
}

impl NavigationStatus {
    /// The name in the original system, for example `goal_reached`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Idle => "idle",
            Self::PreparingBeforeMove => "preparing_before_move",
            Self::Moving => "moving",
            Self::WaitingObstacle => "waiting_obstacle",
            Self::GoalReached => "goal_reached",
            Self::Aborted => "aborted",
            Self::Failing => "failing",
            Self::Thinking => "thinking",
            Self::Error => "error",
        }
    }

    /// Whether there is a goal that the navigator has neither reached nor given up.
    #[must_use]
    pub fn is_under_way(self) -> bool {
        !matches!(self, Self::Idle | Self::GoalReached | Self::Aborted | Self::Error)
    }
}

impl std::fmt::Display for NavigationStatus {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(self.name())
    }
}

/// Why a navigator gave up or cannot navigate.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GiveUpReason {
    /// There is no path.
    #[error(transparent)]
    NoPlan(#[from] PlanError),
    /// The goal is in an area to keep out of, or too near to one.
    #[error("the goal is in an area to keep out of, or too near to one")]
    GoalInZone,
    /// The robot has not come nearer, although it sees no obstacle in its way.
    #[error("no progress in {} s", .0.as_secs())]
    NoProgress(Duration),
    /// The path was blocked too often.
    #[error("the path was blocked {0} times")]
    BlockedTooOften(u32),
    /// The goal has numbers that are not finite, or tolerances that are not positive.
    #[error("the goal has invalid numbers")]
    BadGoal,
    /// The estimate of the pose is not finite.
    #[error("the pose is unknown")]
    BadEstimate,
    /// The lasers that look ahead are silent.
    #[error("no laser has seen the space ahead for {} ms", .0.as_millis())]
    NoScans(Duration),
}
