//! Names that messages, machines and properties can all write.

/// Whether a text is the name of a symbol, as properties write it between `<` and `>`.
pub(crate) fn is_symbol(text: &str) -> bool {
    !text.is_empty() && text.chars().all(|letter| letter.is_alphanumeric() || letter == '_' || letter == '-')
}
