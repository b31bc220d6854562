//! Files that look like SCXML but are something else: one message instead of one per element.

use std::ops::Range;

use diagnostics::Problem;
use roxmltree::Node;

use super::xml::{Element, NAMESPACE, Written, is_scxml, name_span};

/// The problem of a file in another dialect.
pub(super) fn foreign(root: Element<'_>) -> Option<Problem> {
    match root.tag_name().name() {
        "ascxml" => Some(roaml(name_span(root), "this is not <scxml>")),
        "roaml" | "convince_mc_tc" => Some(model(root)),
        "scxml" => extended(root).or_else(|| namespace(root)).or_else(|| data_model(root)),
        _ => None,
    }
}

/// A machine of RoAML.
fn roaml(place: Range<usize>, label: impl Into<String>) -> Problem {
    let problem = Problem::new("this is a machine of RoAML, AS2FM's dialect of SCXML, and runs only within its model");
    problem.at(place, label).with_help("run the model: `steward run main.xml`, with the file whose root is <roaml>")
}

/// The main file of a RoAML model.
fn model(root: Element<'_>) -> Problem {
    let problem = Problem::new("this is a whole RoAML model, not a machine").at(name_span(root), "a model");
    problem.with_help("run it with `steward run FILE`")
}

/// An `<scxml>` with RoAML's elements for ROS and for the tree, in SCXML's own namespace or a similar one.
fn extended(root: Element<'_>) -> Option<Problem> {
    let is_own = |node: &Node<'_, '_>| {
        let name = node.tag_name();
        name.namespace() == root.tag_name().namespace()
            && (name.name().starts_with("ros_") || name.name().starts_with("bt_"))
    };
    let element = root.beside(root.descendants().find(|node| node.is_element() && is_own(node))?);
    let problem = roaml(name_span(element), format!("<{}> is not an SCXML element", element.tag_name().name()));
    Some(match namespace_span(root).filter(|_| !is_scxml(&root)) {
        Some(span) => problem.at(span, "this is not the namespace of SCXML"),
        None => problem,
    })
}

/// An `<scxml>` in another namespace.
fn namespace(root: Element<'_>) -> Option<Problem> {
    if is_scxml(&root) {
        return None;
    }
    let help = format!("a machine begins with <scxml xmlns=\"{NAMESPACE}\" version=\"1.0\">");
    let message = match root.tag_name().namespace() {
        Some(other) => format!("`xmlns=\"{other}\"` is not the namespace of SCXML"),
        None => "this <scxml> has no namespace".to_owned(),
    };
    let span = namespace_span(root).unwrap_or_else(|| name_span(root));
    Some(Problem::new(message).at(span, "this is not the namespace of SCXML").with_help(help))
}

/// The position where the root declares its namespace.
fn namespace_span(root: Element<'_>) -> Option<Range<usize>> {
    let start = root.range().start;
    let tag = root.document().input_text().get(start..)?;
    let tag = tag.get(..tag.find('>')?)?;
    let name = tag.find("xmlns=")?;
    let quote = tag[name + "xmlns=".len()..].chars().next().filter(|quote| matches!(quote, '"' | '\''))?;
    let value = name + "xmlns=".len() + 1;
    let length = tag[value..].find(quote)?;
    Some(root.written(start + name..start + value + length + 1))
}

/// A machine whose expressions are C++.
fn data_model(root: Element<'_>) -> Option<Problem> {
    let written = Written::attribute(root, "datamodel")?;
    let class = written.value.strip_prefix("cplusplus:")?;
    let class = class.split(':').next().filter(|class| !class.is_empty()).unwrap_or("without a name");
    let message = "this is a Qt machine with a C++ data model: its conditions and actions are C++ and cannot run here";
    let help = "write them in ECMAScript and set datamodel=\"ecmascript\", or give the leaf another machine in the \
                scenario: [leaves.NAME] machine = \"…\"";
    Some(Problem::new(message).at(written.span(), format!("its code is the C++ class {class}")).with_help(help))
}
