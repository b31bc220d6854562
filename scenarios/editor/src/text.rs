//! Positions in a text, as editors count them.

use std::ops::Range;

/// How an editor counts within a line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Unit {
    /// Bytes of UTF-8.
    Utf8,
    /// Units of UTF-16, the default of the language server protocol.
    #[default]
    Utf16,
}

impl Unit {
    fn length(self, text: &str) -> usize {
        match self {
            Self::Utf8 => text.len(),
            Self::Utf16 => text.chars().map(char::len_utf16).sum(),
        }
    }
}

/// A place in a text: its line and how far into the line it is, both from 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Position {
    /// The line.
    pub line: u32,
    /// How far into the line, in a [`Unit`].
    pub character: u32,
}

/// The lines of a text. A line ends with `\n`, `\r\n` or `\r`.
#[derive(Clone, Debug)]
pub struct TextLines<'t> {
    text: &'t str,
    /// The first byte of each line.
    starts: Vec<usize>,
    /// What the editor counts at the beginning of the first line, though it is no part of the text.
    before: &'static str,
}

/// The byte order mark, with which an editor's text may begin.
pub(crate) const MARK: &str = "\u{feff}";

impl<'t> TextLines<'t> {
    /// The lines of a text.
    #[must_use]
    pub fn of(text: &'t str) -> Self {
        let bytes = text.as_bytes();
        let ends = |at: &usize| bytes[*at] == b'\n' || bytes[*at] == b'\r' && bytes.get(at + 1) != Some(&b'\n');
        let starts = std::iter::once(0).chain((0..bytes.len()).filter(ends).map(|end| end + 1)).collect();
        Self { text, starts, before: "" }
    }

    /// The lines of the same text behind a byte order mark.
    #[must_use]
    pub fn after_mark(self) -> Self {
        Self { before: MARK, ..self }
    }

    /// What the editor counts before the text in this line.
    fn before(&self, line: usize, unit: Unit) -> usize {
        if line == 0 { unit.length(self.before) } else { 0 }
    }

    /// The position of a byte. One that is outside the text or inside a character moves to the left.
    #[must_use]
    pub fn position(&self, byte: usize, unit: Unit) -> Position {
        let byte = self.text.floor_char_boundary(byte);
        let line = self.starts.partition_point(|start| *start <= byte) - 1;
        let character = self.before(line, unit) + unit.length(&self.text[self.starts[line]..byte]);
        Position { line: short(line), character: short(character) }
    }

    /// The positions at both ends of a range of bytes.
    #[must_use]
    pub fn positions(&self, range: &Range<usize>, unit: Unit) -> Range<Position> {
        self.position(range.start, unit)..self.position(range.end.max(range.start), unit)
    }

    /// The byte at a position. One after the end of a line is that end, and one inside a character moves to the left.
    #[must_use]
    pub fn byte(&self, position: Position, unit: Unit) -> usize {
        let line = position.line as usize;
        let Some(start) = self.starts.get(line) else { return self.text.len() };
        let before = self.before(line, unit);
        let end = self.starts.get(line + 1).copied().unwrap_or(self.text.len());
        let line = self.text[*start..end].trim_end_matches(['\n', '\r']);
        let mut left = (position.character as usize).saturating_sub(before);
        let inside = line.char_indices().find(|(_, character)| {
            let length = unit.length(character.encode_utf8(&mut [0; 4]));
            let fits = length <= left;
            left = left.saturating_sub(length);
            !fits
        });
        start + inside.map_or(line.len(), |(at, _)| at)
    }
}

/// Texts are read up to 16 MiB.
fn short(count: usize) -> u32 {
    u32::try_from(count).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_are_counted_in_the_units_of_the_editor() {
        let lines = TextLines::of("a\r\nä𝄞b\n");
        let places = [(0, 0, 0), (3, 0, 0), (5, 2, 1), (9, 6, 3), (10, 7, 4)];
        for (byte, utf8, utf16) in places {
            let line = u32::from(byte > 0);
            for (unit, character) in [(Unit::Utf8, utf8), (Unit::Utf16, utf16)] {
                let position = Position { line, character };
                assert_eq!(lines.position(byte, unit), position);
                assert_eq!(lines.byte(position, unit), byte);
            }
        }
        assert_eq!(lines.position(11, Unit::Utf8), Position { line: 2, character: 0 });
    }

    #[test]
    fn a_byte_order_mark_counts_in_the_first_line_only() {
        let lines = TextLines::of("ab\nc").after_mark();
        for (byte, line, character) in [(0, 0, 1), (2, 0, 3), (4, 1, 1)] {
            assert_eq!(lines.position(byte, Unit::Utf16), Position { line, character });
            assert_eq!(lines.byte(Position { line, character }, Unit::Utf16), byte);
        }
        assert_eq!(lines.byte(Position::default(), Unit::Utf16), 0);
    }

    #[test]
    fn positions_outside_the_text_move_into_it() {
        let lines = TextLines::of("ab\n𝄞");
        let at = |line, character| lines.byte(Position { line, character }, Unit::Utf16);
        assert_eq!([at(0, 9), at(1, 1), at(1, 9), at(7, 0)], [2, 3, 7, 7]);
        assert_eq!(lines.position(99, Unit::Utf16), Position { line: 1, character: 2 });
        assert_eq!(lines.position(5, Unit::Utf16), Position { line: 1, character: 0 });
    }
}
