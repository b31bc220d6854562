//! Checks that the file consists of SCXML's elements and attributes, each where it is allowed.

use diagnostics::{Problem, did_you_mean, nearest_or_all};
use roxmltree::Node;

use super::rules::{EXCLUSIVE, RULES, Rule};
use super::xml::{Element, NAMESPACE, Written, is_scxml, name_span};

/// The maximum nesting of elements.
const MAX_DEPTH: usize = 64;

/// The problem of elements that are nested too deeply to be read.
pub(super) fn depth(document: &roxmltree::Document<'_>) -> Option<Problem> {
    let mut deepest = vec![0_usize; document.descendants().count()];
    for node in document.descendants().filter(Node::is_element) {
        let depth = node.parent().map_or(0, |parent| deepest[parent.id().get_usize()] + 1);
        if depth > MAX_DEPTH {
            let problem = Problem::new(format!("elements may be nested at most {MAX_DEPTH} deep"));
            return Some(problem.at(diagnostics::xml::name_span(node), "one too many"));
        }
        deepest[node.id().get_usize()] = depth;
    }
    None
}

/// Whether an element is a machine, even if it has problems.
pub(super) fn is_machine(root: &Node<'_, '_>) -> bool {
    is_scxml(root) && root.tag_name().name() == "scxml"
}

/// Reports everything that violates the structure of SCXML, from the root downwards.
pub(super) fn structure(root: Element<'_>, problems: &mut Vec<Problem>) {
    if !is_machine(&root) {
        let help = format!("a machine begins with <scxml xmlns=\"{NAMESPACE}\" version=\"1.0\">");
        problems.push(
            Problem::new("this is not an SCXML machine").at(name_span(root), "the first element").with_help(help),
        );
        return;
    }
    match Written::attribute(root, "version") {
        Some(version) if version.value != "1.0" => {
            let problem = Problem::new(format!("version {} of SCXML is not supported", version.value));
            problems.push(problem.at(version.span(), "unknown version").with_help("version=\"1.0\""));
        }
        Some(_) => {}
        None => {
            let problem = Problem::new("the machine does not state its version").as_warning();
            problems.push(problem.at(name_span(root), "here").with_help("version=\"1.0\""));
        }
    }
    if let Some(rule) = Rule::of("scxml") {
        element(root, rule, problems);
    }
}

fn element(node: Element<'_>, rule: &Rule, problems: &mut Vec<Problem>) {
    attributes(node, rule, problems);
    for child in node.children() {
        if child.is_element() {
            inside(node.beside(child), rule, problems);
        } else if !rule.text && child.is_text() && child.text().is_some_and(|text| !text.trim().is_empty()) {
            let message = format!("text is not allowed in <{}>", rule.element);
            let span = Written::text(node).map_or_else(|| node.written(child.range()), |text| text.span());
            problems.push(Problem::new(message).at(span, "this text").with_help("<!-- a comment --> perhaps?"));
        }
    }
}

fn inside(node: Element<'_>, parent: &Rule, problems: &mut Vec<Problem>) {
    let name = node.tag_name().name();
    if ["data", "assign", "content"].contains(&parent.element) {
        let invokes =
            node.parent().and_then(|content| content.parent()).is_some_and(|node| node.tag_name().name() == "invoke");
        if parent.element == "content" && invokes && is_scxml(&node) {
            structure(node, problems);
        }
        // Elsewhere XML is a value.
        return;
    }
    if !is_scxml(&node) {
        // It has a purpose elsewhere (SCXML 4.10), as the layout that editors save with a machine, unless it is called
        // like one of SCXML.
        if Rule::of(name).is_some() {
            let problem = Problem::new(format!("<{name}> is not an SCXML element and is ignored")).as_warning();
            problems.push(problem.at(name_span(node), "of another namespace"));
        }
        return;
    }
    let Some(rule) = Rule::of(name) else {
        let known: Vec<&str> = RULES.iter().map(|rule| rule.element).collect();
        let near = did_you_mean(name, parent.contents()).or_else(|| did_you_mean(name, known));
        let problem = Problem::new(format!("SCXML has no element <{name}>"));
        problems
            .push(problem.at(name_span(node), "unknown element").with_help(near.unwrap_or_else(|| contents(parent))));
        return;
    };
    if !parent.may_contain(name) {
        let problem = Problem::new(format!("<{name}> is not allowed in <{}>", parent.element));
        problems.push(problem.at(name_span(node), "not here").with_help(contents(parent)));
    }
    element(node, rule, problems);
}

fn contents(rule: &Rule) -> String {
    match rule.contents().as_slice() {
        [] => format!("<{}> contains no elements", rule.element),
        names => format!("<{}> may contain <{}>", rule.element, names.join(">, <")),
    }
}

fn attributes(node: Element<'_>, rule: &Rule, problems: &mut Vec<Problem>) {
    for attribute in node.attributes().filter(|attribute| attribute.namespace().is_none()) {
        let name = attribute.name();
        if rule.required.contains(&name) || rule.optional.contains(&name) {
            continue;
        }
        let problem = Problem::new(format!("<{}> has no attribute `{name}`", rule.element));
        let problem = problem.at(node.written(attribute.range_qname()), "unknown attribute");
        problems.push(problem.with_help(nearest_or_all(name, "its attributes", &rule.attributes())));
    }
    for name in rule.required {
        if Written::attribute(node, name).is_none() {
            let problem = Problem::new(format!("<{}> needs the attribute `{name}`", rule.element));
            problems.push(problem.at(name_span(node), format!("`{name}` is missing")));
        }
    }
    for (_, [one, other]) in EXCLUSIVE.iter().filter(|(element, _)| *element == rule.element) {
        if let (Some(one_at), Some(other_at)) = (Written::attribute(node, one), Written::attribute(node, other)) {
            let problem = Problem::new(format!("`{one}` and `{other}` cannot be combined"));
            problems.push(problem.at(one_at.span(), "either this").at(other_at.span(), "or this"));
        }
    }
}
