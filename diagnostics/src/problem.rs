//! Problems of a text, each with its location.

use std::fmt;
use std::ops::Range;

use miette::{Diagnostic, LabeledSpan, Severity, SourceCode, SourceSpan};

use crate::{Source, Span, counted};

/// One thing that is wrong, or looks wrong, in a text.
///
/// [`Span::problem`] makes a problem with its text. A parser that has only the bytes of the text makes one with
/// [`new`](Self::new): it is rendered with the text of the error of which it becomes part.
#[derive(Clone, Debug)]
pub struct Problem {
    message: String,
    source: Option<Source>,
    labels: Vec<LabeledSpan>,
    help: Option<String>,
    severity: Severity,
}

impl Span {
    /// A problem at this location.
    #[must_use]
    pub fn problem(&self, message: impl Into<String>) -> Problem {
        Problem::new(message).of(self.source()).at_plainly(self.range())
    }
}

impl Problem {
    /// The problem, in one sentence without a full stop.
    #[must_use]
    pub fn new(message: impl Into<String>) -> Self {
        Self { message: message.into(), source: None, labels: Vec::new(), help: None, severity: Severity::Error }
    }

    /// Sets the text to which it refers.
    #[must_use]
    pub fn of(self, source: &Source) -> Self {
        Self { source: Some(source.clone()), ..self }
    }

    /// Marks a range of the text, in bytes, and labels it. The first marked range is the problem's location.
    #[must_use]
    pub fn at(mut self, stretch: impl Into<SourceSpan>, label: impl Into<String>) -> Self {
        self.labels.push(LabeledSpan::new_with_span(Some(label.into()), stretch));
        self
    }

    /// Marks a range without a label.
    pub(crate) fn at_plainly(mut self, stretch: Range<usize>) -> Self {
        self.labels.push(LabeledSpan::new_with_span(None, stretch));
        self
    }

    /// Labels the range that was marked first.
    #[must_use]
    pub fn with_label(mut self, label: impl Into<String>) -> Self {
        if let Some(first) = self.labels.first_mut() {
            first.set_label(Some(label.into()));
        }
        self
    }

    /// The problem of a text that its layout would change. No text should have it.
    #[must_use]
    pub fn of_layout() -> Self {
        let problem = Self::new("this would not mean the same after its layout").at(0..0, "left as it is");
        problem.with_help("this is a mistake in steward; please report it with the file")
    }

    /// Replaces the message.
    #[must_use]
    pub fn with_message(self, message: impl Into<String>) -> Self {
        Self { message: message.into(), ..self }
    }

    /// Adds what would be accepted, or what to do.
    #[must_use]
    pub fn with_help(self, help: impl Into<String>) -> Self {
        self.with_help_if(Some(help.into()))
    }

    /// Like [`with_help`](Self::with_help), if there is any.
    #[must_use]
    pub fn with_help_if(self, help: Option<String>) -> Self {
        Self { help, ..self }
    }

    /// Makes it a warning: it only looks wrong.
    #[must_use]
    pub fn as_warning(self) -> Self {
        Self { severity: Severity::Warning, ..self }
    }

    /// The problem with each of its ranges mapped by `place` into a text that contains its own, or into a part of it.
    #[must_use]
    pub fn moved(mut self, place: impl Fn(Range<usize>) -> Range<usize>) -> Self {
        for label in &mut self.labels {
            let moved = place(label.offset()..label.offset() + label.len());
            *label = LabeledSpan::new_with_span(label.label().map(str::to_owned), moved);
        }
        self
    }

    /// The problem, in one sentence without a full stop.
    #[must_use]
    pub fn message(&self) -> &str {
        &self.message
    }

    /// The label of the range that was marked first.
    #[must_use]
    pub fn label_text(&self) -> Option<&str> {
        self.labels.first().and_then(LabeledSpan::label)
    }

    /// The accepted values, or what to do.
    #[must_use]
    pub fn help_text(&self) -> Option<&str> {
        self.help.as_deref()
    }

    /// Whether a file with this problem is refused; a warning is not an error.
    #[must_use]
    pub fn is_error(&self) -> bool {
        self.severity == Severity::Error
    }

