//! The tree of a log.
//!
//! It is not written as trees usually are. There is a `BehaviorTree` for every place where a tree is used, so several
//! have the same ID; the first one is the main tree; and a `SubTree` refers to its tree by the path of both. Every node
//! has its number, `_uid`, by which transitions name it. Nodes may be of any kind: what they do does not matter here.

use std::collections::BTreeMap;

use bt::{Kind, Tree};
use roxmltree::{Document, Node as Element, ParsingOptions};

use crate::status::{LoggedTransition, NodeStatus, StatusChange};

/// The most bytes that the XML of a tree may have. A node takes some two hundred.
pub(crate) const MAX_XML_BYTES: usize = 64 << 20;

/// The most elements and attributes: more than there are numbers for nodes, as each may have ports.
const MAX_PARTS: u32 = 1 << 20;

/// A node of a tree that was logged.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LoggedNode {
    /// The index of its parent, which comes before it; none for the root.
    pub parent: Option<usize>,
    /// Its number in the log.
    pub uid: u16,
    /// The name under which its kind is registered; for a subtree, the ID of its tree.
    pub type_id: String,
    /// Its instance name: the attribute `name`, or else the same.
    pub name: String,
    /// Its full path, as BehaviorTree.CPP has it: the path of the tree that it belongs to, and its name, with its
    /// number if it has no name of its own: `Fetch/GoTo::7`.
    pub path: String,
    /// Its kind, if it is one that BehaviorTree.CPP or Nav2 brings.
    pub kind: Option<Kind>,
    /// Whether it has no children.
    pub is_leaf: bool,
}

/// A tree as BehaviorTree.CPP sends it while it runs it, or logs it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LoggedTree {
    /// In document order: the root is the first, and every node comes after its parent.
    nodes: Vec<LoggedNode>,
    /// Their indices by their numbers.
    numbers: BTreeMap<u16, usize>,
    blackboards: Vec<String>,
}

impl LoggedTree {
    /// Reads its XML.
    ///
    /// # Errors
    /// What in it cannot be so, in words.
    pub fn read(xml: &str) -> Result<Self, String> {
        let options = ParsingOptions { nodes_limit: MAX_PARTS, ..ParsingOptions::default() };
        let document = Document::parse_with_options(xml, options);
        put_together(document.map_err(|error| format!("its tree is not XML: {error}"))?.root_element())
    }

    /// A tree as it is written for BehaviorTree.CPP, with the numbers that it gives the nodes.
    #[must_use]
    pub fn of(tree: &Tree) -> Self {
        let mut blackboards = vec![tree.name().to_owned()];
        let (mut nodes, mut numbers) = (Vec::<LoggedNode>::new(), BTreeMap::new());
        // The path of the tree below each node; empty in the main tree.
        let mut paths: Vec<String> = Vec::new();
        for node in tree.nodes() {
            // No transition has a greater number.
            let uid = u16::try_from(nodes.len() + 1).unwrap_or(u16::MAX);
            numbers.insert(uid, nodes.len());
            let parent = node.parent().map(bt::NodeId::index);
            let above = parent.map_or("", |parent| paths[parent].as_str());
            let (type_id, name) = (node.type_id().to_owned(), node.label().to_owned());
            let own = if name == type_id { format!("{name}::{uid}") } else { name.clone() };
            let path = if above.is_empty() { own } else { format!("{above}/{own}") };
            if node.kind() == Kind::SubTree {
                blackboards.push(path.clone());
                paths.push(path.clone());
            } else {
                paths.push(above.to_owned());
            }
            let kind = Some(node.kind()).filter(|kind| !kind.is_leaf());
            let is_leaf = tree.children(node.id()).next().is_none();
            nodes.push(LoggedNode { parent, uid, type_id, name, path, kind, is_leaf });
        }
        Self { nodes, numbers, blackboards }
    }

    /// The nodes in document order: the root is the first, and every node comes after its parent.
    #[must_use]
    pub fn nodes(&self) -> &[LoggedNode] {
        &self.nodes
    }

    /// The names of its blackboards: the ID of the main tree, and the paths of the subtrees.
    #[must_use]
    pub fn blackboards(&self) -> &[String] {
        &self.blackboards
    }

    /// What a transition means for this tree.
    ///
    /// # Errors
    /// What in it cannot be so, in words.
    pub fn change(&self, transition: LoggedTransition) -> Result<StatusChange, String> {
        let LoggedTransition { at_us, uid, status } = transition;
        let node = u16::try_from(uid).ok().and_then(|uid| self.numbers.get(&uid));
        let node = *node.ok_or_else(|| format!("its tree has no node with the number {uid}"))?;
        let known = NodeStatus::of(status);
        let status = known.ok_or_else(|| format!("there is no status with the number {status}"))?;
        Ok(StatusChange { at_us, node, before: None, status })
    }
}

