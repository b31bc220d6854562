//! Writing trees as BehaviorTree.CPP writes them while it runs them: in its logs, and for Groot2.

use std::collections::BTreeSet;

use super::write::{Xml, element};
use crate::{Kind, Node, Tree};

/// What is written in another form, or not at all.
const NOT_KEPT: [&str; 5] = ["ID", "name", "_autoremap", "_uid", "_fullpath"];

impl Tree {
    /// The tree in the form in which BehaviorTree.CPP sends it to Groot2 and logs it (`WriteTreeToXML` with
    /// metadata): the main tree first, and a `<BehaviorTree>` for each place where another one is used, with the path
    /// of that place; every node with its name and its number, `_uid`, which is one more than its index here; and the
    /// models of leaves, as in [`to_xml`](Self::to_xml). Left out is what the library leaves out, such as
    /// `_autoremap`, and the models of its own nodes, which Groot2 has.
    #[must_use]
    pub fn to_instance_xml(&self) -> String {
        let paths = self.instance_paths();
        let mut xml = Xml::new();
        xml.open("root", [("BTCPP_format", "4")]);
        self.instance(&mut xml, self.name(), 0, &paths);
        for node in self.nodes.iter().filter(|node| node.kind == Kind::SubTree) {
            self.instance(&mut xml, &node.type_id, node.number.index() + 1, &paths);
        }
        xml.models(&self.library);
        xml.close("root");
        xml.into_text()
    }

    /// The names of its blackboards, by the numbers that [`Blackboard::entries`](crate::Blackboard::entries) gives
    /// them: that of the main tree is its ID, and that of a subtree the path of its place.
    #[must_use]
    pub fn blackboard_names(&self) -> Vec<String> {
        let subtrees = self.instance_paths().into_iter().flatten();
        std::iter::once(self.name().to_owned()).chain(subtrees).collect()
    }

    /// The path of each subtree, by the indices of nodes; none for other nodes. No two are the same.
    fn instance_paths(&self) -> Vec<Option<String>> {
        let mut paths: Vec<Option<String>> = vec![None; self.nodes.len()];
        let mut taken = BTreeSet::new();
        for node in self.nodes.iter().filter(|node| node.kind == Kind::SubTree) {
            let around = self.around(node).and_then(|place| paths[place].as_ref());
            let within = around.map_or_else(String::new, |around| format!("{around}/"));
            let numbered = |name: &str| format!("{within}{name}::{}", uid(node));
            let named = node.name().filter(|name| !name.is_empty()).map(|name| format!("{within}{name}"));
            let path = named.filter(|path| !taken.contains(path)).unwrap_or_else(|| numbered(node.label()));
            taken.insert(path.clone());
            paths[node.number.index()] = Some(path);
        }
        paths
    }

    /// The index of the subtree in which a node is; none in the main tree.
    pub(super) fn around(&self, node: &Node) -> Option<usize> {
        let above = std::iter::successors(node.parent, |parent| self.node(*parent).parent);
        above.map(crate::NodeId::index).find(|place| self.nodes[*place].kind == Kind::SubTree)
    }

    /// Writes the tree that begins at this index, up to the subtrees in it.
    fn instance(&self, xml: &mut Xml, id: &str, start: usize, paths: &[Option<String>]) {
        let path = start.checked_sub(1).and_then(|subtree| paths[subtree].as_deref()).unwrap_or_default();
        xml.open("BehaviorTree", [("ID", id), ("_fullpath", path)]);
        let end = self.nodes.get(start).map_or(start, |root| root.subtree_end as usize);
        // The open nodes, from the outermost: where each ends, and its element.
        let mut open: Vec<(usize, &str)> = Vec::new();
        let mut place = start;
        while place < end {
            while let Some((_, element)) = open.pop_if(|(end, _)| *end <= place) {
                xml.close(element);
            }
            let node = &self.nodes[place];
            let (name, uid) = (element(node.kind, &node.type_id), uid(node).to_string());
            let identity = match &paths[place] {
                Some(path) => vec![("ID", node.type_id.as_str()), ("_fullpath", path)],
                None if name == node.type_id => vec![("name", node.label())],
                None => vec![("ID", node.type_id.as_str()), ("name", node.label())],
            };
            let own = node.attributes.iter().filter(|(name, _)| !NOT_KEPT.contains(&name.as_str()));
            let own = own.map(|(name, value)| (name.as_str(), value.as_str()));
            let attributes = identity.into_iter().chain([("_uid", uid.as_str())]).chain(own);
            let node_end = node.subtree_end as usize;
            if node.kind == Kind::SubTree || node_end == place + 1 {
                xml.tag(name, attributes, "/>");
                place = node_end;
            } else {
                xml.open(name, attributes);
                open.push((node_end, name));
                place += 1;
            }
        }
        for (_, element) in open.iter().rev() {
            xml.close(element);
        }
        xml.close("BehaviorTree");
    }
}

/// The number by which logs name a node.
fn uid(node: &Node) -> u32 {
    node.number.0 + 1
}
