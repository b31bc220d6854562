//! Trips that navigation gave up.

use std::time::Duration;

use components::Software;
use nav::{GiveUpReason, NavigationStatus};

/// A trip that navigation gave up.
#[derive(Clone, Debug, PartialEq)]
pub struct GivenUp {
    /// Since the start of the run.
    pub time: Duration,
    /// Why.
    pub reason: GiveUpReason,
}

/// All trips that navigation gave up.
#[derive(Clone, Debug, Default)]
pub(crate) struct GivenUps {
    all: Vec<GivenUp>,
    /// Whether navigation had given up in the step before, and has done nothing else since.
    before: bool,
}

impl GivenUps {
    /// Notes whether navigation has just given up.
    pub(crate) fn note(&mut self, software: &Software, time: Duration) {
        let gave_up = matches!(software.navigation_status(), NavigationStatus::Aborted | NavigationStatus::Error);
        if let Some(reason) = software.navigation_reason().filter(|_| gave_up && !self.before) {
            self.all.push(GivenUp { time, reason });
        }
        self.before = gave_up;
    }

    pub(crate) fn all(&self) -> &[GivenUp] {
        &self.all
    }
}
