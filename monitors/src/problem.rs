//! What is wrong with a property file, each thing at its place.

use diagnostics::{Problem, Source};
use miette::Diagnostic;

/// A property file that is refused: everything that is wrong with it, in the order of the text.
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

    /// Everything that is wrong, and what looked wrong beside it, in the order of the text.
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

/// What looks wrong in a property file that was accepted, in the order of the text.
#[derive(Clone, Debug, thiserror::Error, Diagnostic)]
#[error("{} is accepted, but look at this", text.name())]
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

    /// What looks wrong, in the order of the text.
    #[must_use]
    pub fn problems(&self) -> &[Problem] {
        &self.problems
    }

    /// Whether nothing looks wrong.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.problems.is_empty()
    }
}
