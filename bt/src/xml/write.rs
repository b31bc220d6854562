//! Writing trees as format 4.

use std::collections::{BTreeMap, BTreeSet};

use diagnostics::markup::{attribute, text};

use super::nav2::nav2_model;
use super::ports::is_port_name;
use super::vocabulary;
use crate::library::{Definition, Library, Model, PortModel, Scanned};
use crate::{Category, Direction, Kind, Tree};

impl Tree {
    /// All trees of the files from which the tree was loaded, as one file of format 4 that Groot2 can open: in short
    /// form, the main tree first, with a `<TreeNodesModel>` of all leaves at the end. Names of version 3 are replaced
    /// with those of version 4. Attributes are kept, even those that have no meaning here, and so are a model's
    /// contents besides ports. Root attributes of included files and comments are not kept.
    ///
    /// The model of a leaf has all ports that any of the trees uses, because BehaviorTree.CPP refuses undeclared ones.
    /// Ports that no file declares are written as `<inout_port>`s without a type, as they are treated here.
    ///
    /// ```
    /// let tree = bt::Tree::from_xml("old.xml", r#"<root> <BehaviorTree ID="Wave">
    ///     <SequenceStar>
    ///         <Action ID="Raise" hand="left"/> <Delay delay_msec="500"> <Action ID="Lower"/> </Delay>
    ///     </SequenceStar>
    /// </BehaviorTree> </root>"#)?;
    /// assert_eq!(tree.to_xml(), r#"<?xml version="1.0" encoding="UTF-8"?>
    /// <root BTCPP_format="4" main_tree_to_execute="Wave">
    ///   <BehaviorTree ID="Wave">
    ///     <SequenceWithMemory>
    ///       <Raise hand="left"/>
    ///       <Delay delay_msec="500">
    ///         <Lower/>
    ///       </Delay>
    ///     </SequenceWithMemory>
    ///   </BehaviorTree>
    ///   <TreeNodesModel>
    ///     <Action ID="Lower" editable="true"/>
    ///     <Action ID="Raise" editable="true">
    ///       <inout_port name="hand"/>
    ///     </Action>
    ///   </TreeNodesModel>
    /// </root>
    /// "#);
    /// # Ok::<(), bt::TreeError>(())
    /// ```
    #[must_use]
    pub fn to_xml(&self) -> String {
        let definitions = &self.library.definitions;
        let mut xml = Xml::new();
        let known = [("BTCPP_format", "4"), ("main_tree_to_execute", self.name())];
        xml.open("root", known.into_iter().chain(pairs(&self.library.kept)));
        let others = definitions.iter().enumerate().filter(|(place, _)| *place != self.main);
        xml.tree(self.name(), &definitions[self.main]);
        for (_, definition) in others {
            xml.tree(definition.id.as_deref().unwrap_or_default(), definition);
        }
        xml.models(&self.library);
        xml.close("root");
        xml.into_text()
    }
}

/// A document that is being written.
pub(super) struct Xml {
    text: String,
    depth: usize,
}

impl Xml {
    pub(super) fn new() -> Self {
        Self { text: "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n".to_owned(), depth: 0 }
    }

    pub(super) fn into_text(self) -> String {
        self.text
    }