    /// The location of the problem: the first byte of its first label, or the beginning of the text.
    #[must_use]
    pub fn offset(&self) -> usize {
        self.labels.first().map_or(0, LabeledSpan::offset)
    }

    /// The location of the problem, if its text is known.
    #[must_use]
    pub fn span(&self) -> Option<Span> {
        let length = self.labels.first().map_or(0, LabeledSpan::len);
        self.source.as_ref().map(|source| source.span(self.offset()..self.offset() + length))
    }

    /// Whether it refers to this very text, not merely to an equal one.
    #[must_use]
    pub fn is_of(&self, source: &Source) -> bool {
        self.source.as_ref().is_some_and(|own| own.is(source))
    }

    /// The problem as one line: `house.yaml:2:13: message (help)`.
    #[must_use]
    pub fn one_line(&self) -> String {
        let help = self.help.as_ref().map(|help| format!(" ({help})")).unwrap_or_default();
        let place = self.span().map(|span| format!("{}:{}:{}: ", span.source().name(), span.line(), span.column()));
        format!("{}{}{help}", place.unwrap_or_default(), self.message)
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

    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.help.as_ref().map(|help| Box::new(help) as _)
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.source.as_ref().map(|source| source as _)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        Some(Box::new(self.labels.iter().cloned()))
    }
}

/// All problems of a file, in the order of their locations; never empty.
///
/// A file's problems may point into more than one text, for example into an override on the command line as well.
#[derive(Clone, Debug)]
pub struct FileProblems {
    problems: Vec<Problem>,
}

impl FileProblems {
    /// `Ok` if `problems` is empty, otherwise all of them as one error.
    ///
    /// # Errors
    /// The problems, sorted by location within a text. The texts are in the order in which they first appear.
    pub fn none_of(mut problems: Vec<Problem>) -> Result<(), Self> {
        if problems.is_empty() {
            return Ok(());
        }
        let mut texts: Vec<Source> = Vec::new();
        for source in problems.iter().filter_map(|problem| problem.source.as_ref()) {
            if !texts.iter().any(|text| text.is(source)) {
                texts.push(source.clone());
            }
        }
        problems.sort_by_key(|problem| (texts.iter().position(|text| problem.is_of(text)), problem.offset()));
        Err(Self { problems })
    }

    /// The problems, in order.
    #[must_use]
    pub fn problems(&self) -> &[Problem] {
        &self.problems
    }

    /// The problems of both, for a caller that reads several files before it returns.
    #[must_use]
    pub fn and(mut self, others: Self) -> Self {
        self.problems.extend(others.problems);
        self
    }

    /// All problems, as [one line](Problem::one_line) each.
    #[must_use]
    pub fn plain(&self) -> String {
        self.problems.iter().map(|problem| problem.one_line() + "\n").collect()
    }
}

impl From<Problem> for FileProblems {
    fn from(problem: Problem) -> Self {
        Self { problems: vec![problem] }
    }
}

impl fmt::Display for FileProblems {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut names: Vec<_> =
            self.problems.iter().filter_map(|problem| Some(problem.source.as_ref()?.name())).collect();
        names.dedup();
        write!(f, "{} in {}", counted(self.problems.len(), "problem"), names.join(" and "))
    }
}

impl std::error::Error for FileProblems {}

impl Diagnostic for FileProblems {
    fn related<'a>(&'a self) -> Option<Box<dyn Iterator<Item = &'a dyn Diagnostic> + 'a>> {
        Some(Box::new(self.problems.iter().map(|problem| problem as _)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn problems_are_ordered_by_text_and_position() {
        let (file, argument) = (Source::new("z.toml", "one two"), Source::new("--set", "three"));
        let problems = [file.span(4..7), argument.span(0..5), file.span(0..3)].map(|span| span.problem("no"));
        let problems = FileProblems::none_of(problems.to_vec()).unwrap_err();
        let order: Vec<_> = problems.problems().iter().map(|problem| problem.span().unwrap()).collect();
        let order: Vec<_> = order.iter().map(Span::text).collect();
        assert_eq!(order, ["one", "two", "three"]);
        assert_eq!(problems.to_string(), "3 problems in z.toml and --set");
    }
}
