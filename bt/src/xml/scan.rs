//! The elements of a document: which nodes they are, and all that can be said of them one by one.

use std::collections::BTreeMap;

use miette::SourceSpan;
use roxmltree::Node as Element;

use super::vocabulary::{self, Builtin};
use super::{Loader, Problems, nearest, span, tag_span};
use crate::{Category, Kind, Problem};

/// A `<BehaviorTree>`.
pub(super) struct Definition {
    pub(super) id: Option<String>,
    pub(super) span: SourceSpan,
    /// In document order, the root first; none where it has no root.
    pub(super) nodes: Vec<Scanned>,
}

/// A node as the file has it.
pub(super) struct Scanned {
    pub(super) kind: Kind,
    pub(super) type_id: String,
    pub(super) attributes: Vec<(String, String)>,
    pub(super) span: SourceSpan,
    /// Its place in the list of its tree.
    pub(super) parent: Option<usize>,
}

/// What is known of a leaf's ID, and where the file says so.
#[derive(Clone, Copy)]
struct Declared {
    category: Category,
    span: Option<SourceSpan>,
}

/// The reading of one document.
pub(super) struct Scan<'a> {
    loader: &'a Loader,
    format: u8,
    problems: &'a mut Problems,
    declared: BTreeMap<String, Declared>,
    trees: Vec<String>,
}

impl<'a> Scan<'a> {
    pub(super) fn new(loader: &'a Loader, format: u8, problems: &'a mut Problems) -> Self {
        Self { loader, format, problems, declared: BTreeMap::new(), trees: Vec::new() }
    }

    /// Reads all that is in the root element.
    pub(super) fn read_root(&mut self, root: Element<'_, '_>) -> Vec<Definition> {
        let elements = || root.children().filter(Element::is_element);
        self.trees = elements()
            .filter(|element| element.has_tag_name("BehaviorTree"))
            .filter_map(|tree| tree.attribute("ID").map(str::to_owned))
            .collect();
        let mut models = elements().filter(|element| element.has_tag_name("TreeNodesModel"));
        if let Some(model) = models.next() {
            self.read_model(model);
        }
        for element in models {
            self.misplaced(element, "one <TreeNodesModel> is enough: put all declarations into the first");
        }
        let mut definitions = Vec::new();
        for element in elements() {
            match element.tag_name().name() {
                "BehaviorTree" => definitions.push(self.read_tree(element)),
                "TreeNodesModel" => {}
                "include" => self.not_supported(element, "put the trees of the other file into this one"),
                name => {
                    let near =
                        nearest(name, ["BehaviorTree", "TreeNodesModel", "include"].into_iter(), self.problems.len());
                    let help = near.map_or("<root> holds <BehaviorTree> and <TreeNodesModel>".to_owned(), |near| {
                        format!("did you mean <{near}>?")
                    });
                    self.misplaced(element, &help);
                }
            }
        }
        definitions
    }

    /// Reads what the file declares of its nodes.
    fn read_model(&mut self, model: Element<'_, '_>) {
        for element in model.children().filter(Element::is_element) {
            let Some(category) = vocabulary::explicit(element.tag_name().name()) else {
                self.misplaced(
                    element,
                    "<TreeNodesModel> holds <Action>, <Condition>, <Control>, <Decorator> and <SubTree>",
                );
                continue;
            };
            if let Some(id) = self.required_id(element, "which node is declared") {
                self.check_category(&id, category, tag_span(element));
            }
        }
    }

