//! Why a command could not be carried out, and the exit status that says so.

use std::io;
use std::path::PathBuf;

use miette::Diagnostic;

use crate::live::StepError;

/// The exit status of a command that was interrupted: what a shell calls such a program.
pub(crate) const INTERRUPTED: u8 = 130;

/// Why a command could not be carried out.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The files or arguments are wrong: everything that was found, each a diagnostic of its own.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))]
    BadInput(Vec<Box<dyn Diagnostic + Send + Sync>>),
    /// The processes that the files describe cannot go on.
    #[error("the run cannot go on: {0}")]
    Run(#[from] channels::RunError),
    /// A run had more communications than this, as many as its scenario allows.
    #[error("the run was given up: it had more than {0} communications (`execution.run_budget`)")]
    Budget(u64),
    /// A file could not be written.
    #[error("cannot write {}: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A run was interrupted: how far it came, and what there is of it.
    #[error("{0}")]
    Interrupted(String),
    /// A picture could not be made.
    #[error("cannot draw: {0}")]
    Draw(String),
}

impl Error {
    /// The error that one diagnostic makes.
    #[must_use]
    pub fn bad_input(diagnostic: impl Diagnostic + Send + Sync + 'static) -> Self {
        Self::BadInput(vec![Box::new(diagnostic)])
    }

    /// Bad input that no place in a file stands for, with what would be accepted.
    #[must_use]
    pub fn refused(message: impl Into<String>, help: impl Into<String>) -> Self {
        Self::bad_input(Refusal { message: message.into(), help: help.into() })
    }

    /// The exit status: 2 for bad input (what the files describe included), 3 when the work could not be done, 130 when it
    /// was interrupted.
    #[must_use]
    pub fn exit_status(&self) -> u8 {
        match self {
            Self::BadInput(_) | Self::Run(_) | Self::Budget(_) => 2,
            Self::Write { .. } | Self::Draw(_) => 3,
            Self::Interrupted(_) => INTERRUPTED,
        }
    }
}

impl From<StepError> for Error {
    fn from(error: StepError) -> Self {
        match error {
            StepError::Run(error) => error.into(),
            StepError::Budget(limit) => Self::Budget(limit),
        }
    }
}

impl From<diagnostics::Error> for Error {
    fn from(error: diagnostics::Error) -> Self {
        match error {
            diagnostics::Error::Write { path, source } => Self::Write { path, source },
            wrong => Self::bad_input(wrong),
        }
    }
}

impl From<maps::Error> for Error {
    fn from(error: maps::Error) -> Self {
        match error {
            maps::Error::File(error) => error.into(),
            wrong => Self::bad_input(wrong),
        }
    }
}

/// A complaint about an argument, without a place in a file.
#[derive(Debug, thiserror::Error, Diagnostic)]
#[error("{message}")]
#[diagnostic(help("{help}"))]
pub(crate) struct Refusal {
    pub(crate) message: String,
    pub(crate) help: String,
}

/// Collects what is wrong with several files, so that all of it is said at once.
#[derive(Debug, Default)]
pub(crate) struct Complaints(Vec<Box<dyn Diagnostic + Send + Sync>>);

impl Complaints {
    /// The value, or nothing after noting what is wrong.
    pub(crate) fn note<T, E: Diagnostic + Send + Sync + 'static>(&mut self, result: Result<T, E>) -> Option<T> {
        result.map_err(|error| self.0.push(Box::new(error))).ok()
    }

    /// The value, or nothing after noting everything that is wrong.
    pub(crate) fn take<T>(&mut self, result: Result<T, Error>) -> Option<T> {
        match result {
            Ok(value) => Some(value),
            Err(Error::BadInput(diagnostics)) => {
                self.0.extend(diagnostics);
                None
            }
            Err(error) => {
                self.0.push(Box::new(Refusal { message: error.to_string(), help: String::new() }));
                None
            }
        }
    }

    /// Notes what is wrong.
    pub(crate) fn push(&mut self, diagnostic: impl Diagnostic + Send + Sync + 'static) {
        self.0.push(Box::new(diagnostic));
    }

    /// # Errors
    /// Everything that was noted, if anything was.
    pub(crate) fn check(&mut self) -> Result<(), Error> {
        if self.0.is_empty() { Ok(()) } else { Err(Error::BadInput(std::mem::take(&mut self.0))) }
    }
}
