//! What is wrong with a property file, each thing at its place.

use std::fmt;
use std::ops::Range;

use miette::{Diagnostic, LabeledSpan, NamedSource, Severity};

/// One thing that is wrong, or looks wrong, in a property file.
///
/// It renders with the text of the [`ScopeError`] or the [`Warnings`] that it belongs to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    message: String,
    labels: Vec<LabeledSpan>,
    help: Option<String>,
    severity: Severity,
}

impl Problem {
    pub(crate) fn new(message: impl Into<String>) -> Self {
        Self { message: message.into(), labels: Vec::new(), help: None, severity: Severity::Error }
    }

    pub(crate) fn at(mut self, span: impl Into<Range<usize>>, label: impl Into<String>) -> Self {
        self.labels.push(LabeledSpan::at(span.into(), label));
        self
    }

    pub(crate) fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    pub(crate) fn warning(mut self) -> Self {
        self.severity = Severity::Warning;
        self
    }

    /// The problem as one of a part of its text, which is `length` bytes from `start` on.
    fn of_part(mut self, start: usize, length: usize) -> Self {
        let inside = |offset: usize| offset.saturating_sub(start).min(length);
        for label in &mut self.labels {
            let (from, to) = (inside(label.offset()), inside(label.offset() + label.len()));
            *label = LabeledSpan::new(label.label().map(str::to_owned), from, to - from);
        }
        self
    }

    /// Whether a file with this problem is refused; a warning lets it pass.
    #[must_use]
    pub fn is_error(&self) -> bool {
        self.severity == Severity::Error
    }

    /// Where the problem is: the first byte of its first label.
    #[must_use]
    pub fn offset(&self) -> usize {
        self.labels.first().map_or(0, LabeledSpan::offset)
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Problem {}

impl Diagnostic for Problem {
    fn severity(&self) -> Option<Severity> {
        Some(self.severity)
    }

    fn help(&self) -> Option<Box<dyn fmt::Display + '_>> {
        self.help.as_ref().map(|help| Box::new(help) as Box<dyn fmt::Display>)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        Some(Box::new(self.labels.iter().cloned()))
    }
}

/// A property file that is refused: everything that is wrong with it, in the order of the text.
#[derive(Debug)]
pub struct ScopeError {
    source: NamedSource<String>,
    problems: Vec<Problem>,
}

impl ScopeError {
    pub(crate) fn new(name: &str, text: &str, problems: Vec<Problem>) -> Self {
        Self { source: NamedSource::new(name, text.to_owned()), problems }
    }

    /// The error of a text as that of a part of it, which begins at byte `start`.
    pub(crate) fn of_part(self, name: &str, part: &str, start: usize) -> Self {
        let problems = self.problems.into_iter().map(|problem| problem.of_part(start, part.len()));
        Self::new(name, part, problems.collect())
    }

    /// Everything that is wrong, and what looked wrong beside it, in the order of the text.
    #[must_use]
    pub fn problems(&self) -> &[Problem] {
        &self.problems
    }
}

impl fmt::Display for ScopeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let errors = self.problems.iter().filter(|problem| problem.is_error()).count();
        let what = if errors == 1 { "mistake" } else { "mistakes" };
        write!(f, "{} has {errors} {what}", self.source.name())
    }
}

impl std::error::Error for ScopeError {}

impl Diagnostic for ScopeError {
    fn source_code(&self) -> Option<&dyn miette::SourceCode> {
        Some(&self.source)
    }

    fn related<'a>(&'a self) -> Option<Box<dyn Iterator<Item = &'a dyn Diagnostic> + 'a>> {
        Some(Box::new(self.problems.iter().map(|problem| problem as &dyn Diagnostic)))
    }
}

/// What looks wrong in a property file that was accepted, in the order of the text.
#[derive(Clone, Debug, Default)]
pub struct Warnings {
    source: Option<NamedSource<String>>,
    problems: Vec<Problem>,
}

impl Warnings {
    pub(crate) fn new(name: &str, text: &str, problems: Vec<Problem>) -> Self {
        Self { source: Some(NamedSource::new(name, text.to_owned())), problems }
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

impl fmt::Display for Warnings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = self.source.as_ref().map_or("the properties", NamedSource::name);
        write!(f, "{name} is accepted, but look at this")
    }
}

impl std::error::Error for Warnings {}

impl Diagnostic for Warnings {
    fn severity(&self) -> Option<Severity> {
        Some(Severity::Warning)
    }

    fn source_code(&self) -> Option<&dyn miette::SourceCode> {
        self.source.as_ref().map(|source| source as &dyn miette::SourceCode)
    }

    fn related<'a>(&'a self) -> Option<Box<dyn Iterator<Item = &'a dyn Diagnostic> + 'a>> {
        Some(Box::new(self.problems.iter().map(|problem| problem as &dyn Diagnostic)))
    }
}
