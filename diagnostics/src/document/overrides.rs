//! Assignments from the command line: `faults.0.charge_pct=5`.

use super::node::{Entries, Entry, Kind, MAX_DEPTH, Node};
use super::toml_text;
use crate::source::ASSIGNMENT;
use crate::{Problem, Source, Span};

/// Applies one assignment to the document.
pub(super) fn apply(root: &mut Node, assignment: &str) -> Result<(), Problem> {
    let source = Source::new(ASSIGNMENT, assignment);
    let Some((key, _)) = assignment.split_once('=') else {
        let problem = source.span(0..assignment.len()).problem("no `=` in the assignment");
        return Err(problem.with_label("expected `key=value`"));
    };
    let path = path(&source, key)?;
    let value = value(&source, key.len() + 1)?;
    assign(root, &path, value)
}

/// The parts of a dotted key, each with its location. A part in quotes may contain dots, and has no escapes.
fn path(source: &Source, key: &str) -> Result<Vec<Span>, Problem> {
    let mut path = Vec::new();
    let mut start = 0;
    let mut is_quoted = false;
    let ends_part = |sign: char| {
        is_quoted ^= sign == '"';
        sign == '.' && !is_quoted
    };
    for part in key.split(ends_part) {
        let blank = part.len() - part.trim_start().len();
        let mut range = start + blank..start + blank + part.trim().len();
        if part.trim().len() > 1 && part.trim().starts_with('"') && part.trim().ends_with('"') {
            range = range.start + 1..range.end - 1;
        }
        let span = source.span(range);
        if span.text().is_empty() {
            return Err(span.problem("an empty part in the key").with_label("a name is missing here"));
        }
        path.push(span);
        start += part.len() + 1;
    }
    if path.len() > MAX_DEPTH {
        return Err(path[MAX_DEPTH].problem("the key has too many parts"));
    }
    Ok(path)
}

/// The value from byte `at` on: TOML, or otherwise plain text.
fn value(source: &Source, at: usize) -> Result<Node, Problem> {
    let text = source.text()[at..].trim();
    let span = source.span(source.text().trim_end().len() - text.len()..source.text().trim_end().len());
    if text.is_empty() {
        return Err(source.span(at..at).problem("no value after `=`").with_help("write an empty string as `\"\"`"));
    }
    match toml_text::value(source, span.range().start) {
        Ok(node) => Ok(node),
        Err(_) if !text.starts_with(['"', '\'', '[', '{']) => Ok(Node { kind: Kind::Text(text.to_owned()), span }),
        Err(problems) => Err(problems.problems()[0].clone()),
    }
}

/// Puts the value where the path leads and creates missing tables on the way.
fn assign(root: &mut Node, path: &[Span], value: Node) -> Result<(), Problem> {
    let (last, way) = path.split_last().expect("splitting a key gives at least one part");
    let mut node = root;
    for (part, next) in way.iter().zip(&path[1..]) {
        let is_missing = |entries: &Entries| !entries.by_key.contains_key(part.text());
        if matches!(&node.kind, Kind::Table(entries) if is_missing(entries)) && next.text().parse::<usize>().is_ok() {
            let problem = part.problem(format!("there are no `{}`, so none can be changed", part.text()));
            let help = format!("`{}=[{{…}}]` sets all of them", part.text());
            return Err(problem.with_label("none are here").with_help(help));
        }
        let new = || Node { span: part.clone(), kind: Kind::Table(Entries::default()) };
        node = step(node, part, new)?;
    }
    let span = value.span.clone();
    let slot = step(node, last, || Node { span, kind: Kind::Nothing })?;
    *slot = value;
    Ok(())
}

/// The value under one part of a key; `new` creates a missing one.
fn step<'n>(node: &'n mut Node, part: &Span, new: impl FnOnce() -> Node) -> Result<&'n mut Node, Problem> {
    match &mut node.kind {
        Kind::Table(entries) => {
            let entry = entries.by_key.entry(part.text().to_owned());
            Ok(&mut entry.or_insert_with(|| Entry { key: part.clone(), value: new() }).value)
        }
        Kind::Array(items) => {
            let count = items.len();
            let slot = part.text().parse().ok().and_then(|index: usize| items.get_mut(index));
            slot.ok_or_else(|| {
                let problem = part.problem(format!("this array has no item `{}`", part.text()));
                problem.with_label("this is an array").with_help(match count {
                    0 => "the array is empty".to_owned(),
                    _ => format!("items are numbered from 0 to {}", count - 1),
                })
            })
        }
        kind => {
            let problem = part.problem(format!("`{}` leads into {}", part.text(), kind.name()));
            Err(problem.with_label("only tables and arrays have parts"))
        }
    }
}
