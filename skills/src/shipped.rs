//! The machines of the shipped tree's seven leaves.

/// The shipped machines: the name of the leaf, and the text of its file `<name>.scxml`.
pub const SHIPPED: [(&str, &str); 7] = [
    ("BatteryLevel", include_str!("../machines/BatteryLevel.scxml")),
    ("BatteryNotCharging", include_str!("../machines/BatteryNotCharging.scxml")),
    ("AtRechargingStation", include_str!("../machines/AtRechargingStation.scxml")),
    ("GotoRechargingStation", include_str!("../machines/GotoRechargingStation.scxml")),
    ("WaitForUser", include_str!("../machines/WaitForUser.scxml")),
    ("AtDestination", include_str!("../machines/AtDestination.scxml")),
    ("GoToDestination", include_str!("../machines/GoToDestination.scxml")),
];

/// The machines that follow the protocol of the paper's published system: the name of the leaf, and the text of its
/// file `original/<name>.scxml`. The seventh leaf has no skill there.
pub const ORIGINAL: [(&str, &str); 6] = [
    ("BatteryLevel", include_str!("../machines/original/BatteryLevel.scxml")),
    ("BatteryNotCharging", include_str!("../machines/original/BatteryNotCharging.scxml")),
    ("AtRechargingStation", include_str!("../machines/original/AtRechargingStation.scxml")),
    ("GotoRechargingStation", include_str!("../machines/original/GotoRechargingStation.scxml")),
    ("AtDestination", include_str!("../machines/original/AtDestination.scxml")),
    ("GoToDestination", include_str!("../machines/original/GoToDestination.scxml")),
];

/// The text of the shipped machine for the leaf with this name.
#[must_use]
pub fn shipped(leaf: &str) -> Option<&'static str> {
    SHIPPED.iter().find(|(name, _)| *name == leaf).map(|(_, text)| *text)
}
