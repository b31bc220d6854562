//! Where a cursor is in a property file, complete or not.

use std::ops::Range;

use crate::expressions::word_in;

/// What the text at a cursor is, or will be.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum ScopePlace {
    /// A word of a formula, or the sender of an event: after a `(`, it may be either.
    Word {
        /// Whether a sender may be here.
        is_first: bool,
    },
    /// The receiver of an event from this sender.
    Receiver { sender: String },
    /// A word of the condition of an event.
    Condition {
        sender: String,
        receiver: String,
        /// Whether it is the name of a field, after `m.`.
        is_field: bool,
    },
    /// A symbol in the condition of an event, after its `<`.
    Symbol { sender: String, receiver: String },
}

/// The place at a cursor, and the range of the word there. Nothing in comments and texts.
pub(crate) fn place(text: &str, at: usize) -> Option<(ScopePlace, Range<usize>)> {
    let word = word_in(text, &(0..text.len()), at, |c| c.is_alphanumeric() || c == '_');
    let before = code(&text[..word.start])?;
    // Brackets that are still open, each with what is between its commas so far.
    let mut open: Vec<Vec<String>> = Vec::new();
    for c in before.chars() {
        match c {
            '(' => open.push(vec![String::new()]),
            ')' => drop(open.pop()),
            ',' => open.last_mut().into_iter().for_each(|parts| parts.push(String::new())),
            c => open.last_mut().and_then(|parts| parts.last_mut()).into_iter().for_each(|part| part.push(c)),
        }
    }
    let is_symbol = before.trim_end_matches(' ').ends_with('<')
        && before.trim_end_matches([' ', '<']).ends_with(['=', '!', '≠', '>']);
    // A condition may have brackets of its own.
    let event = open.iter().rev().find(|parts| parts.len() > 1);
    let place = match event.map(Vec::as_slice) {
        Some([sender, _]) => ScopePlace::Receiver { sender: sender.trim().to_owned() },
        Some([sender, receiver, ..]) => {
            let (sender, receiver) = (sender.trim().to_owned(), receiver.trim().to_owned());
            let is_field = before.ends_with("m.");
            match is_symbol {
                true => ScopePlace::Symbol { sender, receiver },
                false => ScopePlace::Condition { sender, receiver, is_field },
            }
        }
        _ => ScopePlace::Word { is_first: open.last().is_some_and(|parts| parts.concat().trim().is_empty()) },
    };
    Some((place, word))
}

/// The text without comments and texts; nothing if it ends in one.
fn code(text: &str) -> Option<String> {
    let mut code = String::with_capacity(text.len());
    let mut rest = text;
    loop {
        let begins = ["//", "\""].into_iter().filter_map(|begin| Some((rest.find(begin)?, begin)));
        let Some((at, begin)) = begins.min() else {
            code.push_str(rest);
            return Some(code);
        };
        code.push_str(&rest[..at]);
        let end = if begin == "//" { "\n" } else { "\"" };
        let inside = &rest[at + begin.len()..];
        rest = &inside[inside.find(end)? + end.len()..];
        code.push(' ');
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The place at the `|` of a text, without it, and the word there.
    fn at(marked: &str) -> Option<(ScopePlace, String)> {
        let at = marked.find('|').unwrap();
        let text = marked.replacen('|', "", 1);
        place(&text, at).map(|(place, word)| (place, text[word].to_owned()))
    }

    #[test]
    fn a_place_in_an_event_knows_what_is_before_it() {
        let [sender, receiver] = ["A", "B"].map(str::to_owned);
        let symbol = ScopePlace::Symbol { sender: sender.clone(), receiver: receiver.clone() };
        let condition =
            |is_field| ScopePlace::Condition { sender: sender.clone(), receiver: receiver.clone(), is_field };
        let cases = [
            ("property p := alw|", ScopePlace::Word { is_first: false }, "alw"),
            ("property p := always (|", ScopePlace::Word { is_first: true }, ""),
            ("property p := always (not (|", ScopePlace::Word { is_first: true }, ""),
            ("property p := always (A, |", ScopePlace::Receiver { sender: sender.clone() }, ""),
            ("(A, B, m.le|vel > 3)", condition(true), "level"),
            ("(A, B, (m[1] = <ok> and |", condition(false), ""),
            ("(A, B, m[1] = <o|", symbol, "o"),
            ("(A, B, m[1] < |", condition(false), ""),
            ("(A, B, true) implies |", ScopePlace::Word { is_first: false }, ""),
        ];
        for (text, place, word) in cases {
            assert_eq!(at(text), Some((place, word.to_owned())), "{text}");
        }
        assert_eq!(at("// what|"), None);
        assert_eq!(at("(A, B, m = \"x|"), None);
        assert_eq!(at("// (\n(|"), Some((ScopePlace::Word { is_first: true }, String::new())));
    }
}
