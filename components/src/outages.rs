//! Components that stand still or start anew: faults of the software itself.

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

    /// The component whose process has that name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|component| component.name() == name)
    }
}

/// Which components' drivers stand still, as a node that hangs does.
///
/// The component's process goes on answering with what it was told last; to have it hang too, suspend it
/// ([`channels::ChannelSystem::suspend`]).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Outages {
    /// Nobody hands the battery's readings to BatteryReader.
    pub battery_reader: bool,
    /// The pose estimate stays as it is, and so does what Localization is told. Odometry and scans pass by; the
    /// distance driven meanwhile is made up for with the first odometry afterwards.
    pub localization: bool,
    /// No velocity is commanded, so that the base stands still, as one with a command watchdog does; orders wait, and
    /// Navigation is not told how its trip stands. What the lasers see is noted all the same: a queue would deliver it
    /// the moment the driver goes on.
    pub navigation: bool,
}

impl Outages {
    /// Whether that component's driver stands still.
    #[must_use]
    pub fn has(&self, component: Component) -> bool {
        match component {
            Component::BatteryReader => self.battery_reader,
            Component::Localization => self.localization,
            Component::Navigation => self.navigation,
        }
    }

    /// Lets that component's driver stand still, or go on.
    pub fn set(&mut self, component: Component, out: bool) {
        *match component {
            Component::BatteryReader => &mut self.battery_reader,
            Component::Localization => &mut self.localization,
            Component::Navigation => &mut self.navigation,
        } = out;
    }
}
