//! The measurements of every run.

use serde::{Deserialize, Serialize};

/// A number that is measured in every run: a column of the dataset.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Measure {
    /// When the robot came to rest where the scenario stops.
    ArrivedS,
    /// The lowest charge of the battery.
    BatteryMinimumPct,
    /// Distance driven.
    DistanceM,
    /// Contacts of the robot with anything else.
    Collisions,
    /// Root mean square of the localization error.
    LocalizationRmseM,
    /// Its greatest error.
    LocalizationMaxM,
}

impl Measure {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::ArrivedS,
        Self::BatteryMinimumPct,
        Self::DistanceM,
        Self::Collisions,
        Self::LocalizationRmseM,
        Self::LocalizationMaxM,
    ];

    /// The column's name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::ArrivedS => "arrived_s",
            Self::BatteryMinimumPct => "battery_minimum_pct",
            Self::DistanceM => "distance_m",
            Self::Collisions => "collisions",
            Self::LocalizationRmseM => "localization_rmse_m",
            Self::LocalizationMaxM => "localization_max_m",
        }
    }

    /// A description with its unit.
    #[must_use]
    pub fn about(self) -> &'static str {
        match self {
            Self::ArrivedS => "time of arrival, s",
            Self::BatteryMinimumPct => "lowest charge of the battery, %",
            Self::DistanceM => "distance driven, m",
            Self::Collisions => "collisions",
            Self::LocalizationRmseM => "localization error (RMSE), m",
            Self::LocalizationMaxM => "greatest localization error, m",
        }
    }
}
