//! Text in XML.

/// Whether documents may contain a character: no control characters but line breaks and tabs.
pub fn is_allowed(character: char) -> bool {
    let is_space = matches!(character, '\t' | '\n' | '\r');
    (is_space || !character.is_control()) && !matches!(character, '\u{fffe}' | '\u{ffff}')
}

/// The text on one line, with special XML characters as entities; characters that are not allowed are dropped.
pub fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&apos;"),
            '\t' | '\n' | '\r' => escaped.push(' '),
            _ if is_allowed(character) => escaped.push(character),
            _ => {}
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_escaped_onto_one_line_and_forbidden_characters_are_dropped() {
        assert_eq!(escape("a < b & \"c\" >\n'd'\u{0}\u{ffff}"), "a &lt; b &amp; &quot;c&quot; &gt; &apos;d&apos;");
    }
}