    pub(super) fn tag<'a>(
        &mut self,
        element: &str,
        attributes: impl IntoIterator<Item = (&'a str, &'a str)>,
        end: &str,
    ) {
        self.put(format_args!("{:indent$}<{element}", "", indent = 2 * self.depth));
        for (name, value) in attributes {
            self.put(format_args!(" {name}=\"{}\"", attribute(value)));
        }
        self.put(format_args!("{end}\n"));
    }

    pub(super) fn open<'a>(&mut self, element: &str, attributes: impl IntoIterator<Item = (&'a str, &'a str)>) {
        self.tag(element, attributes, ">");
        self.depth += 1;
    }

    pub(super) fn close(&mut self, element: &str) {
        self.depth -= 1;
        self.put(format_args!("{:indent$}</{element}>\n", "", indent = 2 * self.depth));
    }

    fn put(&mut self, what: std::fmt::Arguments<'_>) {
        self.text += &what.to_string();
    }

    fn tree(&mut self, id: &str, definition: &Definition) {
        self.open("BehaviorTree", std::iter::once(("ID", id)).chain(pairs(&definition.kept)));
        // The open nodes, from the outermost.
        let mut open: Vec<(usize, &str)> = Vec::new();
        for (place, node) in definition.nodes.iter().enumerate() {
            while let Some((above, element)) = open.last()
                && node.parent != Some(*above)
            {
                self.close(element);
                open.pop();
            }
            let has_children = definition.nodes.get(place + 1).is_some_and(|next| next.parent == Some(place));
            self.node(node, if has_children { ">" } else { "/>" });
            if has_children {
                self.depth += 1;
                open.push((place, element_of(node)));
            }
        }
        for (_, element) in open.iter().rev() {
            self.close(element);
        }
        self.close("BehaviorTree");
    }

    fn node(&mut self, node: &Scanned, end: &str) {
        let id =
            matches!(element_of(node), "SubTree" | "Action" | "Condition").then_some(("ID", node.type_id.as_str()));
        self.tag(element_of(node), id.into_iter().chain(node.kept_attributes()), end);
    }

    /// The declarations of leaves, and of Nav2's nodes.
    pub(super) fn models(&mut self, library: &Library) {
        self.open("TreeNodesModel", []);
        let mut used = used_ports(&library.definitions);
        for (id, model) in &library.models {
            let undeclared = used.remove(id.as_str()).unwrap_or_default();
            if model.category != Category::SubTree || model.declares_more() {
                self.model(id, model, undeclared.into_iter().filter(|port| model.port(port).is_none()));
            }
        }
        // Groot does not have them.
        let used = library.definitions.iter().flat_map(|definition| &definition.nodes).map(|node| node.kind);
        let used: BTreeSet<&str> = used.filter(|kind| kind.is_of_nav2()).map(Kind::name).collect();
        for id in used.into_iter().filter(|id| !library.models.contains_key(*id)) {
            self.model(id, nav2_model(id).expect("Nav2's model has all its nodes"), std::iter::empty());
        }
        self.close("TreeNodesModel");
    }

    /// The declaration of a node, and its undeclared ports.
    fn model<'a>(&mut self, id: &str, model: &Model, undeclared: impl Iterator<Item = &'a str>) {
        let is_free = vocabulary::builtin(id).is_none() && model.kept.iter().all(|(name, _)| name != "editable");
        let editable = is_free.then_some(("editable", "true"));
        let attributes = std::iter::once(("ID", id)).chain(editable).chain(pairs(&model.kept));
        let mut undeclared = undeclared.peekable();
        if model.ports.is_empty() && model.notes.is_empty() && undeclared.peek().is_none() {
            self.tag(model.category.element(), attributes, "/>");
            return;
        }
        self.open(model.category.element(), attributes);
        for port in &model.ports {
            self.port(port);
        }
        for port in undeclared {
            self.tag(Direction::InOut.element(), [("name", port)], "/>");
        }
        for note in &model.notes {
            self.put(format_args!("{:indent$}{note}\n", "", indent = 2 * self.depth));
        }
        self.close(model.category.element());
    }

    fn port(&mut self, port: &PortModel) {
        let optional = [("type", &port.type_name), ("default", &port.default)];
        let optional = optional.into_iter().filter_map(|(name, value)| Some((name, value.as_deref()?)));
        let attributes = std::iter::once(("name", port.name.as_str())).chain(optional).chain(pairs(&port.kept));
        let element = port.direction.element();
        if port.description.is_empty() {
            self.tag(element, attributes, "/>");
        } else {
            self.tag(element, attributes, &format!(">{}</{element}>", text(&port.description)));
        }
    }
}

/// By leaf ID: the ports that are used anywhere.
fn used_ports(definitions: &[Definition]) -> BTreeMap<&str, BTreeSet<&str>> {
    let mut used: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    let leaves = definitions.iter().flat_map(|definition| &definition.nodes).filter(|node| node.kind.is_leaf());
    for leaf in leaves {
        let ports = leaf.kept_attributes().map(|(name, _)| name).filter(|name| is_port_name(name));
        used.entry(&leaf.type_id).or_default().extend(ports);
    }
    used
}

fn pairs(kept: &[(String, String)]) -> impl Iterator<Item = (&str, &str)> {
    kept.iter().map(|(name, value)| (name.as_str(), value.as_str()))
}

/// The element of a node. An ID that cannot be the name of an element, or that has another meaning, is written in
/// explicit form.
fn element_of(node: &Scanned) -> &str {
    element(node.kind, &node.type_id)
}

pub(super) fn element(kind: Kind, type_id: &str) -> &str {
    let is_name = |id: &str| {
        id.starts_with(|c: char| c.is_alphabetic() || c == '_')
            && id.chars().all(|c| c.is_alphanumeric() || matches!(c, '_' | '-'))
            && !matches!(id, "Root" | "root")
            && vocabulary::builtin(id).is_none()
            && vocabulary::explicit(id).is_none()
    };
    match kind {
        Kind::SubTree => "SubTree",
        kind if !kind.is_leaf() => kind.name(),
        _ if is_name(type_id) => type_id,
        kind => kind.name(),
    }
}
