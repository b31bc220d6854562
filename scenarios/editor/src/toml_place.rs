//! Where a cursor is in a TOML file, complete or not.

use std::ops::Range;

use serde_json::Value;
use toml_parser::Source;
use toml_parser::lexer::TokenKind;

/// What the text at a cursor is, or will be.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum TomlPlace {
    /// A key, or a part of one between dots.
    Key {
        /// The table: the parts of its path, and before a dot those of the key.
        table: Vec<String>,
        /// Whether it begins a line outside of all brackets.
        begins_line: bool,
        /// Keys that the table has already.
        present: Vec<Present>,
    },
    /// The path of a table, in a header, up to the part at the cursor.
    Header {
        /// The parts before.
        table: Vec<String>,
        /// Whether it is that of an item of an array: `[[…]]`.
        is_item: bool,
        /// Keys that the table has already, and what other headers have here.
        present: Vec<Present>,
    },
    /// The value of the key with this path, or an item of it.
    Value {
        /// The path of the key.
        key: Vec<String>,
        /// Whether quotes are already there.
        is_quoted: bool,
    },
}

/// A key that a table has, and its value if that is a string or a Boolean value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Present {
    pub(crate) name: String,
    pub(crate) value: Option<Value>,
}

/// The place at a cursor, and the range of the word or string there, without quotes. Nothing in comments and between
/// values.
pub(crate) fn place(text: &str, at: usize) -> Option<(TomlPlace, Range<usize>)> {
    let AtCursor { mut place, word, instance, walk } = find(text, at)?;
    match &mut place {
        TomlPlace::Key { table, present, .. } => {
            let beside =
                walk.keys.iter().filter(|key| key.instance == instance && key.table == *table && key.at != word.start);
            present.extend(beside.map(|key| key.present.clone()));
        }
        TomlPlace::Header { table, is_item, present } => {
            let begun = text[..word.start].rsplit(['\n', '\r']).next().unwrap_or_default();
            *is_item = begun.trim_start().starts_with("[[");
            let others = walk.parts.iter().filter(|part| part.is_header && part.table == *table);
            let others = others.filter(|part| part.range.start != word.start).map(|part| part.name.clone());
            present.extend(others.map(|name| Present { name, value: None }));
            present.extend(walk.keys.iter().filter(|key| key.table == *table).map(|key| key.present.clone()));
        }
        TomlPlace::Value { .. } => {}
    }
    Some((place, word))
}

/// The string that a key with this path has in the table at a cursor, which may be one of several.
pub(crate) fn beside(text: &str, at: usize, key: &[&str]) -> Option<String> {
    let AtCursor { instance, walk, .. } = find(text, at)?;
    walk.texts.into_iter().find(|text| text.instance == instance && text.key == key).map(|text| text.value)
}

/// What is at a cursor, in which table, and all that was seen on the way through the text.
struct AtCursor {
    place: TomlPlace,
    word: Range<usize>,
    instance: usize,
    walk: TokenWalk,
}

fn find(text: &str, at: usize) -> Option<AtCursor> {
    let mut walk = TokenWalk::default();
    let mut found = None;
    for token in tokens(text) {
        // A cursor at the end of a word is in the word; one among the quotes of a string is not in the string.
        let is_here = match token.kind {
            Kind::Word | Kind::Text | Kind::OpenText => token.content.start <= at && at <= token.content.end,
            Kind::Comment => token.range.start < at && at <= token.range.end,
            _ => false,
        };
        if found.is_none() && (is_here || token.range.start >= at) {
            if token.kind == Kind::Comment && is_here {
                return None;
            }
            let is_quoted = is_here && token.kind != Kind::Word;
            let word = if is_here { token.content.clone() } else { at..at };
            found = Some((walk.place(is_quoted)?, word, walk.instance()));
        }
        walk.step(text, &token);
    }
    let (place, word, instance) = match found {
        Some(found) => found,
        None => (walk.place(false)?, at..at, walk.instance()),
    };
    Some(AtCursor { place, word, instance, walk })
}

/// A part of a key or of a header.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct KeyPart {
    /// The table in which it is: all parts before.
    pub(crate) table: Vec<String>,
    pub(crate) name: String,
    /// Its range, without quotes.
    pub(crate) range: Range<usize>,
    /// Whether it is in a header.
    pub(crate) is_header: bool,
}

/// A string.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Text {
    /// The path of the key whose value it is, or in whose value.
    pub(crate) key: Vec<String>,
    pub(crate) value: String,
    /// Its range, without quotes.
    pub(crate) range: Range<usize>,
    instance: usize,
}

