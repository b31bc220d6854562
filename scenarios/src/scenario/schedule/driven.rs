//! The data that drivers give to the built-in components.

use std::time::Duration;

use channels::{ChannelSystem, Process, ProcessId};
use components::{BATTERY_READER, BatteryReader, LOCALIZATION, Localization, NAVIGATION, Navigation, TripStatus};
use robot::BatteryState;

/// The data that drivers give to the built-in components between two steps.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DriverData {
    /// The level given to BatteryReader, in percent, and whether the battery is being charged.
    pub battery: Option<(f64, bool)>,
    /// Where Localization believes the robot to be.
    pub place: Option<String>,
    /// The status of the trip, if there is one.
    pub trip: Option<TripStatus>,
}

/// The built-in components of a system that receive data from drivers.
pub fn driven(system: &ChannelSystem) -> Vec<ProcessId> {
    let found = [
        process_of::<BatteryReader>(system, BATTERY_READER),
        process_of::<Localization>(system, LOCALIZATION),
        process_of::<Navigation>(system, NAVIGATION),
    ];
    found.into_iter().flatten().collect()
}

/// The process with this name, if it is the built-in one.
pub fn process_of<P: Process>(system: &ChannelSystem, name: &str) -> Option<ProcessId> {
    system.topology().find_process(name).filter(|id| system.process::<P>(*id).is_some())
}

impl DriverData {
    /// The data that the components of a system received last.
    pub fn of(system: &ChannelSystem) -> Self {
        let id = |name| system.topology().find_process(name);
        Self::received_by(
            id(BATTERY_READER).and_then(|id| system.process(id)),
            id(LOCALIZATION).and_then(|id| system.process(id)),
            id(NAVIGATION).and_then(|id| system.process(id)),
        )
    }

    /// The data that these components received last.
    pub fn received_by(
        battery: Option<&BatteryReader>,
        localization: Option<&Localization>,
        navigation: Option<&Navigation>,
    ) -> Self {
        Self {
            battery: battery.and_then(BatteryReader::reading),
            place: localization.and_then(Localization::place).map(str::to_owned),
            trip: navigation.and_then(Navigation::trip_status),
        }
    }

    /// Gives this data to a component. Localization knows the `known` places.
    pub fn update(&self, process: &mut dyn Process, known: &[String]) {
        let process = process.as_any_mut();
        if let (Some(reader), Some((charge_pct, charging))) = (process.downcast_mut::<BatteryReader>(), self.battery) {
            reader.update(&BatteryState { time: Duration::ZERO, charge_pct, charging });
        }
        if let Some(localization) = process.downcast_mut::<Localization>() {
            localization.set_place(known.iter().map(String::as_str), self.place.as_deref());
        }
        if let Some(navigation) = process.downcast_mut::<Navigation>() {
            while navigation.next_order().is_some() {}
            self.trip.into_iter().for_each(|status| navigation.set_trip_status(status));
        }
    }
}
