//! Places in files that people write, as programs that read results need them.

use std::fmt;
use std::ops::Range;
use std::path::{Component, Path, PathBuf};

use diagnostics::Span;

/// Of a marked text, at most this many bytes are kept: enough to recognize it again.
const MOST_TEXT: usize = 200;

/// A place in a file: a range of its text, or the file as a whole.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FilePlace {
    /// Its path, or its name in diagnostics.
    pub file: String,
    /// Whether it is no file on disk: it comes with the program.
    pub is_shipped: bool,
    /// The range; none for the file as a whole.
    pub region: Option<TextRegion>,
}

/// A range of a text. Lines and columns count from 1, offsets from 0; columns and offsets count characters (Unicode
/// code points).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TextRegion {
    /// The line on which it begins.
    pub start_line: usize,
    /// The column in which it begins.
    pub start_column: usize,
    /// The line on which it ends.
    pub end_line: usize,
    /// The column after its last character.
    pub end_column: usize,
    /// How many characters come before it.
    pub char_offset: usize,
    /// How many characters it has.
    pub char_length: usize,
    /// Its text, or the beginning of a long one.
    pub text: String,
}

impl FilePlace {
    /// A file as a whole.
    #[must_use]
    pub fn whole(file: impl Into<String>) -> Self {
        Self { file: file.into(), is_shipped: false, region: None }
    }

    /// Names the file by its path instead of its name in diagnostics; without one, it comes with the program.
    pub(crate) fn find(&mut self, path: impl Fn(&str) -> Option<String>) {
        match path(&self.file) {
            Some(path) => self.file = path,
            None => self.is_shipped = true,
        }
    }

    /// The path of the file, relative if it is below the current folder; none if it is not on disk.
    pub(crate) fn path(&self) -> Option<PathBuf> {
        let path = Path::new(&self.file);
        if self.is_shipped || !path.exists() {
            return None;
        }
        let goes_up = path.components().any(|part| part == Component::ParentDir);
        let whole = if goes_up { path.canonicalize() } else { std::path::absolute(path) }.ok()?;
        let folder = std::env::current_dir().ok()?;
        let folders = [folder.canonicalize().unwrap_or_default(), folder];
        let below = folders.iter().find_map(|folder| whole.strip_prefix(folder).ok());
        Some(below.map_or_else(|| whole.clone(), Path::to_owned))
    }

    /// The place of a span; none if its text is an assignment on the command line.
    #[must_use]
    pub fn of(span: &Span) -> Option<Self> {
        let place = || FileText::new(span.source().name().to_owned(), span.source().text()).place(span.range());
        (!span.is_assignment()).then(place)
    }
}

impl fmt::Display for FilePlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.region {
            Some(TextRegion { start_line, start_column, .. }) => write!(f, "{}:{start_line}:{start_column}", self.file),
            None => f.write_str(&self.file),
        }
    }
}

/// The text of a file, prepared to find many places in it.
#[derive(Debug)]
pub struct FileText<'t> {
    name: String,
    text: &'t str,
    /// Where each line begins, in bytes and in characters.
    lines: Vec<(usize, usize)>,
}

impl<'t> FileText<'t> {
    /// The text of a file with this name. Takes a time proportional to the text.
    #[must_use]
    pub fn new(name: String, text: &'t str) -> Self {
        let mut lines = vec![(0, 0)];
        let after_line_ends = text.char_indices().enumerate().filter(|(_, (_, character))| *character == '\n');
        lines.extend(after_line_ends.map(|(count, (byte, _))| (byte + 1, count + 1)));
        Self { name, text, lines }
    }

    /// The file as a whole.
    #[must_use]
    pub fn whole(&self) -> FilePlace {
        FilePlace::whole(&self.name)
    }

    /// The place of a range in bytes. An end that is outside the text or inside a character moves to the left.
    #[must_use]
    pub fn place(&self, range: Range<usize>) -> FilePlace {
        let start = self.text.floor_char_boundary(range.start);
        let end = self.text.floor_char_boundary(range.end.max(range.start)).max(start);
        let (start_line, start_column, char_offset) = self.position(start);
        let (end_line, end_column, char_end) = self.position(end);
        let shown = self.text.floor_char_boundary(end.min(start + MOST_TEXT)).max(start);
        let region = TextRegion {
            start_line,
            start_column,
            end_line,
            end_column,
            char_offset,
            char_length: char_end - char_offset,
            text: self.text[start..shown].to_owned(),
        };
        FilePlace { region: Some(region), ..self.whole() }
    }

    /// The line and column of a byte, from 1, and the number of characters before it.
    fn position(&self, byte: usize) -> (usize, usize, usize) {
        let line = self.lines.partition_point(|(begin, _)| *begin <= byte);
        let (begin, chars) = self.lines[line - 1];
        let before = self.text[begin..byte].chars().count();
        (line, before + 1, chars + before)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_counted_in_characters() {
        let text = FileText::new("a.toml".to_owned(), "grün = 1\r\n𝄞 = ü2\n");
        let place = |range: Range<usize>| {
            let region = text.place(range).region.expect("a region");
            let TextRegion { start_line, start_column, end_line, end_column, char_offset, char_length, .. } = region;
            ([start_line, start_column, end_line, end_column], [char_offset, char_length])
        };
        let of = |part: &str| text.text.find(part).map(|at| at..at + part.len()).expect("a part of the text");
        assert_eq!(place(of("grün")), ([1, 1, 1, 5], [0, 4]));
        assert_eq!(place(of("= ü2")), ([2, 3, 2, 7], [12, 4]));
        assert_eq!(place(of("1\r\n𝄞")), ([1, 8, 2, 2], [7, 4]));
        assert_eq!(place(900..901), ([3, 1, 3, 1], [17, 0]), "beyond the end");
        assert_eq!(FileText::new("empty".to_owned(), "").place(0..0).region.expect("a region").start_line, 1);
    }

    #[test]
    fn an_assignment_on_the_command_line_is_in_no_file() {
        let span = diagnostics::Source::new("--set", "a=1").span(0..1);
        assert_eq!(FilePlace::of(&span), None);
    }
}
