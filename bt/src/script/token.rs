//! The tokens of a script.

use std::ops::Range;

use super::reading::SyntaxError;

/// A token and its position.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Token<'a> {
    pub(super) kind: TokenKind<'a>,
    pub(super) range: Range<usize>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum TokenKind<'a> {
    Int(i64),
    Real(f64),
    Text(&'a str),
    Name(&'a str),
    /// An operator, a parenthesis or a semicolon.
    Sign(&'static str),
    End,
}

/// Signs, longer ones first.
const SIGNS: [&str; 30] = [
    "..", "&&", "||", "==", "!=", "<=", ">=", ":=", "+=", "-=", "*=", "/=", "+", "-", "*", "/", "&", "|", "^", "~",
    "!", "<", ">", "=", "?", ":", "(", ")", ";", ",",
];

pub(super) fn tokens(text: &str) -> Result<Vec<Token<'_>>, SyntaxError> {
    let mut tokens = Vec::new();
    let mut start = 0;
    loop {
        start += text[start..].len() - text[start..].trim_start_matches([' ', '\t', '\n', '\r']).len();
        let (kind, length) =
            token(&text[start..]).map_err(|(message, length)| SyntaxError { message, range: start..start + length })?;
        tokens.push(Token { kind, range: start..start + length });
        if kind == TokenKind::End {
            return Ok(tokens);
        }
        start += length;
    }
}

/// The first token of a script that does not begin with white space, and its length.
fn token(text: &str) -> Result<(TokenKind<'_>, usize), (String, usize)> {
    let Some(first) = text.chars().next() else { return Ok((TokenKind::End, 0)) };
    if let Some(rest) = text.strip_prefix('\'') {
        let length = rest.find('\'').ok_or_else(|| ("this string has no closing quote".to_owned(), text.len()))?;
        return Ok((TokenKind::Text(&rest[..length]), length + 2));
    }
    if first.is_ascii_digit() {
        return number(text);
    }
    if is_name_start(first) {
        let length = text[1..].find(|c| !is_name_part(c)).map_or(text.len(), |length| length + 1);
        return Ok((TokenKind::Name(&text[..length]), length));
    }
    let sign = SIGNS.iter().find(|sign| text.starts_with(**sign));
    sign.map(|sign| (TokenKind::Sign(sign), sign.len()))
        .ok_or_else(|| (format!("`{first}` is not allowed in a script"), first.len_utf8()))
}

fn is_name_start(c: char) -> bool {
    c.is_ascii_alphabetic() || c == '_' || c == '@'
}

fn is_name_part(c: char) -> bool {
    c.is_ascii_alphanumeric() || c == '_'
}

fn number(text: &str) -> Result<(TokenKind<'_>, usize), (String, usize)> {
    let digits = |from: usize| {
        let rest = &text[from..];
        from + rest.find(|c: char| !c.is_ascii_digit()).unwrap_or(rest.len())
    };
    let is_digit_at = |place: usize| text.as_bytes().get(place).is_some_and(u8::is_ascii_digit);
    let hexadecimal = text.strip_prefix("0x").or_else(|| text.strip_prefix("0X"));
    let (mut end, mut is_real) = (digits(0), false);
    if let Some(rest) = hexadecimal {
        end = 2 + rest.find(|c: char| !c.is_ascii_hexdigit()).unwrap_or(rest.len());
    } else {
        if text[end..].starts_with('.') && is_digit_at(end + 1) {
            (end, is_real) = (digits(end + 1), true);
        }
        if text[end..].starts_with(['e', 'E']) {
            let signed = usize::from(text[end + 1..].starts_with(['+', '-']));
            if is_digit_at(end + 1 + signed) {
                (end, is_real) = (digits(end + 1 + signed), true);
            }
        }
    }
    let rest = &text[end..];
    // `1..'a'`: two dots are the operator that concatenates.
    let joins_texts = rest.starts_with("..") && hexadecimal.is_none();
    if rest.starts_with(|c| is_name_start(c) || is_name_part(c) || c == '.') && !joins_texts {
        let length = end + rest.find(|c| !is_name_part(c) && c != '.').unwrap_or(rest.len());
        return Err((format!("`{}` is not a number", &text[..length]), length));
    }
    let number = if is_real {
        text[..end].parse().ok().map(TokenKind::Real)
    } else if hexadecimal.is_some() {
        i64::from_str_radix(&text[2..end], 16).ok().map(TokenKind::Int)
    } else {
        text[..end].parse().ok().map(TokenKind::Int)
    };
    number.map(|number| (number, end)).ok_or_else(|| (format!("`{}` is not a number, or too large", &text[..end]), end))
}
