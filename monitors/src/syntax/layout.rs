//! The canonical layout of property files.
//!
//! Tokens stay as they are written: a parenthesis that is not needed, or `→` for `implies`. A property that does not
//! fit on a line is broken before its binary operators, those that bind least first. Comments stay at their tokens.

use diagnostics::{LineEnds, Problem, Source};

use super::ast::Item;
use super::parse::{Parsed, parse_file};
use super::pieces::{Piece, pieces};
use super::pretty::Document;
use super::token::{Keyword, TokenKind};
use crate::operator::Infix;
use crate::problem::ScopeError;

/// The longest line that is not broken, in characters.
const WIDTH: usize = 120;

/// The indentation of what belongs to the line above.
const INDENT: usize = 4;

/// The text of a property file in its canonical layout: only white space changes, and the layout of the result is the
/// result. Both texts have the same tree, the same comments and the same summaries.
///
/// ```
/// let text = "property  arrives:=eventually(AtDestination,BT,m[1]=<success>)// at last";
/// let laid_out = "property arrives := eventually (AtDestination, BT, m[1] = <success>) // at last\n";
/// assert_eq!(monitors::layout("arrives.scope", text)?, laid_out);
/// # Ok::<(), monitors::ScopeError>(())
/// ```
///
/// # Errors
/// [`ScopeError`] if the text cannot be parsed. Whether its names exist does not matter.
pub fn layout(name: &str, text: &str) -> Result<String, ScopeError> {
    let refused = |problems| ScopeError::new(Source::new(name, text), problems);
    let plain = LineEnds::plain(text);
    let parsed = parse_file(&plain);
    if parsed.problems.iter().any(Problem::is_error) {
        return Err(refused(parse_file(text).problems));
    }
    let laid_out = lay_out(pieces(&plain));
    let again = parse_file(&laid_out);
    let is_same = parsed.file == again.file
        && parsed.problems.len() == again.problems.len()
        && comments(&plain) == comments(&laid_out)
        && summaries(&parsed, &plain) == summaries(&again, &laid_out);
    if is_same { Ok(LineEnds::of(text).write(laid_out)) } else { Err(refused(vec![Problem::of_layout()])) }
}

fn comments(text: &str) -> Vec<&str> {
    let pieces = pieces(text);
    pieces.into_iter().flat_map(|piece| piece.above.into_iter().map(|above| above.text).chain(piece.behind)).collect()
}

fn summaries(parsed: &Parsed, text: &str) -> Vec<Option<String>> {
    let summary = |item: &Item| match item {
        Item::Property(property) => super::summary_above(text, property.span.start),
        Item::Constant(_) => None,
    };
    parsed.file.items.iter().map(summary).collect()
}

/// The text of these pieces, item by item.
fn lay_out(mut pieces: Vec<Piece<'_>>) -> String {
    let mut out = String::new();
    let mut rest = &mut pieces[..];
    while let [first, ..] = rest {
        let apart = |is_apart: bool, out: &str| if is_apart && !out.is_empty() { "\n" } else { "" };
        for above in std::mem::take(&mut first.above) {
            out.extend([apart(above.is_apart, &out), above.text, "\n"]);
        }
        if first.kind == TokenKind::End {
            break;
        }
        out.push_str(apart(first.is_apart, &out));
        let length = (1..rest.len()).find(|place| begins_item(rest, *place)).unwrap_or(rest.len());
        let (item, others) = rest.split_at_mut(length);
        item_document(item).write(WIDTH, &mut out);
        out.push('\n');
        rest = others;
    }
    out
}

