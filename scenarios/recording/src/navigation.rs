//! What navigation is doing.

use serde::{Deserialize, Serialize};

/// The status of navigation, and its reason.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Navigation {
    /// Its status.
    pub status: NavigationStatus,
    /// Why it has given up or has no path, in words.
    pub reason: Option<String>,
    /// The recovery behavior that is running: `back_up`.
    pub recovery: Option<String>,
}

impl Navigation {
    /// The status with the reason and the recovery behavior, in words: `failing (back up): there is no path to the
    /// goal`.
    #[must_use]
    pub fn words(&self) -> String {
        let mut words = self.status.words();
        if let Some(recovery) = &self.recovery {
            words += &format!(" ({})", recovery.replace('_', " "));
        }
        if let Some(reason) = &self.reason {
            words += &format!(": {reason}");
        }
        words
    }
}

/// The status of navigation. It is written by its name in the original system: `waiting_obstacle`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub enum NavigationStatus {
    /// Nothing to do.
    Idle,
    /// Turning in place to the direction of the path.
    PreparingBeforeMove,
    /// Driving along the path.
    Moving,
    /// Standing still because of an obstacle.
    WaitingObstacle,
    /// At rest at the goal.
    GoalReached,
    /// Given up.
    Aborted,
    /// There is no path.
    Failing,
    /// Standing still because of a command to pause.
    Paused,
    /// Searching for a path.
    Thinking,
    /// Cannot navigate at all.
    Error,
}

impl NavigationStatus {
    const ALL: [Self; 10] = [
        Self::Idle,
        Self::PreparingBeforeMove,
        Self::Moving,
        Self::WaitingObstacle,
        Self::GoalReached,
        Self::Aborted,
        Self::Failing,
        Self::Paused,
        Self::Thinking,
        Self::Error,
    ];

    fn name(self) -> &'static str {
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

    /// The status in words: `waiting obstacle`.
    #[must_use]
    pub fn words(self) -> String {
        self.name().replace('_', " ")
    }
}

impl From<NavigationStatus> for String {
    fn from(status: NavigationStatus) -> Self {
        status.name().to_owned()
    }
}

impl TryFrom<String> for NavigationStatus {
    type Error = String;

    fn try_from(name: String) -> Result<Self, String> {
        let found = Self::ALL.into_iter().find(|status| status.name() == name);
        found.ok_or_else(|| format!("navigation has no status `{name}`"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_words_contain_the_reason_and_the_behavior() {
        let status = NavigationStatus::PreparingBeforeMove;
        let mut navigation = Navigation { status, reason: None, recovery: None };
        assert_eq!(navigation.words(), "preparing before move");
        navigation.status = NavigationStatus::Failing;
        navigation.reason = Some("there is no path to the goal".to_owned());
        navigation.recovery = Some("back_up".to_owned());
        assert_eq!(navigation.words(), "failing (back up): there is no path to the goal");
    }

    #[test]
    fn a_status_is_written_by_its_name() {
        for status in NavigationStatus::ALL {
            let written = serde_json::to_string(&status).unwrap();
            assert_eq!(written, format!("{:?}", status.name()));
            assert_eq!(serde_json::from_str::<NavigationStatus>(&written).unwrap(), status);
        }
        assert!(serde_json::from_str::<NavigationStatus>("\"flying\"").is_err());
    }
}
