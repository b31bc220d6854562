//! Why a command could not be carried out, and the corresponding exit status.

use std::io;
use std::path::PathBuf;

use diagnostics::Problem;
use miette::Diagnostic;

/// Why runs could not be carried out or shown.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file or an argument is wrong, or a run cannot continue.
    #[error(transparent)]
    Scenario(#[from] scenarios::Error),
    /// A run cannot be shown.
    #[error(transparent)]
    Report(#[from] reports::Error),
}

impl Error {
    /// The error for one diagnostic.
    #[must_use]
    pub fn bad_input(diagnostic: impl Diagnostic + Send + Sync + 'static) -> Self {
        scenarios::Error::bad_input(diagnostic).into()
    }

    /// Bad input without a location in a file, with help on what would be accepted.
    #[must_use]
    pub fn refused(message: impl Into<String>, help: impl Into<String>) -> Self {
        Self::bad_input(Problem::new(message).with_help(help))
    }

    /// A file that could not be written, with the operating system's error.
    pub(crate) fn unwritten(path: impl Into<PathBuf>, source: io::Error) -> Self {
        diagnostics::Error::Write { path: path.into(), source }.into()
    }

    /// The problems of the input, one diagnostic each; none for other errors.
    #[must_use]
    pub fn diagnostics(&self) -> Vec<&dyn Diagnostic> {
        match self {
            Self::Scenario(scenarios::Error::BadInput(all)) => {
                all.iter().map(|diagnostic| -> &dyn Diagnostic { &**diagnostic }).collect()
            }
            Self::Report(error @ reports::Error::Recording(_)) => vec![error],
            Self::Report(reports::Error::File(error @ diagnostics::Error::Overwrites { .. })) => vec![error],
            _ => Vec::new(),
        }
    }

    /// Everything that is wrong, on one line.
    #[must_use]
    pub fn reasons(&self) -> String {
        match self {
            Self::Scenario(error) => error.reasons(),
            other => other.to_string(),
        }
    }

    /// The exit status: 2 for bad input (including the described files), 3 when the work could not be done.
    #[must_use]
    pub fn exit_status(&self) -> u8 {
        match self {
            Self::Scenario(scenarios::Error::Write(_)) => 3,
            Self::Scenario(_) | Self::Report(reports::Error::Recording(_)) => 2,
            Self::Report(reports::Error::File(diagnostics::Error::Overwrites { .. })) => 2,
            Self::Report(_) => 3,
        }
    }
}

impl From<diagnostics::Error> for Error {
    fn from(error: diagnostics::Error) -> Self {
        scenarios::Error::from(error).into()
    }
}
