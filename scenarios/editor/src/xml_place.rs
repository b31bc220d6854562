//! Where a cursor is in an XML file, complete or not.

use std::ops::Range;

/// What the text at a cursor is, or will be.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum XmlPlace {
    /// The name of an element, after its `<`.
    Element {
        /// The names of the elements around it, the outermost first.
        around: Vec<String>,
    },
    /// The name of an attribute.
    Attribute {
        /// The element.
        element: String,
        /// The names of the elements around it, the outermost first.
        around: Vec<String>,
        /// Attributes that it has already.
        present: Vec<String>,
    },
    /// The value of an attribute.
    Value {
        /// The element.
        element: String,
        /// The attribute.
        attribute: String,
    },
    /// Between elements.
    Content {
        /// The names of the elements around it, the outermost first.
        around: Vec<String>,
    },
}

/// The place at a cursor, and the range of the word there. Nothing in comments and outside of what XML has.
pub(crate) fn place(text: &str, at: usize) -> Option<(XmlPlace, Range<usize>)> {
    let mut around: Vec<String> = Vec::new();
    let mut next = 0;
    while let Some(open) = text[next..].find('<').map(|offset| next + offset).filter(|open| *open < at) {
        let rest = &text[open..];
        let skipped = [("<!--", "-->"), ("<![CDATA[", "]]>"), ("<?", "?>"), ("<!", ">")]
            .into_iter()
            .find(|(begin, _)| rest.starts_with(begin));
        if let Some((begin, end)) = skipped {
            let length = rest[begin.len()..].find(end)?;
            next = open + begin.len() + length + end.len();
            if at < next {
                return None;
            }
            continue;
        }
        let tag = WrittenTag::read(text, open);
        if at <= tag.end && !(tag.is_closed && at == tag.end) {
            return tag.place(text, at, around);
        }
        next = tag.end;
        if tag.is_end {
            if let Some(place) = around.iter().rposition(|name| *name == text[tag.name.clone()]) {
                around.truncate(place);
            }
        } else if !tag.is_empty {
            around.push(text[tag.name].to_owned());
        }
    }
    Some((XmlPlace::Content { around }, at..at))
}

/// A tag, up to its `>`, or to the next `<` if it has none.
struct WrittenTag {
    name: Range<usize>,
    /// The name of each attribute, and its value without quotes.
    attributes: Vec<(Range<usize>, Option<Range<usize>>)>,
    end: usize,
    is_closed: bool,
    is_end: bool,
    is_empty: bool,
}

impl WrittenTag {
    fn read(text: &str, open: usize) -> Self {
        let bytes = text.as_bytes();
        let is_end = bytes.get(open + 1) == Some(&b'/');
        let begin = open + 1 + usize::from(is_end);
        let name = begin..word_end(bytes, begin);
        let mut tag = Self { end: name.end, name, attributes: Vec::new(), is_closed: false, is_end, is_empty: false };
        while let Some(byte) = bytes.get(tag.end) {
            match byte {
                b'>' => {
                    tag.end += 1;
                    tag.is_closed = true;
                    break;
                }
                b'<' => break,
                b'/' => {
                    tag.is_empty = bytes.get(tag.end + 1) == Some(&b'>');
                    tag.end += 1;
                }
                b'=' => {
                    tag.end += 1;
                    while bytes.get(tag.end).is_some_and(u8::is_ascii_whitespace) {
                        tag.end += 1;
                    }
                    let Some(quote @ (b'"' | b'\'')) = bytes.get(tag.end) else { continue };
                    let start = tag.end + 1;
                    // A value without its second quote ends with the line.
                    let ends = |byte: &u8| byte == quote || *byte == b'\n' || *byte == b'<';
                    let end = bytes[start..].iter().position(ends).map_or(bytes.len(), |length| start + length);
                    if let Some(last) = tag.attributes.last_mut() {
                        last.1 = Some(start..end);
                    }
                    tag.end = end + usize::from(bytes.get(end) == Some(quote));
                }
                byte if byte.is_ascii_whitespace() || matches!(byte, b'"' | b'\'') => tag.end += 1,
                _ => {
                    let end = word_end(bytes, tag.end);
                    tag.attributes.push((tag.end..end, None));
                    tag.end = end;
                }
            }
        }
        tag
    }

