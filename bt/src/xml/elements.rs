//! Elements and attributes: their positions and their limits.

use diagnostics::Problem;
use miette::SourceSpan;

use super::problems::Problems;

/// The position of an attribute's value, without its quotes.
pub(super) fn value_span(element: roxmltree::Node<'_, '_>, attribute: &str) -> Option<SourceSpan> {
    element.attribute_node(attribute).map(|attribute| span(attribute.range_value()))
}

pub(super) fn required_id(element: roxmltree::Node<'_, '_>, meaning: &str, problems: &mut Problems) -> Option<String> {
    match element.attribute("ID").map(str::trim) {
        Some(id) if !id.is_empty() => Some(id.to_owned()),
        _ => {
            let problem = Problem::new(format!("<{}> has no ID", element.tag_name().name()));
            let problem = problem.at(tag_span(element), "needs ID=\"…\"");
            problems.push(problem.with_help(format!("the ID determines {meaning}")));
            None
        }
    }
}

/// The position of an element's start tag, up to its last attribute.
pub(super) fn tag_span(element: roxmltree::Node<'_, '_>) -> SourceSpan {
    let start = element.range().start;
    let name_end = start + 1 + element.tag_name().name().len();
    let end = element.attributes().map(|attribute| attribute.range().end).max().unwrap_or(name_end);
    span(start..end.max(name_end))
}

pub(super) fn span(range: std::ops::Range<usize>) -> SourceSpan {
    (range.start, range.len()).into()
}

/// The maximum number of attributes of an element, and of ports of a node.
pub(super) const MAX_ATTRIBUTES: usize = 1000;

pub(super) const MAX_PORTS: usize = MAX_ATTRIBUTES;
