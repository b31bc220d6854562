//! Literal values (SCXML B.2.1).

use std::ops::Range;

use super::xml::{Element, Written, name_span};
use crate::Datum;
use crate::datum::standalone;
use crate::expression;

/// A value between two tags (SCXML B.2.1): XML, JSON, or else text with white space collapsed.
pub(super) struct InlineContent {
    pub(super) value: Datum,
    pub(super) span: Range<usize>,
}

impl InlineContent {
    /// The content of an element; `None` if it is empty.
    pub(super) fn of(node: Element<'_>) -> Option<Self> {
        if let Some(element) = node.children().find(|child| child.is_element()) {
            let span = name_span(node.beside(element));
            return Some(Self { value: Datum::Xml(standalone(node.children()).into()), span });
        }
        Written::text(node).map(|text| Self { value: literal(text.value), span: text.span() })
    }
}

fn literal(text: &str) -> Datum {
    expression::literal(text).unwrap_or_else(|| {
        let words: Vec<&str> = text.split_whitespace().collect();
        Datum::text(&words.join(" "))
    })
}

pub(super) fn content_of_file(text: &str) -> Datum {
    let text = text.trim_start_matches('\u{feff}').trim();
    if text.starts_with('<')
        && let Ok(document) = roxmltree::Document::parse(text)
    {
        return Datum::Xml(standalone(std::iter::once(document.root_element())).into());
    }
    literal(text)
}
