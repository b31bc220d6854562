//! Tokens of a property file.

use channels::Relation;
use diagnostics::Problem;

use super::ast::ByteRange;
use crate::formula::Arithmetic;
use crate::operator::{Infix, Prefix};

/// A token with its span.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Token {
    pub(super) kind: TokenKind,
    pub(super) span: ByteRange,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum TokenKind {
    /// A name that is not a keyword.
    Name(String),
    /// `"text"`
    Text(String),
    /// `<symbol>`, only right after an operator.
    Symbol(String),
    /// A number as it is written.
    Number(String),
    Keyword(Keyword),
    Relation(Relation),
    Arithmetic(Arithmetic),
    /// `:=`
    Define,
    Open,
    Close,
    OpenIndex,
    CloseIndex,
    Comma,
    Dot,
    Semicolon,
    /// `%`
    Percent,
    End,
}

/// Declares the words that are no operators with operands on one or both sides, each once: those of the paper's
/// language, and the others.
macro_rules! keywords {
    ($($paper:ident $word:literal),*; $($own:ident $own_word:literal),*) => {
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(super) enum Keyword {
            $($paper,)*
            $($own,)*
            Prefix(Prefix),
            Infix(Infix),
        }

        impl Keyword {
            pub(super) fn all() -> impl Iterator<Item = Self> {
                let operators = Prefix::ALL.map(Self::Prefix).into_iter().chain(Infix::ALL.map(Self::Infix));
                [$(Self::$paper,)* $(Self::$own,)*].into_iter().chain(operators)
            }

            /// Whether it is a keyword only where the grammar expects it, and an ordinary name elsewhere. This is true
            /// of the words that the paper's language does not have.
            fn is_soft(self) -> bool {
                match self {
                    $(Self::$paper => false,)*
                    $(Self::$own => true,)*
                    Self::Prefix(operator) => !operator.is_of_the_paper(),
                    Self::Infix(operator) => !operator.is_of_the_paper(),
                }
            }

            pub(super) fn text(self) -> &'static str {
                match self {
                    $(Self::$paper => $word,)*
                    $(Self::$own => $own_word,)*
                    Self::Prefix(operator) => operator.word(),
                    Self::Infix(operator) => operator.word(),
                }
            }
        }
    };
}

keywords!(
    Const "const",
    Property "property",
    True "true",
    False "false",
    And "and",
    Or "or",
    TimeUntil "time_until";
    Fresh "fresh",
    At "at",
    Most "most",
    Least "least",
    In "in",
    Timed "timed",
    As "as"
);

impl Keyword {
    /// The keyword that is written like this.
    pub(super) fn of(word: &str) -> Option<Self> {
        Self::all().find(|keyword| keyword.text() == word)
    }
}

impl TokenKind {
    pub(super) fn as_name(&self) -> Option<&str> {
        match self {
            Self::Name(name) => Some(name),
            Self::Keyword(keyword) if keyword.is_soft() => Some(keyword.text()),
            _ => None,
        }
    }

    /// The token's name in messages.
    pub(super) fn describe(&self) -> String {
        match self {
            Self::Name(name) | Self::Number(name) => format!("`{name}`"),
            Self::Text(text) => format!("{text:?}"),
            Self::Symbol(symbol) => format!("`<{symbol}>`"),
            Self::Keyword(keyword) => format!("`{}`", keyword.text()),
            Self::Relation(relation) => format!("`{relation}`"),
            Self::Arithmetic(operator) => format!("`{}`", operator.sign()),
            Self::Define => "`:=`".to_owned(),
            Self::Open => "`(`".to_owned(),
            Self::Close => "`)`".to_owned(),
            Self::OpenIndex => "`[`".to_owned(),
            Self::CloseIndex => "`]`".to_owned(),
            Self::Comma => "`,`".to_owned(),
            Self::Dot => "`.`".to_owned(),
            Self::Semicolon => "`;`".to_owned(),
            Self::Percent => "`%`".to_owned(),
            Self::End => "the end of the file".to_owned(),
        }
    }
}

