//! Why a scenario could not be run.

use std::convert::Infallible;

use diagnostics::Problem;
use miette::Diagnostic;

/// Why a scenario could not be run.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The files or arguments are wrong. Contains every problem found, each as a separate diagnostic.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))]
    BadInput(Vec<Box<dyn Diagnostic + Send + Sync>>),
    /// The processes that the files describe cannot continue.
    #[error("the run cannot continue: {0}")]
    Run(#[from] channels::RunError),
    /// A run had more communications than its scenario allows.
    #[error("the run was stopped after more than {0} communications (`execution.run_budget`)")]
    Budget(u64),
    /// A file could not be written.
    #[error(transparent)]
    Write(diagnostics::Error),
}

impl Error {
    /// The error that consists of one diagnostic.
    #[must_use]
    pub fn bad_input(diagnostic: impl Diagnostic + Send + Sync + 'static) -> Self {
        Self::BadInput(vec![Box::new(diagnostic)])
    }

    /// Bad input that has no location in a file, with advice on what is accepted.
    #[must_use]
    pub fn refused(message: impl Into<String>, help: impl Into<String>) -> Self {
        Self::bad_input(Problem::new(message).with_help(help))
    }

    /// All problems, on one line.
    #[must_use]
    pub fn reasons(&self) -> String {
        let Self::BadInput(diagnostics) = self else { return self.to_string() };
        let mut reasons: Vec<String> = Vec::new();
        for diagnostic in diagnostics {
            let related: Vec<String> = diagnostic.related().into_iter().flatten().map(ToString::to_string).collect();
            reasons.extend(if related.is_empty() { vec![diagnostic.to_string()] } else { related });
        }
        reasons.join("; ")
    }
}

impl From<Infallible> for Error {
    fn from(never: Infallible) -> Self {
        match never {}
    }
}

impl From<diagnostics::Error> for Error {
    fn from(error: diagnostics::Error) -> Self {
        match error {
            unwritten @ diagnostics::Error::Write { .. } => Self::Write(unwritten),
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

/// Something does not exist because of problems, which have been recorded.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Recorded;

/// Collects the problems of several files, so that all are reported at once.
#[derive(Debug, Default)]
pub struct Complaints(Vec<Box<dyn Diagnostic + Send + Sync>>);

impl Complaints {
    /// The value, or `None` after recording the problem.
    pub fn note<T, E: Diagnostic + Send + Sync + 'static>(&mut self, result: Result<T, E>) -> Option<T> {
        result.map_err(|error| self.0.push(Box::new(error))).ok()
    }

    /// The value, or `None` after recording all problems.
    pub fn take<T>(&mut self, result: Result<T, Error>) -> Option<T> {
        match result {
            Ok(value) => Some(value),
            Err(Error::BadInput(diagnostics)) => {
                self.0.extend(diagnostics);
                None
            }
            Err(error) => {
                self.0.push(Box::new(Problem::new(error.to_string())));
                None
            }
        }
    }

    /// Records a problem.
    pub fn push(&mut self, diagnostic: impl Diagnostic + Send + Sync + 'static) {
        self.0.push(Box::new(diagnostic));
    }

    /// # Errors
    /// All recorded problems, if there are any.
    pub fn check(&mut self) -> Result<(), Error> {
        if self.0.is_empty() { Ok(()) } else { Err(Error::BadInput(std::mem::take(&mut self.0))) }
    }
}
