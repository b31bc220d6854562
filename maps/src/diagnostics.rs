//! What is wrong with a file that a user wrote, and where.
//!
//! Readers collect [`Problem`]s instead of stopping at the first one and hand them over as one [`FileProblems`].
//! Everything here implements [`miette::Diagnostic`], so that a binary can render it with the offending text; line and
//! column can be asked for without any renderer.

use std::fmt;
use std::ops::Range;
use std::sync::Arc;

use miette::{Diagnostic, LabeledSpan, NamedSource, SourceCode};

/// A named text: usually a file, sometimes an argument of the command line. Cheap to clone.
#[derive(Clone, Debug)]
pub struct Source(Arc<NamedSource<String>>);

impl Source {
    /// A text under the name that diagnostics shall call it by.
    #[must_use]
    pub fn new(name: &str, text: impl Into<String>) -> Self {
        Self(Arc::new(NamedSource::new(name, text.into())))
    }

    /// What the text is called.
    #[must_use]
    pub fn name(&self) -> &str {
        self.0.name()
    }

    /// The text itself.
    #[must_use]
    pub fn text(&self) -> &str {
        self.0.inner()
    }

    /// Whether both are the same text, not merely equal ones.
    pub(crate) fn is(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }

    /// A stretch of the text, in bytes. What lies outside the text or cuts a character in two is moved to the nearest
    /// character boundary on the left.
    #[must_use]
    pub fn span(&self, range: Range<usize>) -> Span {
        let start = self.text().floor_char_boundary(range.start);
        let end = self.text().floor_char_boundary(range.end.max(range.start)).max(start);
        Span { source: self.clone(), range: start..end }
    }
}

/// A stretch of a named text. Cheap to clone; keep it beside a value to be able to complain about the value later.
#[derive(Clone, Debug)]
pub struct Span {
    source: Source,
    range: Range<usize>,
}

impl Span {
    /// The text that the stretch belongs to.
    #[must_use]
    pub fn source(&self) -> &Source {
        &self.source
    }

    /// Where the stretch lies, in bytes from the beginning of its text.
    #[must_use]
    pub fn range(&self) -> Range<usize> {
        self.range.clone()
    }

    /// The characters that the stretch covers.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.source.text()[self.range()]
    }

    /// The line on which the stretch begins, from 1.
    #[must_use]
    pub fn line(&self) -> usize {
        1 + self.before().matches('\n').count()
    }

    /// The column at which the stretch begins, in characters from 1.
    #[must_use]
    pub fn column(&self) -> usize {
        1 + self.before().chars().rev().take_while(|character| *character != '\n').count()
    }

    /// A problem at this place.
    #[must_use]
    pub fn problem(&self, message: impl Into<String>) -> Problem {
        Problem { span: self.clone(), message: message.into(), label: None, help: None }
    }

    fn before(&self) -> &str {
        &self.source.text()[..self.range.start]
    }
}

/// A value with the place where a file says it.
#[derive(Clone, Debug)]
pub struct Spanned<T> {
    /// The value.
    pub value: T,
    /// Where it is written.
    pub span: Span,
}

/// One thing that is wrong at one place of a file.
#[derive(Clone, Debug)]
pub struct Problem {
    span: Span,
    message: String,
    label: Option<String>,
    help: Option<String>,
}

impl Problem {
    /// Adds what the marked text is.
    #[must_use]
    pub fn with_label(self, label: impl Into<String>) -> Self {
        Self { label: Some(label.into()), ..self }
    }

    /// Adds what would be accepted, or what to do.
    #[must_use]
    pub fn with_help(self, help: impl Into<String>) -> Self {
        Self { help: Some(help.into()), ..self }
    }

    /// What is wrong, in one sentence without a full stop.
    #[must_use]
    pub fn message(&self) -> &str {
        &self.message
    }

    /// What the marked text is.
    #[must_use]
    pub fn label_text(&self) -> Option<&str> {
        self.label.as_deref()
    }

    /// What would be accepted, or what to do.
    #[must_use]
    pub fn help_text(&self) -> Option<&str> {
        self.help.as_deref()
    }

    /// Where it is wrong.
    #[must_use]
    pub fn span(&self) -> &Span {
        &self.span
    }

