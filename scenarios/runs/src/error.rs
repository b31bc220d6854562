//! Why a run cannot continue.

use diagnostics::Problem;
use scenarios::Error;

/// Why a run cannot continue.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StepError {
    /// The processes cannot continue.
    #[error(transparent)]
    Run(#[from] channels::RunError),
    /// There have been more communications than the scenario allows.
    #[error("there have been more than {0} communications")]
    Budget(u64),
    /// The schedule that it follows requires something impossible.
    #[error("{0}")]
    Schedule(Problem),
}

impl From<StepError> for Error {
    fn from(error: StepError) -> Self {
        match error {
            StepError::Run(error) => error.into(),
            StepError::Budget(limit) => Self::Budget(limit),
            StepError::Schedule(problem) => Self::bad_input(problem),
        }
    }
}
