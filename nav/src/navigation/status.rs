//! What a navigator is doing, and why it gave up.

use std::time::Duration;

use crate::PlanError;

/// What a navigator is doing; the names are those of the original system.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum NavigationStatus {
    /// Nothing to do.
    #[default]
    Idle,
    /// Turning in place to where the path leads.
    PreparingBeforeMove,
    /// Driving along the path.
    Moving,
    /// Standing, because something is in the way; it may go away.
    WaitingObstacle,
    /// At rest at the goal. Stays until the next start or stop.
    GoalReached,
    /// Given up; [`Navigator::reason`](crate::Navigator::reason) says why. Stays until the next start or stop.
    Aborted,
    /// There is no way: tries to get one by [recovery behaviours](crate::Recovery), for a while.
    Failing,
    /// Standing, because it was told to pause.
    Paused,
    /// Looking for a path.
    Thinking,
    /// Cannot navigate at all; [`Navigator::reason`](crate::Navigator::reason) says why. Stays until the next start
    /// or stop.
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
            Self::Paused => "paused",
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
    /// The robot has not come nearer, though nothing that it sees is in its way.
    #[error("no progress in {} s", .0.as_secs())]
    NoProgress(Duration),
    /// The way was blocked again and again.
    #[error("the way was blocked {0} times")]
    BlockedTooOften(u32),
    /// The goal has numbers that are not finite, or tolerances that are not positive.
    #[error("the goal has numbers that make no sense")]
    BadGoal,
    /// The estimate of the pose is not finite.
    #[error("the pose is not known")]
    BadEstimate,
    /// The lasers that look ahead are silent.
    #[error("no laser has seen what is ahead for {} ms", .0.as_millis())]
    NoScans(Duration),
}
