//! What all XML files have in common: the problems that they may have (they are not well-formed, or would take too long
//! to read), and their layout.

mod layout;

use std::ops::Range;

use roxmltree::{Error, Node, TextPos};

pub use layout::{HasValue, is_same, layout};

use crate::{Problem, nearest};

/// Refuses elements with more than `limit` attributes, since the XML parser compares each with all others. Call this
/// before parsing.
///
/// # Errors
/// At the first attribute beyond the limit.
pub fn check_attributes(text: &str, limit: usize) -> Result<(), Problem> {
    let Some(at) = crowded_element(text, limit) else { return Ok(()) };
    let problem = Problem::new(format!("an element may have at most {limit} attributes"));
    Err(problem.at(at..at + 1, "one too many"))
}

fn crowded_element(text: &str, limit: usize) -> Option<usize> {
    // Few files have as many quotes as one element may have attributes, and counting them takes next to no time: chunks
    // whose counts fit into a byte let the compiler compare many bytes at once.
    let quotes = |chunk: &[u8]| chunk.iter().map(|byte| u8::from(matches!(byte, b'"' | b'\''))).sum::<u8>();
    if text.as_bytes().chunks(255).map(|chunk| usize::from(quotes(chunk))).sum::<usize>() <= limit {
        return None;
    }
    let mut rest = 0;
    while let Some(start) = text[rest..].find('<').map(|start| rest + start) {
        let tag = &text[start..];
        let no_element = [("<!--", "-->"), ("<![CDATA[", "]]>"), ("<?", "?>")];
        if let Some((_, end)) = no_element.into_iter().find(|(begin, _)| tag.starts_with(begin)) {
            rest = start + tag.find(end)? + end.len();
            continue;
        }
        let (mut quote, mut values) = (None, 0);
        rest = text.len();
        for (place, byte) in (start..).zip(tag.bytes()) {
            match (quote, byte) {
                (None, b'>') => {
                    rest = place;
                    break;
                }
                (None, b'"' | b'\'') if values == limit => return Some(place),
                (None, b'"' | b'\'') => (quote, values) = (Some(byte), values + 1),
                (Some(open), byte) if open == byte => quote = None,
                _ => {}
            }
        }
    }
    None
}

/// The problem with a text that the XML parser refuses, at the location where the parser stopped. `is_known` recognizes
/// the names of elements.
#[must_use]
pub fn problem(text: &str, error: &Error, is_known: impl Fn(&str) -> bool) -> Problem {
    if matches!(error, Error::DtdDetected) {
        let start = text.find("<!DOCTYPE").unwrap_or(0);
        let problem = Problem::new("a document type declaration is not accepted");
        let problem = problem.at(start..text.len().min(start + "<!DOCTYPE".len()), "starts here");
        return problem.with_help("remove it: document types and entities are not supported");
    }
    let not_xml = |message: &str| Problem::new(format!("this is not well-formed XML: {message}"));
    let before = text.len() - text.trim_start().len();
    if before > 0 && text[before..].starts_with("<?xml ") {
        let problem = not_xml("`<?xml …?>` must be at the very beginning of the file").at(0..before, "here");
        return problem.with_help("remove the blanks and lines before it");
    }
    let message = error.to_string();
    if matches!(error, Error::UnclosedRootNode | Error::UnexpectedEndOfStream | Error::NoRootNode) {
        return not_xml(&message).at(text.len()..text.len(), "here");
    }
    // The parser appends the location to its message; the label shows it better.
    let message = message.rsplit_once(" at ").map_or(message.as_str(), |(message, _)| message);
    let start = offset(text, error.pos());
    let end = text[start..].chars().next().map_or(start, |character| start + character.len_utf8());
    not_xml(message).at(start..end, "here").with_help_if(match error {
        Error::UnexpectedCloseTag(opened, closed, _) => misspelt(opened, closed, is_known),
        Error::InvalidAttributeValue(_) | Error::InvalidChar(b'"' | b'\'', ..) if text[start..].starts_with('<') => {
            Some("write `<` in an attribute as `&lt;`".to_owned())
        }
        Error::MalformedEntityReference(_) => Some("write `&` as `&amp;`, and `&&` as `&amp;&amp;`".to_owned()),
        _ => None,
    })
}