/// All keys and strings of a file, in the order of the file.
pub(crate) fn contents(text: &str) -> (Vec<KeyPart>, Vec<Text>) {
    let mut walk = TokenWalk::default();
    tokens(text).iter().for_each(|token| walk.step(text, token));
    (walk.parts, walk.texts)
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Word,
    /// A string with both of its quotes.
    Text,
    /// A string that ends with the line instead.
    OpenText,
    Sign(u8),
    NewLine,
    Comment,
}

#[derive(Clone, Debug)]
struct Token {
    kind: Kind,
    range: Range<usize>,
    /// The range of its content, without quotes.
    content: Range<usize>,
}

fn tokens(text: &str) -> Vec<Token> {
    let token = |lexed: toml_parser::lexer::Token| {
        let range = lexed.span().start()..lexed.span().end();
        let string = |quote: &str, has_escapes: bool| {
            let inside = text[range.clone()].strip_prefix(quote).and_then(|rest| rest.strip_suffix(quote));
            let escapes = |inside: &str| inside.bytes().rev().take_while(|byte| *byte == b'\\').count();
            let is_closed = inside.is_some_and(|inside| !has_escapes || escapes(inside).is_multiple_of(2));
            let start = range.start + quote.len();
            if is_closed { (Kind::Text, start..range.end - quote.len()) } else { (Kind::OpenText, start..range.end) }
        };
        let (kind, content) = match lexed.kind() {
            TokenKind::Whitespace | TokenKind::Eof => return None,
            TokenKind::LiteralString => string("'", false),
            TokenKind::BasicString => string("\"", true),
            TokenKind::MlLiteralString => string("'''", false),
            TokenKind::MlBasicString => string("\"\"\"", true),
            TokenKind::Newline => (Kind::NewLine, range.clone()),
            TokenKind::Comment => (Kind::Comment, range.clone()),
            TokenKind::Atom => (Kind::Word, range.clone()),
            TokenKind::Dot
            | TokenKind::Equals
            | TokenKind::Comma
            | TokenKind::LeftSquareBracket
            | TokenKind::RightSquareBracket
            | TokenKind::LeftCurlyBracket
            | TokenKind::RightCurlyBracket => (Kind::Sign(text.as_bytes()[range.start]), range.clone()),
        };
        Some(Token { kind, range, content })
    };
    Source::new(text).lex().filter_map(token).collect()
}

/// A key of a table, for what is present there.
#[derive(Debug)]
struct TableKey {
    table: Vec<String>,
    present: Present,
    at: usize,
    instance: usize,
}

/// An open bracket.
#[derive(Clone, Debug)]
struct Frame {
    /// Whether it is that of a table, not of an array.
    is_table: bool,
    /// The path of the table, or of the key whose value the array is.
    path: Vec<String>,
    instance: usize,
}

/// Follows the tokens of a file.
#[derive(Debug, Default)]
struct TokenWalk {
    /// The path of the last header.
    header: Vec<String>,
    frames: Vec<Frame>,
    /// The parts of the key that is being read.
    key: Vec<String>,
    is_after_equals: bool,
    /// Whether the value or the header that was read is complete.
    is_complete: bool,
    /// Whether a header is being read.
    is_header: bool,
    /// Whether nothing of the line has been read.
    begins_line: bool,
    /// Tables so far: each header and each bracket begins another one.
    instances: usize,
    of_header: usize,
    keys: Vec<TableKey>,
    parts: Vec<KeyPart>,
    texts: Vec<Text>,
    started: bool,
}

impl TokenWalk {
    fn path(&self) -> Vec<String> {
        self.frames.last().map_or_else(|| self.header.clone(), |frame| frame.path.clone())
    }

    fn instance(&self) -> usize {
        self.frames.last().map_or(self.of_header, |frame| frame.instance)
    }

    /// What a word here would be.
    fn place(&self, is_quoted: bool) -> Option<TomlPlace> {
        if self.is_complete {
            return None;
        }
        if self.is_header {
            return Some(TomlPlace::Header { table: self.key.clone(), is_item: false, present: Vec::new() });
        }
        let is_array = self.frames.last().is_some_and(|frame| !frame.is_table);
        if is_array {
            return Some(TomlPlace::Value { key: self.path(), is_quoted });
        }
        let path = [self.path(), self.key.clone()].concat();
        if self.is_after_equals {
            return Some(TomlPlace::Value { key: path, is_quoted });
        }
        let begins_line = self.frames.is_empty() && self.key.is_empty() && (self.begins_line || !self.started);
        Some(TomlPlace::Key { table: path, begins_line, present: Vec::new() })
    }

