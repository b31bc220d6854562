//! The names that ROS permits.

/// Whether this is a valid name of a node, topic or service in ROS 2, without a namespace.
#[must_use]
pub fn is_name(word: &str) -> bool {
    word.starts_with(|first: char| first.is_ascii_alphabetic() || first == '_')
        && word.chars().all(|letter| letter.is_ascii_alphanumeric() || letter == '_')
}

/// A name of a field or a package: `^(?!.*__)(?!.*_$)[a-z][a-z0-9_]*$` in rosidl.
pub(super) fn is_field_name(name: &str) -> bool {
    is_made_of(name, |letter| letter.is_ascii_lowercase())
}

/// A name of a constant: `^[A-Z]([A-Z0-9_]?[A-Z0-9]+)*$` in rosidl.
pub(super) fn is_constant_name(name: &str) -> bool {
    is_made_of(name, |letter| letter.is_ascii_uppercase())
}

/// A name of a message. Those that ROS derives from services and actions contain an underscore.
pub(super) fn is_type_name(name: &str) -> bool {
    name.starts_with(|letter: char| letter.is_ascii_uppercase())
        && name.chars().all(|letter| letter.is_ascii_alphanumeric() || letter == '_')
}

/// Whether a name has such letters, digits and single underscores, with a letter first and no underscore last.
fn is_made_of(name: &str, is_letter: impl Fn(char) -> bool) -> bool {
    name.starts_with(&is_letter)
        && name.chars().all(|letter| is_letter(letter) || letter.is_ascii_digit() || letter == '_')
        && !name.contains("__")
        && !name.ends_with('_')
}
