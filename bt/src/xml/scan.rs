//! The elements of a document: their nodes, and all checks that concern a single node.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use diagnostics::Problem;
use diagnostics::xml::name_span;
use miette::SourceSpan;
use roxmltree::Node as Element;

use super::compile::{Compiler, Nowhere};
use super::elements::{required_id, span, tag_span, value_span};
use super::kept::{other_attributes, written_name};
use super::loader::Loader;
use super::model::misplaced;
use super::nav2::nav2_models;
use super::ports::is_port_name;
use super::problems::{
    MAX_PROBLEMS, Problems, child_count, missing_port, near, not_supported, port_value, too_deep, unbraced_output,
    unknown_node, wrong_category,
};
use super::vocabulary::{self, Builtin};
use crate::blackboard::pointed_key;
use crate::library::{Attribute, Definition, Model, Models, Scanned};
use crate::{Category, Direction, Kind};

/// The port of a RoundRobin.
const WRAP_AROUND: &str = "wrap_around";

/// The reading of one document.
pub(super) struct Scan<'a> {
    pub(super) loader: &'a Loader,
    pub(super) format: u8,
    pub(super) file: usize,
    pub(super) problems: &'a mut Problems,
    /// The declarations of all files, and the categories in which the nodes read so far were used.
    pub(super) models: &'a mut Models,
    /// The IDs of all trees.
    pub(super) trees: &'a BTreeSet<String>,
    /// The indices of problems about unknown element names, and how many more elements have these names.
    pub(super) unknown: BTreeMap<String, (usize, usize)>,
}