    fn step(&mut self, text: &str, token: &Token) {
        self.is_complete = match token.kind {
            Kind::Word | Kind::Text | Kind::OpenText => self.is_in_value(),
            Kind::Sign(b']' | b'}') => true,
            Kind::Sign(b'[') => self.is_header && self.is_complete,
            Kind::Sign(_) | Kind::NewLine => false,
            Kind::Comment => self.is_complete,
        };
        let begins_line = std::mem::replace(&mut self.begins_line, false) || !self.started;
        self.started = true;
        match token.kind {
            Kind::Comment => self.begins_line = begins_line,
            Kind::NewLine => self.end_line(),
            Kind::Word | Kind::Text | Kind::OpenText => self.word(text, token, begins_line),
            Kind::Sign(b'=') => {
                self.is_header = false;
                self.is_after_equals = true;
                let is_array = self.frames.last().is_some_and(|frame| !frame.is_table);
                if is_array {
                    self.recover();
                }
            }
            Kind::Sign(b'[') if begins_line && self.frames.iter().all(|frame| frame.is_table) => {
                self.frames.clear();
                (self.is_header, self.is_after_equals) = (true, false);
                self.key.clear();
            }
            // The second bracket of an array of tables.
            Kind::Sign(b'[' | b']') if self.is_header => {
                if token.kind == Kind::Sign(b']') {
                    self.header = self.key.clone();
                    if self.of_header <= self.instances {
                        self.instances += 1;
                        self.of_header = self.instances;
                    }
                }
            }
            Kind::Sign(sign @ (b'[' | b'{')) => {
                self.instances += 1;
                let is_array = self.frames.last().is_some_and(|frame| !frame.is_table);
                let path = if is_array { self.path() } else { [self.path(), std::mem::take(&mut self.key)].concat() };
                self.frames.push(Frame { is_table: sign == b'{', path, instance: self.instances });
                self.is_after_equals = false;
            }
            Kind::Sign(b']' | b'}') => {
                self.frames.pop();
                self.key.clear();
                self.is_after_equals = false;
            }
            Kind::Sign(b',') => {
                self.key.clear();
                self.is_after_equals = false;
            }
            Kind::Sign(_) => {}
        }
    }

    /// Whether what comes next is a value, or an item of one.
    fn is_in_value(&self) -> bool {
        self.is_after_equals || self.frames.last().is_some_and(|frame| !frame.is_table)
    }

    fn end_line(&mut self) {
        self.begins_line = true;
        if self.frames.is_empty() || self.is_header {
            self.key.clear();
            (self.is_after_equals, self.is_header) = (false, false);
        }
    }

    /// A `=` among the items of an array: the array was not closed, and the word before is a key.
    fn recover(&mut self) {
        self.frames.clear();
        if let Some(text) = self.texts.pop() {
            let part = KeyPart { table: self.path(), name: text.value.clone(), range: text.range, is_header: false };
            self.add_key(self.path(), text.value.clone(), part.range.start);
            self.parts.push(part);
            self.key = vec![text.value];
        }
    }

    fn add_key(&mut self, table: Vec<String>, name: String, at: usize) {
        let present = Present { name, value: None };
        self.keys.push(TableKey { table, present, at, instance: self.instance() });
    }

