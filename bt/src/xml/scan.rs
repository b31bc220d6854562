//! The elements of a document: which nodes they are, and all that can be said of them one by one.

use std::collections::BTreeSet;
use std::sync::Arc;

use miette::SourceSpan;
use roxmltree::Node as Element;

use super::compile::{Attribute, Compiler, Nowhere};
use super::kept::{Kept, other_attributes, written_name};
use super::model::{Model, Models, misplaced};
use super::ports::is_port_name;
use super::vocabulary::{self, Builtin};
use super::{Loader, Problems, nearest, required_id, span, tag_span};
use crate::{Category, Kind, Problem};

/// A `<BehaviorTree>`.
#[derive(Debug)]
pub(crate) struct Definition {
    pub(crate) id: Option<String>,
    /// What the element says besides its ID.
    pub(super) kept: Kept,
    pub(super) span: SourceSpan,
    /// In which of the files.
    pub(super) file: usize,
    /// In document order, the root first; none where it has no root.
    pub(crate) nodes: Vec<Scanned>,
}

/// A node as the file has it.
#[derive(Debug)]
pub(crate) struct Scanned {
    pub(crate) kind: Kind,
    pub(crate) type_id: String,
    pub(super) attributes: Vec<Attribute>,
    pub(super) span: SourceSpan,
    /// Its place in the list of its tree.
    pub(crate) parent: Option<usize>,
}

impl Scanned {
    /// The attributes that are kept: all but those that spell out what the node is.
    pub(crate) fn kept_attributes(&self) -> impl Iterator<Item = (&str, &str)> {
        let kept = self.attributes.iter().filter(|attribute| attribute.name != "ID");
        kept.map(|attribute| (attribute.name.as_str(), attribute.value.as_str()))
    }

    pub(crate) fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|attribute| attribute.name == name).map(|attribute| attribute.value.as_str())
    }
}

/// The reading of one document.
pub(super) struct Scan<'a> {
    pub(super) loader: &'a Loader,
    pub(super) format: u8,
    pub(super) file: usize,
    pub(super) problems: &'a mut Problems,
    /// What all files declare, and what the nodes read so far have been used as.
    pub(super) models: &'a mut Models,
    /// The IDs of all trees.
    pub(super) trees: &'a BTreeSet<String>,
}

