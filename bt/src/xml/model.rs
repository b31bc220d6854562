//! What a file declares of nodes: its `<TreeNodesModel>`.

use std::collections::BTreeMap;

use miette::SourceSpan;
use roxmltree::Node as Element;

use super::ports::is_port_name;
use super::{Problems, tag_span, value_span, vocabulary};
use crate::blackboard::{Type, pointed_key};
use crate::{Category, Direction, Problem};

/// What is declared of a node's ID.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Model {
    pub(crate) category: Category,
    pub(crate) ports: Vec<PortModel>,
    /// Where, if a file says so; and in which of the files.
    pub(crate) declared: Option<(usize, SourceSpan)>,
}

/// What is declared of a port.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PortModel {
    pub(crate) name: String,
    pub(crate) direction: Direction,
    pub(crate) of: Type,
    /// The type's name in the file.
    pub(crate) type_name: Option<String>,
    pub(crate) default: Option<String>,
    pub(crate) description: String,
}

impl Model {
    pub(crate) fn port(&self, name: &str) -> Option<&PortModel> {
        self.ports.iter().find(|port| port.name == name)
    }
}

/// Models by ID.
pub(crate) type Models = BTreeMap<String, Model>;

/// Reads what a file declares, besides what is declared already.
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
    let Some(id) = super::required_id(element, "which node is declared", problems) else { return };
    // Groot writes down what it knows of BehaviorTree.CPP's own nodes, too. So do we know it.
    let builtin = vocabulary::builtin(&id);
    if let Some(builtin) = builtin {
        let (is, used_as, span) = (builtin.category(), category, tag_span(element));
        if is != used_as {
            problems.push(Problem::WrongCategory { id, is, used_as, span, declared: None });
        }
        return;
    }
    let mut model = Model { category, ports: Vec::new(), declared: Some((file, tag_span(element))) };
    for child in element.children().filter(Element::is_element) {
        read_port(child, &mut model.ports, problems);
    }
    match models.get(&id) {
        Some(known) if known.category != category && known.declared.is_some_and(|(first, _)| first == file) => {
            let declared = known.declared.map(|(_, span)| span);
            let (is, used_as, span) = (known.category, category, tag_span(element));
            problems.push(Problem::WrongCategory { id, is, used_as, span, declared });
        }
        _ => {
            models.insert(id, model);
        }
    }
}

fn read_port(element: Element<'_, '_>, ports: &mut Vec<PortModel>, problems: &mut Problems) {
    let directions = [Direction::Input, Direction::Output, Direction::InOut];
    let name = element.tag_name().name();
    let Some(direction) = directions.into_iter().find(|direction| direction.element() == name) else {
        // <MetadataFields>, <description> and whatever else a tool may note.
        return;
    };
    let Some(name) = element.attribute("name").filter(|name| is_port_name(name)) else {
        let help = Some("a port has a name that begins with a letter, and is not `name` or `ID`".to_owned());
        problems.push(Problem::PortName { span: tag_span(element), help });
        return;
    };
    let of = element.attribute("type").map_or(Type::Any, Type::named);
    let default = element.attribute("default").map(str::to_owned);
    if let Some(text) = &default
        && pointed_key(name, text).is_none()
        && let Err(error) = of.parse(text)
        && !text.is_empty()
    {
        let span = value_span(element, "default").unwrap_or_else(|| tag_span(element));
        problems.push(Problem::PortValue { port: name.to_owned(), message: error.to_string(), span, help: None });
    }
    ports.push(PortModel {
        name: name.to_owned(),
        direction,
        of,
        type_name: element.attribute("type").map(str::to_owned),
        default: default.filter(|default| !default.is_empty()),
        description: element.text().unwrap_or_default().trim().to_owned(),
    });
}

pub(super) fn misplaced(element: Element<'_, '_>, help: &str, problems: &mut Problems) {
    let (name, help) = (element.tag_name().name().to_owned(), Some(help.to_owned()));
    problems.push(Problem::Misplaced { element: name, span: tag_span(element), help });
}
