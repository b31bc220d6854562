//! Expressions and their words, complete or not.

use std::ops::Range;

use channels::{FieldKind, Symbol};

/// The word at a byte of a range.
pub(crate) fn word_in(text: &str, range: &Range<usize>, at: usize, is_word: fn(char) -> bool) -> Range<usize> {
    let [before, after] = [&text[range.start..at], &text[at..range.end]];
    let start =
        before.rfind(|c| !is_word(c)).map_or(0, |end| end + before[end..].chars().next().map_or(1, char::len_utf8));
    let end = after.find(|c| !is_word(c)).unwrap_or(after.len());
    range.start + start..at + end
}

/// Whether a text begins before a place and does not end there.
pub(crate) fn is_in_text(before: &str) -> bool {
    ['\'', '"'].iter().any(|quote| before.matches(*quote).count() % 2 == 1)
}

/// The field of this object with which a text that has just begun is compared.
pub(crate) fn compared<'e>(before: &'e str, object: &str) -> Option<&'e str> {
    let comparison = before.strip_suffix(['\'', '"'])?.trim_end();
    let left = comparison.trim_end_matches('=').trim_end_matches('!');
    // Two signs, or three.
    let field_of = left.trim_end();
    let (object_of, field) = field_of.rsplit_once('.').filter(|_| comparison.len() >= left.len() + 2)?;
    object_of.ends_with(object).then_some(field)
}

/// The symbols that a field of this name may be.
pub(crate) fn symbols<'f>(
    fields: impl Iterator<Item = &'f (String, FieldKind)>,
    name: &str,
) -> impl Iterator<Item = &'f Symbol> {
    fn of(kind: &FieldKind) -> &[Symbol] {
        match kind {
            FieldKind::Symbol(symbols) => symbols,
            FieldKind::Optional(kind) => of(kind),
            _ => &[],
        }
    }
    fields.filter(move |(field, _)| field == name).flat_map(|(_, kind)| of(kind))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_is_compared_with_the_field_before_it() {
        let field = |before| compared(before, "_event.data");
        for before in ["_event.data.x == '", "x && _event.data.x===\"", "(_event.data.x != '"] {
            assert_eq!(field(before), Some("x"), "{before}");
        }
        for before in ["_event.data.x == ", "data.x == '", "_event.data.x = '", "_event.data.x + '", "'"] {
            assert_eq!(field(before), None, "{before}");
        }
    }
}
