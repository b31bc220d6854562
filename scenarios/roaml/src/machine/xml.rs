//! XML, with places.

use std::ops::Range;

use diagnostics::Problem;
use roxmltree::{Document, Node, ParsingOptions};

use super::vocabulary;

pub(crate) fn parse(text: &str) -> Result<Document<'_>, Problem> {
    diagnostics::xml::check_attributes(text, 1000)?;
    let options = ParsingOptions { allow_dtd: false, nodes_limit: 100_000, ..ParsingOptions::default() };
    Document::parse_with_options(text, options).map_err(|error| {
        diagnostics::xml::problem(text, &error, |name| vocabulary::elements().any(|known| known == name))
    })
}

/// Whether a node is an element with this name, in any namespace: models are careless about namespaces.
pub(crate) fn is(node: &Node<'_, '_>, name: &str) -> bool {
    node.is_element() && node.tag_name().name() == name
}

/// The range of an attribute's value, or of the element's name.
pub(crate) fn value_span(node: Node<'_, '_>, attribute: &str) -> Range<usize> {
    node.attribute_node(attribute).map_or_else(|| diagnostics::xml::name_span(node), |found| found.range_value())
}
