//! Problems of a property file, each with its location.

use diagnostics::{Problem, Source};
use miette::Diagnostic;

/// A refused property file: all its problems, in the order of the text.
#[derive(Clone, Debug, thiserror::Error, Diagnostic)]
#[error("{} has {}", text.name(), mistakes(problems))]
pub struct ScopeError {
    #[source_code]
    text: Source,
    #[related]
    problems: Vec<Problem>,
}

impl ScopeError {
    pub(crate) fn new(text: Source, problems: Vec<Problem>) -> Self {
        Self { text, problems }
    }

    /// All problems, including warnings, in the order of the text.
    #[must_use]
    pub fn problems(&self) -> &[Problem] {
        &self.problems
    }
}

fn mistakes(problems: &[Problem]) -> String {
    match problems.iter().filter(|problem| problem.is_error()).count() {
        1 => "1 mistake".to_owned(),
        many => format!("{many} mistakes"),
    }
}

/// The warnings about an accepted property file, in the order of the text.
#[derive(Clone, Debug, thiserror::Error, Diagnostic)]
#[error("{} is accepted, with warnings", text.name())]
#[diagnostic(severity(Warning))]
pub struct Warnings {
    #[source_code]
    text: Source,
    #[related]
    problems: Vec<Problem>,
}

impl Warnings {
    pub(crate) fn new(text: Source, problems: Vec<Problem>) -> Self {
        Self { text, problems }
    }

    /// The warnings, in the order of the text.
    #[must_use]
    pub fn problems(&self) -> &[Problem] {
        &self.problems
    }

    /// Whether there are no warnings.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.problems.is_empty()
    }
}
