//! Diagnostics as text, each with the line to which it refers.
//!
//! A file that a program wrote may be one very long line: only the part around the location is shown. If there are very
//! many problems, only the first ones are shown; of a very long text, only the beginning.
//!
//! Names and texts of files may contain anything. Characters that would control a terminal are replaced by harmless
//! ones.

use std::borrow::Cow;
use std::fmt;
use std::sync::OnceLock;

use diagnostics::parts;
use miette::{
    Diagnostic, GraphicalReportHandler, LabeledSpan, MietteError, MietteSpanContents, NamedSource, Severity,
    SourceCode, SourceSpan, SpanContents,
};
use serde::Serialize;

/// Longer lines are cut, in bytes.
const LONG_LINE: usize = 2000;
/// How much is shown before and after the location, in bytes.
const AROUND: usize = 60;

/// The maximum number of problems shown.
const MOST_PROBLEMS: usize = 100;
/// Longer messages, labels and hints are cut, in bytes.
const LONG_TEXT: usize = 2000;

/// The diagnostics with everything that belongs to them, as a terminal shows them: each problem of a file separately.
pub(crate) fn rendered<'d>(
    handler: &GraphicalReportHandler,
    diagnostics: impl IntoIterator<Item = &'d dyn Diagnostic>,
) -> String {
    let mut text = String::new();
    let mut render = |diagnostic: &Cut<'_>| {
        // A label that lies outside of its text cannot be shown; what was shown before it remains.
        let _ = handler.render_report(&mut text, diagnostic);
    };
    let (mut shown, mut all) = (0, 0);
    for diagnostic in diagnostics {
        let problems = parts(diagnostic);
        if problems.len() > 1 && shown < MOST_PROBLEMS {
            render(&Cut { diagnostic, text: None });
        }
        let room = MOST_PROBLEMS - shown;
        problems.iter().take(room).for_each(|(problem, text)| render(&Cut::of(*problem, *text)));
        shown += problems.len().min(room);
        all += problems.len();
    }
    if all > shown {
        text += &format!("and {} more\n", grouped(all - shown));
    }
    text
}

/// One part of a diagnostic, with its location.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub(crate) struct Finding {
    message: String,
    file: Option<String>,
    line: Option<usize>,
    column: Option<usize>,
    help: Option<String>,
}

impl Finding {
    /// A message without a location.
    pub(crate) fn of_message(message: String) -> Self {
        Self { message, ..Self::default() }
    }
}

/// All parts of a diagnostic, with their locations.
pub(crate) fn findings(diagnostic: &dyn Diagnostic) -> Vec<Finding> {
    parts(diagnostic).into_iter().map(|(problem, text)| found(problem, text)).collect()
}

fn found(diagnostic: &dyn Diagnostic, source: Option<&dyn SourceCode>) -> Finding {
    let label = diagnostic.labels().and_then(|mut labels| labels.next());
    let text = source.map(CutText::of);
    let place = text.as_ref().zip(label.as_ref()).and_then(|(text, label)| text.place(label.inner()).ok());
    let name = place.as_ref().and_then(|place| place.name().map(str::to_owned));
    Finding {
        message: diagnostic.to_string(),
        file: name.or_else(|| Some(source?.read_span(&SourceSpan::from((0, 0)), 0, 0).ok()?.name()?.to_owned())),
        line: place.as_ref().map(|place| place.line() + 1),
        column: place.as_ref().map(|place| place.column() + 1),
        help: diagnostic.help().map(|help| help.to_string()).filter(|help| !help.is_empty()),
    }
}

/// A number with a comma between thousands.
fn grouped(number: usize) -> String {
    let digits = number.to_string();
    let comma = |place: usize| place > 0 && (digits.len() - place).is_multiple_of(3);
    digits.char_indices().flat_map(|(place, digit)| comma(place).then_some(',').into_iter().chain([digit])).collect()
}

/// A text as it is shown.
fn shown(text: &dyn fmt::Display) -> String {
    let mut text = visible(&text.to_string()).into_owned();
    if text.len() > LONG_TEXT {
        text.truncate(text.floor_char_boundary(LONG_TEXT));
        text.push('…');
    }
    text
}

/// The text without characters that would control a terminal: control characters other than line ends and tabs, and
/// those that reverse the direction of writing. Each is replaced by one with the same number of bytes, so that spans
/// stay valid.
pub(crate) fn visible(text: &str) -> Cow<'_, str> {
    let steers = |c: char| {
        c.is_control() && !matches!(c, '\n' | '\t') || matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
    };
    if !text.contains(steers) {
        return Cow::Borrowed(text);
    }
    let mut rest = text.chars().peekable();
    let mut shown = String::with_capacity(text.len());
    while let Some(c) = rest.next() {
        shown.push(match c.len_utf8() {
            _ if !steers(c) || c == '\r' && rest.peek() == Some(&'\n') => c,
            1 => '?',
            2 => '·',
            _ => '\u{fffd}',
        });
    }
    Cow::Owned(shown)
}

