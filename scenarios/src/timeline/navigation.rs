//! What navigation is doing, and why.

use components::Software;
use nav::{GiveUpReason, NavigationStatus, Recovery};

/// What navigation is doing, and why.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Navigation {
    /// Its status.
    pub status: NavigationStatus,
    /// Why it has given up, or has no way.
    pub reason: Option<GiveUpReason>,
    /// By what behaviour it is trying to get a way.
    pub recovery: Option<Recovery>,
}

impl Navigation {
    /// What the navigation of a robot's software is doing.
    pub(super) fn of(software: &Software) -> Self {
        Self {
            status: software.navigation_status(),
            reason: software.navigation_reason(),
            recovery: software.recovery(),
        }
    }

    /// The status with the reason and the behaviour, in words: `failing (back up): no way leads to the goal`.
    #[must_use]
    pub fn words(&self) -> String {
        let mut words = self.status.name().replace('_', " ");
        if let Some(recovery) = self.recovery {
            words += &format!(" ({})", recovery.name().replace('_', " "));
        }
        if let Some(reason) = self.reason {
            words += &format!(": {reason}");
        }
        words
    }
}

#[cfg(test)]
mod tests {
    use nav::PlanError;

    use super::*;

    #[test]
    fn words_tell_the_reason_and_the_behaviour() {
        let mut navigation = Navigation { status: NavigationStatus::PreparingBeforeMove, reason: None, recovery: None };
        assert_eq!(navigation.words(), "preparing before move");
        navigation.status = NavigationStatus::Failing;
        navigation.reason = Some(PlanError::NoPath.into());
        navigation.recovery = Some(Recovery::BackUp);
        assert_eq!(navigation.words(), "failing (back up): no way leads to the goal");
    }
}
