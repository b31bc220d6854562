//! The components that can be frozen or restarted: faults of the software itself.

use crate::{BATTERY_READER, LOCALIZATION, NAVIGATION};

/// A component.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Component {
    /// BatteryReader.
    BatteryReader,
    /// Localization.
    Localization,
    /// Navigation.
    Navigation,
}

impl Component {
    /// All components.
    pub const ALL: [Self; 3] = [Self::BatteryReader, Self::Localization, Self::Navigation];

    /// The name of its process.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::BatteryReader => BATTERY_READER,
            Self::Localization => LOCALIZATION,
            Self::Navigation => NAVIGATION,
        }
    }

    /// The component whose process has this name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|component| component.name() == name)
    }
}
