//! Named texts, and ranges of them.

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use miette::{MietteError, NamedSource, SourceCode, SourceSpan, SpanContents};

/// The name of an assignment on the command line in diagnostics: such a text is no file.
pub const ASSIGNMENT: &str = "--set";

/// A named text: usually a file, sometimes a command-line argument. Cheap to clone.
#[derive(Clone, Debug)]
pub struct Source(Arc<Named>);

#[derive(Debug)]
struct Named {
    text: NamedSource<String>,
    folder: PathBuf,
}

impl Source {
    /// A text with the name that it has in diagnostics.
    #[must_use]
    pub fn new(name: &str, text: impl Into<String>) -> Self {
        Self::in_folder(PathBuf::new(), name, text)
    }

    /// Like [`new`](Self::new), for a text whose paths are relative to this folder.
    #[must_use]
    pub fn in_folder(folder: impl Into<PathBuf>, name: &str, text: impl Into<String>) -> Self {
        Self(Arc::new(Named { text: NamedSource::new(name, text.into()), folder: folder.into() }))
    }

    /// The folder to which the text's paths are relative; empty unless it was [set](Self::in_folder).
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.0.folder
    }

    /// The name of the text.
    #[must_use]
    pub fn name(&self) -> &str {
        self.0.text.name()
    }

    /// The text itself.
    #[must_use]
    pub fn text(&self) -> &str {
        self.0.text.inner()
    }

    /// Whether both are the same text, not merely equal ones.
    pub(crate) fn is(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }

    /// A range of the text, in bytes. An end that is outside the text or inside a character moves to the nearest
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
        self.0.text.read_span(span, lines_before, lines_after)
    }
}

/// A range of a named text. Cheap to clone; keep it beside a value so that problems with the value can be reported
/// later.
#[derive(Clone, Debug)]
pub struct Span {
    source: Source,
    range: Range<usize>,
}

impl Span {
    /// The text to which the range belongs.
    #[must_use]
    pub fn source(&self) -> &Source {
        &self.source
    }

    /// The range, in bytes from the beginning of its text.
    #[must_use]
    pub fn range(&self) -> Range<usize> {
        self.range.clone()
    }

    /// Whether the text is an assignment on the command line (`--set`), not a file.
    #[must_use]
    pub fn is_assignment(&self) -> bool {
        self.source.name() == ASSIGNMENT
    }

    /// The characters in the range.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.source.text()[self.range()]
    }

    /// The line on which the range begins, from 1.
    #[must_use]
    pub fn line(&self) -> usize {
        1 + self.before().matches('\n').count()
    }

    /// The column at which the range begins, in characters from 1.
    #[must_use]
    pub fn column(&self) -> usize {
        1 + self.before().chars().rev().take_while(|character| *character != '\n').count()
    }

    fn before(&self) -> &str {
        &self.source.text()[..self.range.start]
    }
}

/// A value and its location in a file.
#[derive(Clone, Debug)]
pub struct Spanned<T> {
    /// The value.
    pub value: T,
    /// Its location.
    pub span: Span,
}

/// Values are equal wherever they are written.
impl<T: PartialEq> PartialEq for Spanned<T> {
    fn eq(&self, other: &Self) -> bool {
        self.value == other.value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_are_counted_in_lines_and_characters() {
        let source = Source::new("a.toml", "grün = 1\nblau = ü2\n");
        let span = source.span(19..21);
        assert_eq!((span.line(), span.column(), span.text()), (2, 9, "2\n"));
    }

    #[test]
    fn a_span_never_leaves_its_text_or_splits_a_character() {
        let source = Source::new("a.toml", "aü");
        assert_eq!(source.span(2..900).range(), 1..3);
        assert_eq!(source.span(700..900).range(), 3..3);
    }
}
