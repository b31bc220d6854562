//! Errors in the input of this crate.

/// Why a localization or a navigator cannot be built.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A parameter has an invalid value.
    #[error("{name} is {value}, but must be {expected}")]
    Parameter {
        /// Name of the parameter, as in its struct.
        name: &'static str,
        /// The value that was given.
        value: f64,
        /// The accepted values.
        expected: &'static str,
    },
    /// The map has no free cell.
    #[error("the map has no free cell for the robot")]
    NoFreeSpace,
}

/// Checks parameters; the first invalid one is the error.
pub(crate) fn check(rules: &[(&'static str, f64, bool, &'static str)]) -> Result<(), Error> {
    match rules.iter().find(|(.., holds, _)| !holds) {
        Some(&(name, value, _, expected)) => Err(Error::Parameter { name, value, expected }),
        None => Ok(()),
    }
}
