//! Elements and attributes with their places in the file.

use std::ops::Range;

use roxmltree::Node;

/// The namespace of SCXML.
pub(super) const NAMESPACE: &str = "http://www.w3.org/2005/07/scxml";

/// Whether the node is an element of SCXML.
pub(super) fn is_scxml(node: &Node<'_, '_>) -> bool {
    node.is_element() && node.tag_name().namespace() == Some(NAMESPACE)
}

/// The SCXML elements directly inside.
pub(super) fn elements<'a, 'i: 'a>(node: Node<'a, 'i>) -> impl Iterator<Item = Node<'a, 'i>> {
    node.children().filter(is_scxml)
}

/// The SCXML elements of that name directly inside.
pub(super) fn elements_named<'a, 'i: 'a>(node: Node<'a, 'i>, name: &'static str) -> impl Iterator<Item = Node<'a, 'i>> {
    elements(node).filter(move |child| child.tag_name().name() == name)
}

/// The elements of a machine, itself included, without those of machines inside of it and of XML that is data.
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

/// Where an element's name stands.
pub(crate) fn name_span(node: Node<'_, '_>) -> Range<usize> {
    let start = (node.range().start + 1).min(node.range().end);
    let written = node.document().input_text().get(start..).unwrap_or_default();
    let length = written.find(|c: char| c.is_whitespace() || c == '/' || c == '>').unwrap_or(written.len());
    start..start + length
}

/// A piece of text out of the file: an attribute's value, or what stands between two tags.
#[derive(Clone, Debug)]
pub(crate) struct Written<'a> {
    /// The text without the XML around it: `&gt;` is `>`.
    pub(crate) value: &'a str,
    /// As it stands in the file.
    raw: &'a str,
    start: usize,
}

impl<'a> Written<'a> {
    /// The attribute of that name.
    pub(crate) fn attribute(node: Node<'a, '_>, name: &str) -> Option<Self> {
        let attribute =
            node.attributes().find(|attribute| attribute.namespace().is_none() && attribute.name() == name)?;
        Some(Self::within(node, attribute.value(), attribute.range_value()))
    }

    /// The text between an element's tags, if there is any but white space.
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

    /// Where the whole text stands.
    pub(crate) fn span(&self) -> Range<usize> {
        self.start..self.start + self.raw.len()
    }

    /// Where a part of the value stands, given in bytes of the value.
    pub(crate) fn span_of(&self, part: Range<usize>) -> Range<usize> {
        self.offset_of(part.start)..self.offset_of(part.end)
    }

    /// Where a byte of the value stands in the file: an entity takes more room there than the letter it stands for.
    fn offset_of(&self, value_offset: usize) -> usize {
        let mut value_rest = value_offset;
        let mut raw = self.raw;
        let mut letters = self.value.chars();
        while value_rest > 0
            && let Some(letter) = letters.next()
        {
            value_rest = value_rest.saturating_sub(letter.len_utf8());
            let length = match raw.chars().next() {
                Some('&') => raw.find(';').map_or(1, |end| end + 1),
                Some('\r') if raw[1..].starts_with('\n') => 2,
                Some(written) => written.len_utf8(),
                None => break,
            };
            raw = &raw[length..];
        }
        self.start + self.raw.len() - raw.len()
    }

    /// Another text in the place of this one: it stands in a file that the attribute names, and what is wrong with it is
    /// reported here.
    pub(crate) fn whole<'t>(&self, text: &'t str) -> Written<'t> {
        Written { value: text, raw: "", start: self.start }
    }

    /// A word of the value as a piece of its own.
    pub(crate) fn part(&self, word: &'a str, span: Range<usize>) -> Self {
        let raw = self.raw.get(span.start - self.start..span.end - self.start).unwrap_or_default();
        Self { value: word, raw, start: span.start }
    }

    /// The words of the value, each with its place in the file.
    pub(crate) fn words(&self) -> Vec<(&'a str, Range<usize>)> {
        let base = self.value.as_ptr() as usize;
        let place = |word: &'a str| {
            let start = word.as_ptr() as usize - base;
            (word, self.span_of(start..start + word.len()))
        };
        self.value.split_whitespace().map(place).collect()
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
