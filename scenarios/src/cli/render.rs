//! Diagnostics as text, each with the line that it is about, however long that is.
//!
//! A file without line breaks, as programs write them, is one line of any length. What is shown of such a line is the
//! stretch around the place that is meant.

use std::fmt;

use miette::{
    Diagnostic, LabeledSpan, MietteError, MietteSpanContents, Severity, SourceCode, SourceSpan, SpanContents,
};

/// Longer lines are cut, in bytes.
const LONG_LINE: usize = 2000;
/// So much is shown before and after the place, in bytes.
const AROUND: usize = 60;

/// The diagnostic with everything that belongs to it, as a terminal shows it.
pub(super) fn rendered(diagnostic: &dyn Diagnostic) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = miette::GraphicalReportHandler::new().render_report(&mut text, &Cut::of(diagnostic));
    text
}

/// A diagnostic whose long lines are cut.
#[derive(Debug)]
struct Cut<'d> {
    diagnostic: &'d dyn Diagnostic,
    text: Option<CutText<'d>>,
    related: Vec<Cut<'d>>,
}

impl<'d> Cut<'d> {
    fn of(diagnostic: &'d dyn Diagnostic) -> Self {
        let related = diagnostic.related().into_iter().flatten().map(Self::of).collect();
        Self { diagnostic, text: diagnostic.source_code().map(CutText), related }
    }
}

impl fmt::Display for Cut<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self.diagnostic, f)
    }
}

impl std::error::Error for Cut<'_> {}

impl Diagnostic for Cut<'_> {
    fn code<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.diagnostic.code()
    }

    fn severity(&self) -> Option<Severity> {
        self.diagnostic.severity()
    }

    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.diagnostic.help()
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.text.as_ref().map(|text| -> &dyn SourceCode { text })
    }

    /// The labels, none longer than what is shown of a long line.
    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let shown = |label: LabeledSpan| {
            let window = self.text.as_ref().and_then(|text| text.window(label.inner()));
            let length =
                window.map_or(label.len(), |window| label.len().min(window.end.saturating_sub(label.offset())));
            LabeledSpan::new(label.label().map(str::to_owned), label.offset(), length)
        };
        self.diagnostic.labels().map(|labels| Box::new(labels.map(shown)) as _)
    }

    fn related<'a>(&'a self) -> Option<Box<dyn Iterator<Item = &'a dyn Diagnostic> + 'a>> {
        (!self.related.is_empty())
            .then(|| Box::new(self.related.iter().map(|related| -> &dyn Diagnostic { related })) as _)
    }
}

/// A text whose long lines are cut.
struct CutText<'d>(&'d dyn SourceCode);

impl fmt::Debug for CutText<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("CutText").finish_non_exhaustive()
    }
}

/// What is shown of a long line.
struct Window {
    /// Where it begins and ends in the text, in bytes.
    start: usize,
    end: usize,
    /// Its line and column, from 0.
    line: usize,
    column: usize,
    name: Option<String>,
}

impl CutText<'_> {
    /// A stretch alone, which says where it begins: its column counts characters, as everywhere, and not bytes.
    fn place<'a>(&'a self, span: &SourceSpan) -> Result<Box<dyn SpanContents<'a> + 'a>, MietteError> {
        let alone = self.0.read_span(span, 0, 0)?;
        let before = SourceSpan::from((span.offset().saturating_sub(alone.column()), alone.column()));
        let before = self.0.read_span(&before, 0, 0)?.data();
        let column = std::str::from_utf8(before).map_or(alone.column(), |before| before.chars().count());
        Ok(contents(alone.name().map(str::to_owned), alone.data(), *alone.span(), (alone.line(), column)))
    }

    /// What to show of the line on which a stretch begins, if a line around it is long.
    fn window(&self, span: &SourceSpan) -> Option<Window> {
        let around = self.0.read_span(span, 1, 1).ok()?;
        let text = std::str::from_utf8(around.data()).ok()?;
        if text.lines().all(|line| line.len() <= LONG_LINE) {
            return None;
        }
        let place = text.floor_char_boundary(span.offset().checked_sub(around.span().offset())?);
        let line_start = text[..place].rfind('\n').map_or(0, |end| end + 1);
        let line_end = text[place..].find('\n').map_or(text.len(), |length| place + length);
        let start = text.floor_char_boundary(place.saturating_sub(AROUND)).max(line_start);
        let marked = place + span.len().min(2 * AROUND);
        let end = text.floor_char_boundary(marked + AROUND).min(line_end).max(start);
        let column_of_line = if line_start == 0 { around.column() } else { 0 };
        Some(Window {
            start: around.span().offset() + start,
            end: around.span().offset() + end,
            line: around.line() + text[..line_start].matches('\n').count(),
            column: column_of_line + text[line_start..start].chars().count(),
            name: around.name().map(str::to_owned),
        })
    }
}

impl SourceCode for CutText<'_> {
    fn read_span<'a>(
        &'a self,
        span: &SourceSpan,
        lines_before: usize,
        lines_after: usize,
    ) -> Result<Box<dyn SpanContents<'a> + 'a>, MietteError> {
        if lines_before + lines_after == 0 {
            return self.place(span);
        }
        let Some(Window { start, end, line, column, name }) = self.window(span) else {
            return self.0.read_span(span, lines_before, lines_after);
        };
        let shown = SourceSpan::from(start..end);
        let data = self.0.read_span(&shown, 0, 0)?.data();
        Ok(contents(name, data, shown, (line, column)))
    }
}

/// What is shown of a text: a stretch of it that begins in that line and column, counted from 0.
fn contents<'a>(
    name: Option<String>,
    data: &'a [u8],
    span: SourceSpan,
    (line, column): (usize, usize),
) -> Box<dyn SpanContents<'a> + 'a> {
    match name {
        Some(name) => Box::new(MietteSpanContents::new_named(name, data, span, line, column, 1)),
        None => Box::new(MietteSpanContents::new(data, span, line, column, 1)),
    }
}

#[cfg(test)]
mod tests {
    use maps::Source;

    use super::rendered;

    /// How a problem with the last word of this text looks.
    fn problem_at_end(text: &str, word: &str) -> String {
        let source = Source::new("file.xml", text);
        rendered(&source.span(text.len() - word.len()..text.len()).problem("wrong").with_label("here"))
    }

    #[test]
    fn a_short_line_is_shown_whole() {
        let said = problem_at_end("a\nfirst second\tthird", "third");
        assert!(said.contains("file.xml:2:14") && said.contains("first second"), "{said}");
    }

    #[test]
    fn of_a_long_line_the_place_is_shown() {
        for blanks in [3000, 65_000, 65_480, 65_536, 70_000, 200_000] {
            let said = problem_at_end(&format!("<a>\n{}é <Nope/>", " ".repeat(blanks)), "<Nope/>");
            assert!(said.contains(&format!("file.xml:2:{}", blanks + 3)), "{said}");
            assert!(said.contains("é <Nope/>") && said.contains("here") && said.len() < 2000, "{said}");
        }
    }

    #[test]
    fn a_long_stretch_is_shown_at_its_beginning() {
        let said = problem_at_end(&format!("x = {}", "y".repeat(100_000)), &"y".repeat(100_000));
        assert!(said.contains("x = yyy") && said.contains("here") && said.len() < 2000, "{said}");
    }

    #[test]
    fn a_long_line_beside_the_place_is_left_out() {
        let said = problem_at_end(&format!("{}\nshort Nope", "z".repeat(100_000)), "Nope");
        assert!(said.contains("file.xml:2:7") && said.contains("short Nope") && said.len() < 2000, "{said}");
    }
}
