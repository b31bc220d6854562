//! A rough reading of any ECMAScript: its words and marks, what it declares, how deeply it is nested.
//!
//! It knows strings and comments and nothing of grammar, and it never fails; whether the text is ECMAScript is for others
//! to say.

use std::ops::Range;

/// A piece of a source text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Piece {
    /// A name, keyword or number.
    Word,
    /// A character of punctuation; `=>` counts as `>` behind `=`.
    Mark(u8),
    /// A string or a template.
    Text,
    LineEnd,
}

/// The pieces with their places. Comments and blanks are left out.
pub(crate) fn pieces(source: &str) -> Vec<(Piece, Range<usize>)> {
    let bytes = source.as_bytes();
    let is_word = |byte: u8| byte.is_ascii_alphanumeric() || byte == b'_' || byte == b'$' || !byte.is_ascii();
    let mut pieces = Vec::new();
    let mut at = 0;
    while let Some(&byte) = bytes.get(at) {
        let start = at;
        let rest = &bytes[at..];
        let until = |end: &[u8]| rest.windows(end.len()).position(|window| window == end);
        let piece = match byte {
            b'\n' => Some((Piece::LineEnd, 1)),
            b'/' if rest.starts_with(b"//") => {
                at += until(b"\n").unwrap_or(rest.len());
                None
            }
            b'/' if rest.starts_with(b"/*") => {
                at += until(b"*/").map_or(rest.len(), |end| end + 2);
                None
            }
            b'"' | b'\'' | b'`' => Some((Piece::Text, string_length(rest, byte))),
            _ if is_word(byte) => {
                let length = rest.iter().position(|byte| !is_word(*byte)).unwrap_or(rest.len());
                Some((Piece::Word, length))
            }
            _ if byte.is_ascii_whitespace() => {
                at += 1;
                None
            }
            _ => Some((Piece::Mark(byte), 1)),
        };
        if let Some((piece, length)) = piece {
            at += length;
            pieces.push((piece, start..at));
        }
    }
    pieces
}

/// A string ends at its quote or, if it is no template, with its line.
fn string_length(bytes: &[u8], quote: u8) -> usize {
    let mut at = 1;
    while let Some(&byte) = bytes.get(at) {
        match byte {
            b'\\' => at += 2,
            b'\n' if quote != b'`' => return at,
            _ if byte == quote => return at + 1,
            _ => at += 1,
        }
    }
    bytes.len()
}

/// The words that occur in a source, those in templates included.
pub(crate) fn words(source: &str) -> impl Iterator<Item = &str> {
    source
        .split(|c: char| !(c.is_alphanumeric() || c == '_' || c == '$'))
        .filter(|word| word.starts_with(|c: char| !c.is_ascii_digit()))
}

/// What a script declares outside of functions.
#[derive(Debug, Default, PartialEq, Eq)]
pub(crate) struct Declarations {
    /// The names declared by `var`, `let` and `const`.
    pub(crate) variables: Vec<String>,
    /// The names of functions.
    pub(crate) functions: Vec<String>,
    /// The script with blanks in place of `var`, `let` and `const`: what they declare are data.
    pub(crate) script: String,
}

/// Brackets that are open, and what that means for what stands in them.
#[derive(Clone, Copy)]
enum Open {
    /// A bracket or brace of no particular meaning.
    Plain,
    /// The parenthesis behind `if`, `for` and their kin.
    Head,
    /// The body of a function.
    Body,
}

/// Reads what a script declares outside of functions.
pub(crate) fn declarations(source: &str) -> Declarations {
    let found = Declarations { script: source.to_owned(), ..Declarations::default() };
    let (pieces, open) = (pieces(source), Vec::new());
    let mut reading = Reading { source, pieces, open, closed: Open::Plain, declaring: None, found };
    for index in 0..reading.pieces.len() {
        reading.read(index);
    }
    reading.found
}