    /// The problem as one line: `house.yaml:2:13: message (help)`.
    #[must_use]
    pub fn one_line(&self) -> String {
        let help = self.help.as_ref().map(|help| format!(" ({help})")).unwrap_or_default();
        let Span { source, .. } = &self.span;
        format!("{}:{}:{}: {}{help}", source.name(), self.span.line(), self.span.column(), self.message)
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Problem {}

impl Diagnostic for Problem {
    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.help.as_ref().map(|help| Box::new(help) as _)
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        Some(&*self.span.source.0)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let label = LabeledSpan::new_with_span(self.label.clone(), self.span.range());
        Some(Box::new(std::iter::once(label)))
    }
}

/// Everything that is wrong with a file, in the order of the places; never empty.
///
/// A file's problems may point into more than one text, for example into an override of the command line as well.
#[derive(Clone, Debug)]
pub struct FileProblems {
    problems: Vec<Problem>,
}

impl FileProblems {
    /// Nothing to complain about if `problems` is empty, else all of them as one error.
    ///
    /// # Errors
    /// The problems, by place within a text, and the texts in the order in which they first come up.
    pub fn none_of(mut problems: Vec<Problem>) -> Result<(), Self> {
        if problems.is_empty() {
            return Ok(());
        }
        let mut texts: Vec<Source> = Vec::new();
        for Problem { span, .. } in &problems {
            if !texts.iter().any(|text| text.is(&span.source)) {
                texts.push(span.source.clone());
            }
        }
        problems.sort_by_key(|Problem { span, .. }| {
            (texts.iter().position(|text| text.is(&span.source)), span.range.start)
        });
        Err(Self { problems })
    }

    /// The problems, in order.
    #[must_use]
    pub fn problems(&self) -> &[Problem] {
        &self.problems
    }

    /// The problems of both, for a caller who reads several files before giving up.
    #[must_use]
    pub fn and(mut self, others: Self) -> Self {
        self.problems.extend(others.problems);
        self
    }

    /// All problems, [one line](Problem::one_line) each.
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
        let mut names: Vec<_> = self.problems.iter().map(|problem| problem.span.source.name()).collect();
        names.dedup();
        let count = self.problems.len();
        write!(f, "{count} problem{} in {}", if count == 1 { "" } else { "s" }, names.join(" and "))
    }
}

impl std::error::Error for FileProblems {}

impl Diagnostic for FileProblems {
    fn related<'a>(&'a self) -> Option<Box<dyn Iterator<Item = &'a dyn Diagnostic> + 'a>> {
        Some(Box::new(self.problems.iter().map(|problem| problem as _)))
    }
}

/// The candidate that `name` most likely was meant to be: the one with the fewest typing errors between them, if those
/// are few for the name's length. Case does not count.
#[must_use]
pub fn nearest<'c>(name: &str, candidates: impl IntoIterator<Item = &'c str>) -> Option<&'c str> {
    let name = name.to_lowercase();
    let allowed = (name.chars().count() / 3).max(1);
    candidates
        .into_iter()
        .map(|candidate| (strsim::damerau_levenshtein(&name, &candidate.to_lowercase()), candidate))
        .filter(|(distance, _)| *distance <= allowed)
        .min()
        .map(|(_, candidate)| candidate)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_counted_in_lines_and_characters() {
        let source = Source::new("a.toml", "grün = 1\nblau = ü2\n");
        let span = source.span(19..21);
        assert_eq!((span.line(), span.column(), span.text()), (2, 9, "2\n"));
    }

    #[test]
    fn a_span_never_leaves_its_text_or_cuts_a_character() {
        let source = Source::new("a.toml", "aü");
        assert_eq!(source.span(2..900).range(), 1..3);
        assert_eq!(source.span(700..900).range(), 3..3);
    }

    #[test]
    fn problems_are_ordered_by_text_and_place() {
        let (file, argument) = (Source::new("z.toml", "one two"), Source::new("--set", "three"));
        let problems = [file.span(4..7), argument.span(0..5), file.span(0..3)].map(|span| span.problem("no"));
        let problems = FileProblems::none_of(problems.to_vec()).unwrap_err();
        let order: Vec<_> = problems.problems().iter().map(|problem| problem.span().text()).collect();
        assert_eq!(order, ["one", "two", "three"]);
        assert_eq!(problems.to_string(), "3 problems in z.toml and --set");
    }

    #[test]
    fn only_near_names_are_suggested() {
        let known = ["resolution", "origin", "mode"];
        assert_eq!(nearest("resolutoin", known), Some("resolution"));
        assert_eq!(nearest("Mod", known), Some("mode"));
        assert_eq!(nearest("battery", known), None);
    }
}
