//! Text as it is written in XML, so that a reader gets the same text back.
//!
//! XML 1.0 cannot carry most control characters, not even as references: a file with one of them is refused as a whole.
//! They are therefore dropped.

/// Text for an attribute in double quotes. Readers replace tabs and line breaks in attributes by blanks (XML 1.0,
/// 3.3.3) unless they are written as references.
///
/// ```
/// assert_eq!(diagnostics::markup::attribute("a < \"b\"\n"), "a &lt; &quot;b&quot;&#10;");
/// ```
#[must_use]
pub fn attribute(text: &str) -> String {
    escaped(text, |character| match character {
        '"' => Some("&quot;"),
        '\t' => Some("&#9;"),
        '\n' => Some("&#10;"),
        _ => None,
    })
}

/// Text between tags.
///
/// ```
/// assert_eq!(diagnostics::markup::text("a < \"b\"\n"), "a &lt; \"b\"\n");
/// ```
#[must_use]
pub fn text(text: &str) -> String {
    escaped(text, |_| None)
}

fn escaped(text: &str, reference: impl Fn(char) -> Option<&'static str>) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            // Only `]]>` must not be written between tags, but people expect `>` to be treated as `<` is.
            '>' => escaped.push_str("&gt;"),
            // Readers make a line feed of it anywhere (2.11).
            '\r' => escaped.push_str("&#13;"),
            _ => match reference(character) {
                Some(reference) => escaped.push_str(reference),
                None if is_char(character) => escaped.push(character),
                None => {}
            },
        }
    }
    escaped
}

/// Whether XML 1.0 can carry a character (2.2).
fn is_char(character: char) -> bool {
    matches!(character, '\t' | '\n' | '\r' | ' '..) && !matches!(character, '\u{fffe}' | '\u{ffff}')
}

#[cfg(test)]
mod tests {
    #[cfg(feature = "xml")]
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn characters_that_xml_cannot_carry_are_dropped() {
        for escaped in [attribute, text] {
            assert_eq!(escaped("a\u{0}b\u{1b}c\u{fffe}d\u{ffff}e\u{7f}\u{9b}"), "abcde\u{7f}\u{9b}");
        }
    }

    #[cfg(feature = "xml")]
    proptest! {
        #[test]
        fn a_reader_gets_the_same_text_back(written in r#"[&<>"'\t\n\r\];a-c\x00\x7f-\xa0\u{d7ff}\u{fffe}\u{1f600}]*"#) {
            let file = format!("<a b=\"{}\">{}</a>", attribute(&written), text(&written));
            let read = roxmltree::Document::parse(&file).expect("well-formed");
            let kept: String = written.chars().filter(|character| is_char(*character)).collect();
            prop_assert_eq!(read.root_element().attribute("b"), Some(&*kept));
            prop_assert_eq!(read.root_element().text().unwrap_or_default(), kept);
        }
    }
}