/// A script that is being read for what it declares.
struct Reading<'s> {
    source: &'s str,
    pieces: Vec<(Piece, Range<usize>)>,
    /// The brackets around the place that has been reached.
    open: Vec<Open>,
    /// The bracket that was closed last.
    closed: Open,
    /// How many brackets are open around the declaration that goes on.
    declaring: Option<usize>,
    found: Declarations,
}

impl<'s> Reading<'s> {
    fn read(&mut self, index: usize) {
        let before = self.before(index);
        match self.pieces[index].0 {
            Piece::Mark(b'(' | b'{' | b'[') => self.open.push(self.opened(index)),
            Piece::Mark(b')' | b'}' | b']') => {
                self.closed = self.open.pop().unwrap_or(Open::Plain);
                self.declaring = self.declaring.filter(|depth| *depth <= self.open.len());
            }
            Piece::Mark(b';') => self.declaring = None,
            Piece::LineEnd if before != Piece::Mark(b',') => {
                self.declaring = self.declaring.filter(|depth| *depth < self.open.len());
            }
            Piece::Mark(b',') if self.declaring == Some(self.open.len()) && !self.word(index + 1).is_empty() => {
                self.found.variables.push(self.word(index + 1).to_owned());
            }
            Piece::Word if before != Piece::Mark(b'.') && !self.open.iter().any(|open| matches!(open, Open::Body)) => {
                self.declare(index, before);
            }
            _ => {}
        }
    }

    /// What the bracket means that opens here.
    fn opened(&self, index: usize) -> Open {
        let before = self.before(index);
        match self.pieces[index].0 {
            Piece::Mark(b'(')
                if ["if", "for", "while", "switch", "catch", "with"].contains(&self.word(index.wrapping_sub(1))) =>
            {
                Open::Head
            }
            Piece::Mark(b'{') if before == Piece::Mark(b')') && !matches!(self.closed, Open::Head) => Open::Body,
            Piece::Mark(b'{') if before == Piece::Mark(b'>') => Open::Body,
            _ => Open::Plain,
        }
    }

    /// What a word outside of functions declares, if it does.
    fn declare(&mut self, index: usize, before: Piece) {
        let (span, name) = (self.pieces[index].1.clone(), self.word(index + 1));
        match &self.source[span.clone()] {
            "var" | "let" | "const" if !name.is_empty() => {
                self.found.variables.push(name.to_owned());
                self.found.script.replace_range(span.clone(), &" ".repeat(span.len()));
                self.declaring = Some(self.open.len());
            }
            "function" if !name.is_empty() && starts_statement(before) => self.found.functions.push(name.to_owned()),
            _ => {}
        }
    }

    fn before(&self, index: usize) -> Piece {
        index.checked_sub(1).map_or(Piece::Mark(b';'), |before| self.pieces[before].0)
    }

    /// The word there; nothing if there is something else.
    fn word(&self, index: usize) -> &'s str {
        match self.pieces.get(index) {
            Some((Piece::Word, span)) => &self.source[span.clone()],
            _ => "",
        }
    }
}

fn starts_statement(before: Piece) -> bool {
    matches!(before, Piece::LineEnd | Piece::Mark(b';' | b'{' | b'}' | b')'))
}

/// How deeply the parts of a source may lie in each other: what reads it goes down as deep.
const MAX_DEPTH: usize = 250;
/// What a bracket counts: a reader goes through all of the grammar's levels for each.
const BRACKET: usize = 6;

