//! Parts of a line.

use diagnostics::Span;

/// The part of a span between two bytes, counted from its beginning.
pub(super) fn part(span: &Span, from: usize, to: usize) -> Span {
    let start = span.range().start;
    span.source().span(start + from..start + to)
}

/// The span without surrounding white space.
pub(super) fn trimmed(span: &Span) -> Span {
    let text = span.text();
    let from = text.len() - text.trim_start().len();
    part(span, from, from + text.trim().len())
}

/// The text before the first letter for which `ends` holds, and the rest.
pub(super) fn split(span: &Span, ends: impl Fn(char) -> bool) -> (Span, Span) {
    let at = span.text().find(ends).unwrap_or(span.text().len());
    (part(span, 0, at), part(span, at, span.text().len()))
}