fn put_together(root: Element<'_, '_>) -> Result<LoggedTree, String> {
    let trees = root.children().filter(|child| child.has_tag_name("BehaviorTree"));
    let mut by_path: BTreeMap<&str, Element<'_, '_>> = BTreeMap::new();
    for tree in trees {
        let path = tree.attribute("_fullpath").unwrap_or_default();
        if by_path.insert(path, tree).is_some() {
            return Err(format!("its tree has two trees with the path `{path}`"));
        }
    }
    let main = root.children().find(|child| child.has_tag_name("BehaviorTree"));
    let main = main.ok_or_else(|| "it has no tree".to_owned())?;
    let main = by_path.remove(main.attribute("_fullpath").unwrap_or_default()).unwrap_or(main);
    let (mut nodes, mut numbers) = (Vec::new(), BTreeMap::new());
    let main_path = main.attribute("_fullpath").filter(|path| !path.is_empty());
    let mut blackboards = vec![main_path.or(main.attribute("ID")).unwrap_or_default().to_owned()];
    // Depth first, in document order, without recursion: how deep a tree goes is up to the file.
    let mut waiting: Vec<(Element<'_, '_>, Option<usize>, &str)> = Vec::new();
    waiting.extend(only_child(main)?.map(|top| (top, None, "")));
    while let Some((element, parent, tree_path)) = waiting.pop() {
        let node = node(element, parent, tree_path)?;
        let index = nodes.len();
        if numbers.insert(node.uid, index).is_some() {
            return Err(format!("its tree has two nodes with the number {}", node.uid));
        }
        let below = waiting.len();
        if node.kind == Some(Kind::SubTree) {
            let (path, tree) = subtree(element, &node, &mut by_path)?;
            blackboards.push(path.to_owned());
            waiting.extend(only_child(tree)?.map(|top| (top, Some(index), path)));
        } else {
            let children = element.children().filter(Element::is_element);
            waiting.extend(children.map(|child| (child, Some(index), tree_path)));
        }
        waiting[below..].reverse();
        nodes.push(LoggedNode { is_leaf: waiting.len() == below, ..node });
    }
    if nodes.is_empty() {
        Err("its tree has no node".to_owned())
    } else {
        Ok(LoggedTree { nodes, numbers, blackboards })
    }
}

/// The single node of a tree's element; none if it has none.
fn only_child<'x>(tree: Element<'x, 'x>) -> Result<Option<Element<'x, 'x>>, String> {
    let mut children = tree.children().filter(Element::is_element);
    match (children.next(), children.next()) {
        (_, Some(_)) => Err(format!("the tree `{}` has more than one node", tree.attribute("ID").unwrap_or_default())),
        (only, None) => Ok(only),
    }
}

/// A node without its children.
fn node(element: Element<'_, '_>, parent: Option<usize>, tree_path: &str) -> Result<LoggedNode, String> {
    let tag = element.tag_name().name();
    let uid = element.attribute("_uid").and_then(|uid| uid.parse::<u16>().ok());
    let uid = uid.ok_or_else(|| format!("the node <{tag}> of its tree has no number `_uid`"))?;
    let kind = Kind::BUILTIN.into_iter().chain([Kind::SubTree]).find(|kind| kind.name() == tag);
    let type_id = element.attribute("ID").unwrap_or(tag);
    let number = format!("::{uid}");
    // A subtree has its path, which ends with its name, instead of that.
    let of_path = element.attribute("_fullpath").and_then(|path| path.rsplit('/').next());
    let of_path = of_path.map(|name| name.strip_suffix(&number).unwrap_or(name));
    let name = element.attribute("name").or(of_path).filter(|name| !name.is_empty()).unwrap_or(type_id);
    let own = if name == type_id { name.to_owned() + &number } else { name.to_owned() };
    let path = if tree_path.is_empty() { own } else { format!("{tree_path}/{own}") };
    Ok(LoggedNode { parent, uid, type_id: type_id.to_owned(), name: name.to_owned(), path, kind, is_leaf: true })
}

/// The tree to which a subtree's node refers, with its path. A tree belongs to one node only.
fn subtree<'x>(
    element: Element<'x, 'x>,
    node: &LoggedNode,
    by_path: &mut BTreeMap<&'x str, Element<'x, 'x>>,
) -> Result<(&'x str, Element<'x, 'x>), String> {
    let path = element.attribute("_fullpath").unwrap_or_default();
    // If its name is that of its tree, the node's path ends with its number, and the tree's path does not.
    let named = path.strip_suffix(&format!("::{}", node.uid)).unwrap_or(path);
    let found = [path, named].into_iter().find_map(|path| by_path.remove_entry(path));
    found.ok_or_else(|| format!("its subtree `{path}` has no tree, or shares one with another node"))
}
