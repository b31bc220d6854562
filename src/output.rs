//! Output to stdout and stderr.
//!
//! Colors are for terminals: `anstream` leaves them out elsewhere, and if NO_COLOR or CLICOLOR requires that. Names and
//! texts of files may contain anything; characters that would control a terminal are made [visible] before they get
//! here.

use std::io::{self, IsTerminal, Write};
use std::ops::AddAssign;
use std::path::PathBuf;

use anstyle::{AnsiColor, Style};
use campaigns::Error;
use miette::{Diagnostic, GraphicalReportHandler, GraphicalTheme};
use scenarios::scenario::Scenario;
use serde::Serialize;
use terminal_size::{Width, terminal_size};

use crate::render::{rendered, visible};

/// Success.
pub(crate) const GOOD: Style = AnsiColor::Green.on_default().bold();
/// What is not.
pub(crate) const BAD: Style = AnsiColor::Red.on_default().bold();
/// What is undecided.
pub(crate) const OPEN: Style = AnsiColor::Yellow.on_default().bold();
/// The subject of a line.
pub(crate) const HEAD: Style = Style::new().bold();

/// The longest line of an explanation or of a diagnostic's help, however wide the terminal is.
const LONGEST_HELP: usize = 100;

/// A text for people. What is added to it is made [visible]; only [`paint`](Self::paint) adds colors.
#[derive(Clone, Debug, Default)]
pub(crate) struct Text(String);

impl Text {
    /// Adds a word in a color, padded with blanks to `width`.
    pub(crate) fn paint(&mut self, style: Style, word: &str, width: usize) {
        let blanks = " ".repeat(width.saturating_sub(word.chars().count()));
        self.0 += &format!("{style}{}{style:#}{blanks}", visible(word));
    }
}

impl<T: AsRef<str>> AddAssign<T> for Text {
    fn add_assign(&mut self, text: T) {
        self.0.push_str(&visible(text.as_ref()));
    }
}

impl<T: AsRef<str>> From<T> for Text {
    fn from(text: T) -> Self {
        Self(visible(text.as_ref()).into_owned())
    }
}

/// Writes data to stdout, control characters made [visible]. A closed pipe is not an error.
///
/// # Errors
/// If stdout cannot be written to for another reason.
pub(crate) fn print(text: &str) -> Result<(), Error> {
    write_to(&mut io::stdout(), &visible(text))
}

/// Writes a file to stdout as it is, for other programs. On a terminal, control characters are made [visible].
///
/// # Errors
/// As [`print`].
pub(crate) fn print_exactly(text: &str) -> Result<(), Error> {
    let mut stdout = io::stdout();
    if stdout.is_terminal() { print(text) } else { write_to(&mut stdout, text) }
}

/// Writes a value to stdout, as JSON.
///
/// # Errors
/// As [`print`].
pub(crate) fn print_json(value: &impl Serialize) -> Result<(), Error> {
    print(&(serde_json::to_string_pretty(value).expect("printed values are always JSON") + "\n"))
}

/// Writes a value to stdout, as a line of JSON.
///
/// # Errors
/// As [`print`].
pub(crate) fn print_json_line(value: &impl Serialize) -> Result<(), Error> {
    print(&(serde_json::to_string(value).expect("printed values are always JSON") + "\n"))
}

/// Writes results for people to stdout: wrapped to the terminal's width, or unwrapped without a terminal.
///
/// # Errors
/// As [`print`].
pub(crate) fn print_wrapped(text: impl Into<Text>) -> Result<(), Error> {
    write_in_lines(text.into(), width_of(&io::stdout()))
}

/// Writes an explanation to stdout: wrapped to the terminal's width, or to 80 columns without a terminal.
///
/// # Errors
/// As [`print`].
pub(crate) fn explain(text: impl Into<Text>) -> Result<(), Error> {
    write_in_lines(text.into(), Some(width_of(&io::stdout()).map_or(80, |width| width.min(LONGEST_HELP))))
}

fn write_in_lines(Text(text): Text, width: Option<usize>) -> Result<(), Error> {
    let broken = |width| text.split_inclusive('\n').map(|line| fit(line, width)).collect();
    write_to(&mut anstream::stdout(), &width.map_or_else(|| text.clone(), broken))
}