    fn read_tree(&mut self, tree: Element<'_, '_>) -> Definition {
        let id = match tree.attribute("ID") {
            Some(id) if id.trim().is_empty() => self.required_id(tree, "the name of the tree"),
            id => id.map(str::to_owned),
        };
        let mut definition = Definition { id, span: tag_span(tree), nodes: Vec::new() };
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
            self.check_attributes(element);
            place = Some(nodes.len());
            let attributes = element.attributes().map(|a| (a.name().to_owned(), a.value().to_owned())).collect();
            nodes.push(Scanned { kind, type_id, attributes, span: tag_span(element), parent });
        }
        for child in element.children().filter(Element::is_element) {
            self.read_node(child, place, depth + 1, nodes);
        }
    }

    /// What node an element is, and of which ID.
    fn resolve(&mut self, element: Element<'_, '_>) -> Option<(Kind, String)> {
        let name = element.tag_name().name();
        if let Some(category) = vocabulary::explicit(name) {
            let meaning = match category {
                Category::SubTree => "the tree that stands in this place",
                Category::Action | Category::Condition => "the skill that this leaf asks",
                Category::Control | Category::Decorator => "what kind of node it is",
            };
            let id = self.required_id(element, meaning)?;
            return self.resolve_explicit(element, category, id);
        }
        if let Some(builtin) = vocabulary::builtin(name) {
            return self.known(element, name, builtin).map(|kind| (kind, kind.name().to_owned()));
        }
        let declared = self.declared.get(name).copied();
        let kind = match declared.map(|declared| declared.category) {
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

    /// The kind of one of BehaviorTree.CPP's own nodes, if we run it.
    fn known(&mut self, element: Element<'_, '_>, name: &str, builtin: Builtin) -> Option<Kind> {
        match builtin {
            Builtin::Known(kind) => Some(kind),
            Builtin::Later(_) => {
                let (what, help) = (format!("the node {name}"), None);
                self.problems.push(Problem::NotSupported { what, span: tag_span(element), help });
                None
            }
        }
    }

    /// An ID is one thing throughout a file.
    fn check_category(&mut self, id: &str, used_as: Category, span: SourceSpan) {
        let here = Declared { category: used_as, span: Some(span) };
        let Declared { category: is, span: declared } = *self.declared.entry(id.to_owned()).or_insert(here);
        if is != used_as {
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
        if let Some(expected) = kind.category().expected_children(found) {
            let node = format!("<{}>", element.tag_name().name());
            self.problems.push(Problem::ChildCount { node, expected, found, span: tag_span(element) });
        }
    }

    fn check_attributes(&mut self, element: Element<'_, '_>) {
        for attribute in element.attributes().filter(|attribute| vocabulary::is_script(attribute.name())) {
            let (what, span) = (format!("the attribute {}", attribute.name()), span(attribute.range()));
            let help = Some("without it the node would do something else: remove it to run the tree so".to_owned());
            self.problems.push(Problem::NotSupported { what, span, help });
        }
    }

    /// The ID of an element that must have one.
    fn required_id(&mut self, element: Element<'_, '_>, meaning: &str) -> Option<String> {
        match element.attribute("ID").map(str::trim) {
            Some(id) if !id.is_empty() => Some(id.to_owned()),
            _ => {
                let help = Some(format!("the ID says {meaning}"));
                let element_name = element.tag_name().name().to_owned();
                self.problems.push(Problem::MissingId { element: element_name, span: tag_span(element), help });
                None
            }
        }
    }

    fn unknown(&mut self, element: Element<'_, '_>, name: &str) {
        let known = vocabulary::names()
            .chain(self.declared.keys().map(String::as_str))
            .chain(self.loader.leaves.iter().map(String::as_str));
        let help = if self.trees.iter().any(|tree| tree == name) {
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

    fn misplaced(&mut self, element: Element<'_, '_>, help: &str) {
        let (name, help) = (element.tag_name().name().to_owned(), Some(help.to_owned()));
        self.problems.push(Problem::Misplaced { element: name, span: tag_span(element), help });
    }

    fn not_supported(&mut self, element: Element<'_, '_>, help: &str) {
        let (what, help) = (format!("<{}>", element.tag_name().name()), Some(help.to_owned()));
        self.problems.push(Problem::NotSupported { what, span: tag_span(element), help });
    }
}
