//! Errors of a tree file.

use diagnostics::{Problem, Source};
use miette::{Diagnostic, Severity, SourceCode};

/// All errors and warnings of a tree file, in the order of their positions. Problems of included files are listed with
/// those files.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{} {}", text.name(), verdict(self.is_error()))]
pub struct TreeError {
    text: Source,
    problems: Vec<Problem>,
    included: Vec<TreeError>,
}

impl TreeError {
    pub(crate) fn new(text: Source, mut problems: Vec<Problem>) -> Self {
        problems.sort_by_cached_key(Problem::offset);
        Self { text, problems, included: Vec::new() }
    }

    pub(crate) fn with_included(mut self, included: Vec<Self>) -> Self {
        self.included = included;
        self
    }

    /// The problems of the file itself, in the order of their positions.
    #[must_use]
    pub fn problems(&self) -> &[Problem] {
        &self.problems
    }

    /// The problems of included files.
    #[must_use]
    pub fn included(&self) -> &[Self] {
        &self.included
    }

    /// Whether the file, or one that it includes, cannot be used. Otherwise there are only warnings: see
    /// [`Tree::concerns`](crate::Tree::concerns).
    #[must_use]
    pub fn is_error(&self) -> bool {
        self.problems.iter().any(Problem::is_error) || self.included.iter().any(Self::is_error)
    }

    /// The name of the file.
    #[must_use]
    pub fn file(&self) -> &str {
        self.text.name()
    }
}

impl Diagnostic for TreeError {
    fn severity(&self) -> Option<Severity> {
        Some(if self.is_error() { Severity::Error } else { Severity::Warning })
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        Some(&self.text)
    }

    fn related<'a>(&'a self) -> Option<Box<dyn Iterator<Item = &'a dyn Diagnostic> + 'a>> {
        let problems = self.problems.iter().map(|problem| problem as &dyn Diagnostic);
        let included = self.included.iter().map(|error| error as &dyn Diagnostic);
        Some(Box::new(problems.chain(included)))
    }
}

fn verdict(is_error: bool) -> &'static str {
    if is_error { "cannot be used as a behavior tree" } else { "can be used, with warnings" }
}