fn write_to(stdout: &mut impl Write, text: &str) -> Result<(), Error> {
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(source) if source.kind() != io::ErrorKind::BrokenPipe => {
            Err(diagnostics::Error::Write { path: PathBuf::from("<stdout>"), source }.into())
        }
        _ => Ok(()),
    }
}

/// The terminal's width, or otherwise the value of COLUMNS; `None` if neither is known.
fn width_of(stream: &impl IsTerminal) -> Option<usize> {
    let columns = || std::env::var("COLUMNS").ok()?.parse().ok();
    let terminal = if stream.is_terminal() { terminal_size() } else { None };
    let width = terminal.map(|(Width(width), _)| usize::from(width)).or_else(columns);
    width.map(|width| width.max(40))
}

/// A line of a table or a text, wrapped between words. Continuation lines begin where the line's last column does.
fn fit(line: &str, width: usize) -> String {
    let (text, end) = line.strip_suffix('\n').map_or((line, ""), |text| (text, "\n"));
    if textwrap::core::display_width(text) <= width {
        return line.to_owned();
    }
    let indent = " ".repeat(last_column(&anstream::adapter::strip_str(text).to_string()).min(width / 2));
    let options = textwrap::Options::new(width).subsequent_indent(&indent).break_words(false);
    let options = options.word_splitter(textwrap::WordSplitter::NoHyphenation);
    let options = options.word_separator(textwrap::WordSeparator::AsciiSpace);
    textwrap::fill(text, options) + end
}

/// Where the last column of a line begins: after the last sequence of two or more blanks in its first 50 characters.
fn last_column(line: &str) -> usize {
    let mut column = line.chars().take_while(|c| *c == ' ').count();
    let mut blanks = 0;
    for (at, c) in line.chars().enumerate().take(50).skip(column) {
        if c != ' ' && blanks >= 2 {
            column = at;
        }
        blanks = if c == ' ' { blanks + 1 } else { 0 };
    }
    column
}

/// Writes an error to stderr, each diagnostic with the text to which it refers.
pub(crate) fn complain(error: &Error) {
    match error.diagnostics() {
        none if none.is_empty() => complain_of(format!("error: {error}\n")),
        diagnostics => show(diagnostics),
    }
}

/// Writes warnings to stderr.
pub(crate) fn warn(diagnostic: &dyn Diagnostic) {
    show([diagnostic]);
}

fn show<'d>(diagnostics: impl IntoIterator<Item = &'d dyn Diagnostic>) {
    let stderr = io::stderr();
    let colored = anstream::AutoStream::choice(&stderr) != anstream::ColorChoice::Never;
    let theme = if stderr.is_terminal() || colored { GraphicalTheme::unicode() } else { GraphicalTheme::none() };
    let width = width_of(&stderr).map_or(LONGEST_HELP, |width| width.min(LONGEST_HELP));
    let handler = GraphicalReportHandler::new_themed(theme).with_width(width).with_break_words(false);
    // If stderr is closed, it is lost.
    let _ = anstream::stderr().write_all(rendered(&handler, diagnostics).as_bytes());
}

/// Writes lines to stderr.
pub(crate) fn complain_of(text: impl Into<Text>) {
    let _ = anstream::stderr().write_all(text.into().0.as_bytes());
}

/// Names the files that a scenario takes from elsewhere, on stderr.
pub(crate) fn note_elsewhere(scenario: &Scenario) {
    for words in scenario.elsewhere_in_words() {
        note(&format!("{}: {words}", scenario.origin.argument));
    }
}

/// Writes one line to stderr that a user should know.
pub(crate) fn note(text: &str) {
    complain_of(format!("note: {text}\n"));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_line_continues_below_its_last_column() {
        let line = "phi1   violated  at tick 21, 21.02 s: BatteryReader → BatteryLevel [<ok>, 9.975]\n";
        let broken =
            "phi1   violated  at tick 21, 21.02 s: BatteryReader →\n                 BatteryLevel [<ok>, 9.975]\n";
        assert_eq!(fit(line, 54), broken);
        assert_eq!(fit(line, 80), line);
        let mut painted = Text::from("  ");
        painted.paint(BAD, "violated", 10);
        assert_eq!(painted.0.len(), 12 + BAD.render().to_string().len() + BAD.render_reset().to_string().len());
        assert_eq!(fit(&painted.0, 12), painted.0, "colors take no space");
    }

    #[test]
    fn only_paint_colors_text() {
        assert_eq!(Text::from("\u{1b}[31mred").0, "?[31mred");
    }
}
