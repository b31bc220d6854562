//! Where a cursor is in an XML file, complete or not.

use std::ops::Range;

/// An element's name and attributes, as far as they are written.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Tag {
    pub(crate) name: String,
    pub(crate) attributes: Vec<(String, String)>,
}

impl Tag {
    /// The value of an attribute, as written.
    pub(crate) fn get(&self, attribute: &str) -> Option<&str> {
        self.attributes.iter().find(|(name, _)| name == attribute).map(|(_, value)| value.as_str())
    }
}

/// What the text at a cursor is, or will be.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum XmlPlace {
    /// The name of an element, after its `<`.
    Element,
    /// The name of an attribute of this element, whose others it has already.
    Attribute(Tag),
    /// The value of an attribute of this element.
    Value(Tag, String),
    /// Between elements.
    Content,
}

/// A place in an XML file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct XmlCursor {
    pub(crate) place: XmlPlace,
    /// The elements around it, the outermost first.
    pub(crate) around: Vec<Tag>,
    /// The name or the value there.
    pub(crate) word: Range<usize>,
}

/// What begins with a `<`.
enum Piece {
    Tag(WrittenTag),
    /// A comment or something else without tags. It has no end if the text ends first.
    Other(Option<usize>),
}

impl Piece {
    /// The first one at or after a byte, with its beginning.
    fn after(text: &str, byte: usize) -> Option<(usize, Self)> {
        let open = byte + text[byte..].find('<')?;
        let rest = &text[open..];
        let kinds = [("<!--", "-->"), ("<![CDATA[", "]]>"), ("<?", "?>"), ("<!", ">")];
        let piece = match kinds.into_iter().find(|(begin, _)| rest.starts_with(begin)) {
            Some((begin, end)) => {
                let length = rest[begin.len()..].find(end);
                Self::Other(length.map(|length| open + begin.len() + length + end.len()))
            }
            None => Self::Tag(WrittenTag::read(text, open)),
        };
        Some((open, piece))
    }

    fn end(&self) -> Option<usize> {
        match self {
            Self::Tag(tag) => Some(tag.end),
            Self::Other(end) => *end,
        }
    }
}

/// The place at a cursor. Nothing in comments and outside of what XML has.
pub(crate) fn place(text: &str, at: usize) -> Option<XmlCursor> {
    let mut around: Vec<Tag> = Vec::new();
    let mut next = 0;
    while let Some((_, piece)) = Piece::after(text, next).filter(|(open, _)| *open < at) {
        next = piece.end()?;
        let Piece::Tag(tag) = piece else {
            if at < next {
                return None;
            }
            continue;
        };
        if at <= tag.end && !(tag.is_closed && at == tag.end) {
            return tag.cursor(text, at, around);
        }
        if tag.is_end {
            if let Some(place) = around.iter().rposition(|open| open.name == text[tag.name.clone()]) {
                around.truncate(place);
            }
        } else if !tag.is_empty {
            around.push(tag.content(text));
        }
    }
    Some(XmlCursor { place: XmlPlace::Content, around, word: at..at })
}

/// All elements of a text, as far as they are written.
pub(crate) fn elements(text: &str) -> impl Iterator<Item = Tag> {
    let pieces = std::iter::successors(Piece::after(text, 0), |(_, piece)| Piece::after(text, piece.end()?));
    pieces.filter_map(|(_, piece)| match piece {
        Piece::Tag(tag) if !tag.is_end => Some(tag.content(text)),
        _ => None,
    })
}

/// The elements inside the one in whose start tag a byte is.
pub(crate) fn inside(text: &str, at: usize) -> impl Iterator<Item = Tag> {
    let inside = up_to_end(text, at).filter_map(|(tag, depth)| (depth.is_some() && !tag.is_end).then_some(tag));
    inside.map(|tag| tag.content(text))
}

/// The name in the end tag of the element in whose start tag a byte is.
pub(crate) fn end_name(text: &str, at: usize) -> Option<Range<usize>> {
    up_to_end(text, at).find_map(|(tag, depth)| depth.is_none().then_some(tag.name))
}