fn begins_item(pieces: &[Piece<'_>], place: usize) -> bool {
    let is = |place: usize, keyword| pieces.get(place).is_some_and(|piece| piece.kind == TokenKind::Keyword(keyword));
    is(place, Keyword::Const)
        || is(place, Keyword::Property) && !is(place - 1, Keyword::Timed)
        || is(place, Keyword::Timed) && is(place + 1, Keyword::Property)
        || pieces[place].kind == TokenKind::End
}

fn item_document(item: &[Piece<'_>]) -> Document {
    let define = item.iter().position(|piece| piece.kind == TokenKind::Define).map_or(item.len(), |place| place + 1);
    let (head, body) = (parts(&item[..define]), parts(&item[define..]));
    let mut document = vec![flat(&head, Breaks::Inside)];
    if operators(&body).is_empty() {
        document.extend([Document::Space, flat(&body, Breaks::After)]);
    } else {
        document.push(Document::Sequence(vec![Document::Line, expression(&body)]).nest(INDENT));
    }
    Document::Sequence(document).group()
}

/// A token, or a bracket with what is in it.
enum Nested<'p, 't> {
    Token(&'p Piece<'t>),
    Bracket {
        open: &'p Piece<'t>,
        inside: Vec<Nested<'p, 't>>,
        /// The paper's φ2 lacks its last parenthesis.
        close: Option<&'p Piece<'t>>,
    },
}

impl<'p, 't> Nested<'p, 't> {
    fn first(&self) -> &'p Piece<'t> {
        match self {
            Self::Token(piece) | Self::Bracket { open: piece, .. } => piece,
        }
    }

    /// The token, if it is no bracket.
    fn kind(&self) -> Option<&'p TokenKind> {
        match self {
            Self::Token(piece) => Some(&piece.kind),
            Self::Bracket { .. } => None,
        }
    }
}

fn parts<'p, 't>(pieces: &'p [Piece<'t>]) -> Vec<Nested<'p, 't>> {
    let mut open: Vec<(&Piece<'_>, Vec<Nested<'_, '_>>)> = Vec::new();
    let mut parts = Vec::new();
    let bracket = |parts: &mut Vec<Nested<'p, 't>>, (open, outside): (&'p Piece<'t>, Vec<Nested<'p, 't>>), close| {
        let inside = std::mem::replace(parts, outside);
        parts.push(Nested::Bracket { open, inside, close });
    };
    for piece in pieces {
        match piece.kind {
            TokenKind::Open | TokenKind::OpenIndex => open.push((piece, std::mem::take(&mut parts))),
            TokenKind::Close | TokenKind::CloseIndex if !open.is_empty() => {
                open.pop().into_iter().for_each(|opened| bracket(&mut parts, opened, Some(piece)));
            }
            _ => parts.push(Nested::Token(piece)),
        }
    }
    while let Some(opened) = open.pop() {
        bracket(&mut parts, opened, None);
    }
    parts
}

/// The places of the binary operators that bind least; none if there are no operators.
fn operators(parts: &[Nested<'_, '_>]) -> Vec<usize> {
    let levels: [&[Keyword]; 4] = [
        &[Keyword::Infix(Infix::Implies)],
        &[Keyword::Or],
        &[Keyword::And],
        &[Keyword::Infix(Infix::Until), Keyword::Infix(Infix::Since)],
    ];
    let of = |level: &[Keyword]| -> Vec<usize> {
        let is_of = |place: &usize| match parts[*place].kind() {
            Some(TokenKind::Keyword(word)) => {
                // `since` may also be a name.
                level.contains(word) && (*word != Keyword::Infix(Infix::Since) || parts[*place].first().is_operator)
            }
            _ => false,
        };
        (0..parts.len()).filter(is_of).collect()
    };
    levels.into_iter().map(of).find(|places| !places.is_empty()).unwrap_or_default()
}

/// Operands joined by operators, each of which may begin a line.
fn expression(parts: &[Nested<'_, '_>]) -> Document {
    let places = operators(parts);
    let Some(first) = places.first() else { return flat(parts, Breaks::Inside) };
    let mut document = vec![expression(&parts[..*first]).group().nest(INDENT)];
    for (number, place) in places.iter().enumerate() {
        let end = places.get(number + 1).copied().unwrap_or(parts.len());
        // `since[<= 5]`
        let has_bound = parts.get(place + 1).is_some_and(|part| part.first().kind == TokenKind::OpenIndex);
        let operand = place + 1 + usize::from(has_bound);
        let operator = flat(&parts[*place..operand], Breaks::Inside);
        document.extend([Document::Line, operator, Document::Space, expression(&parts[operand..end]).group().align()]);
    }
    Document::Sequence(document)
}

/// Where a parenthesis is broken.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Breaks {
    /// After its beginning, and what is in it is indented.
    After,
    /// Only inside, and what is in it is aligned.
    Inside,
}

/// Parts without operators between them.
fn flat(parts: &[Nested<'_, '_>], breaks: Breaks) -> Document {
    let mut document = Vec::new();
    for (place, part) in parts.iter().enumerate() {
        if place > 0 && part.first().has_blank {
            document.push(Document::Space);
        }
        match part {
            Nested::Token(piece) => token(piece, &mut document),
            Nested::Bracket { open, inside, close } => {
                let is_call = place > 0 && !open.has_blank;
                document.push(bracket(open, inside, *close, is_call, breaks));
            }
        }
    }
    Document::Sequence(document)
}

fn bracket(
    open: &Piece<'_>,
    inside: &[Nested<'_, '_>],
    close: Option<&Piece<'_>>,
    is_call: bool,
    breaks: Breaks,
) -> Document {
    let mut document = Vec::new();
    token(open, &mut document);
    if open.kind == TokenKind::OpenIndex {
        document.push(flat(inside, Breaks::Inside));
        close.into_iter().for_each(|close| token(close, &mut document));
        return Document::Sequence(document);
    }
    let is_comma = |part: &Nested<'_, '_>| part.kind() == Some(&TokenKind::Comma);
    let commas: Vec<usize> = (0..inside.len()).filter(|place| is_comma(&inside[*place])).collect();
    let Some(last) = commas.last() else {
        document.push(match breaks {
            Breaks::After => Document::Sequence(vec![Document::Break, expression(inside)]).nest(INDENT),
            Breaks::Inside => expression(inside).group().align(),
        });
        close.into_iter().for_each(|close| token(close, &mut document));
        return Document::Sequence(document).group();
    };
    let (mut list, mut start) = (Vec::new(), 0);
    for comma in &commas {
        list.push(expression(&inside[start..*comma]).group());
        token(inside[*comma].first(), &mut list);
        // The processes of an event stay on one line.
        list.push(if is_call || comma == last { Document::Line } else { Document::Space });
        start = comma + 1;
    }
    list.push(expression(&inside[start..]).group().align());
    document.push(Document::Sequence(list).align());
    close.into_iter().for_each(|close| token(close, &mut document));
    Document::Sequence(document).group()
}

fn token(piece: &Piece<'_>, document: &mut Vec<Document>) {
    let comment = |text: &str, is_behind| Document::Comment { text: text.to_owned(), is_behind };
    document.extend(piece.above.iter().map(|above| comment(above.text, false)));
    document.push(Document::Text(piece.text.to_string()));
    document.extend(piece.behind.map(|behind| comment(behind, true)));
}
