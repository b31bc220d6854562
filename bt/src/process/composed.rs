//! A tree as a process for every node.

use std::collections::BTreeMap;

use channels::{Capacity, ChannelSystem, Domain, FieldKind, Process, ProcessId, Shape, Topology, WiringError};

use super::leaf::LeafProcess;
use super::node::{Child, NodeProcess, Role};
use super::protocol::{LeafIds, Line, find_channel};
use super::whole::TreeProcess;
use crate::{Kind, Node, NodeId, NodeState, Tree};

/// A process and its place in the topology, as a channel system takes them.
pub type WiredProcess = (ProcessId, Box<dyn Process>);

/// The processes of a tree whose nodes are processes, which are the paper's semantics: "the BT is a subsystem whose
/// nodes interact in a synchronous way".
///
/// Declares a member of the process `bt` for every node ("BT/3 ReactiveFallback"; one for all leaves of the same ID),
/// and handshake channels between them. The channels between the tree and the others are declared already (see
/// [`declare_channels`](crate::declare_channels)). `bt` itself gets no behaviour: it is the sum of its members. To
/// everybody else they do what a [`TreeProcess`] does, message for message and number for number.
///
/// # Errors
/// [`WiringError::MissingChannel`] if a channel between the tree and the others is missing,
/// [`WiringError::MissingProcess`] if there is no process `bt`, [`WiringError::DuplicateProcess`] if a member is there
/// already.
pub fn node_processes(
    tree: &Tree,
    topology: &mut Topology,
    bt: &str,
    tick_generator: &str,
) -> Result<Vec<WiredProcess>, WiringError> {
    let missing = || WiringError::MissingProcess { process: bt.to_owned() };
    let whole = topology.find_process(bt).ok_or_else(missing)?;
    let ticks = find_channel(topology, bt, tick_generator, bt)?;
    let leaf_ids = LeafIds::of(tree);
    let mut composition = Composition { tree, topology, leaf_ids, members: Vec::new(), lines: BTreeMap::new() };
    let above_root = composition.topology.member(whole, &format!("{bt}/root"))?;
    composition.declare_members(whole, bt)?;
    composition.declare_lines(above_root)?;

    let root = NodeProcess::new(Role::Root(ticks), vec![composition.child(above_root, tree.node(NodeId::ROOT))]);
    let mut processes: Vec<WiredProcess> = vec![(above_root, Box::new(root))];
    for node in tree.nodes().iter().filter(|node| !node.kind().is_leaf()) {
        processes.push((composition.member(node), Box::new(composition.inner_node(above_root, node))));
    }
    for (place, id) in composition.leaf_ids.ids().enumerate() {
        let line = Line::find(composition.topology, bt, id)?;
        processes.push(composition.leaf(place, id, line));
    }
    Ok(processes)
}

/// How all nodes of a tree stand, in document order, where the tree is the process `bt` of a system: in one process or
/// in one for every node.
#[must_use]
pub fn states_in(tree: &Tree, system: &ChannelSystem, bt: ProcessId) -> Vec<NodeState> {
    if let Some(process) = system.process::<TreeProcess>(bt) {
        return process.states();
    }
    let topology = system.topology();
    let members = || topology.processes().filter(|member| topology.whole(*member) == bt);
    let nodes = || members().filter_map(|member| system.process::<NodeProcess>(member));
    let tick = nodes().find_map(NodeProcess::tree_tick);
    let mut states = vec![NodeState::default(); tree.nodes().len()];
    for node in nodes() {
        node.show(tick, &mut states);
    }
    states
}

struct Composition<'a> {
    tree: &'a Tree,
    topology: &'a mut Topology,
    leaf_ids: LeafIds,
    /// The process of each node; leaves of one ID have the same.
    members: Vec<ProcessId>,
    /// The channels from a parent to a child and back. A parent has one pair for all its leaves of one ID.
    lines: BTreeMap<(ProcessId, ProcessId), Line>,
}

impl Composition<'_> {
    fn declare_members(&mut self, whole: ProcessId, bt: &str) -> Result<(), WiringError> {
        let mut leaves: BTreeMap<usize, ProcessId> = BTreeMap::new();
        for node in self.tree.nodes() {
            let place = self.leaf_ids.place(node.id().index());
            let member = match place.and_then(|place| leaves.get(&place)) {
                Some(member) => *member,
                None => {
                    let name = if node.kind() == Kind::SubTree { node.kind().name() } else { node.type_id() };
                    self.topology.member(whole, &format!("{bt}/{} {name}", node.id()))?
                }
            };
            leaves.extend(place.map(|place| (place, member)));
            self.members.push(member);
        }
        Ok(())
    }

    fn declare_lines(&mut self, above_root: ProcessId) -> Result<(), WiringError> {
        for node in self.tree.nodes() {
            let ends @ (parent, child) = (self.parent(above_root, node), self.member(node));
            if self.lines.contains_key(&ends) {
                continue;
            }
            let requests = self.topology.channel(parent, child, Capacity::Zero, question_domain())?;
            let replies = self.topology.channel(child, parent, Capacity::Zero, said_domain())?;
            self.lines.insert(ends, Line { requests, replies });
        }
        Ok(())
    }

    fn member(&self, node: &Node) -> ProcessId {
        self.members[node.id().index()]
    }

    fn parent(&self, above_root: ProcessId, node: &Node) -> ProcessId {
        node.parent().map_or(above_root, |parent| self.members[parent.index()])
    }

    fn child(&self, parent: ProcessId, node: &Node) -> Child {
        Child { node: node.id(), kind: node.kind(), line: self.lines[&(parent, self.member(node))] }
    }

    fn inner_node(&self, above_root: ProcessId, node: &Node) -> NodeProcess {
        let own = self.member(node);
        let line = self.lines[&(self.parent(above_root, node), own)];
        let children = self.tree.children(node.id()).map(|child| self.child(own, child)).collect();
        NodeProcess::new(Role::Node(node.kind(), line), children)
    }

    fn leaf(&self, place: usize, id: &str, skill: Line) -> WiredProcess {
        let nodes = || self.tree.leaves().filter(|leaf| self.leaf_ids.place(leaf.id().index()) == Some(place));
        let member = self.member(nodes().next().expect("every leaf ID is that of a leaf"));
        let parents = self.lines.iter().filter(|((_, child), _)| *child == member).map(|(_, line)| *line).collect();
        (member, Box::new(LeafProcess::new(id.to_owned(), skill, self.leaf_ids.halts(place), parents)))
    }
}

/// What a node asks another: `[<tick>, n]` or `[<halt>, n]`, n being the number of the tree's tick.
fn question_domain() -> Domain {
    Domain::new([Shape::new([("request", FieldKind::symbols(["tick", "halt"])), ("tick", FieldKind::Int)])])
}

/// What a node answers another.
fn said_domain() -> Domain {
    let said = FieldKind::symbols(["running", "again", "success", "failure", "halted"]);
    Domain::new([Shape::new([("reply", said)])])
}