/// A diagnostic whose long lines are cut, and whose texts are [visible].
#[derive(Debug)]
struct Cut<'d> {
    diagnostic: &'d dyn Diagnostic,
    text: Option<CutText<'d>>,
}

impl<'d> Cut<'d> {
    /// The diagnostic alone, with the text to which it refers.
    fn of(diagnostic: &'d dyn Diagnostic, text: Option<&'d dyn SourceCode>) -> Self {
        Self { diagnostic, text: text.map(CutText::of) }
    }
}

impl fmt::Display for Cut<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&shown(&self.diagnostic))
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
        self.diagnostic.help().map(|help| Box::new(shown(&help)) as _)
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.text.as_ref().map(|text| -> &dyn SourceCode { text })
    }

    /// The labels, none longer than the visible part of a long line.
    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let shown = |label: LabeledSpan| {
            let window = self.text.as_ref().and_then(|text| text.window(label.inner()));
            let length =
                window.map_or(label.len(), |window| label.len().min(window.end.saturating_sub(label.offset())));
            LabeledSpan::new(label.label().map(|label| self::shown(&label)), label.offset(), length)
        };
        self.diagnostic.labels().map(|labels| Box::new(labels.map(shown)) as _)
    }
}

/// A text whose long lines are cut.
struct CutText<'d> {
    source: &'d dyn SourceCode,
    /// The file's name and its whole text, made visible and with a final line end, unless they already were so;
    /// computed on first use.
    shown: OnceLock<Option<NamedSource<String>>>,
}

impl fmt::Debug for CutText<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("CutText").finish_non_exhaustive()
    }
}

/// The visible part of a long line.
struct Window {
    /// Where it begins and ends in the text, in bytes.
    start: usize,
    end: usize,
    /// Its line and column, from 0.
    line: usize,
    column: usize,
    name: Option<String>,
}

impl<'d> CutText<'d> {
    fn of(source: &'d dyn SourceCode) -> Self {
        Self { source, shown: OnceLock::new() }
    }

    fn made_visible(&self) -> Option<NamedSource<String>> {
        let whole = self.source.read_span(&SourceSpan::from((0, 0)), 0, usize::MAX).ok()?;
        let name = visible(whole.name().unwrap_or_default());
        let mut text = visible(std::str::from_utf8(whole.data()).ok()?);
        if !text.ends_with('\n') {
            // After the last character of a text, miette marks nothing.
            text.to_mut().push('\n');
        }
        let changed = matches!((&name, &text), (Cow::Owned(_), _) | (_, Cow::Owned(_)));
        changed.then(|| NamedSource::new(name, text.into_owned()))
    }

    fn read(
        &self,
        span: &SourceSpan,
        before: usize,
        after: usize,
    ) -> Result<Box<dyn SpanContents<'_> + '_>, MietteError> {
        match self.shown.get_or_init(|| self.made_visible()) {
            Some(shown) => shown.read_span(span, before, after),
            None => self.source.read_span(span, before, after),
        }
    }

    /// A part alone, with its starting position: its column counts characters, as everywhere, not bytes.
    fn place<'a>(&'a self, span: &SourceSpan) -> Result<Box<dyn SpanContents<'a> + 'a>, MietteError> {
        let alone = self.read(span, 0, 0)?;
        let before = SourceSpan::from((span.offset().saturating_sub(alone.column()), alone.column()));
        let column = match alone.column() {
            // Nothing comes before it, and for an empty part at the beginning of a text, miette returns the first byte.
            0 => 0,
            bytes => {
                std::str::from_utf8(self.read(&before, 0, 0)?.data()).map_or(bytes, |before| before.chars().count())
            }
        };
        Ok(contents(alone.name().map(str::to_owned), alone.data(), *alone.span(), (alone.line(), column)))
    }

    /// The visible part of the line on which a span begins, if a line around it is long.
    fn window(&self, span: &SourceSpan) -> Option<Window> {
        let around = self.read(span, 1, 1).ok()?;
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
            return self.read(span, lines_before, lines_after);
        };
        let shown = SourceSpan::from(start..end);
        let data = self.read(&shown, 0, 0)?.data();
        Ok(contents(name, data, shown, (line, column)))
    }
}

