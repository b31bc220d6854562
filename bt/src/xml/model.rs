//! The declarations of nodes in a file: its `<TreeNodesModel>`.

use std::collections::BTreeMap;

use diagnostics::Problem;
use miette::SourceSpan;
use roxmltree::Node as Element;

use super::elements::{MAX_PORTS, required_id, tag_span, value_span};
use super::kept::{Kept, other_attributes, verbatim};
use super::ports::is_port_name;
use super::problems::{Problems, port_value, too_many, wrong_category};
use super::vocabulary;
use crate::blackboard::{Type, pointed_key};
use crate::{Category, Direction};

/// The declaration of a node's ID.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Model {
    pub(crate) category: Category,
    pub(crate) ports: Vec<PortModel>,
    /// The index of each port.
    pub(super) places: BTreeMap<String, usize>,
    /// Whether a `<TreeNodesModel>` or Nav2's model declares it with all its ports; otherwise it is only used as a node
    /// of this category.
    pub(super) is_declared: bool,
    /// Other contents of the declaration: attributes, and elements such as `<MetadataFields>` and `<description>`.
    pub(super) kept: Kept,
    pub(super) notes: Vec<String>,
    /// The position of its declaration or first use, and the index of the file; none in Nav2's model.
    pub(crate) declared: Option<(usize, SourceSpan)>,
}

/// The declaration of a port.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PortModel {
    pub(crate) name: String,
    pub(crate) direction: Direction,
    pub(crate) of: Type,
    /// The type's name in the file.
    pub(crate) type_name: Option<String>,
    pub(crate) default: Option<String>,
    pub(crate) description: String,
    pub(super) kept: Kept,
}

impl Model {
    /// A model without a declaration.
    pub(super) fn of(category: Category) -> Self {
        Self {
            category,
            ports: Vec::new(),
            places: BTreeMap::new(),
            is_declared: false,
            kept: Kept::new(),
            notes: Vec::new(),
            declared: None,
        }
    }

    /// Whether it is from Nav2's model, because no file declares the node.
    pub(crate) fn is_of_nav2(&self) -> bool {
        self.declared.is_none()
    }

    /// Whether it contains more than the category.
    pub(super) fn says_something(&self) -> bool {
        !self.ports.is_empty() || !self.notes.is_empty() || self.kept.iter().any(|(name, _)| name != "editable")
    }

    pub(crate) fn port(&self, name: &str) -> Option<&PortModel> {
        self.places.get(name).map(|place| &self.ports[*place])
    }

    fn add(&mut self, port: PortModel) {
        self.places.entry(port.name.clone()).or_insert(self.ports.len());
        self.ports.push(port);
    }
}

/// Models by ID.
pub(crate) type Models = BTreeMap<String, Model>;

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
