//! The tokens of an expression.

use std::ops::Range;

use winnow::ascii::{digit0, digit1, hex_digit1};
use winnow::combinator::{alt, delimited, not, opt, peek, preceded, repeat};
use winnow::prelude::*;
use winnow::stream::{LocatingSlice, Location};
use winnow::token::{any, one_of, take_till, take_until, take_while};

use super::ExpressionProblem;

type Input<'s> = LocatingSlice<&'s str>;

#[derive(Clone, Debug, PartialEq)]
pub(super) enum TokenKind<'s> {
    Number(f64),
    Text(String),
    Name(&'s str),
    /// An operator or punctuation mark.
    Mark(&'s str),
    End,
}

/// A token and its position.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Token<'s> {
    pub(super) kind: TokenKind<'s>,
    pub(super) span: Range<usize>,
}

/// Longest first, so that `===` is not read as `==` and `=`.
const MARKS: [&str; 53] = [
    ">>>=", "===", "!==", ">>>", "<<=", ">>=", "**=", "&&=", "||=", "??=", "...", "==", "!=", "<=", ">=", "&&", "||",
    "??", "?.", "=>", "++", "--", "+=", "-=", "*=", "/=", "%=", "&=", "|=", "^=", "<<", ">>", "**", "+", "-", "*", "/",
    "%", "<", ">", "=", "!", "~", "&", "|", "^", "?", ":", ".", ",", ";", "(", ")",
];
const BRACKETS: [&str; 4] = ["[", "]", "{", "}"];

/// Splits an expression into tokens; the last one is [`TokenKind::End`].
pub(super) fn tokens(source: &str) -> Result<Vec<Token<'_>>, ExpressionProblem> {
    let mut input = Input::new(source);
    let mut tokens = Vec::new();
    loop {
        let start = input.current_token_start();
        blank.parse_next(&mut input).map_err(|_| unreadable(source, start))?;
        let start = input.current_token_start();
        if input.starts_with("/*") {
            return Err(unreadable(source, start));
        }
        if input.is_empty() {
            tokens.push(Token { kind: TokenKind::End, span: start..start });
            return Ok(tokens);
        }
        match token.with_span().parse_next(&mut input) {
            Ok((kind, span)) => tokens.push(Token { kind, span }),
            Err(_) => return Err(unreadable(source, start)),
        }
    }
}

fn unreadable(source: &str, start: usize) -> ExpressionProblem {
    let rest = &source[start..];
    let first = rest.chars().next().unwrap_or(' ');
    let here = start..start + first.len_utf8();
    match first {
        '"' | '\'' => ExpressionProblem::new("a string is never closed", here, "opened here"),
        '`' => ExpressionProblem::outside_subset("a template string", here),
        '/' if rest.starts_with("/*") => ExpressionProblem::new("a comment is never closed", here, "opened here"),
        '0'..='9' => ExpressionProblem::new(
            "this is not a number",
            here,
            "a digit is followed by a character that no number has",
        ),
        other => ExpressionProblem::new(format!("unexpected `{other}`"), here, "not part of an expression"),
    }
}

fn blank(input: &mut Input<'_>) -> ModalResult<()> {
    let line_comment = ("//", take_till(0.., ['\n', '\r'])).void();
    let comment = ("/*", take_until(0.., "*/"), "*/").void();
    repeat(0.., alt((take_while(1.., char::is_whitespace).void(), line_comment, comment))).parse_next(input)
}

fn token<'s>(input: &mut Input<'s>) -> ModalResult<TokenKind<'s>> {
    alt((
        number.map(TokenKind::Number),
        text.map(TokenKind::Text),
        name.map(TokenKind::Name),
        alt(MARKS).map(TokenKind::Mark),
        alt(BRACKETS).map(TokenKind::Mark),
    ))
    .parse_next(input)
}

fn starts_name(c: char) -> bool {
    c.is_alphabetic() || c == '_' || c == '$'
}

fn name<'s>(input: &mut Input<'s>) -> ModalResult<&'s str> {
    let continues = |c: char| starts_name(c) || c.is_numeric();
    (one_of(starts_name), take_while(0.., continues)).take().parse_next(input)
}