    fn place(&self, text: &str, at: usize, around: Vec<String>) -> Option<(XmlPlace, Range<usize>)> {
        if at <= self.name.end {
            // An end tag closes the element in which it is.
            let word = self.name.start..self.name.end;
            return (!self.is_end && at >= self.name.start).then_some((XmlPlace::Element { around }, word));
        }
        let element = text[self.name.clone()].to_owned();
        for (name, value) in &self.attributes {
            if let Some(value) = value.as_ref().filter(|value| value.start <= at && at <= value.end) {
                let attribute = text[name.clone()].to_owned();
                return Some((XmlPlace::Value { element, attribute }, value.clone()));
            }
        }
        let word = self.attributes.iter().map(|(name, _)| name).find(|name| name.start <= at && at <= name.end);
        let word = word.cloned().unwrap_or(at..at);
        let others = self.attributes.iter().filter(|(name, _)| *name != word);
        let present = others.map(|(name, _)| text[name.clone()].to_owned()).collect();
        (!self.is_end).then_some((XmlPlace::Attribute { element, around, present }, word))
    }
}

fn word_end(bytes: &[u8], at: usize) -> usize {
    let ends = |byte: &u8| byte.is_ascii_whitespace() || b"<>/=\"'".contains(byte);
    // Whatever it is, it is not read twice.
    bytes[at..].iter().position(ends).map_or(bytes.len(), |length| at + length)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The place at the `|` of a text, without it, and the word there.
    fn at(marked: &str) -> Option<(XmlPlace, String)> {
        let at = marked.find('|').unwrap();
        let text = marked.replacen('|', "", 1);
        place(&text, at).map(|(place, word)| (place, text[word].to_owned()))
    }

    fn owned(names: &[&str]) -> Vec<String> {
        names.iter().map(|name| (*name).to_owned()).collect()
    }

    #[test]
    fn elements_know_those_around_them() {
        let element =
            |around: &[&str], word: &str| Some((XmlPlace::Element { around: owned(around) }, word.to_owned()));
        assert_eq!(at("<|"), element(&[], ""));
        assert_eq!(at("<a><b x='1'/><c>\n<!-- <d> --></c><e|\n</a>"), element(&["a"], "e"));
        assert_eq!(at("<a><b\n<c><|"), element(&["a", "b", "c"], ""));
        let content = |around: &[&str]| Some((XmlPlace::Content { around: owned(around) }, String::new()));
        assert_eq!(at("<a><b></b>|"), content(&["a"]));
        assert_eq!(at("<a><b></a>|"), content(&[]));
        assert_eq!(at("<!-- |"), None);
        assert_eq!(at("<a></|"), None);
    }

    #[test]
    fn attributes_know_their_element_and_its_other_attributes() {
        let (element, around) = ("b".to_owned(), owned(&["a"]));
        let present = owned(&["x"]);
        let place = XmlPlace::Attribute { element: element.clone(), around, present };
        assert_eq!(at("<a><b x='1' |/>"), Some((place.clone(), String::new())));
        assert_eq!(at("<a><b x='1' na|\n<c/>"), Some((place, "na".to_owned())));
        let value = XmlPlace::Value { element, attribute: "x".to_owned() };
        assert_eq!(at("<b x='1|2'/>"), Some((value.clone(), "12".to_owned())));
        assert_eq!(at("<b x=\"|\n<c/>"), Some((value.clone(), String::new())));
        assert_eq!(at("<b x = \"|\"/>"), Some((value, String::new())));
    }

    #[test]
    fn every_place_of_a_broken_text_has_an_answer_without_a_panic() {
        let text = "<?x?><a ü='ä'><![CDATA[]]>< b=\"<//>=</ä><!-- 𝄞 --><c d/e='\n<x></a";
        for at in (0..=text.len()).filter(|at| text.is_char_boundary(*at)) {
            for end in (at..=text.len()).filter(|end| text.is_char_boundary(*end)) {
                if let Some((_, word)) = place(&text[..end], at) {
                    assert!(text[..end].get(word).is_some());
                }
            }
        }
    }
}
