//! XML made from parts of another text, with the place of each part.

use std::ops::Range;

use diagnostics::markup;

/// The translation of a file: copied parts, and words that replace others.
#[derive(Debug)]
pub(crate) struct Plain<'f> {
    file: &'f str,
    text: String,
    pieces: Vec<Piece>,
}

/// A piece of the translation, from `start` to the next piece.
#[derive(Debug)]
struct Piece {
    start: usize,
    /// The text in the file to which it corresponds.
    from: Range<usize>,
    /// Whether it is a copy, so that positions inside it are exact.
    copied: bool,
}

impl<'f> Plain<'f> {
    pub(crate) fn of(file: &'f str) -> Self {
        Self { file, text: String::new(), pieces: Vec::new() }
    }

    /// Appends the beginning of a start tag with these attributes; others may follow.
    pub(crate) fn open(&mut self, element: &str, from: &Range<usize>, attributes: &[(&str, &str)]) {
        self.write(&format!("<{element}"), from);
        attributes.iter().for_each(|(name, value)| self.attribute(name, value, from));
    }

    pub(crate) fn attribute(&mut self, name: &str, value: &str, from: &Range<usize>) {
        self.write(&format!(" {name}=\"{}\"", markup::attribute(value)), from);
    }

    /// Appends an attribute whose value is a part of the file, as XML already.
    pub(crate) fn copied_attribute(&mut self, name: &str, value: Range<usize>, from: &Range<usize>) {
        self.write(&format!(" {name}=\""), from);
        self.copy(value);
        self.write("\"", from);
    }

    /// Ends the start tag of an element with content.
    pub(crate) fn begin_content(&mut self, from: &Range<usize>) {
        self.write(">", from);
    }

    pub(crate) fn close_empty(&mut self, from: &Range<usize>) {
        self.write("/>", from);
    }

    pub(crate) fn close(&mut self, element: &str, from: &Range<usize>) {
        self.write(&format!("</{element}>"), from);
    }

    pub(crate) fn copy(&mut self, from: Range<usize>) {
        let copy = self.file.get(from.clone()).unwrap_or_default();
        self.pieces.push(Piece { start: self.text.len(), from, copied: true });
        self.text.push_str(copy);
    }

    /// Appends other words, which stand for this range of the file.
    pub(crate) fn write(&mut self, words: &str, from: &Range<usize>) {
        self.pieces.push(Piece { start: self.text.len(), from: from.clone(), copied: false });
        self.text.push_str(words);
    }

    pub(crate) fn text(&self) -> &str {
        &self.text
    }

    /// The range of the file that a range of the translation stands for.
    pub(crate) fn place(&self, range: Range<usize>) -> Range<usize> {
        let from = self.from(range.start, false);
        let to = if range.is_empty() { from } else { self.from(range.end - 1, true) };
        from..to.max(from)
    }

    /// The position of a byte, or the one after it.
    fn from(&self, byte: usize, behind: bool) -> usize {
        let after = self.pieces.partition_point(|piece| piece.start <= byte);
        let Some(piece) = after.checked_sub(1).map(|index| &self.pieces[index]) else { return 0 };
        match (piece.copied, behind) {
            (true, _) => (piece.from.start + (byte - piece.start) + usize::from(behind)).min(piece.from.end),
            (false, true) => piece.from.end,
            (false, false) => piece.from.start,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn locations_inside_copies_are_exact_and_others_are_those_of_the_replaced_words() {
        let file = "if _msg.data then";
        let mut plain = Plain::of(file);
        plain.copy(0..3);
        plain.write("_event.data", &(3..7));
        plain.copy(7..17);
        assert_eq!(plain.text(), "if _event.data.data then");
        assert_eq!(&file[plain.place(3..14)], "_msg");
        assert_eq!(&file[plain.place(3..19)], "_msg.data");
        assert_eq!(&file[plain.place(20..24)], "then");
        assert_eq!(&file[plain.place(0..2)], "if");
    }
}
