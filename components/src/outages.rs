//! Components that freeze or restart: faults of the software itself.

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

/// The components whose drivers are frozen, like a node that hangs.
///
/// The component's process continues to answer with the data it received last. To freeze the process too, suspend it
/// ([`channels::ChannelSystem::suspend`]).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Outages {
    /// BatteryReader gets no readings of the battery.
    pub battery_reader: bool,
    /// The pose estimate and the data of Localization stay unchanged. Odometry and scans are lost; the first odometry
    /// afterwards includes the distance driven in the meantime.
    pub localization: bool,
    /// No velocity is commanded, so the base stands still, as with a command watchdog. Orders wait, and Navigation gets
    /// no status of its trip. Laser scans are still recorded: a queue would deliver them as soon as the driver
    /// continues.
    pub navigation: bool,
}

impl Outages {
    /// Whether this component's driver is frozen.
    #[must_use]
    pub fn has(&self, component: Component) -> bool {
        match component {
            Component::BatteryReader => self.battery_reader,
            Component::Localization => self.localization,
            Component::Navigation => self.navigation,
        }
    }

    /// Freezes this component's driver, or lets it continue.
    pub fn set(&mut self, component: Component, out: bool) {
        *match component {
            Component::BatteryReader => &mut self.battery_reader,
            Component::Localization => &mut self.localization,
            Component::Navigation => &mut self.navigation,
        } = out;
    }
}
