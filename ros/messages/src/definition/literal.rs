//! Values in definitions: of constants, and default values of fields.

use diagnostics::{Problem, Span};

use super::span_parts::{part, trimmed};
use super::{Base, Count, Primitive, Type};
use crate::value::Value;

pub(super) fn of_type(value: &Span, kind: &Type) -> Result<Value, Problem> {
    let text = value.text();
    if kind.count != Count::One && !(text.len() >= 2 && text.starts_with('[') && text.ends_with(']')) {
        let problem = value.problem(format!("`{text}` is not an array")).with_label("this value");
        return Err(problem.with_help("the items of an array are written between `[` and `]`, separated by commas"));
    }
    let Base::Primitive(primitive) = kind.base else { return Err(no_message(value)) };
    if kind.count == Count::One {
        return of_primitive(value, primitive);
    }
    let inside = part(value, 1, text.len() - 1);
    let items = items(&inside)?.iter().map(|item| of_primitive(item, primitive)).collect::<Result<Vec<_>, _>>()?;
    let (fits, must) = match kind.count {
        Count::Exactly(count) => (items.len() == count, format!("{count} items")),
        Count::UpTo(count) => (items.len() <= count, format!("at most {count} items")),
        Count::One | Count::Any => (true, String::new()),
    };
    if !fits {
        let problem = value.problem(format!("{kind} has {must}, and this has {}", items.len()));
        return Err(problem.with_label("this array"));
    }
    Ok(Value::List(items))
}

/// The items of an array: separated by commas, except within quotes. A quote counts only at the beginning of an item:
/// `[it's, so]` has two.
fn items(inside: &Span) -> Result<Vec<Span>, Problem> {
    let text = inside.text();
    if text.trim().is_empty() {
        return Ok(Vec::new());
    }
    let mut items = Vec::new();
    let mut start = 0;
    loop {
        let rest = &text[start..];
        let begins = start + rest.len() - rest.trim_start().len();
        let quoted = text[begins..].chars().next().filter(|first| is_quote(*first));
        let ends = match quoted {
            Some(quote) => begins + 1 + closing(&text[begins + 1..], quote).unwrap_or(text.len() - begins - 1),
            None => begins,
        };
        let comma = text[ends..].find(',').map(|length| ends + length);
        let item = part(inside, start, comma.unwrap_or(text.len()));
        if trimmed(&item).text().is_empty() {
            return Err(item.problem("an item is missing").with_label("here").with_help("an empty string is `\"\"`"));
        }
        items.push(trimmed(&item));
        match comma {
            Some(comma) => start = comma + 1,
            None => return Ok(items),
        }
    }
}

/// The end of a string that begins with this quote: the next quote without a backslash before it.
fn closing(text: &str, quote: char) -> Option<usize> {
    text.match_indices(quote).map(|(at, _)| at).find(|at| !text[..*at].ends_with('\\'))
}

fn is_quote(letter: char) -> bool {
    letter == '"' || letter == '\''
}

/// A value of one item.
pub(super) fn of_primitive(value: &Span, kind: Primitive) -> Result<Value, Problem> {
    let text = value.text();
    let wrong = |help: String| {
        let problem = value.problem(format!("`{text}` is not a value of type {kind}")).with_label("this value");
        Err(problem.with_help(help))
    };
    if let Some((least, greatest)) = kind.range() {
        return match integer(text).filter(|number| (least..=greatest).contains(number)) {
            Some(number) => Ok(Value::Int(number)),
            None => wrong(format!("an integer from {least} to {greatest}")),
        };
    }
    match kind {
        Primitive::Bool => match text.to_ascii_lowercase().as_str() {
            "true" | "1" => Ok(Value::Bool(true)),
            "false" | "0" => Ok(Value::Bool(false)),
            _ => wrong("true or false".to_owned()),
        },
        Primitive::Float32 | Primitive::Float64 => match ungrouped(text, 10).and_then(|digits| digits.parse().ok()) {
            Some(number) => Ok(Value::Real(number)),
            None => wrong("a number".to_owned()),
        },
        Primitive::String(bound) | Primitive::WString(bound) => {
            let text = unquoted(value)?;
            match bound {
                Some(bound) if text.chars().count() > bound => wrong(format!("at most {bound} letters")),
                _ => Ok(Value::Text(text)),
            }
        }
        _ => wrong("a value of this type".to_owned()),
    }
}

/// An integer as Python reads it: decimal, or with `0x`, `0o` or `0b`, and underscores between digits.
fn integer(text: &str) -> Option<i128> {
    let (sign, digits) = match text.strip_prefix('-') {
        Some(digits) => (-1, digits),
        None => (1, text.strip_prefix('+').unwrap_or(text)),
    };
    let prefixes = [("0x", 16), ("0X", 16), ("0o", 8), ("0O", 8), ("0b", 2), ("0B", 2)];
    let prefixed = prefixes.iter().find_map(|(prefix, base)| Some((digits.strip_prefix(prefix)?, *base)));
    let (digits, base) = prefixed.unwrap_or((digits, 10));
    let is_sound = digits.starts_with(|digit: char| digit.is_digit(base));
    let number = is_sound.then(|| i128::from_str_radix(&ungrouped(digits, base)?, base).ok())??;
    Some(sign * number)
}

/// A number without the underscores in it, if each has digits around it.
fn ungrouped(text: &str, base: u32) -> Option<String> {
    let begins = |part: &str| part.starts_with(|letter: char| letter.is_digit(base));
    let ends = |part: &str| part.ends_with(|letter: char| letter.is_digit(base));
    let mut parts = text.split('_');
    let first = parts.next()?;
    let is_sound = parts.clone().all(begins) && text.rsplit('_').skip(1).all(ends);
    is_sound.then(|| parts.fold(first.to_owned(), |text, part| text + part))
}

fn no_message(value: &Span) -> Problem {
    let problem = value.problem("a field that holds messages has no default value").with_label("this value");
    problem.with_help("leave it out; a comment begins with `#`")
}

/// A text without the quotes around it, if it has some.
fn unquoted(value: &Span) -> Result<String, Problem> {
    let text = value.text();
    let Some(quote) = text.chars().next().filter(|first| is_quote(*first)) else { return Ok(text.to_owned()) };
    let inside = text.get(1..text.len() - 1).filter(|_| text.len() >= 2 && text.ends_with(quote));
    // As in ROS, where a `#` begins a comment even in a string: what is left of the string has its quote.
    let Some(inside) = inside else { return Ok(text.to_owned()) };
    if let Some(at) = closing(inside, quote) {
        let problem = part(value, 1 + at, 2 + at).problem(format!("a {quote} inside the string ends it"));
        return Err(problem.with_label("this quote").with_help(format!("write \\{quote}")));
    }
    Ok(inside.replace(&format!("\\{quote}"), &quote.to_string()))
}