impl Scan<'_> {
    pub(super) fn read_root(&mut self, root: Element<'_, '_>) -> Vec<Definition> {
        let mut definitions = Vec::new();
        for element in root.children().filter(Element::is_element) {
            match element.tag_name().name() {
                "BehaviorTree" => definitions.push(self.read_tree(element)),
                "TreeNodesModel" | "include" => {}
                name => {
                    let near = near(name, vocabulary::IN_ROOT.into_iter(), self.problems.len());
                    let help = near
                        .map_or("<root> may contain <BehaviorTree> and <TreeNodesModel>".to_owned(), |near| {
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
        self.check_id(id.as_deref(), || value_span(tree, "ID"));
        let kept = other_attributes(tree, &["ID"]);
        let mut definition = Definition { id, kept, span: tag_span(tree), file: self.file, nodes: Vec::new() };
        let children = tree.children().filter(Element::is_element);
        let found = children.clone().count();
        if found != 1 {
            let expected = "exactly one node, its root";
            self.problems.push(child_count("<BehaviorTree>", expected, found, tag_span(tree)));
        }
        for child in children {
            self.read_node(child, None, 1, &mut definition.nodes);
        }
        self.check_neighbors(&definition.nodes);
        definition
    }

    /// Checks that BehaviorTree.CPP 4 allows this ID.
    fn check_id(&mut self, id: Option<&str>, span: impl FnOnce() -> Option<SourceSpan>) {
        let Some(id) = id else { return };
        let (reason, help) = match vocabulary::forbidden(id) {
            Some(forbidden) => {
                let what = match forbidden {
                    ' ' => "a space".to_owned(),
                    c if c.is_control() => "a control character".to_owned(),
                    c => format!("`{c}`"),
                };
                let allowed = id.replace(|c: char| vocabulary::forbidden(c.encode_utf8(&mut [0; 4])).is_some(), "_");
                (format!("it contains {what}"), format!("write `{allowed}`"))
            }
            None if matches!(id, "Root" | "root") => {
                ("BehaviorTree.CPP reserves it".to_owned(), "give it a different ID".to_owned())
            }
            None => return,
        };
        let Some(span) = span() else { return };
        let problem = Problem::new(format!("`{id}` cannot be an ID: {reason}")).at(span, "not allowed");
        self.problems.push(problem.with_help(help));
    }

    /// Checks for names that several subtrees of a tree share, which would make their paths equal, and for asynchronous
    /// nodes that would halt each other forever.
    fn check_neighbors(&mut self, nodes: &[Scanned]) {
        let (mut names, mut parents) = (BTreeMap::new(), BTreeMap::new());
        for node in nodes {
            let span = node.span;
            let name = node.attribute("name").filter(|name| node.kind == Kind::SubTree && !name.is_empty());
            if let Some(name) = name
                && let Some(first) = earlier(&mut names, name, span)
            {
                let problem = Problem::new(format!("there are two subtrees named `{name}` in this tree"));
                let problem = problem.at(span, "again here").at(first, "first here");
                self.problems.push(problem.with_help("give one of them a different name, or remove the name"));
            }
            let reactive = node.parent.filter(|parent| nodes[*parent].kind == Kind::ReactiveSequence);
            if let Some(parent) = reactive.filter(|_| node.kind == Kind::AsyncSequence)
                && let Some(first) = earlier(&mut parents, parent, span)
            {
                let problem = Problem::new("a <ReactiveSequence> cannot have two <AsyncSequence>");
                let problem = problem.at(span, "again here").at(first, "first here");
                let help = "when one runs, the other is halted and starts over: write <Sequence> for one of them";
                self.problems.push(problem.with_help(help));
            }
        }
    }

    /// Reads a node and everything below it.
    fn read_node(&mut self, element: Element<'_, '_>, parent: Option<usize>, depth: usize, nodes: &mut Vec<Scanned>) {
        if self.problems.len() >= MAX_PROBLEMS {
            return;
        }
        if depth > self.loader.max_depth {
            self.problems.push(too_deep(self.loader.max_depth, tag_span(element)));
            return;
        }
        // Below an unknown node, the others are still read, for their own problems.
        let mut place = parent;
        if let Some((kind, type_id)) = self.resolve(element) {
            self.check_children(element, kind);
            if parent.is_some_and(|parent| nodes[parent].kind == Kind::ReactiveSequence) {
                self.check_explicit_child(element, kind, &type_id);
            }
            let mut attributes = self.read_attributes(element, kind);
            self.name_outputs(&type_id, &mut attributes);
            let scanned = Scanned { kind, type_id, attributes, span: tag_span(element), parent };
            self.check_ports(element, &scanned);
            place = Some(nodes.len());
            nodes.push(scanned);
        }
        for child in element.children().filter(Element::is_element) {
            self.read_node(child, place, depth + 1, nodes);
        }
    }

    /// The attributes of a node, with their names and meaning in format 4.
    fn read_attributes(&self, element: Element<'_, '_>, kind: Kind) -> Vec<Attribute> {
        let text = element.document().input_text();
        let is_old = self.format == 3 && element.tag_name().name() == "SubTree";
        let read = |attribute: roxmltree::Attribute<'_, '_>| {
            let (written, mut value) = (written_name(element, &attribute), attribute.value().to_owned());
            if is_old && is_port_name(written) && value.parse::<f64>().is_err() && !value.contains('{') {
                // In version 3 these were names of entries, not values.
                value = format!("{{{value}}}");
            }
            // XML reads a line break or a tab in an attribute as a space.
            let raw = text.get(attribute.range_value()).map(|raw| raw.replace(['\t', '\n', '\r'], " "));
            let is_plain = raw.as_ref() == Some(&value);
            Attribute {
                name: vocabulary::current_port_name(kind, written).to_owned(),
                written: written.to_owned(),
                value,
                span: span(attribute.range()),
                value_span: span(attribute.range_value()),
                is_plain,
            }
        };
        let mut attributes: Vec<Attribute> = element.attributes().map(read).collect();
        if kind == Kind::RoundRobin && self.format == 3 && !element.has_attribute(WRAP_AROUND) {
            // Humble's trees are of version 3, and its RoundRobin always wraps around.
            let (name, value, span) = (WRAP_AROUND.to_owned(), "true".to_owned(), tag_span(element));
            attributes.push(Attribute { written: name.clone(), name, value, span, value_span: span, is_plain: false });
        }
        attributes
    }

    /// In version 3, an output port without braces names an entry, too.
    fn name_outputs(&mut self, type_id: &str, attributes: &mut [Attribute]) {
        let Some(model) = self.models.get(type_id).filter(|_| self.format == 3) else { return };
        for attribute in attributes {
            let Attribute { name, written, value, value_span, is_plain, .. } = attribute;
            let is_output = model.port(name).is_some_and(|port| port.direction == Direction::Output);
            if is_output && !value.is_empty() && pointed_key(name, value).is_none() {
                self.problems.push(unbraced_output(written, value, *value_span));
                (*value, *is_plain) = (format!("{{{value}}}"), false);
            }
        }
    }

    fn resolve(&mut self, element: Element<'_, '_>) -> Option<(Kind, String)> {
        let name = element.tag_name().name();
        let explicit = vocabulary::explicit(name).or_else(|| (name == "SubTreePlus").then_some(Category::SubTree));
        if let Some(category) = explicit {
            let meaning = match category {
                Category::SubTree => "the tree to insert here",
                Category::Action | Category::Condition => "which skill this leaf calls",
                Category::Control | Category::Decorator => "the kind of node",
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
            // A tree is no element of its own name, even if it has a model.
            Some(Category::SubTree) | None => {
                self.unknown(element, name);
                return None;
            }
        };
        self.check_id(Some(name), || Some(name_span(element).into()));
        self.check_needless_id(element, kind);
        self.check_category(name, kind.category(), tag_span(element));
        Some((kind, name.to_owned()))
    }

    /// `<Control ID="Sequence">`, `<Action ID="GoTo"/>` and similar forms.
    fn resolve_explicit(&mut self, element: Element<'_, '_>, used_as: Category, id: String) -> Option<(Kind, String)> {
        if used_as == Category::SubTree {
            self.check_name(element, element.tag_name().name(), Kind::SubTree.name());
            self.check_id(element.attribute("ID"), || value_span(element, "ID"));
            return Some((Kind::SubTree, id));
        }
        if let Some(builtin) = vocabulary::builtin(&id) {
            let is = builtin.category();
            if is != used_as {
                self.problems.push(wrong_category(&id, is, used_as, tag_span(element), None));
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
            Builtin::Known(kind) => {
                self.check_name(element, name, kind.name());
                Some(kind)
            }
            Builtin::Gone(_, help) => {
                self.problems.push(not_supported(&format!("version 3's <{name}>"), tag_span(element), help));
                None
            }
        }
    }

    /// Warns of a name of version 3 in a file of format 4.
    fn check_name(&mut self, element: Element<'_, '_>, name: &str, is: &str) {
        if self.format == 4 && name != is {
            let problem = Problem::new(format!("<{name}> is <{is}> in format 4")).as_warning();
            let help = "BehaviorTree.CPP refuses to load this tree: \"Node not recognized\"";
            self.problems.push(problem.at(tag_span(element), format!("write <{is}>")).with_help(help));
        }
    }

    /// Checks that an ID has the same category everywhere, as declared or first used.
    fn check_category(&mut self, id: &str, used_as: Category, span: SourceSpan) {
        let here = || Model { declared: Some((self.file, span)), ..Model::of(used_as) };
        let model = match self.models.get(id) {
            Some(model) => model,
            None => self.models.entry(id.to_owned()).or_insert(here()),
        };
        let is = model.category;
        if is != used_as {
            let declared = model.declared.filter(|(file, _)| *file == self.file).map(|(_, span)| span);
            self.problems.push(wrong_category(id, is, used_as, span, declared));
        }
    }

    /// In format 4 only one of both forms is allowed; in format 3 a redundant ID was ignored.
    fn check_needless_id(&mut self, element: Element<'_, '_>, kind: Kind) {
        let Some(attribute) = element.attribute_node("ID").filter(|_| self.format == 4) else { return };
        let name = element.tag_name().name();
        let problem = Problem::new(format!("<{name}> is the ID already, so the attribute ID is not allowed"));
        let help = format!("write <{name}/>, or <{kind} ID=\"{}\"/>", attribute.value());
        self.problems.push(problem.at(attribute.range(), "a second ID").with_help(help));
    }

    /// Warns of a child of a `<ReactiveSequence>` in explicit form: BehaviorTree.CPP looks up its element there, and
    /// not its ID.
    fn check_explicit_child(&mut self, element: Element<'_, '_>, kind: Kind, id: &str) {
        let name = element.tag_name().name();
        let is_unknown = vocabulary::explicit(name).is_some_and(|category| category != Category::SubTree);
        if self.format == 3 || !is_unknown {
            return;
        }
        let declare = if kind.is_leaf() { ", and declare it in <TreeNodesModel>" } else { "" };
        let problem =
            Problem::new(format!("a child of a <ReactiveSequence> cannot be written as <{name} ID=\"{id}\">"));
        self.problems.push(problem.as_warning().at(tag_span(element), format!("write <{id}>{declare}")).with_help(
            format!("BehaviorTree.CPP from 4.7.0 on refuses to load this tree: \"Unknown node type: {name}\""),
        ));
    }

    fn check_children(&mut self, element: Element<'_, '_>, kind: Kind) {
        let found = element.children().filter(Element::is_element).count();
        if let Some(expected) = kind.expected_children(found) {
            let node = format!("<{}>", element.tag_name().name());
            self.problems.push(child_count(&node, expected, found, tag_span(element)));
        }
    }

    /// Checks the attributes, as far as this does not depend on the node's position in the tree.
    fn check_ports(&mut self, element: Element<'_, '_>, scanned: &Scanned) {
        let &Scanned { kind, span, ref attributes, ref type_id, .. } = scanned;
        let model = self.models.get(type_id);
        let mut nowhere = Nowhere(Arc::clone(&self.loader.constants));
        let problems = &mut *self.problems;
        let mut compiler = Compiler { kind, name: type_id, attributes, span, names: &mut nowhere, problems };
        compiler.hooks();
        compiler.check_scripts();
        compiler.check_braces(model);
        compiler.check_values(model);
        match kind {
            Kind::SubTree => self.check_subtree_ports(scanned),
            Kind::Action | Kind::Condition => {
                compiler.given_ports(model);
                compiler.check_leaf_ports(model, self.format);
            }
            _ => {
                compiler.setting();
                compiler.check_builtin_ports();
                self.check_thresholds(element, scanned);
                self.check_round(scanned);
            }
        }
    }

    /// Checks that a subtree gets all ports that its model requires, from entries that it can write.
    fn check_subtree_ports(&mut self, scanned: &Scanned) {
        for attribute in scanned.attributes.iter().filter(|attribute| is_port_name(&attribute.name)) {
            let key = pointed_key(&attribute.name, &attribute.value).and_then(|key| key.strip_prefix('@'));
            if let Some(key) = key.filter(|_| self.format == 4) {
                let message = format!("the tree `{}` can read the entry `@{key}`, but not write it", scanned.type_id);
                let problem = Problem::new(message).as_warning().at(attribute.value_span, "of the main tree");
                self.problems.push(problem.with_help(format!(
                    "in BehaviorTree.CPP, what ports write to `{}` is lost, and a script that creates it throws \"Bug: \
                     report\"; write @{key} in the tree itself",
                    attribute.name
                )));
            }
        }
        if let Some(attribute) = scanned.attributes.iter().find(|attribute| attribute.name == "_autoremap") {
            match crate::blackboard::Type::Bool.parse(&attribute.value) {
                Ok(truth) if truth.to_bool() == Ok(true) => return,
                Ok(_) => {}
                Err(error) => {
                    let problem = port_value(&attribute.name, &error.to_string(), attribute.value_span, None);
                    self.problems.push(problem);
                }
            }
        }
        let model = self.models.get(&scanned.type_id).filter(|model| model.category == Category::SubTree);
        for port in model.iter().flat_map(|model| &model.ports) {
            if port.default.is_none() && scanned.attribute(&port.name).is_none() {
                let help = Some(format!("write {}=\"…\", or _autoremap=\"true\"", port.name));
                let node = format!("the tree `{}`", scanned.type_id);
                self.problems.push(missing_port(&node, &port.name, scanned.span, help));
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
                self.problems.push(port_value(&attribute.written, &message, attribute.value_span, None));
            }
        }
    }

    /// Warns of a RoundRobin that does not set whether it wraps around, because Nav2's releases differ.
    fn check_round(&mut self, scanned: &Scanned) {
        if scanned.kind == Kind::RoundRobin && scanned.attribute(WRAP_AROUND).is_none() {
            let problem = Problem::new("Nav2's RoundRobin wraps around up to Kilted, but not since Lyrical");
            let help = "this one does not; for a tree of an older release, add wrap_around=\"true\"";
            let problem = problem.as_warning().at(scanned.span, "ends after its last child");
            self.problems.push(problem.with_help(help));
        }
    }

    fn unknown(&mut self, element: Element<'_, '_>, name: &str) {
        if let Some((at, more)) = self.unknown.get_mut(name) {
            *more += 1;
            let problem = &mut self.problems[*at];
            *problem = problem.clone().with_message(unknown_node(name, *more).message());
            return;
        }
        self.unknown.insert(name.to_owned(), (self.problems.len(), 0));
        let known = vocabulary::names()
            .chain(self.models.keys().map(String::as_str))
            .chain(self.loader.leaves.iter().map(String::as_str))
            .chain(nav2_models().keys().map(String::as_str));
        let help = if self.trees.contains(name) {
            format!("to insert the tree with this name, write <SubTree ID=\"{name}\"/>")
        } else if let Some(near) = near(name, known, self.problems.len()) {
            format!("did you mean <{near}>?")
        } else {
            format!(
                "for a skill, declare it in <TreeNodesModel>, or write <Action ID=\"{name}\"/> or <Condition ID=\"{name}\"/>"
            )
        };
        self.problems.push(unknown_node(name, 0).at(tag_span(element), "unknown").with_help(help));
    }

    fn custom(&mut self, element: Element<'_, '_>, category: Category, id: &str) {
        let near = near(id, vocabulary::builtins_of(category), self.problems.len());
        let help = near.map_or("only leaves can be custom nodes: they are skills".to_owned(), |near| {
            format!("did you mean `{near}`?")
        });
        let message =
            format!("`{id}` is not one of BehaviorTree.CPP's or Nav2's nodes, so it cannot be run as a <{category}>");
        self.problems.push(Problem::new(message).at(tag_span(element), "unknown").with_help(help));
    }
}

/// The position where a key was seen before; a new key is recorded.
fn earlier<K: Ord>(seen: &mut BTreeMap<K, SourceSpan>, key: K, span: SourceSpan) -> Option<SourceSpan> {
    let first = *seen.entry(key).or_insert(span);
    (first != span).then_some(first)
}