    fn word(&mut self, text: &str, token: &Token, begins_line: bool) {
        let range = token.content.clone();
        let name = text[range.clone()].to_owned();
        let is_array = self.frames.last().is_some_and(|frame| !frame.is_table);
        if self.is_in_value() {
            if let Some(key) = self.keys.last_mut().filter(|_| !is_array) {
                let boolean = || name.parse().ok().map(Value::Bool);
                key.present.value = if token.kind == Kind::Word { boolean() } else { Some(name.as_str().into()) };
            }
            // Words are kept for `recover` only.
            if token.kind != Kind::Word || begins_line && is_array {
                let key = if is_array { self.path() } else { [self.path(), self.key.clone()].concat() };
                self.texts.push(Text { key, value: name, range, instance: self.instance() });
            }
            return;
        }
        let before = if self.is_header { self.key.clone() } else { [self.path(), self.key.clone()].concat() };
        self.parts.push(KeyPart {
            table: before.clone(),
            name: name.clone(),
            range: range.clone(),
            is_header: self.is_header,
        });
        if !self.is_header {
            self.add_key(before, name.clone(), range.start);
        }
        self.key.push(name);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The place at the `|` of a text, without it, and the word there.
    fn at(marked: &str) -> Option<(TomlPlace, String)> {
        let at = marked.find('|').unwrap();
        let text = marked.replacen('|', "", 1);
        place(&text, at).map(|(place, word)| (place, text[word].to_owned()))
    }

    fn path(parts: &[&str]) -> Vec<String> {
        parts.iter().map(|part| (*part).to_owned()).collect()
    }

    /// Keys, some with `=` and their value.
    fn present(keys: &[&str]) -> Vec<Present> {
        let present = keys.iter().map(|key| match key.split_once('=') {
            Some((name, value)) => Present { name: name.to_owned(), value: value.parse().ok() },
            None => Present { name: (*key).to_owned(), value: None },
        });
        present.collect()
    }

    fn key(table: &[&str], begins_line: bool, keys: &[&str]) -> TomlPlace {
        TomlPlace::Key { table: path(table), begins_line, present: present(keys) }
    }

    fn value(parts: &[&str], is_quoted: bool) -> TomlPlace {
        TomlPlace::Value { key: path(parts), is_quoted }
    }

    #[test]
    fn keys_are_found_in_every_kind_of_table() {
        let cases = [
            ("|", key(&[], true, &[]), ""),
            ("a = 1\nb|\n", key(&[], true, &["a"]), "b"),
            ("a = \"x\"\nb = true\n|", key(&[], true, &["a=\"x\"", "b=true"]), ""),
            ("a = 1\n[x.y]\nb = 2\nc|", key(&["x", "y"], true, &["b"]), "c"),
            ("[[x]]\nb = 2\n[[x]]\n|", key(&["x"], true, &[]), ""),
            ("x.y.|", key(&["x", "y"], false, &[]), ""),
            ("x = { a = 1, | }", key(&["x"], false, &["a"]), ""),
            ("x = [{ a = 1 }, { b| }]", key(&["x"], false, &[]), "b"),
            ("x = [\n  { a = { c = 1, d|", key(&["x", "a"], false, &["c"]), "d"),
            ("x = [1,\ny = 2\nz|", key(&[], true, &["x", "y"]), "z"),
            ("x = { a = 1\n[y]\n|", key(&["y"], true, &[]), ""),
        ];
        for (text, place, word) in cases {
            assert_eq!(at(text), Some((place, word.to_owned())), "{text}");
        }
    }

    #[test]
    fn values_know_the_path_of_their_key() {
        let cases = [
            ("a = |", value(&["a"], false), ""),
            ("[t]\nk.l = \"wo|rd\"", value(&["t", "k", "l"], true), "word"),
            ("[t]\nk = \"wo|", value(&["t", "k"], true), "wo"),
            ("k = [\"a\", \"|\"]", value(&["k"], true), ""),
            ("k = [\n  1,\n  x|\n]", value(&["k"], false), "x"),
            ("k = [{ kind = \"b|\" }]", value(&["k", "kind"], true), "b"),
        ];
        for (text, place, word) in cases {
            assert_eq!(at(text), Some((place, word.to_owned())), "{text}");
        }
    }

    #[test]
    fn headers_and_comments_are_recognized() {
        let header = |table: &[&str], is_item, keys: &[&str]| TomlPlace::Header {
            table: path(table),
            is_item,
            present: present(keys),
        };
        assert_eq!(at("[a]\n[bat|]\n[b.c]"), Some((header(&[], false, &["a", "b"]), "bat".to_owned())));
        assert_eq!(at("[[a.b.|"), Some((header(&["a", "b"], true, &[]), String::new())));
        for nothing in [
            "a = \"\"|\"b\"\"\"",
            "a = 1 # so|",
            "a = \"b\"|",
            "a = 1 |",
            "a = [\"b\"|]",
            "a = [1]|",
            "a = { b = 1 }|",
            "[a]|",
        ] {
            assert_eq!(at(nothing), None, "{nothing}");
        }
    }

    #[test]
    fn every_place_of_a_broken_text_has_an_answer_without_a_panic() {
        let text = "a = [\"ä\n[[x.'y']]\nb={c=\"\"\"𝄞\n\"\"\",d=[[1],{e=\\\n}}]=.#ü\n'";
        for at in (0..=text.len()).filter(|at| text.is_char_boundary(*at)) {
            for end in (at..=text.len()).filter(|end| text.is_char_boundary(*end)) {
                if let Some((_, word)) = place(&text[..end], at) {
                    assert!(text[..end].get(word).is_some());
                }
            }
        }
    }
}
