//! Trips that navigation abandons.

use components::Software;
use nav::{GiveUpReason, NavigationStatus};

/// Watches for trips that navigation abandons.
#[derive(Clone, Debug, Default)]
pub(crate) struct GivenUps {
    /// Whether navigation had given up in the previous step and has done nothing else since.
    before: bool,
}

impl GivenUps {
    /// The reason, if navigation has just given up.
    pub(crate) fn note(&mut self, software: &Software) -> Option<GiveUpReason> {
        let gave_up = matches!(software.navigation_status(), NavigationStatus::Aborted | NavigationStatus::Error);
        let is_new = gave_up && !self.before;
        self.before = gave_up;
        software.navigation_reason().filter(|_| is_new)
    }
}
