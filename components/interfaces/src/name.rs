//! Names that messages, machines and properties can all write.

/// Whether a text is the name of a symbol, as properties write it between `<` and `>`.
pub(crate) fn is_symbol(text: &str) -> bool {
    !text.is_empty() && text.chars().all(|letter| letter.is_alphanumeric() || letter == '_' || letter == '-')
}

/// Whether a text is the name of a field: `_event.data.NAME` in a machine, `m.NAME` in a property.
pub(crate) fn is_field(text: &str) -> bool {
    let starts = text.starts_with(|letter: char| letter.is_ascii_alphabetic() || letter == '_');
    starts && text.chars().all(|letter| letter.is_ascii_alphanumeric() || letter == '_')
}
