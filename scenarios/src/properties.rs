//! The properties that scenarios can watch.

use channels::{Topology, WiringError};
use monitors::{PhiTwo, Property};

/// The names of all properties.
pub(crate) const NAMES: [&str; 2] = ["phi1", "phi2"];

/// The property of that name with its monitor, for a system of this topology.
///
/// # Errors
/// [`WiringError::MissingChannel`] if the property speaks of a channel that is not there.
///
/// # Panics
/// If the name is none of [`NAMES`].
pub(crate) fn build(name: &str, topology: &Topology) -> Result<Property, WiringError> {
    match name {
        "phi1" => monitors::phi1(topology, 20),
        "phi2" => monitors::phi2(topology, PhiTwo::default()),
        _ => unreachable!("unknown properties are refused when a scenario is loaded"),
    }
}
