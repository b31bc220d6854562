//! What is counted over the steps of a run.

use std::time::Duration;

use crate::{Battery, RobotState, Truth};

/// Aggregates over the steps of a run.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    battery: Option<BatteryTally>,
    /// The present error of localization, squared, in position and heading; none unless both poses are known.
    error: Option<(f64, f64)>,
    /// The number of steps with such an error.
    localized: u64,
    squared_m2: f64,
    max_m: f64,
    squared_rad2: f64,
}

/// The charge of the battery over the steps of a run.
#[derive(Clone, Copy, Debug)]
pub struct BatteryTally {
    /// At the start, in percent.
    pub initial_pct: f64,
    /// The lowest so far, in percent.
    pub minimum_pct: f64,
    /// When it was empty for the first time, if it was: then the robot stands still.
    pub empty_at: Option<Duration>,
}

/// The error of localization over the steps of a run.
#[derive(Clone, Copy, Debug)]
pub struct LocalizationError {
    /// Root mean square of the error in position, in meters.
    pub rmse_m: f64,
    /// Its maximum, in meters.
    pub max_m: f64,
    /// Root mean square of the error in heading, in radians.
    pub rmse_rad: f64,
}

impl Tally {
    /// Takes note of the robot's state and of what has changed in it.
    pub(crate) fn note(&mut self, now: Duration, robot: &RobotState, changes: &RobotState) {
        if let Some(Battery { charge_pct, .. }) = changes.battery {
            let first = BatteryTally { initial_pct: charge_pct, minimum_pct: charge_pct, empty_at: None };
            let battery = self.battery.get_or_insert(first);
            battery.minimum_pct = battery.minimum_pct.min(charge_pct);
            battery.empty_at = battery.empty_at.or((charge_pct <= 0.0).then_some(now));
        }
        if changes.pose().is_some() {
            self.error = robot.truth.zip(robot.estimate).map(|(Truth { pose, .. }, estimate)| {
                let turn_rad = maps::wrap_angle(maps::heading(&pose) - maps::heading(&estimate));
                ((pose.translation.vector - estimate.translation.vector).norm_squared(), turn_rad * turn_rad)
            });
        }
    }

    pub(crate) fn count_step(&mut self) {
        let Some((squared_m2, squared_rad2)) = self.error else { return };
        self.localized += 1;
        self.squared_m2 += squared_m2;
        self.squared_rad2 += squared_rad2;
        self.max_m = self.max_m.max(squared_m2.sqrt());
    }

    /// The battery's charge; none if it was never known.
    #[must_use]
    pub fn battery(&self) -> Option<BatteryTally> {
        self.battery
    }

    /// The error of localization; none if the true or the estimated pose was never known.
    #[must_use]
    pub fn localization_error(&self) -> Option<LocalizationError> {
        let steps = self.localized as f64;
        (self.localized > 0).then(|| LocalizationError {
            rmse_m: (self.squared_m2 / steps).sqrt(),
            max_m: self.max_m,
            rmse_rad: (self.squared_rad2 / steps).sqrt(),
        })
    }
}
