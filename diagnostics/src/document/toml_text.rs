//! TOML as a tree of nodes.

use std::ops::Range;

use toml::de::{DeInteger, DeTable, DeValue};
use toml::{Spanned, Value};

use super::node::{Entries, Entry, Kind, Node};
use crate::{FileProblems, Problem, Source, Span};

/// Further syntax errors add nothing: the text is probably not TOML.
const MAX_SYNTAX_ERRORS: usize = 20;

/// Parses a whole file.
pub(super) fn document(source: &Source) -> Result<Node, FileProblems> {
    let (root, errors) = DeTable::parse_recoverable(source.text());
    let root = Spanned::new(0..0, DeValue::Table(root.into_inner()));
    node(source, root, errors, 0)
}

/// The value of a node; `None` for what TOML cannot express.
pub(super) fn value_of(node: &Node) -> Option<Value> {
    Some(match &node.kind {
        Kind::Text(text) => Value::String(text.clone()),
        Kind::Integer(number) => Value::Integer(i64::try_from(*number).ok()?),
        Kind::Real(number) => Value::Float(*number),
        Kind::Boolean(flag) => Value::Boolean(*flag),
        Kind::Moment | Kind::Nothing | Kind::Unreadable => return None,
        Kind::Array(items) => Value::Array(items.iter().filter_map(value_of).collect()),
        Kind::Table(Entries { by_key, .. }) => {
            let entry = |(key, entry): (&String, &Entry)| Some((key.clone(), value_of(&entry.value)?));
            Value::Table(by_key.iter().filter_map(entry).collect())
        }
    })
}

/// Parses the value in `source` that extends from byte `at` to the end.
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

/// The syntax errors, at most one per line, since later ones mostly follow from the first.
fn syntax_problems(source: &Source, errors: Vec<toml::de::Error>, at: usize) -> Vec<Problem> {
    let mut problems: Vec<Problem> = Vec::new();
    for error in errors {
        let range = error.span().unwrap_or_default();
        let span = source.span(range.start + at..range.end + at);
        if problems.iter().filter_map(Problem::span).any(|other| other.line() == span.line()) {
            continue;
        }
        problems.push(problem(&span, error.message()));
        if problems.len() == MAX_SYNTAX_ERRORS {
            break;
        }
    }
    problems
}

/// Advice on how lines, lists and numbers are written, for parser messages that begin like this; `LINE` is for all
/// others.
const ADVICE: &[(&[&str], &str)] = &[
    (&["duplicate key"], "a key appears in its table only once; further tables of a list begin with `[[NAME]]`"),
    (&["unclosed array table"], "end it with `]]`"),
    (&["unclosed inline table"], "end it with `}`"),
    (&["unclosed"], "end it with `]`"),
    (
        &[
            "invalid basic string",
            "invalid literal string",
            "invalid multi-line",
            "missing opening quote",
            "missing esc",
        ],
        "a string begins and ends with the same quotes; between `'…'`, a backslash is a backslash",
    ),
    (
        &["missing", "extra", "unexpected `=`", "invalid inline table"],
        "an array is written `[1, 2]`, a table in one line `{ key = 1, other = 2 }`",
    ),
    (&["unexpected key or value", "unexpected content"], "the value ends before this; the next key begins a line"),
    (&["string values"], "a string is written `\"…\"`; a comma separates the items of an array"),
    (&["invalid unquoted key", "unquoted keys"], "other keys are written in quotes"),
    (&["invalid key", "invalid comment"], LINE),
    (&["invalid", "unexpected", "redundant", "integers", "radix", "`_`"], "numbers are written `10`, `-0.5` or `1e-3`"),
];
const LINE: &str = "a line is `KEY = VALUE`, `[TABLE]` or `# comment`";

/// The parser's message, with advice. For a bare word, the parser reports that it is not `true`, `false`, `inf` or
/// `nan`, whichever begins with the same letter.
fn problem(span: &Span, reported: &str) -> Problem {
    let is_word = ["string values", "invalid float", "invalid boolean"].iter().any(|begin| reported.starts_with(begin));
    if is_word && span.text().is_empty() {
        return span.problem("a value is missing").with_label("after the `=`").with_help("an empty string is `\"\"`");
    }
    let small = span.text().to_lowercase();
    if is_word && matches!(small.as_str(), "true" | "false" | "inf" | "nan") {
        return span.problem(format!("unknown value `{}`", span.text())).with_help(format!("write `{small}`"));
    }
    if is_word && span.text().starts_with(char::is_alphabetic) {
        let help = format!("write `\"{}\"`", span.text());
        return span.problem("a string must be in quotes").with_label("not TOML").with_help(help);
    }
    let reported = reported.trim_end_matches(", expected nothing");
    let advice = ADVICE.iter().find(|(begins, _)| begins.iter().any(|begin| reported.starts_with(begin)));
    span.problem(reported).with_label("not TOML").with_help(advice.map_or(LINE, |(_, help)| help))
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