/// Where a source becomes too deeply nested to be read, if it does: brackets in brackets and operators on operators, for
/// each of which a reader goes down a level. A statement begins anew.
pub(crate) fn too_deep(source: &str) -> Option<Range<usize>> {
    let pieces = pieces(source);
    // In templates and regular expressions marks are not what they seem to be; there everything counts.
    let is_plain = !source.contains('`') && !pieces.iter().any(|(piece, _)| *piece == Piece::Mark(b'/'));
    let mut levels = vec![0_usize];
    let mut last: (Piece, &str) = (Piece::Mark(b';'), "");
    for (piece, span) in &pieces {
        let text = &source[span.clone()];
        let depth = levels.len();
        let level = levels.last_mut().expect("the outermost level is never closed");
        match piece {
            Piece::LineEnd => continue,
            Piece::Mark(b'(' | b'[' | b'{') => levels.push(BRACKET),
            Piece::Mark(b')' | b']' | b'}') if is_plain && depth > 1 => {
                levels.pop();
            }
            Piece::Mark(b';') if is_plain => *level = (*level).min(BRACKET),
            Piece::Mark(b',') if is_plain => *level = (*level).min(BRACKET),
            Piece::Mark(_) => *level += 1,
            Piece::Word if is_plain && ends_statement(last) && !CONTINUES.contains(&text) => {
                *level = (*level).min(BRACKET);
            }
            Piece::Word => *level += usize::from(RECURS.contains(&text)),
            Piece::Text => *level += text.matches("${").count(),
        }
        last = (*piece, text);
        if levels.iter().sum::<usize>() > MAX_DEPTH {
            return Some(span.clone());
        }
    }
    None
}

/// Whether a word behind this must begin a statement, if it is no operator.
fn ends_statement((piece, text): (Piece, &str)) -> bool {
    match piece {
        Piece::Mark(mark) => mark == b'}',
        Piece::Word => !RECURS.contains(&text),
        Piece::Text | Piece::LineEnd => false,
    }
}

/// Words that go on with what stands before them.
const CONTINUES: [&str; 7] = ["else", "in", "instanceof", "catch", "finally", "while", "of"];

/// Words behind which a reader goes down a level.
const RECURS: [&str; 23] = [
    "typeof",
    "void",
    "delete",
    "new",
    "await",
    "yield",
    "if",
    "else",
    "for",
    "while",
    "do",
    "with",
    "in",
    "of",
    "instanceof",
    "function",
    "class",
    "async",
    "try",
    "switch",
    "return",
    "throw",
    "case",
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn declarations_outside_of_functions_are_found() {
        let found = declarations(
            "var a = 1, b = {c: 1, d: 2}, e\nlet f; for (const g of [1]) { var h = 'var x' } // var y\n\
             function i(j) { var k; let l } class M { n() { var o } }\nvar p = function q() { var r }, s = () => { var t }",
        );
        assert_eq!(found.variables, ["a", "b", "e", "f", "g", "h", "p", "s"]);
        assert_eq!(found.functions, ["i"]);
        assert!(found.script.starts_with("    a = 1, b = {c: 1, d: 2}, e\n    f; for (      g of [1]) {     h ="));
        assert!(found.script.contains("function i(j) { var k; let l }"));
    }

    #[test]
    fn what_is_nested_too_deeply_is_found_and_what_is_long_is_not() {
        for nested in ["(", "[", "!", "-", "a=>", "1+", "new ", "x.y", "if(a)", "`${", "a?b:", "x=", "/;/+"] {
            assert!(too_deep(&nested.repeat(300)).is_some(), "{nested}");
        }
        assert!(too_deep(&"x = x + 1;".repeat(2000)).is_none());
        assert!(too_deep(&"f(x, {a: [1, 2, 3]});\n".repeat(2000)).is_none());
        assert!(too_deep(&"if (x) { y = a.b }\n".repeat(2000)).is_none());
        assert!(too_deep(&"x = a + b\n".repeat(2000)).is_none());
        assert!(too_deep(&format!("[{}1]", "1, 2, ".repeat(2000))).is_none());
    }

    #[test]
    fn strings_and_comments_are_no_words() {
        let marks = |source| pieces(source).iter().filter(|(piece, _)| matches!(piece, Piece::Mark(_))).count();
        assert_eq!(marks("'(((' + \"[\\\"[\" // {\n /* { */ x"), 1);
    }
}