/// The probable name of an element that begins with one name and ends with a similar one.
fn misspelt(opened: &str, closed: &str, is_known: impl Fn(&str) -> bool) -> Option<String> {
    nearest(opened, [closed])?;
    let meant = if is_known(closed) { closed } else { opened };
    Some(format!("<{opened}> ends as </{closed}>: did you mean <{meant}>?"))
}

/// The byte at a row and a column, both counted from 1.
fn offset(text: &str, place: TextPos) -> usize {
    let row = place.row.saturating_sub(1) as usize;
    let line_start = text.split_inclusive('\n').take(row).map(str::len).sum::<usize>();
    let column = place.col.saturating_sub(1) as usize;
    text[line_start..].char_indices().nth(column).map_or(text.len(), |(offset, _)| line_start + offset)
}

/// The range of an element's name in its start tag, including its prefix.
#[must_use]
pub fn name_span(element: Node<'_, '_>) -> Range<usize> {
    let start = (element.range().start + 1).min(element.range().end);
    let written = element.document().input_text().get(start..).unwrap_or_default();
    let length = written.find(|c: char| c.is_whitespace() || c == '/' || c == '>').unwrap_or(written.len());
    start..start + length
}

/// The name of the outermost element, with its prefix, even if the text is not well-formed; `None` if it has none.
///
/// ```
/// let text = "<?xml version=\"1.0\"?> <!-- <a> --> <root> <unclosed </root>";
/// assert_eq!(diagnostics::xml::root_name(text), Some("root"));
/// assert_eq!(diagnostics::xml::root_name("property p := true"), None);
/// ```
#[must_use]
pub fn root_name(text: &str) -> Option<&str> {
    let mut rest = text.trim_start();
    while let Some((_, end)) =
        [("<!--", "-->"), ("<?", "?>"), ("<!", ">")].into_iter().find(|(begin, _)| rest.starts_with(begin))
    {
        rest = rest[rest.find(end)? + end.len()..].trim_start();
    }
    let name = rest.strip_prefix('<')?;
    let name = &name[..name.find(|c: char| c.is_whitespace() || c == '/' || c == '>').unwrap_or(name.len())];
    (!name.is_empty()).then_some(name)
}

#[cfg(test)]
mod tests {
    use roxmltree::Document;

    use super::*;

    fn reported(text: &str) -> Vec<String> {
        let problem = problem(text, &Document::parse(text).expect_err(text), |name| name == "state");
        let marked = problem.of(&crate::Source::new("file.xml", text));
        let place = marked.span().map(|span| format!("{}:{} {}", span.line(), span.column(), span.text()));
        place.into_iter().chain([marked.message().to_owned()]).chain(marked.help_text().map(str::to_owned)).collect()
    }

    #[test]
    fn text_that_is_not_xml_is_refused_with_its_location() {
        let meant = "<stat> ends as </state>: did you mean <state>?";
        assert_eq!(
            reported("<stat>\n</state>"),
            ["2:1 <", "this is not well-formed XML: expected 'stat' tag, not 'state'", meant]
        );
        assert_eq!(reported("<a>"), ["1:4 ", "this is not well-formed XML: the root node was opened but never closed"]);
        assert_eq!(reported("<!DOCTYPE a><a/>")[..2], ["1:1 <!DOCTYPE", "a document type declaration is not accepted"]);
        assert_eq!(reported("\n<?xml version='1.0'?><a/>")[2], "remove the blanks and lines before it");
    }

    #[test]
    fn an_operator_in_an_attribute_is_told_how_to_be_written() {
        let help = |text: &str| reported(text).pop().expect("a help");
        for text in ["<a b=\"x < 2\"/>", "<a b='x < 2'/>", "<a b=\"x <= 2\"/>"] {
            assert_eq!(help(text), "write `<` in an attribute as `&lt;`");
        }
        for text in ["<a b=\"x && y\"/>", "<a b=\"x & y\"/>"] {
            assert_eq!(help(text), "write `&` as `&amp;`, and `&&` as `&amp;&amp;`");
        }
    }

    #[test]
    fn attributes_are_counted_element_by_element() {
        let text = "<!-- a='' b='' c='' --><a b='<' c='>'/><d e=''><f g='' h=''/></d>";
        assert!(check_attributes(text, 2).is_ok());
        assert_eq!(check_attributes(text, 1).expect_err("two").offset(), text.find("'>'").expect("the second"));
    }
}
