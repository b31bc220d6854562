//! The tokens of a property file with what is between them.

use std::borrow::Cow;

use super::token::{Keyword, Token, TokenKind, tokens};
use crate::formula::Arithmetic;

/// A token as it is written, with the comments around it.
pub(super) struct Piece<'t> {
    pub(super) kind: TokenKind,
    pub(super) text: Cow<'t, str>,
    /// The comments that have their own lines above it.
    pub(super) above: Vec<Above<'t>>,
    /// Whether an empty line is above it.
    pub(super) is_apart: bool,
    /// The comment behind it on its line.
    pub(super) behind: Option<&'t str>,
    /// Whether a blank belongs before it.
    pub(super) has_blank: bool,
    /// Whether it follows an operand, so that a word that may be a name is an operator.
    pub(super) is_operator: bool,
}

/// A comment that has its own line.
pub(super) struct Above<'t> {
    pub(super) text: &'t str,
    /// Whether an empty line is above it.
    pub(super) is_apart: bool,
}

/// The pieces of a text without errors, the last one its end.
pub(super) fn pieces(text: &str) -> Vec<Piece<'_>> {
    let tokens = tokens(text, &mut Vec::new());
    let (mut pieces, mut end): (Vec<Piece<'_>>, _) = (Vec::new(), 0);
    for place in 0..tokens.len() {
        let Token { kind, span } = &tokens[place];
        let between: Vec<&str> = text[end..span.start].split('\n').collect();
        let (mut above, mut is_apart) = (Vec::new(), false);
        for (line, written) in between.iter().enumerate() {
            let comment = written.find("//").map(|start| written[start..].trim_end());
            match (comment, pieces.last_mut()) {
                (Some(comment), Some(last)) if line == 0 => last.behind = Some(comment),
                (Some(text), _) => above.push(Above { text, is_apart: std::mem::take(&mut is_apart) }),
                // The rest of a token's line, and the beginning of the next one's, are not empty lines.
                (None, _) => is_apart |= line > 0 && line + 1 < between.len(),
            }
        }
        let (has_blank, is_operator) = (has_blank(text, &tokens, place), place > 0 && is_operand(&tokens, place - 1));
        let text = written(kind, &text[span.start..span.end], is_operator);
        pieces.push(Piece { kind: kind.clone(), text, above, is_apart, behind: None, has_blank, is_operator });
        end = span.end;
    }
    pieces
}

/// A token as it is written, without blanks inside.
fn written<'t>(kind: &TokenKind, text: &'t str, follows_operand: bool) -> Cow<'t, str> {
    match kind {
        TokenKind::Symbol(name) => match (text.chars().next(), text.chars().next_back()) {
            (Some(open), Some(close)) => format!("{open}{name}{close}").into(),
            _ => text.into(),
        },
        // `level -3`: the sign belongs to the sum.
        TokenKind::Number(number) if follows_operand && number.starts_with('-') => format!("- {}", &number[1..]).into(),
        _ => text.into(),
    }
}

fn is_operand(tokens: &[Token], place: usize) -> bool {
    match tokens[place].kind {
        TokenKind::Name(_)
        | TokenKind::Text(_)
        | TokenKind::Symbol(_)
        | TokenKind::Number(_)
        | TokenKind::Percent
        | TokenKind::Keyword(Keyword::True | Keyword::False)
        | TokenKind::Close
        | TokenKind::CloseIndex => true,
        // A word that is a name here.
        TokenKind::Keyword(_) => place > 0 && tokens[place - 1].kind == TokenKind::Dot,
        _ => false,
    }
}

/// Whether a blank belongs before a token.
fn has_blank(text: &str, tokens: &[Token], place: usize) -> bool {
    let Some(before) = place.checked_sub(1) else { return false };
    let kind = |place: usize| tokens.get(place).map(|token| &token.kind);
    match (&tokens[before].kind, &tokens[place].kind) {
        (TokenKind::Open | TokenKind::OpenIndex | TokenKind::Dot, _)
        | (
            _,
            TokenKind::Close
            | TokenKind::CloseIndex
            | TokenKind::OpenIndex
            | TokenKind::Comma
            | TokenKind::Dot
            | TokenKind::Semicolon,
        ) => false,
        // `at most n (…)` is no call.
        (TokenKind::Name(_), TokenKind::Open) => {
            let counts = |keyword| before > 0 && kind(before - 1) == Some(&TokenKind::Keyword(keyword));
            counts(Keyword::Most) || counts(Keyword::Least)
        }
        (TokenKind::Arithmetic(Arithmetic::Divide), _) => !is_unit(tokens, before),
        (_, TokenKind::Arithmetic(Arithmetic::Divide)) => !is_unit(tokens, place),
        // Signs such as `¬` and `□`.
        (TokenKind::Keyword(Keyword::Prefix(_)), _) => {
            text[tokens[before].span.start..].starts_with(char::is_alphabetic)
        }
        _ => true,
    }
}

/// Whether a slash is that of a unit, `3 m/s`, which is none with blanks.
fn is_unit(tokens: &[Token], slash: usize) -> bool {
    let Some([number, of, slash, per]) = slash.checked_sub(2).and_then(|start| tokens.get(start..start + 4)) else {
        return false;
    };
    matches!((&number.kind, &of.kind, &per.kind), (TokenKind::Number(_), TokenKind::Name(_), TokenKind::Name(_)))
        && of.span.end == slash.span.start
        && slash.span.end == per.span.start
}