fn number(input: &mut Input<'_>) -> ModalResult<f64> {
    let radix = (alt(("0x", "0X", "0o", "0O", "0b", "0B")), hex_digit1).void();
    let exponent = (one_of(['e', 'E']), opt(one_of(['+', '-'])), digit1).void();
    let digits = alt(((digit1, opt(('.', digit0))).void(), ('.', digit1).void()));
    let written = alt((radix, (digits, opt(exponent)).void())).take();
    let value = written.map(crate::datum::numeric).verify(|number: &f64| !number.is_nan());
    (value, peek(not(one_of(starts_name)))).map(|(value, ())| value).parse_next(input)
}

fn text(input: &mut Input<'_>) -> ModalResult<String> {
    alt((delimited('"', pieces('"'), '"'), delimited('\'', pieces('\''), '\''))).parse_next(input)
}

fn pieces<'s>(quote: char) -> impl ModalParser<Input<'s>, String, winnow::error::ContextError> {
    move |input: &mut Input<'s>| {
        let plain = take_while(1.., |c: char| c != quote && c != '\\' && c != '\n').map(str::to_owned);
        repeat(0.., alt((plain, preceded('\\', escape)))).parse_next(input)
    }
}

fn escape(input: &mut Input<'_>) -> ModalResult<String> {
    let code = |digits: &str| {
        let code = u32::from_str_radix(digits, 16).unwrap_or(u32::MAX);
        String::from(char::from_u32(code).unwrap_or(char::REPLACEMENT_CHARACTER))
    };
    let hex = |count: usize| take_while(count, |c: char| c.is_ascii_hexdigit());
    alt((
        preceded('x', hex(2)).map(code),
        preceded('u', surrogates).map(String::from),
        preceded('u', alt((delimited('{', hex_digit1, '}'), hex(4)))).map(code),
        any.map(|c| match c {
            'n' => "\n".to_owned(),
            't' => "\t".to_owned(),
            'r' => "\r".to_owned(),
            'b' => "\u{8}".to_owned(),
            'f' => "\u{c}".to_owned(),
            'v' => "\u{b}".to_owned(),
            '0' => "\0".to_owned(),
            '\n' => String::new(),
            other => other.to_string(),
        }),
    ))
    .parse_next(input)
}

/// One character, written as the two halves that UTF-16 has for it: `d83d\udd0b`.
fn surrogates(input: &mut Input<'_>) -> ModalResult<char> {
    let half = |from: u32| {
        take_while(4, |c: char| c.is_ascii_hexdigit()).verify_map(move |digits| {
            u32::from_str_radix(digits, 16).ok()?.checked_sub(from).filter(|half| *half < 0x400)
        })
    };
    (half(0xD800), preceded("\\u", half(0xDC00)))
        .verify_map(|(high, low)| char::from_u32(0x10000 + (high << 10) + low))
        .parse_next(input)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kinds(source: &str) -> Vec<TokenKind<'_>> {
        tokens(source).unwrap().into_iter().map(|token| token.kind).collect()
    }

    #[test]
    fn the_longest_operator_wins() {
        assert_eq!(
            kinds("a===b"),
            [TokenKind::Name("a"), TokenKind::Mark("==="), TokenKind::Name("b"), TokenKind::End]
        );
        assert_eq!(
            kinds("x>>>=1"),
            [TokenKind::Name("x"), TokenKind::Mark(">>>="), TokenKind::Number(1.0), TokenKind::End]
        );
    }

    #[test]
    fn strings_unescape() {
        let expected = TokenKind::Text("a'\n\u{e9}\u{41}".to_owned());
        assert_eq!(kinds(r"'a\'\n\u00e9\x41'"), [expected, TokenKind::End]);
        assert_eq!(kinds(r"'\uD83D\uDD0B\u{1F50B}'"), [TokenKind::Text("🔋🔋".to_owned()), TokenKind::End]);
        let half = TokenKind::Text("\u{FFFD}a".to_owned());
        assert_eq!(kinds(r"'\uD83Da'"), [half, TokenKind::End], "half a character is not one");
    }

    #[test]
    fn comments_and_spaces_are_ignored() {
        assert_eq!(kinds(" /* a */ 1 // b"), [TokenKind::Number(1.0), TokenKind::End]);
    }

    #[test]
    fn unreadable_text_is_reported_with_its_location() {
        for (source, span) in [("1 + 'abc", 4..5), ("a # b", 2..3), ("3px", 0..1), ("1 /* x", 2..3), ("é@", 2..3)] {
            assert_eq!(tokens(source).unwrap_err().span, span, "{source}");
        }
    }
}
