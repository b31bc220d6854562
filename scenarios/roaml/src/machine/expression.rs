//! Expressions: what RoAML adds to ECMAScript, and the types of their values.

use std::collections::BTreeMap;
use std::ops::Range;

use super::kind::DataKind;

/// The names by which an expression refers to the message that it handles.
const MESSAGE: [&str; 7] = ["_msg", "_req", "_res", "_goal", "_feedback", "_action", "_wrapped_result"];

/// The byte ranges of the words in an expression, outside strings, that refer to the message. Each word stands for
/// `_event.data`.
pub(super) fn mentions(text: &str) -> Vec<Range<usize>> {
    let mut found = Vec::new();
    for (word, range) in words(text) {
        if !MESSAGE.contains(&word) {
            continue;
        }
        let result = word == "_wrapped_result" && text[range.end..].starts_with(".result");
        found.push(range.start..range.end + if result { ".result".len() } else { 0 });
    }
    found
}

/// The identifiers in an expression, except inside strings and after a dot.
fn words(text: &str) -> Vec<(&str, Range<usize>)> {
    let mut words = Vec::new();
    let (mut quote, mut start, mut before) = (None, None, ' ');
    for (place, letter) in text.char_indices().chain([(text.len(), ' ')]) {
        let is_word = letter.is_alphanumeric() || matches!(letter, '_' | '$');
        match (quote, letter) {
            (Some(open), letter) if letter == open && before != '\\' => quote = None,
            (Some(_), _) => {}
            (None, '"' | '\'' | '`') => quote = Some(letter),
            (None, _) if is_word && start.is_none() => start = Some((place, before)),
            _ => {}
        }
        if let Some((begin, previous)) = start.filter(|_| !is_word) {
            let word = &text[begin..place];
            if previous != '.' && !word.starts_with(|letter: char| letter.is_ascii_digit()) {
                words.push((word, begin..place));
            }
            start = None;
        }
        before = letter;
    }
    words
}

/// The kind of an expression's value, as far as the types of the data in it determine it.
pub(super) fn kind(text: &str, data: &BTreeMap<String, DataKind>) -> DataKind {
    let text = text.trim();
    if text == "true" || text == "false" || outside(text, &["==", "!=", "<", ">", "&&", "||", "!"]) {
        return if text.contains('?') { DataKind::Any } else { DataKind::Bool };
    }
    if let Some(kind) = data.get(text) {
        return *kind;
    }
    let is_string = |quote| text.len() > 1 && text.starts_with(quote) && text[1..].find(quote) == Some(text.len() - 2);
    if is_string('\'') || is_string('"') {
        return DataKind::Text;
    }
    let is_plain = text.chars().all(|c| c.is_alphanumeric() || "_+-*% ().".contains(c)) && !text.is_empty();
    let mut kinds = words(text).into_iter().map(|(word, _)| data.get(word).copied());
    if !is_plain || kinds.clone().any(|kind| !matches!(kind, Some(DataKind::Int | DataKind::Real))) {
        return DataKind::Any;
    }
    if text.contains('.') || kinds.any(|kind| kind == Some(DataKind::Real)) { DataKind::Real } else { DataKind::Int }
}

/// Whether one of these operators occurs outside strings and brackets.
fn outside(text: &str, operators: &[&str]) -> bool {
    let (mut quote, mut depth) = (None, 0_i32);
    for (place, letter) in text.char_indices() {
        match (quote, letter) {
            (Some(open), letter) if letter == open => quote = None,
            (Some(_), _) => {}
            (None, '"' | '\'') => quote = Some(letter),
            (None, '(' | '[' | '{') => depth += 1,
            (None, ')' | ']' | '}') => depth -= 1,
            (None, _) if depth == 0 && operators.iter().any(|operator| text[place..].starts_with(operator)) => {
                return true;
            }
            _ => {}
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_the_message_are_found_outside_strings() {
        let found = |text| mentions(text).into_iter().map(|range| &text[range]).collect::<Vec<_>>();
        assert_eq!(found("_msg.data < 30 && x_msg._msg != '_msg'"), ["_msg"]);
        assert_eq!(
            found("_wrapped_result.result.ok || _wrapped_result.code == 4"),
            ["_wrapped_result.result", "_wrapped_result"]
        );
    }

    #[test]
    fn kinds_follow_from_literals_operators_and_data() {
        let data = [("count", DataKind::Int), ("speed", DataKind::Real), ("list", DataKind::Any)];
        let data = data.map(|(name, kind)| (name.to_owned(), kind)).into();
        let kinds = ["count + 1", "-1", "speed * count", "0.5", "'a < b'", "count == 3", "true", "list[0]", "list"];
        let kinds = kinds.map(|text| kind(text, &data));
        let expected = [
            DataKind::Int,
            DataKind::Int,
            DataKind::Real,
            DataKind::Real,
            DataKind::Text,
            DataKind::Bool,
            DataKind::Bool,
            DataKind::Any,
            DataKind::Any,
        ];
        assert_eq!(kinds, expected);
    }
}
