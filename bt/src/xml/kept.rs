//! Parts of files that have no meaning here, but are kept so that they can be written back.

use std::collections::BTreeMap;

use roxmltree::{Attribute, Document, Node as Element};

use crate::library::Kept;

/// An attribute's name as written, with its prefix.
pub(super) fn written_name<'a>(element: Element<'a, '_>, attribute: &Attribute<'_, '_>) -> &'a str {
    element.document().input_text().get(attribute.range_qname()).unwrap_or_default()
}

/// The attributes of an element except the known ones.
pub(super) fn other_attributes(element: Element<'_, '_>, known: &[&str]) -> Kept {
    let all = element.attributes().map(|attribute| (written_name(element, &attribute).to_owned(), attribute.value()));
    let others = all.filter(|(name, _)| !known.contains(&name.as_str()));
    others.map(|(name, value)| (name, value.to_owned())).collect()
}

/// An element with its contents, unchanged.
pub(super) fn verbatim(element: Element<'_, '_>) -> String {
    element.document().input_text().get(element.range()).unwrap_or_default().to_owned()
}

/// The namespaces that documents declare, as attributes.
pub(super) fn namespaces<'a, 'i: 'a>(documents: impl Iterator<Item = &'a Document<'i>>) -> Kept {
    let mut declared = BTreeMap::new();
    let documents = documents.filter(|document| document.input_text().contains("xmlns"));
    for element in documents.flat_map(Document::descendants).filter(Element::is_element) {
        let inherited = element.parent_element().map_or(0, |parent| parent.namespaces().len());
        let own = element.namespaces().filter(|_| element.namespaces().len() > inherited);
        for namespace in own {
            let name = namespace.name().map_or("xmlns".to_owned(), |prefix| format!("xmlns:{prefix}"));
            declared.entry(name).or_insert_with(|| namespace.uri().to_owned());
        }
    }
    declared.into_iter().collect()
}
