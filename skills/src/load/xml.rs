//! Elements and attributes with their positions in the file.

use std::ops::{Deref, Range};

use roxmltree::Node;

/// Maps ranges of the text that is read to the text that its author wrote, from which it may have been translated.
pub(crate) type RangeMap<'p> = &'p dyn Fn(Range<usize>) -> Range<usize>;

/// The map of a text that its author wrote.
pub(crate) const AS_READ: RangeMap<'static> = &|range| range;

pub(super) const NAMESPACE: &str = "http://www.w3.org/2005/07/scxml";

/// The namespace of the attribute `chance` of transitions, which is not part of SCXML.
pub(super) const CHANCE_NAMESPACE: &str = "urn:steward:chance";

/// An element of the text that is read. All ranges that become part of a chart or of a problem come from here or from
/// [`Written`], and are ranges of the text that its author wrote.
#[derive(Clone, Copy)]
pub(crate) struct Element<'a> {
    node: Node<'a, 'a>,
    map: RangeMap<'a>,
}

impl<'a> Element<'a> {
    pub(crate) fn new(node: Node<'a, 'a>, map: RangeMap<'a>) -> Self {
        Self { node, map }
    }

    /// An element of the same text.
    pub(super) fn beside(self, node: Node<'a, 'a>) -> Self {
        Self { node, ..self }
    }

    /// The range that its author wrote for a range of the text that is read.
    pub(super) fn written(self, range: Range<usize>) -> Range<usize> {
        (self.map)(range)
    }
}

impl<'a> Deref for Element<'a> {
    type Target = Node<'a, 'a>;

    fn deref(&self) -> &Self::Target {
        &self.node
    }
}

/// The range of an element's name in its start tag, including its prefix.
pub(crate) fn name_span(element: Element<'_>) -> Range<usize> {
    element.written(diagnostics::xml::name_span(element.node))
}

pub(super) fn is_scxml(node: &Node<'_, '_>) -> bool {
    node.is_element() && node.tag_name().namespace() == Some(NAMESPACE)
}

/// The child elements in SCXML's namespace.
pub(super) fn elements(element: Element<'_>) -> impl Iterator<Item = Element<'_>> {
    element.children().filter(is_scxml).map(move |child| element.beside(child))
}

/// The child elements in SCXML's namespace with this name.
pub(super) fn elements_named<'a>(element: Element<'a>, name: &'static str) -> impl Iterator<Item = Element<'a>> {
    elements(element).filter(move |child| child.tag_name().name() == name)
}

/// The elements of a machine, including itself, without those of machines inside it and of XML data.
pub(crate) fn own_elements(root: Element<'_>) -> Vec<Element<'_>> {
    let mut found = Vec::new();
    let mut open = vec![root];
    while let Some(element) = open.pop() {
        found.push(element);
        if !["content", "data", "assign"].contains(&element.tag_name().name()) {
            open.extend(elements(element).collect::<Vec<_>>().into_iter().rev());
        }
    }
    found
}

/// A piece of text in the file: an attribute's value, or the text between two tags.
#[derive(Clone)]
pub(crate) struct Written<'a> {
    /// The text with entities resolved: `&gt;` is `>`.
    pub(crate) value: &'a str,
    /// The text as it is read.
    raw: &'a str,
    start: usize,
    map: RangeMap<'a>,
}

impl<'a> Written<'a> {
    pub(crate) fn attribute(element: Element<'a>, name: &str) -> Option<Self> {
        let attribute =
            element.attributes().find(|attribute| attribute.namespace().is_none() && attribute.name() == name)?;
        Some(Self::within(element, attribute.value(), attribute.range_value()))
    }

    /// The text between an element's tags, unless it is only white space.
    pub(crate) fn text(element: Element<'a>) -> Option<Self> {
        let text = element
            .children()
            .find(|child| child.is_text() && child.text().is_some_and(|text| !text.trim().is_empty()))?;
        Some(Self::within(element, text.text()?, text.range()))
    }

    fn within(element: Element<'a>, value: &'a str, range: Range<usize>) -> Self {
        let raw = element.document().input_text().get(range.clone()).unwrap_or_default();
        let inside = raw.strip_prefix("<![CDATA[").unwrap_or(raw);
        Self { value, raw: inside, start: range.start + raw.len() - inside.len(), map: element.map }
    }

    /// The position of the whole text.
    pub(crate) fn span(&self) -> Range<usize> {
        (self.map)(self.start..self.start + self.raw.len())
    }

    /// The position of a part of the value, given in bytes of the value.
    pub(crate) fn span_of(&self, part: Range<usize>) -> Range<usize> {
        let mut walk = self.walk();
        (self.map)(walk.advance(part.start)..walk.advance(part.len()))
    }

    fn walk(&self) -> Walk<'a> {
        Walk { value: self.value, raw: self.raw, place: self.start }
    }

    /// Replaces the text with that of a file that the attribute names; its problems are reported here.
    pub(crate) fn whole<'t>(&self, text: &'t str) -> Written<'t>
    where
        'a: 't,
    {
        Written { value: text, raw: "", ..*self }
    }

    /// The words of the value, each as a separate piece.
    pub(crate) fn words(&self) -> Vec<Self> {
        let (base, mut walk, mut end) = (self.value.as_ptr() as usize, self.walk(), 0);
        let piece = |word: &'a str| {
            let start = word.as_ptr() as usize - base;
            let begins = walk.advance(start - end);
            end = start + word.len();
            let ends = walk.advance(word.len());
            let raw = self.raw.get(begins - self.start..ends - self.start).unwrap_or_default();
            Self { value: word, raw, start: begins, map: self.map }
        };
        self.value.split_whitespace().map(piece).collect()
    }
}

/// A parallel walk through the value and the text in the file, in which an entity is longer than the character that it
/// represents.
struct Walk<'a> {
    /// The rest of both.
    value: &'a str,
    raw: &'a str,
    place: usize,
}

impl Walk<'_> {
    /// Advances by this many bytes of the value. Returns the position in the file.
    fn advance(&mut self, mut bytes: usize) -> usize {
        while bytes > 0
            && let Some(letter) = self.value.chars().next()
        {
            bytes = bytes.saturating_sub(letter.len_utf8());
            self.value = &self.value[letter.len_utf8()..];
            let length = match self.raw.chars().next() {
                Some('&') => self.raw.find(';').map_or(1, |end| end + 1),
                Some('\r') if self.raw[1..].starts_with('\n') => 2,
                Some(written) => written.len_utf8(),
                None => break,
            };
            self.raw = &self.raw[length..];
            self.place += length;
        }
        self.place
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_inside_an_attribute_account_for_entities() {
        let text = "<a b='x &gt; y\r\n&#38;&amp; zz'/>";
        let document = roxmltree::Document::parse(text).unwrap();
        let written = Written::attribute(Element::new(document.root_element(), AS_READ), "b").unwrap();
        assert_eq!(written.value, "x > y && zz");
        assert_eq!(&text[written.span_of(4..5)], "y");
        assert_eq!(&text[written.span_of(2..3)], "&gt;");
        assert_eq!(&text[written.span_of(9..11)], "zz");
        assert_eq!(written.words().last().map(|word| (word.value, &text[word.span()])), Some(("zz", "zz")));
    }
}