/// Operators made of one or two signs, longer ones first.
pub(super) const SIGNS: [(&str, TokenKind); 35] = [
    (":=", TokenKind::Define),
    ("≔", TokenKind::Define),
    ("<=", TokenKind::Relation(Relation::LessOrEqual)),
    ("≤", TokenKind::Relation(Relation::LessOrEqual)),
    (">=", TokenKind::Relation(Relation::GreaterOrEqual)),
    ("≥", TokenKind::Relation(Relation::GreaterOrEqual)),
    ("!=", TokenKind::Relation(Relation::NotEqual)),
    ("≠", TokenKind::Relation(Relation::NotEqual)),
    ("<", TokenKind::Relation(Relation::Less)),
    ("->", TokenKind::Keyword(Keyword::Infix(Infix::Implies))),
    (">", TokenKind::Relation(Relation::Greater)),
    ("=", TokenKind::Relation(Relation::Equal)),
    ("→", TokenKind::Keyword(Keyword::Infix(Infix::Implies))),
    ("⇒", TokenKind::Keyword(Keyword::Infix(Infix::Implies))),
    ("¬", TokenKind::Keyword(Keyword::Prefix(Prefix::Not))),
    ("!", TokenKind::Keyword(Keyword::Prefix(Prefix::Not))),
    ("∧", TokenKind::Keyword(Keyword::And)),
    ("∨", TokenKind::Keyword(Keyword::Or)),
    ("□", TokenKind::Keyword(Keyword::Prefix(Prefix::Always))),
    ("◇", TokenKind::Keyword(Keyword::Prefix(Prefix::Eventually))),
    ("○", TokenKind::Keyword(Keyword::Prefix(Prefix::Next))),
    ("⊤", TokenKind::Keyword(Keyword::True)),
    ("⊥", TokenKind::Keyword(Keyword::False)),
    ("(", TokenKind::Open),
    (")", TokenKind::Close),
    ("[", TokenKind::OpenIndex),
    ("]", TokenKind::CloseIndex),
    (",", TokenKind::Comma),
    (".", TokenKind::Dot),
    (";", TokenKind::Semicolon),
    ("%", TokenKind::Percent),
    ("+", TokenKind::Arithmetic(Arithmetic::Add)),
    ("-", TokenKind::Arithmetic(Arithmetic::Subtract)),
    ("*", TokenKind::Arithmetic(Arithmetic::Multiply)),
    ("/", TokenKind::Arithmetic(Arithmetic::Divide)),
];

/// Operators of other languages, and the ones to write here instead.
const FOREIGN: [(&str, &str, TokenKind); 4] = [
    ("==", "=", TokenKind::Relation(Relation::Equal)),
    ("&&", "and", TokenKind::Keyword(Keyword::And)),
    ("||", "or", TokenKind::Keyword(Keyword::Or)),
    ("=>", "implies", TokenKind::Keyword(Keyword::Infix(Infix::Implies))),
];

/// All tokens of a text, the last one [`TokenKind::End`]. Anything that is not a token is reported and left out.
pub(super) fn tokens(text: &str, problems: &mut Vec<Problem>) -> Vec<Token> {
    let mut lexer = Lexer { text, at: 0, tokens: Vec::new(), problems };
    while lexer.skip_blank() {
        lexer.token();
    }
    let end = ByteRange { start: text.len(), end: text.len() };
    lexer.tokens.push(Token { kind: TokenKind::End, span: end });
    lexer.tokens
}

struct Lexer<'a> {
    text: &'a str,
    at: usize,
    tokens: Vec<Token>,
    problems: &'a mut Vec<Problem>,
}

