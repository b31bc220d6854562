//! XML as data: stand-alone text.

use diagnostics::markup;
use roxmltree::Node;

/// Elements, and the text between them, as text in which every element declares its namespace if it differs from its
/// parent's.
pub(crate) fn standalone<'a, 'i: 'a>(nodes: impl Iterator<Item = Node<'a, 'i>>) -> String {
    let mut text = String::new();
    nodes.for_each(|node| write_node(node, None, &mut text));
    text.trim().to_owned()
}

fn write_node(node: Node<'_, '_>, namespace: Option<&str>, text: &mut String) {
    if node.is_text() {
        text.push_str(&markup::text(node.text().unwrap_or_default()));
    }
    if !node.is_element() {
        return;
    }
    let own = node.tag_name().namespace().filter(|namespace| !namespace.is_empty());
    let name = node.tag_name().name();
    *text += &format!("<{name}");
    if own != namespace {
        *text += &format!(" xmlns=\"{}\"", markup::attribute(own.unwrap_or_default()));
    }
    for attribute in node.attributes() {
        *text += &format!(" {}=\"{}\"", attribute.name(), markup::attribute(attribute.value()));
    }
    if node.has_children() {
        text.push('>');
        node.children().for_each(|child| write_node(child, own, text));
        *text += &format!("</{name}>");
    } else {
        text.push_str("/>");
    }
}

/// XML as an object: `name`, `namespace`, `attributes` by name, `children` and the `source`. Text is a string. Several
/// elements are the children of a nameless one.
#[cfg(feature = "ecmascript")]
pub(crate) fn describe_xml(source: &str) -> Result<crate::Datum, crate::TooLarge> {
    use crate::Datum;

    fn describe(node: Node<'_, '_>, source: &str) -> Result<Datum, crate::TooLarge> {
        let attributes = node.attributes().map(|attribute| (attribute.name(), Datum::text(attribute.value())));
        let children: Vec<Datum> = node
            .children()
            .filter_map(|child| match child.text() {
                Some(text) if child.is_text() => Some(Ok(Datum::text(text))),
                _ if child.is_element() => Some(describe(child, &standalone(std::iter::once(child)))),
                _ => None,
            })
            .collect::<Result<_, _>>()?;
        Datum::object([
            ("name", Datum::text(node.tag_name().name())),
            ("namespace", node.tag_name().namespace().map_or(Datum::Null, Datum::text)),
            ("attributes", Datum::object(attributes)?),
            ("children", Datum::array(children)?),
            ("source", Datum::text(source)),
        ])
    }

    // XML has one root; a datum may have several elements, and text beside them.
    let wrapped = format!("<_>{source}</_>");
    let Ok(document) = roxmltree::Document::parse(&wrapped) else {
        return Ok(Datum::Null);
    };
    let root = document.root_element();
    let mut elements = root.children().filter(Node::is_element);
    match (elements.next(), elements.next()) {
        (Some(only), None) => describe(only, source),
        _ => describe(root, source),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_keep_their_namespaces() {
        let text = "<a xmlns='urn:a' xmlns:b='urn:b'><b:c d='&lt;'>1 &amp; 2<e/></b:c></a>";
        let document = roxmltree::Document::parse(text).unwrap();
        let alone = standalone(document.root_element().children());
        assert_eq!(alone, r#"<c xmlns="urn:b" d="&lt;">1 &amp; 2<e xmlns="urn:a"/></c>"#);
        assert!(roxmltree::Document::parse(&alone).is_ok());
    }
}
