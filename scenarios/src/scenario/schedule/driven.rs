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
    /// Where the robot is according to Localization.
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
        Self::inside(system, |process| process)
    }

    /// The same of a system with wrapped components, which `unwrap` unwraps.
    pub fn inside(system: &ChannelSystem, unwrap: fn(&dyn Process) -> &dyn Process) -> Self {
        let component = |name| Some(unwrap(system.any_process(system.topology().find_process(name)?)?).as_any());
        let [battery, localization, navigation] = [BATTERY_READER, LOCALIZATION, NAVIGATION].map(component);
        Self {
            battery: battery.and_then(|battery| battery.downcast_ref::<BatteryReader>()?.reading()),
            place: localization.and_then(|process| process.downcast_ref::<Localization>()?.place()).map(str::to_owned),
            trip: navigation.and_then(|navigation| navigation.downcast_ref::<Navigation>()?.trip_status()),
        }
    }

    /// Gives this data to a component. The `known` places are those of Localization.
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
