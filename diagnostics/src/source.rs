//! Named texts, and stretches of them.

use std::ops::Range;
use std::sync::Arc;

use miette::{MietteError, NamedSource, SourceCode, SourceSpan, SpanContents};

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

impl SourceCode for Source {
    fn read_span<'a>(
        &'a self,
        span: &SourceSpan,
        lines_before: usize,
        lines_after: usize,
    ) -> Result<Box<dyn SpanContents<'a> + 'a>, MietteError> {
        self.0.read_span(span, lines_before, lines_after)
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
}
