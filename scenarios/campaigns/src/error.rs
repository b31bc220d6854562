//! Why a command could not be carried out, and the exit status that says so.

use std::io;
use std::path::PathBuf;

use diagnostics::Problem;
use miette::Diagnostic;

/// Why runs could not be carried out or shown.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file or an argument is wrong, or a run cannot go on.
    #[error(transparent)]
    Scenario(#[from] scenarios::Error),
    /// A run cannot be shown.
    #[error(transparent)]
    Report(#[from] reports::Error),
    /// A run was interrupted: how far it came, and what there is of it.
    #[error("{0}")]
    Interrupted(String),
}

impl Error {
    /// The exit status of a command that was interrupted: what a shell calls such a program.
    pub const INTERRUPTED: u8 = 130;

    /// The error that one diagnostic makes.
    #[must_use]
    pub fn bad_input(diagnostic: impl Diagnostic + Send + Sync + 'static) -> Self {
        scenarios::Error::bad_input(diagnostic).into()
    }

    /// Bad input that no place in a file stands for, with what would be accepted.
    #[must_use]
    pub fn refused(message: impl Into<String>, help: impl Into<String>) -> Self {
        Self::bad_input(Problem::new(message).with_help(help))
    }

    /// A file that could not be written, with what the system said.
    pub(crate) fn unwritten(path: impl Into<PathBuf>, source: io::Error) -> Self {
        diagnostics::Error::Write { path: path.into(), source }.into()
    }

    /// What is wrong with the input, each a diagnostic of its own; none if the error is another one.
    #[must_use]
    pub fn diagnostics(&self) -> Vec<&dyn Diagnostic> {
        match self {
            Self::Scenario(scenarios::Error::BadInput(all)) => {
                all.iter().map(|diagnostic| -> &dyn Diagnostic { &**diagnostic }).collect()
            }
            Self::Report(error @ reports::Error::Recording(_)) => vec![error],
            _ => Vec::new(),
        }
    }

    /// Everything that is wrong, in a line.
    #[must_use]
    pub fn reasons(&self) -> String {
        match self {
            Self::Scenario(error) => error.reasons(),
            other => other.to_string(),
        }
    }

    /// The exit status: 2 for bad input (what the files describe included), 3 when the work could not be done, 130 when it
    /// was interrupted.
    #[must_use]
    pub fn exit_status(&self) -> u8 {
        match self {
            Self::Scenario(scenarios::Error::Write(_)) => 3,
            Self::Scenario(_) | Self::Report(reports::Error::Recording(_)) => 2,
            Self::Report(_) => 3,
            Self::Interrupted(_) => Self::INTERRUPTED,
        }
    }
}

impl From<diagnostics::Error> for Error {
    fn from(error: diagnostics::Error) -> Self {
        scenarios::Error::from(error).into()
    }
}