impl Scan<'_> {
    /// Reads all that is in the root element.
    pub(super) fn read_root(&mut self, root: Element<'_, '_>) -> Vec<Definition> {
        let mut definitions = Vec::new();
        for element in root.children().filter(Element::is_element) {
            match element.tag_name().name() {
                "BehaviorTree" => definitions.push(self.read_tree(element)),
                "TreeNodesModel" | "include" => {}
                name => {
                    let known = ["BehaviorTree", "TreeNodesModel", "include"];
                    let near = nearest(name, known.into_iter(), self.problems.len());
                    let help = near.map_or("<root> holds <BehaviorTree> and <TreeNodesModel>".to_owned(), |near| {
                        format!("did you mean <{near}>?")
                    });
                    misplaced(element, &help, self.problems);
                }
            }
        }
        definitions
    }

    fn read_tree(&mut self, tree: Element<'_, '_>) -> Definition {
        let id = match tree.attribute("ID") {
            Some(id) if id.trim().is_empty() => required_id(tree, "the name of the tree", self.problems),
            id => id.map(str::to_owned),
        };
        let kept = other_attributes(tree, &["ID"]);
        let mut definition = Definition { id, kept, span: tag_span(tree), file: self.file, nodes: Vec::new() };
        let children = tree.children().filter(Element::is_element);
        let found = children.clone().count();
        if found != 1 {
            let expected = "exactly one node, its root";
            let node = "<BehaviorTree>".to_owned();
            self.problems.push(Problem::ChildCount { node, expected, found, span: tag_span(tree) });
        }
        for child in children {
            self.read_node(child, None, 1, &mut definition.nodes);
        }
        definition
    }

    /// Reads a node and all below it.
    fn read_node(&mut self, element: Element<'_, '_>, parent: Option<usize>, depth: usize, nodes: &mut Vec<Scanned>) {
        if depth > self.loader.max_depth {
            self.problems.push(Problem::TooDeep { limit: self.loader.max_depth, span: tag_span(element) });
            return;
        }
        // Below a node that is not understood, the others are read on, for their own problems.
        let mut place = parent;
        if let Some((kind, type_id)) = self.resolve(element) {
            self.check_children(element, kind);
            let attributes = self.read_attributes(element, kind);
            let scanned = Scanned { kind, type_id, attributes, span: tag_span(element), parent };
            self.check_ports(element, &scanned);
            place = Some(nodes.len());
            nodes.push(scanned);
        }
        for child in element.children().filter(Element::is_element) {
            self.read_node(child, place, depth + 1, nodes);
        }
    }

    /// The attributes of a node, under the names and with the meaning that they have in format 4.
    fn read_attributes(&self, element: Element<'_, '_>, kind: Kind) -> Vec<Attribute> {
        let text = element.document().input_text();
        let is_old = self.format == 3 && element.tag_name().name() == "SubTree";
        let read = |attribute: roxmltree::Attribute<'_, '_>| {
            let (written, mut value) = (written_name(element, &attribute), attribute.value().to_owned());
            if is_old && is_port_name(written) && value.parse::<f64>().is_err() && !value.contains('{') {
                // Version 3 had no values here, but names of entries.
                value = format!("{{{value}}}");
            }
            let is_plain = text.get(attribute.range_value()) == Some(&value);
            Attribute {
                name: vocabulary::current_port_name(kind, written).to_owned(),
                value,
                span: span(attribute.range()),
                value_span: span(attribute.range_value()),
                is_plain,
            }
        };
        element.attributes().map(read).collect()
    }

    /// What node an element is, and of which ID.
    fn resolve(&mut self, element: Element<'_, '_>) -> Option<(Kind, String)> {
        let name = element.tag_name().name();
        let explicit = vocabulary::explicit(name).or_else(|| (name == "SubTreePlus").then_some(Category::SubTree));
        if let Some(category) = explicit {
            let meaning = match category {
                Category::SubTree => "the tree that stands in this place",
                Category::Action | Category::Condition => "the skill that this leaf asks",
                Category::Control | Category::Decorator => "what kind of node it is",
            };
            let id = required_id(element, meaning, self.problems)?;
            return self.resolve_explicit(element, category, id);
        }
        if let Some(builtin) = vocabulary::builtin(name) {
            return self.known(element, name, builtin).map(|kind| (kind, kind.name().to_owned()));
        }
        let kind = match self.models.get(name).map(|model| model.category) {
            Some(Category::Action) => Kind::Action,
            Some(Category::Condition) => Kind::Condition,
            Some(category @ (Category::Control | Category::Decorator)) => {
                self.custom(element, category, name);
                return None;
            }
            None if self.loader.leaves.contains(name) => Kind::Action,
            Some(Category::SubTree) | None => {
                self.unknown(element, name);
                return None;
            }
        };
        self.check_needless_id(element, kind);
        self.check_category(name, kind.category(), tag_span(element));
        Some((kind, name.to_owned()))
    }

    /// `<Control ID="Sequence">`, `<Action ID="GoTo"/>` and their like.
    fn resolve_explicit(&mut self, element: Element<'_, '_>, used_as: Category, id: String) -> Option<(Kind, String)> {
        if used_as == Category::SubTree {
            return Some((Kind::SubTree, id));
        }
        if let Some(builtin) = vocabulary::builtin(&id) {
            let is = builtin.category();
            if is != used_as {
                self.problems.push(Problem::WrongCategory { id, is, used_as, span: tag_span(element), declared: None });
                return None;
            }
            return self.known(element, &id, builtin).map(|kind| (kind, kind.name().to_owned()));
        }
        let kind = match used_as {
            Category::Action => Kind::Action,
            Category::Condition => Kind::Condition,
            _ => {
                self.custom(element, used_as, &id);
                return None;
            }
        };
        self.check_category(&id, used_as, tag_span(element));
        Some((kind, id))
    }

    fn known(&mut self, element: Element<'_, '_>, name: &str, builtin: Builtin) -> Option<Kind> {
        match builtin {
            Builtin::Known(kind) => Some(kind),
            Builtin::Gone(_, help) => {
                let (what, help) = (format!("version 3's <{name}>"), Some(help.to_owned()));
                self.problems.push(Problem::NotSupported { what, span: tag_span(element), help });
                None
            }
        }
    }

    /// An ID is one thing throughout: what it was declared, or used as first.
    fn check_category(&mut self, id: &str, used_as: Category, span: SourceSpan) {
        let here = || Model { declared: Some((self.file, span)), ..Model::of(used_as) };
        let model = match self.models.get(id) {
            Some(model) => model,
            None => self.models.entry(id.to_owned()).or_insert(here()),
        };
        let is = model.category;
        if is != used_as {
            let declared = model.declared.filter(|(file, _)| *file == self.file).map(|(_, span)| span);
            self.problems.push(Problem::WrongCategory { id: id.to_owned(), is, used_as, span, declared });
        }
    }

    /// Format 4 knows one spelling or the other; in format 3 an ID beside a name that says it all was ignored.
    fn check_needless_id(&mut self, element: Element<'_, '_>, kind: Kind) {
        let Some(attribute) = element.attribute_node("ID").filter(|_| self.format == 4) else { return };
        let name = element.tag_name().name();
        let help = Some(format!("write <{name}/>, or <{kind} ID=\"{}\"/>", attribute.value()));
        let span = span(attribute.range());
        self.problems.push(Problem::NeedlessId { element: name.to_owned(), span, help });
    }

    fn check_children(&mut self, element: Element<'_, '_>, kind: Kind) {
        let found = element.children().filter(Element::is_element).count();
        if let Some(expected) = kind.expected_children(found) {
            let node = format!("<{}>", element.tag_name().name());
            self.problems.push(Problem::ChildCount { node, expected, found, span: tag_span(element) });
        }
    }

    /// What the attributes say is right, as far as can be seen without knowing where the node will stand.
    fn check_ports(&mut self, element: Element<'_, '_>, scanned: &Scanned) {
        let &Scanned { kind, span, ref attributes, ref type_id, .. } = scanned;
        let model = self.models.get(type_id);
        let mut nowhere = Nowhere(Arc::clone(&self.loader.constants));
        let problems = &mut *self.problems;
        let mut compiler = Compiler { kind, name: type_id, attributes, span, names: &mut nowhere, problems };
        compiler.hooks();
        compiler.check_scripts();
        match kind {
            Kind::SubTree => self.check_subtree_ports(scanned),
            Kind::Action | Kind::Condition => {
                compiler.leaf_ports(model);
                compiler.check_leaf_ports(model);
            }
            _ => {
                compiler.setting();
                compiler.check_builtin_ports();
                self.check_thresholds(element, scanned);
            }
        }
    }

    /// A subtree is given all that its model asks for.
    fn check_subtree_ports(&mut self, scanned: &Scanned) {
        if let Some(attribute) = scanned.attributes.iter().find(|attribute| attribute.name == "_autoremap") {
            match crate::blackboard::Type::Bool.parse(&attribute.value) {
                Ok(truth) if truth.to_bool() == Ok(true) => return,
                Ok(_) => {}
                Err(error) => {
                    let (port, message) = (attribute.name.clone(), error.to_string());
                    self.problems.push(Problem::PortValue { port, message, span: attribute.value_span, help: None });
                }
            }
        }
        let model = self.models.get(&scanned.type_id).filter(|model| model.category == Category::SubTree);
        for port in model.iter().flat_map(|model| &model.ports) {
            if port.default.is_none() && scanned.attribute(&port.name).is_none() {
                let help = Some(format!("write {}=\"…\", or _autoremap=\"true\"", port.name));
                let (node, port) = (format!("the tree `{}`", scanned.type_id), port.name.clone());
                self.problems.push(Problem::MissingPort { node, port, span: scanned.span, help });
            }
        }
    }

    /// A parallel node with constant thresholds can succeed and can fail.
    fn check_thresholds(&mut self, element: Element<'_, '_>, scanned: &Scanned) {
        if !scanned.kind.passes_over_completed() {
            return;
        }
        let children = element.children().filter(Element::is_element).count();
        let ports = ["success_count", "failure_count", "max_failures"];
        for attribute in scanned.attributes.iter().filter(|attribute| ports.contains(&attribute.name.as_str())) {
            if attribute
                .value
                .parse::<i32>()
                .is_ok_and(|limit| usize::try_from(limit).is_ok_and(|limit| limit > children))
            {
                let message = format!("the node has only {children} of them to count");
                let (port, span) = (attribute.name.clone(), attribute.value_span);
                self.problems.push(Problem::PortValue { port, message, span, help: None });
            }
        }
    }

    fn unknown(&mut self, element: Element<'_, '_>, name: &str) {
        let known = vocabulary::names()
            .chain(self.models.keys().map(String::as_str))
            .chain(self.loader.leaves.iter().map(String::as_str));
        let help = if self.trees.contains(name) {
            format!("for the tree of that name, write <SubTree ID=\"{name}\"/>")
        } else if let Some(near) = nearest(name, known, self.problems.len()) {
            format!("did you mean <{near}>?")
        } else {
            format!(
                "for a skill, write <Action ID=\"{name}\"/> or <Condition ID=\"{name}\"/>, or declare it so in <TreeNodesModel>"
            )
        };
        let (element_name, span) = (name.to_owned(), tag_span(element));
        self.problems.push(Problem::UnknownNode { element: element_name, span, help: Some(help) });
    }

    fn custom(&mut self, element: Element<'_, '_>, category: Category, id: &str) {
        let near = nearest(id, vocabulary::builtins_of(category), self.problems.len());
        let help = near.map_or("only leaves can be of your own making: they are skills".to_owned(), |near| {
            format!("did you mean `{near}`?")
        });
        let (id, span) = (id.to_owned(), tag_span(element));
        self.problems.push(Problem::CustomNode { id, category, span, help: Some(help) });
    }
}