/// The visible part of a text, which begins at that line and column, counted from 0.
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
    use diagnostics::{FileProblems, Source};

    use super::*;

    fn handler() -> GraphicalReportHandler {
        GraphicalReportHandler::new_themed(miette::GraphicalTheme::none())
    }

    /// The rendering of a problem with the last word of this text.
    fn problem_at_end(text: &str, word: &str) -> String {
        let source = Source::new("file.xml", text);
        let problem = source.span(text.len() - word.len()..text.len()).problem("wrong").with_label("here");
        rendered(&handler(), [&problem as &dyn Diagnostic])
    }

    #[test]
    fn only_the_first_of_very_many_problems_are_shown() {
        let source = Source::new("file.toml", "x");
        let problems = |count: usize| {
            let problems = (0..count).map(|number| source.span(0..1).problem(format!("wrong {number}.")));
            FileProblems::none_of(problems.collect()).expect_err("problems")
        };
        let (few, many) = (problems(30), problems(10_000));
        let text = rendered(&handler(), [&few as &dyn Diagnostic, &many, &few]);
        assert_eq!(text.matches("wrong ").count(), MOST_PROBLEMS);
        assert!(text.contains("wrong 29.") && text.contains("wrong 69.") && !text.contains("wrong 70."), "{text}");
        assert!(text.ends_with("and 9,960 more\n"), "{text}");
        assert!(!rendered(&handler(), [&few as &dyn Diagnostic]).contains("more"));
        assert_eq!([1, 12, 999, 1000, 1_234_567].map(grouped), ["1", "12", "999", "1,000", "1,234,567"]);
    }

    #[test]
    fn only_the_beginning_of_a_very_long_text_is_shown() {
        let source = Source::new("file.toml", "x");
        let long = "é".repeat(10_000);
        let problem = source.span(0..1).problem(&long).with_label(&long).with_help(&long);
        assert!(rendered(&handler(), [&problem as &dyn Diagnostic]).matches('é').count() <= 3 * LONG_TEXT / 2);
    }

    #[test]
    fn the_first_byte_of_a_text_is_in_its_first_column() {
        for text in ["first", "first\nsecond", "é"] {
            let source = Source::new("file.xml", text);
            let problem = source.span(0..text.len()).problem("wrong");
            assert!(rendered(&handler(), [&problem as &dyn Diagnostic]).contains("file.xml:1:1]"), "{text}");
            assert_eq!(findings(&problem)[0].column, Some(1));
        }
        assert!(problem_at_end("first\nsecond", "second").contains("file.xml:2:1]"));
    }

    #[test]
    fn a_short_line_is_shown_in_full() {
        let text = problem_at_end("a\nfirst second\tthird", "third");
        assert!(text.contains("file.xml:2:14") && text.contains("first second"), "{text}");
    }

    #[test]
    fn the_relevant_part_of_a_long_line_is_shown() {
        for blanks in [3000, 65_000, 65_480, 65_536, 70_000, 200_000] {
            let text = problem_at_end(&format!("<a>\n{}é <Nope/>", " ".repeat(blanks)), "<Nope/>");
            assert!(text.contains(&format!("file.xml:2:{}", blanks + 3)), "{text}");
            assert!(text.contains("é <Nope/>") && text.contains("here") && text.len() < 2000, "{text}");
        }
    }

    #[test]
    fn a_long_span_is_shown_at_its_beginning() {
        let text = problem_at_end(&format!("x = {}", "y".repeat(100_000)), &"y".repeat(100_000));
        assert!(text.contains("x = yyy") && text.contains("here") && text.len() < 2000, "{text}");
    }

    #[test]
    fn a_missing_line_end_is_marked() {
        let source = Source::new("a.toml", "a =");
        let problem = source.span(3..3).problem("a value is missing").with_label("here");
        assert!(rendered(&handler(), [&problem as &dyn Diagnostic]).contains("-- here"));
    }

    #[test]
    fn nothing_in_a_file_controls_the_terminal() {
        let text = "one\r\n\u{1b}[31mtwo\u{7}\u{9b}31m \u{202e}three\n";
        let source = Source::new("a\u{1b}]0;title\u{7}.xml", text);
        let at = text.find("three").unwrap();
        let problem = source.span(at..at + 5).problem("no \u{1b}[2J").with_label("here\u{1b}").with_help("\u{8}help");
        let text = rendered(&handler(), [&problem as &dyn Diagnostic]);
        assert!(!text.chars().any(|c| c.is_control() && c != '\n'), "{text:?}");
        assert!(text.contains("?[31mtwo?·31m \u{fffd}three") && text.contains("a?]0;title?.xml:2:"), "{text}");
        assert!(text.contains("no ?[2J") && text.contains("here?") && text.contains("?help"), "{text}");
        assert_eq!(visible("a\tb\r\nc"), "a\tb\r\nc");
    }

    #[test]
    fn a_long_line_next_to_the_location_is_left_out() {
        let text = problem_at_end(&format!("{}\nshort Nope", "z".repeat(100_000)), "Nope");
        assert!(text.contains("file.xml:2:7") && text.contains("short Nope") && text.len() < 2000, "{text}");
    }
}
