//! The declarations of nodes in a file: its `<TreeNodesModel>`.

use diagnostics::Problem;
use miette::SourceSpan;
use roxmltree::Node as Element;

use super::elements::{MAX_PORTS, required_id, tag_span, value_span};
use super::kept::{other_attributes, verbatim};
use super::ports::is_port_name;
use super::problems::{Problems, port_value, too_many, wrong_category};
use super::vocabulary;
use crate::blackboard::{Type, pointed_key};
use crate::library::{Model, Models, PortModel};
use crate::{Category, Direction};

/// Reads the declarations of a file, in addition to existing ones.
pub(super) fn read_models(root: Element<'_, '_>, file: usize, models: &mut Models, problems: &mut Problems) {
    let mut elements = root.children().filter(|element| element.has_tag_name("TreeNodesModel"));
    if let Some(first) = elements.next() {
        for element in first.children().filter(Element::is_element) {
            read_model(element, file, models, problems);
        }
    }
    for element in elements {
        misplaced(element, "one <TreeNodesModel> is enough: put all declarations into the first", problems);
    }
}

fn read_model(element: Element<'_, '_>, file: usize, models: &mut Models, problems: &mut Problems) {
    let Some(category) = vocabulary::explicit(element.tag_name().name()) else {
        misplaced(
            element,
            "<TreeNodesModel> holds <Action>, <Condition>, <Control>, <Decorator> and <SubTree>",
            problems,
        );
        return;
    };
    let Some(id) = required_id(element, "which node is declared", problems) else { return };
    let span = tag_span(element);
    if let Some(builtin) = vocabulary::builtin(&id) {
        let (is, used_as) = (builtin.category(), category);
        if is != used_as {
            problems.push(wrong_category(&id, is, used_as, span, None));
            return;
        }
        // Groot also lists BehaviorTree.CPP's own nodes. They are known here, so only its annotations are kept.
        let model = declaration(element, category, Some((file, span)), &mut Problems::new());
        if builtin.is_called(&id) && !model.notes.is_empty() {
            models.insert(id, model);
        }
        return;
    }
    let model = declaration(element, category, Some((file, span)), problems);
    match models.get(&id) {
        Some(known) if known.category != category && known.declared.is_some_and(|(first, _)| first == file) => {
            let declared = known.declared.map(|(_, span)| span);
            let (is, used_as) = (known.category, category);
            problems.push(wrong_category(&id, is, used_as, span, declared));
        }
        _ => {
            models.insert(id, model);
        }
    }
}

/// The declaration of a node by an element, at this position in a file.
pub(super) fn declaration(
    element: Element<'_, '_>,
    category: Category,
    declared: Option<(usize, SourceSpan)>,
    problems: &mut Problems,
) -> Model {
    let kept = other_attributes(element, &["ID"]);
    let mut model = Model { kept, declared, is_declared: true, ..Model::of(category) };
    for child in element.children().filter(Element::is_element) {
        match direction(child) {
            Some(_) if model.ports.len() == MAX_PORTS => {
                problems.push(too_many("ports", MAX_PORTS, tag_span(child)));
                break;
            }
            Some(direction) => read_port(child, direction, problems).into_iter().for_each(|port| model.add(port)),
            None => model.notes.push(verbatim(child)),
        }
    }
    model
}

/// The direction of the port that an element declares; `None` if it does not declare a port.
fn direction(element: Element<'_, '_>) -> Option<Direction> {
    let directions = [Direction::Input, Direction::Output, Direction::InOut];
    directions.into_iter().find(|direction| direction.element() == element.tag_name().name())
}

fn read_port(element: Element<'_, '_>, direction: Direction, problems: &mut Problems) -> Option<PortModel> {
    let name = element.attribute("name");
    let Some(name) = name.filter(|name| is_port_name(name)) else {
        let help = "a port's name begins with a letter, has no space, dot or other special character, and is neither \
                    `name` nor `ID`";
        let unnamed = || "this port has no name".to_owned();
        let problem = Problem::new(name.map_or_else(unnamed, |name| format!("`{name}` is not a valid name of a port")));
        problems.push(problem.at(tag_span(element), "give it a name").with_help(help));
        return None;
    };
    let of = element.attribute("type").map_or(Type::Any, Type::named);
    let default = element.attribute("default").map(str::to_owned);
    if let Some(text) = &default
        && pointed_key(name, text).is_none()
        && let Err(error) = of.parse(text)
        && !text.is_empty()
    {
        let span = value_span(element, "default").unwrap_or_else(|| tag_span(element));
        problems.push(port_value(name, &error.to_string(), span, None));
    }
    Some(PortModel {
        name: name.to_owned(),
        direction,
        of,
        type_name: element.attribute("type").map(str::to_owned),
        default: default.filter(|default| !default.is_empty()),
        description: element.text().unwrap_or_default().trim().to_owned(),
        kept: other_attributes(element, &["name", "type", "default"]),
    })
}

pub(super) fn misplaced(element: Element<'_, '_>, help: &str, problems: &mut Problems) {
    let problem = Problem::new(format!("<{}> is not allowed here", element.tag_name().name()));
    problems.push(problem.at(tag_span(element), "unexpected").with_help(help));
}
