//! Entries of a list: names with their meanings beside them.

use scenarios::schema::Key;

/// How wide a list is, in columns.
pub(crate) const WIDTH: usize = 80;

/// What a key means, what it takes, and what it is where the file does not say.
pub(crate) fn meaning(key: &Key) -> String {
    let default = match key.default() {
        _ if key.required => "; required".to_owned(),
        Some(default) => format!("; default {default}"),
        None => String::new(),
    };
    format!("{} [{}{default}]", key.about, key.accepts())
}

/// A name with its meaning beside it, or below if the name is long.
pub(crate) fn entry(name: &str, meaning: &str) -> String {
    const INDENT: &str = "                    ";
    let options = textwrap::Options::new(WIDTH).subsequent_indent(INDENT);
    let name = format!("  {name}");
    if name.chars().count() + 2 <= INDENT.len() {
        let first = format!("{name:<20}");
        return textwrap::fill(meaning, options.initial_indent(&first)) + "\n";
    }
    format!("{name}\n{}\n", textwrap::fill(meaning, options.initial_indent(INDENT)))
}
