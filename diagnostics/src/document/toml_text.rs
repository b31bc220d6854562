//! TOML as a tree of nodes.

use std::ops::Range;

use toml::Spanned;
use toml::de::{DeInteger, DeTable, DeValue};

use super::node::{Entries, Entry, Kind, Node};
use crate::{FileProblems, Problem, Source, Span};

/// Further syntax errors tell nothing new: the file is something else.
const MAX_SYNTAX_ERRORS: usize = 20;

/// Parses a whole file.
pub(super) fn document(source: &Source) -> Result<Node, FileProblems> {
    let (root, errors) = DeTable::parse_recoverable(source.text());
    let root = Spanned::new(0..0, DeValue::Table(root.into_inner()));
    node(source, root, errors, 0)
}

/// Parses the value that extends in `source` from byte `at` to the end.
pub(super) fn value(source: &Source, at: usize) -> Result<Node, FileProblems> {
    let (value, errors) = DeValue::parse_recoverable(&source.text()[at..]);
    node(source, value, errors, at)
}

fn node(
    source: &Source,
    root: Spanned<DeValue>,
    errors: Vec<toml::de::Error>,
    at: usize,
) -> Result<Node, FileProblems> {
    FileProblems::none_of(syntax_problems(source, errors, at))?;
    // The parser limits nesting, so recursion is safe.
    Ok(convert(root, &|range| source.span(range.start + at..range.end + at)))
}

/// The syntax errors, at most one per line: later ones mostly follow from the first.
fn syntax_problems(source: &Source, errors: Vec<toml::de::Error>, at: usize) -> Vec<Problem> {
    let mut problems: Vec<Problem> = Vec::new();
    for error in errors {
        let range = error.span().unwrap_or_default();
        let span = source.span(range.start + at..range.end + at);
        if problems.iter().filter_map(Problem::span).any(|other| other.line() == span.line()) {
            continue;
        }
        problems.push(span.problem(error.message()).with_label("not TOML"));
        if problems.len() == MAX_SYNTAX_ERRORS {
            break;
        }
    }
    problems
}

fn convert(value: Spanned<DeValue>, place: &dyn Fn(Range<usize>) -> Span) -> Node {
    let span = place(value.span());
    let kind = match value.into_inner() {
        DeValue::String(text) => Kind::Text(text.into_owned()),
        DeValue::Integer(number) => integer(&number),
        DeValue::Float(number) => Kind::Real(number.as_str().parse().unwrap_or(f64::NAN)),
        DeValue::Boolean(value) => Kind::Boolean(value),
        DeValue::Datetime(_) => Kind::Moment,
        DeValue::Array(items) => Kind::Array(items.into_iter().map(|item| convert(item, place)).collect()),
        DeValue::Table(table) => {
            let entry = |(key, value): (Spanned<_>, _)| {
                let span = place(key.span());
                (String::from(key.into_inner()), Entry { key: span, value: convert(value, place) })
            };
            Kind::Table(Entries { by_key: table.into_iter().map(entry).collect(), ..Entries::default() })
        }
    };
    Node { span, kind }
}

/// An integer too large for 128 bits is still a number.
fn integer(number: &DeInteger) -> Kind {
    match i128::from_str_radix(number.as_str(), number.radix()) {
        Ok(number) => Kind::Integer(number),
        Err(_) => Kind::Real(number.as_str().parse().unwrap_or(f64::INFINITY)),
    }
}