impl<'a> Lexer<'a> {
    fn rest(&self) -> &'a str {
        &self.text[self.at..]
    }

    /// Skips white space, a byte order mark and comments; false at the end of the text.
    fn skip_blank(&mut self) -> bool {
        loop {
            let rest = self.rest();
            let blank = rest.len() - rest.trim_start_matches(|c: char| c.is_whitespace() || c == '\u{FEFF}').len();
            let comment = if rest[blank..].starts_with("//") {
                rest[blank..].find('\n').unwrap_or(rest.len() - blank)
            } else {
                0
            };
            if blank + comment == 0 {
                return !rest.is_empty();
            }
            self.at += blank + comment;
        }
    }

    fn push(&mut self, kind: TokenKind, length: usize) {
        let span = ByteRange { start: self.at, end: self.at + length };
        self.at += length;
        self.tokens.push(Token { kind, span });
    }

    fn token(&mut self) {
        let rest = self.rest();
        let first = rest.chars().next().unwrap_or_default();
        if let Some((symbol, length)) = self.symbol() {
            self.push(TokenKind::Symbol(symbol), length);
        } else if first == '"' {
            self.string();
        } else if let Some(length) = number_length(rest) {
            self.push(TokenKind::Number(rest[..length].to_owned()), length);
        } else if first.is_alphabetic() || first == '_' {
            let name = &rest[..name_length(rest)];
            let keyword = Keyword::of(name);
            self.push(keyword.map_or_else(|| TokenKind::Name(name.to_owned()), TokenKind::Keyword), name.len());
        } else {
            self.sign();
        }
    }

    /// The symbol that starts here, and its length. Only directly after an operator.
    fn symbol(&self) -> Option<(String, usize)> {
        let after_operator = matches!(self.tokens.last()?.kind, TokenKind::Relation(_) | TokenKind::Define);
        let inside =
            self.rest().strip_prefix('<').or_else(|| self.rest().strip_prefix('⟨')).filter(|_| after_operator)?;
        let open = self.rest().len() - inside.len();
        let length = inside.find(['>', '⟩', '\n'])?;
        let close = inside[length..].chars().next().filter(|close| *close != '\n')?.len_utf8();
        let name = inside[..length].trim();
        let is_name = !name.is_empty() && name.chars().all(|c| c.is_alphanumeric() || matches!(c, '_' | '-' | '.'));
        is_name.then(|| (name.to_owned(), open + length + close))
    }

    fn string(&mut self) {
        let rest = self.rest();
        let mut text = String::new();
        let mut chars = rest.char_indices().skip(1);
        while let Some((at, char)) = chars.next() {
            match char {
                '"' => return self.push(TokenKind::Text(text), at + 1),
                '\n' => break,
                '\\' => match chars.next().map(|(_, escaped)| escaped) {
                    Some('n') => text.push('\n'),
                    Some('t') => text.push('\t'),
                    Some(escaped @ ('"' | '\\')) => text.push(escaped),
                    _ => {
                        let span = self.at + at..self.at + at + 1;
                        let problem = Problem::new("unknown escape in a string").at(span, "this escape");
                        self.problems.push(problem.with_help(r#"known escapes are \n, \t, \" and \\"#));
                    }
                },
                _ => text.push(char),
            }
        }
        let length = rest.find('\n').unwrap_or(rest.len());
        let span = self.at..self.at + length;
        self.problems.push(Problem::new("unterminated text").at(span, "starts here").with_help("end it with `\"`"));
        self.push(TokenKind::Text(text), length);
    }

    fn sign(&mut self) {
        let rest = self.rest();
        if let Some((foreign, ours, kind)) = FOREIGN.iter().find(|(foreign, ..)| rest.starts_with(foreign)) {
            let span = self.at..self.at + foreign.len();
            let problem = Problem::new(format!("unknown operator `{foreign}`")).at(span, "unknown operator");
            self.problems.push(problem.with_help(format!("write `{ours}`")));
            return self.push(kind.clone(), foreign.len());
        }
        if let Some((sign, kind)) = SIGNS.iter().find(|(sign, _)| rest.starts_with(sign)) {
            return self.push(kind.clone(), sign.len());
        }
        let char = rest.chars().next().unwrap_or_default();
        let span = self.at..self.at + char.len_utf8();
        self.problems.push(Problem::new(format!("unexpected `{}`", char.escape_debug())).at(span, "this sign"));
        self.at += char.len_utf8();
    }
}

fn name_length(text: &str) -> usize {
    text.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(text.len())
}

/// Whether a text can be a name without quotes.
pub(super) fn is_plain_name(text: &str) -> bool {
    let first = text.chars().next().is_some_and(|first| first.is_alphabetic() || first == '_');
    first && name_length(text) == text.len() && Keyword::of(text).is_none_or(Keyword::is_soft)
}

/// The length of the number that starts here: `-12.5e-3`.
fn number_length(text: &str) -> Option<usize> {
    let digits = |at: usize| text[at..].bytes().take_while(u8::is_ascii_digit).count();
    let sign = usize::from(text.starts_with('-'));
    let mut length = sign + digits(sign);
    if length == sign {
        return None;
    }
    if text[length..].starts_with('.') && digits(length + 1) > 0 {
        length += 1 + digits(length + 1);
    }
    if text[length..].starts_with(['e', 'E']) {
        let sign = usize::from(text[length + 1..].starts_with(['-', '+']));
        let exponent = digits(length + 1 + sign);
        length += if exponent > 0 { 1 + sign + exponent } else { 0 };
    }
    Some(length)
}
