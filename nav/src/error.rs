//! What can be wrong with what this crate is given.

/// Why a localization or a navigator cannot be built.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A parameter has a value that makes no sense.
    #[error("{name} is {value}, but must be {expected}")]
    Parameter {
        /// Name of the parameter, as in its struct.
        name: &'static str,
        /// The value that was given.
        value: f64,
        /// What would be accepted.
        expected: &'static str,
    },
    /// The map has no free cell, so there is nowhere to be.
    #[error("the map has no free cell, so the robot cannot be anywhere on it")]
    NoFreeSpace,
}

/// Holds parameters to what they must be; the first that fails is the error.
pub(crate) fn check(rules: &[(&'static str, f64, bool, &'static str)]) -> Result<(), Error> {
    match rules.iter().find(|(.., holds, _)| !holds) {
        Some(&(name, value, _, expected)) => Err(Error::Parameter { name, value, expected }),
        None => Ok(()),
    }
}
