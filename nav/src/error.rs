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

/// What a parameter must be.
pub(crate) struct Requirement {
    name: &'static str,
    value: f64,
    is_met: bool,
    expected: &'static str,
}

pub(crate) fn require(name: &'static str, value: f64, is_met: bool, expected: &'static str) -> Requirement {
    Requirement { name, value, is_met, expected }
}

pub(crate) fn positive(name: &'static str, value: f64) -> Requirement {
    require(name, value, value > 0.0 && value.is_finite(), "positive")
}

pub(crate) fn at_least_zero(name: &'static str, value: f64) -> Requirement {
    require(name, value, value >= 0.0 && value.is_finite(), "zero or positive")
}

pub(crate) fn share(name: &'static str, value: f64) -> Requirement {
    require(name, value, (0.0..=1.0).contains(&value), "from 0 to 1")
}

/// Checks parameters; the first invalid one is the error.
pub(crate) fn check(requirements: &[Requirement]) -> Result<(), Error> {
    match requirements.iter().find(|requirement| !requirement.is_met) {
        Some(&Requirement { name, value, expected, .. }) => Err(Error::Parameter { name, value, expected }),
        None => Ok(()),
    }
}
