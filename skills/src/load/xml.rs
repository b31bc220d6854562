//! Elements and attributes with their positions in the file.

use std::ops::Range;

use roxmltree::Node;

pub(crate) use diagnostics::xml::name_span;

/// The namespace of SCXML.
pub(super) const NAMESPACE: &str = "http://www.w3.org/2005/07/scxml";

/// The namespace of the attribute `chance` of transitions, which is not part of SCXML.
pub(super) const CHANCE_NAMESPACE: &str = "urn:steward:chance";

/// Whether the node is an element of SCXML.
pub(super) fn is_scxml(node: &Node<'_, '_>) -> bool {
    node.is_element() && node.tag_name().namespace() == Some(NAMESPACE)
}

/// The child elements in SCXML's namespace.
pub(super) fn elements<'a, 'i: 'a>(node: Node<'a, 'i>) -> impl Iterator<Item = Node<'a, 'i>> {
    node.children().filter(is_scxml)
}

/// The child elements in SCXML's namespace with this name.
pub(super) fn elements_named<'a, 'i: 'a>(node: Node<'a, 'i>, name: &'static str) -> impl Iterator<Item = Node<'a, 'i>> {
    elements(node).filter(move |child| child.tag_name().name() == name)
}

/// The elements of a machine, including itself, without those of machines inside it and of XML data.
pub(crate) fn own_elements<'a, 'i: 'a>(root: Node<'a, 'i>) -> Vec<Node<'a, 'i>> {
    let mut found = Vec::new();
    let mut open = vec![root];
    while let Some(node) = open.pop() {
        found.push(node);
        if !["content", "data", "assign"].contains(&node.tag_name().name()) {
            open.extend(elements(node).collect::<Vec<_>>().into_iter().rev());
        }
    }
    found
}

/// A piece of text in the file: an attribute's value, or the text between two tags.
#[derive(Clone, Debug)]
pub(crate) struct Written<'a> {
    /// The text with entities resolved: `&gt;` is `>`.
    pub(crate) value: &'a str,
    /// The text as written in the file.
    raw: &'a str,
    start: usize,
}

impl<'a> Written<'a> {
    /// The attribute with this name.
    pub(crate) fn attribute(node: Node<'a, '_>, name: &str) -> Option<Self> {
        let attribute =
            node.attributes().find(|attribute| attribute.namespace().is_none() && attribute.name() == name)?;
        Some(Self::within(node, attribute.value(), attribute.range_value()))
    }

    /// The text between an element's tags, unless it is only white space.
    pub(crate) fn text(node: Node<'a, '_>) -> Option<Self> {
        let text = node
            .children()
            .find(|child| child.is_text() && child.text().is_some_and(|text| !text.trim().is_empty()))?;
        Some(Self::within(node, text.text()?, text.range()))
    }

    fn within(node: Node<'a, '_>, value: &'a str, range: Range<usize>) -> Self {
        let raw = node.document().input_text().get(range.clone());
        let (raw, start) = (raw.unwrap_or_default(), range.start);
        match raw.strip_prefix("<![CDATA[") {
            Some(inside) => Self { value, raw: inside, start: start + raw.len() - inside.len() },
            None => Self { value, raw, start },
        }
    }

    /// The position of the whole text.
    pub(crate) fn span(&self) -> Range<usize> {
        self.start..self.start + self.raw.len()
    }

    /// The position of a part of the value, given in bytes of the value.
    pub(crate) fn span_of(&self, part: Range<usize>) -> Range<usize> {
        let mut walk = self.walk();
        walk.advance(part.start)..walk.advance(part.len())
    }

    fn walk(&self) -> Walk<'a> {
        Walk { value: self.value, raw: self.raw, place: self.start }
    }

    /// Replaces the text with that of a file that the attribute names; its problems are reported here.
    pub(crate) fn whole<'t>(&self, text: &'t str) -> Written<'t> {
        Written { value: text, raw: "", start: self.start }
    }

    /// A word of the value as a separate piece.
    pub(crate) fn part(&self, word: &'a str, span: Range<usize>) -> Self {
        let raw = self.raw.get(span.start - self.start..span.end - self.start).unwrap_or_default();
        Self { value: word, raw, start: span.start }
    }

    /// The words of the value, each with its position in the file.
    pub(crate) fn words(&self) -> Vec<(&'a str, Range<usize>)> {
        let (base, mut walk, mut end) = (self.value.as_ptr() as usize, self.walk(), 0);
        let place = |word: &'a str| {
            let start = word.as_ptr() as usize - base;
            let begins = walk.advance(start - end);
            end = start + word.len();
            (word, begins..walk.advance(word.len()))
        };
        self.value.split_whitespace().map(place).collect()
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
        let written = Written::attribute(document.root_element(), "b").unwrap();
        assert_eq!(written.value, "x > y && zz");
        assert_eq!(&text[written.span_of(4..5)], "y");
        assert_eq!(&text[written.span_of(2..3)], "&gt;");
        assert_eq!(&text[written.span_of(9..11)], "zz");
        assert_eq!(written.words().last().map(|(word, span)| (*word, &text[span.clone()])), Some(("zz", "zz")));
    }
}
