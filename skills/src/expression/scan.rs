//! A rough lexer for any ECMAScript: words and marks, declarations, nesting.
//!
//! It reads strings and comments but no grammar, and never fails; it does not check whether the text is ECMAScript.

use std::ops::Range;

/// A piece of a source text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Piece {
    /// A name, keyword or number.
    Word,
    /// A punctuation character; `=>` counts as `>` after `=`.
    Mark(u8),
    /// A string or a template.
    Text,
    LineEnd,
}

/// The pieces with their positions, without comments and white space.
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
            // Only a grammar distinguishes a division from a regular expression, which is therefore words and marks.
            _ => Some((Piece::Mark(byte), 1)),
        };
        if let Some((piece, length)) = piece {
            at += length;
            pieces.push((piece, start..at));
        }
    }
    pieces
}

/// A string ends at its quote or, unless it is a template, at the end of its line.
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

/// The words in a source, including those in templates.
pub(crate) fn words(source: &str) -> impl Iterator<Item = &str> {
    source
        .split(|c: char| !(c.is_alphanumeric() || c == '_' || c == '$'))
        .filter(|word| word.starts_with(|c: char| !c.is_ascii_digit()))
}

/// The declarations of a script outside of functions.
#[derive(Debug, Default, PartialEq, Eq)]
pub(crate) struct Declarations {
    /// The names declared by `var`, `let` and `const`.
    pub(crate) variables: Vec<String>,
    /// The names of functions.
    pub(crate) functions: Vec<String>,
    /// The positions after `=` where variables and their members get values.
    pub(crate) values: Vec<usize>,
    /// The script with spaces instead of `var`, `let` and `const`: the declared variables become data.
    pub(crate) script: String,
}

/// An open bracket, and what it means for its contents.
#[derive(Clone, Copy)]
enum Open {
    /// A bracket or brace of no particular meaning.
    Plain,
    /// The parenthesis after `if`, `for` and similar keywords.
    Head,
    /// Any other parenthesis.
    Parenthesis,
    /// The body of a function.
    Body,
}

/// Finds the declarations of a script outside of functions.
pub(crate) fn declarations(source: &str) -> Declarations {
    let found = Declarations { script: source.to_owned(), ..Declarations::default() };
    let (pieces, open) = (pieces(source), Vec::new());
    let mut search = DeclarationSearch { source, pieces, open, closed: Open::Plain, declaring: None, found };
    for index in 0..search.pieces.len() {
        search.read(index);
    }
    search.found
}

struct DeclarationSearch<'s> {
    source: &'s str,
    pieces: Vec<(Piece, Range<usize>)>,
    /// The brackets around the current position.
    open: Vec<Open>,
    /// The bracket closed last.
    closed: Open,
    /// The number of brackets around the current declaration.
    declaring: Option<usize>,
    found: Declarations,
}

impl<'s> DeclarationSearch<'s> {
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
            Piece::Mark(b'=') if self.assigns(before) => self.found.values.push(self.pieces[index].1.end),
            _ => {}
        }
    }

    /// The meaning of the bracket that opens here.
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
            Piece::Mark(b'(') => Open::Parenthesis,
            _ => Open::Plain,
        }
    }

    /// Whether `=` after this piece may assign to a variable: in a parenthesis, it may give a parameter its default.
    fn assigns(&self, before: Piece) -> bool {
        matches!(before, Piece::Word | Piece::Mark(b']')) && self.open.iter().all(|open| matches!(open, Open::Plain))
    }

    /// The declaration that a word outside of functions makes, if any.
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

    /// The word there, or an empty string.
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

/// The maximum nesting of a source: a parser recurses to the same depth. This and the weight are chosen, not measured.
const MAX_DEPTH: usize = 250;
/// The weight of a bracket: a parser goes through all levels of the grammar for each.
const BRACKET: usize = 6;

/// The position at which a source is nested too deeply to be parsed, if there is one: nested brackets and operators,
/// for each of which a parser recurses. Each statement starts again from zero.
pub(crate) fn too_deep(source: &str) -> Option<Range<usize>> {
    let pieces = pieces(source);
    // In templates and regular expressions, marks are not what they seem; there everything counts.
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

/// Whether a word after this piece must begin a statement, unless it is an operator.
fn ends_statement((piece, text): (Piece, &str)) -> bool {
    match piece {
        Piece::Mark(mark) => mark == b'}',
        Piece::Word => !RECURS.contains(&text),
        Piece::Text | Piece::LineEnd => false,
    }
}

/// Words that continue the previous expression.
const CONTINUES: [&str; 7] = ["else", "in", "instanceof", "catch", "finally", "while", "of"];

/// Words after which a parser recurses.
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
    fn deep_nesting_is_found_and_long_code_is_accepted() {
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
    fn strings_and_comments_are_not_words() {
        let marks = |source| pieces(source).iter().filter(|(piece, _)| matches!(piece, Piece::Mark(_))).count();
        assert_eq!(marks("'(((' + \"[\\\"[\" // {\n /* { */ x"), 1);
    }
}