/// The tags behind a start tag in which a byte is, each with the number of open elements inside it; none at its end.
fn up_to_end(text: &str, at: usize) -> impl Iterator<Item = (WrittenTag, Option<usize>)> {
    let mut depth = Some(0_usize);
    let pieces = std::iter::successors(Piece::after(text, at), |(_, piece)| Piece::after(text, piece.end()?));
    let tags = pieces.filter_map(|(_, piece)| if let Piece::Tag(tag) = piece { Some(tag) } else { None });
    tags.map_while(move |tag| {
        let before = depth?;
        depth = if tag.is_end { before.checked_sub(1) } else { Some(before + usize::from(!tag.is_empty)) };
        Some((tag, depth))
    })
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

    fn content(&self, text: &str) -> Tag {
        let attribute = |(name, value): &(Range<usize>, Option<Range<usize>>)| {
            (text[name.clone()].to_owned(), value.clone().map_or_else(String::new, |value| text[value].to_owned()))
        };
        Tag { name: text[self.name.clone()].to_owned(), attributes: self.attributes.iter().map(attribute).collect() }
    }

    fn cursor(&self, text: &str, at: usize, around: Vec<Tag>) -> Option<XmlCursor> {
        if at <= self.name.end {
            // An end tag closes the element in which it is.
            let word = self.name.start..self.name.end;
            let place = XmlPlace::Element;
            return (!self.is_end && at >= self.name.start).then_some(XmlCursor { place, around, word });
        }
        let mut tag = self.content(text);
        for (name, value) in &self.attributes {
            if let Some(value) = value.as_ref().filter(|value| value.start <= at && at <= value.end) {
                let place = XmlPlace::Value(tag, text[name.clone()].to_owned());
                return Some(XmlCursor { place, around, word: value.clone() });
            }
        }
        let here = self.attributes.iter().position(|(name, _)| name.start <= at && at <= name.end);
        let word = here.map_or(at..at, |here| self.attributes[here].0.clone());
        if let Some(here) = here {
            tag.attributes.remove(here);
        }
        (!self.is_end).then_some(XmlCursor { place: XmlPlace::Attribute(tag), around, word })
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

    /// The place at the `|` of a text, the elements around it, and the word there.
    fn at(marked: &str) -> Option<(XmlPlace, Vec<String>, String)> {
        let at = marked.find('|').unwrap();
        let text = marked.replacen('|', "", 1);
        let XmlCursor { place, around, word } = place(&text, at)?;
        Some((place, around.into_iter().map(|tag| tag.name).collect(), text[word].to_owned()))
    }

    fn owned(names: &[&str]) -> Vec<String> {
        names.iter().map(|name| (*name).to_owned()).collect()
    }

    #[test]
    fn elements_know_those_around_them() {
        let element = |around: &[&str], word: &str| Some((XmlPlace::Element, owned(around), word.to_owned()));
        assert_eq!(at("<|"), element(&[], ""));
        assert_eq!(at("<a><b x='1'/><c>\n<!-- <d> --></c><e|\n</a>"), element(&["a"], "e"));
        assert_eq!(at("<a><b\n<c><|"), element(&["a", "b", "c"], ""));
        let content = |around: &[&str]| Some((XmlPlace::Content, owned(around), String::new()));
        assert_eq!(at("<a><b></b>|"), content(&["a"]));
        assert_eq!(at("<a><b></a>|"), content(&[]));
        assert_eq!(at("<!-- |"), None);
        assert_eq!(at("<a></|"), None);
    }

    #[test]
    fn attributes_know_their_element_and_its_other_attributes() {
        let tag = |attributes: &[(&str, &str)]| Tag {
            name: "b".to_owned(),
            attributes: attributes.iter().map(|(name, value)| ((*name).to_owned(), (*value).to_owned())).collect(),
        };
        let with = |word: &str| Some((XmlPlace::Attribute(tag(&[("x", "1")])), owned(&["a"]), word.to_owned()));
        assert_eq!(at("<a><b x='1' |/>"), with(""));
        assert_eq!(at("<a><b x='1' na|\n<c/>"), with("na"));
        let value = |of: &str| Some((XmlPlace::Value(tag(&[("x", of)]), "x".to_owned()), owned(&[]), of.to_owned()));
        assert_eq!(at("<b x='1|2'/>"), value("12"));
        assert_eq!(at("<b x=\"|\n<c/>"), value(""));
        assert_eq!(at("<b x = \"|\"/>"), value(""));
    }

    #[test]
    fn elements_are_those_outside_comments() {
        let names: Vec<String> = elements("<a><!-- <b/> --><c x='1'></c></a><d").map(|tag| tag.name).collect();
        assert_eq!(names, ["a", "c", "d"]);
        assert_eq!(elements("<a x='1' y/>").next().unwrap().get("x"), Some("1"));
    }

    #[test]
    fn elements_inside_another_are_those_before_its_end() {
        let names = |text| inside(text, 2).map(|tag| tag.name).collect::<Vec<_>>();
        assert_eq!(names("<a ><b><c/></b><d></d></a><e/>"), ["b", "c", "d"]);
        assert_eq!(names("<a ><b><c"), ["b", "c"]);
        assert_eq!(names("<a >"), [""; 0]);
        assert_eq!(end_name("<a ><b><c/></b></d><e/></a>", 2), Some(17..18));
        assert_eq!(end_name("<a ><b></b>", 2), None);
    }

    #[test]
    fn every_place_of_a_broken_text_has_an_answer_without_a_panic() {
        let text = "<?x?><a ü='ä'><![CDATA[]]>< b=\"<//>=</ä><!-- 𝄞 --><c d/e='\n<x></a";
        for at in (0..=text.len()).filter(|at| text.is_char_boundary(*at)) {
            for end in (at..=text.len()).filter(|end| text.is_char_boundary(*end)) {
                if let Some(XmlCursor { word, .. }) = place(&text[..end], at) {
                    assert!(text[..end].get(word).is_some());
                }
            }
        }
    }
}
