//! A tree as one process per node.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use channels::{Capacity, ChannelSystem, Domain, Process, ProcessId, Topology, WiringError};

use super::board::{BlackboardProcess, board_answer_domain, board_question_domain, has_entries, leaf_domains};
use super::leaf::{LeafProcess, LeafWiring};
use super::node::{Child, InnerNode, NodeProcess, Role};
use super::protocol::{ChannelPair, Skill, find_channel, node_reply_domain, node_request_domain};
use super::whole::TreeProcess;
use crate::blackboard::Blackboard;
use crate::program::Flags;
use crate::semantics::PortReading;
use crate::{Fault, Kind, Node, NodeId, NodeState, NodeTransition, Outcome, Tree};

/// A process and its id in the topology, as a channel system expects them.
pub type WiredProcess = (ProcessId, Box<dyn Process>);

/// The processes of a tree whose nodes are processes, according to the paper's semantics: "the BT is a subsystem whose
/// nodes interact in a synchronous way".
///
/// Declares a member of the process `bt` for every node ("BT/3 ReactiveFallback"; an additional one for a leaf with
/// scripts, "BT/5 scripts of GoTo"), and handshake channels between them. If the tree uses its blackboard, that is a
/// member, too ("BT/blackboard"). The channels between the tree and other processes must already be declared (see
/// [`declare_channels`](crate::declare_channels)). `bt` itself has no behavior: it is composed of its members. To other
/// processes they behave like a [`TreeProcess`], with the same messages and the same numbers. `leaf_timeout` is the
/// time to wait for each leaf's answer.
///
/// # Errors
/// [`WiringError::MissingChannel`] if a channel between the tree and another process is missing,
/// [`WiringError::MissingProcess`] if there is no process `bt`, [`WiringError::DuplicateProcess`] if a member exists
/// already.
pub fn node_processes(
    tree: &Arc<Tree>,
    topology: &mut Topology,
    bt: &str,
    tick_generator: &str,
    leaf_timeout: Duration,
) -> Result<Vec<WiredProcess>, WiringError> {
    let missing = || WiringError::MissingProcess { process: bt.to_owned() };
    let whole = topology.find_process(bt).ok_or_else(missing)?;
    let ticks = find_channel(topology, bt, tick_generator, bt)?;
    let above_root = topology.member(whole, &format!("{bt}/root"))?;
    let mut composition = Composition {
        tree,
        topology,
        above_root,
        members: Vec::new(),
        leaves: BTreeMap::new(),
        pairs: BTreeMap::new(),
        board: None,
    };
    composition.declare_members(whole, bt)?;
    composition.declare_pairs()?;

    // The process above the root stands for the executor: it takes the ticks, and repeats one if a node requests that.
    let root = NodeProcess::new(Role::Root(ticks), vec![composition.child(above_root, tree.node(NodeId::ROOT))]);
    let mut processes: Vec<WiredProcess> = vec![(above_root, Box::new(root))];
    for node in tree.nodes().iter().filter(|node| composition.has_process(node)) {
        processes.push((composition.member(node), Box::new(composition.inner_node(node))));
    }
    for leaf in tree.leaves() {
        let skill = Skill::find(tree, leaf, composition.topology, bt)?;
        processes.push(composition.leaf(leaf, skill, leaf_timeout));
    }
    processes.extend(composition.board_process());
    Ok(processes)
}

/// The states of all nodes of a tree, in document order, for a tree that is the process `bt` of a system, in either
/// form.
#[must_use]
pub fn states_in(tree: &Tree, system: &ChannelSystem, bt: ProcessId) -> Vec<NodeState> {
    if let Some(process) = system.process::<TreeProcess>(bt) {
        return process.states();
    }
    let nodes = || members(system.topology(), bt).filter_map(|member| system.process::<NodeProcess>(member));
    let tick = nodes().find_map(NodeProcess::tree_tick);
    let mut states = vec![NodeState::default(); tree.nodes().len()];
    for node in nodes() {
        node.show(tick, &mut states);
    }
    states
}

/// Everything that has happened to nodes in the current tick, as far as this process has it: to all nodes if it is the
/// whole tree, to the children of its node if the tree's nodes are processes; nothing for any other process. If the
/// process was brought into normal form, everything since then.
#[must_use]
pub fn outcomes_known_to(process: &dyn Process) -> Vec<(NodeId, Outcome)> {
    if let Some(tree) = process.as_any().downcast_ref::<TreeProcess>() {
        return tree.execution().outcomes();
    }
    process.as_any().downcast_ref::<NodeProcess>().map_or_else(Vec::new, NodeProcess::outcomes)
}

/// The faults of a tree that is the process `bt` of a system: those of its last tick if it is one process, all so far
/// if its nodes are processes. A caller that reads them after every step of the system gets them all.
#[must_use]
pub fn faults_in(system: &ChannelSystem, bt: ProcessId) -> Vec<Fault> {
    members(system.topology(), bt).filter_map(|member| system.any_process(member)).flat_map(faults_known_to).collect()
}

/// The faults that a process has recorded, if it is (a part of) a tree.
#[must_use]
pub fn faults_known_to(process: &dyn Process) -> Vec<Fault> {
    let process = process.as_any();
    let of_tree = || process.downcast_ref().map(TreeProcess::faults);
    let of_board = || process.downcast_ref().map(BlackboardProcess::faults);
    let of_leaf = || process.downcast_ref().map(LeafProcess::faults);
    let several = of_tree().or_else(of_board).or_else(of_leaf).unwrap_or_default();
    several.iter().cloned().chain(process.downcast_ref().and_then(NodeProcess::fault)).collect()
}

/// Begins to note the changes of status of a tree that is the process `bt` of a system. If the tree's nodes are
/// processes, nothing is noted: they report to each other only what they need.
pub fn note_transitions_in(system: &mut ChannelSystem, bt: ProcessId) {
    if let Some(process) = system.process_mut::<TreeProcess>(bt) {
        process.execution_mut().note_transitions();
    }
}

/// The changes of status that have been [noted](note_transitions_in) since the last call.
pub fn take_transitions_in(system: &mut ChannelSystem, bt: ProcessId) -> Vec<NodeTransition> {
    system.process_mut::<TreeProcess>(bt).map_or_else(Vec::new, |process| process.execution_mut().take_transitions())
}

/// The blackboard of a tree that is the process `bt` of a system, in either form. `None` if the tree's nodes are
/// processes and do not use it.
#[must_use]
pub fn blackboard_in(system: &ChannelSystem, bt: ProcessId) -> Option<&Blackboard> {
    if let Some(process) = system.process::<TreeProcess>(bt) {
        return Some(process.execution().blackboard());
    }
    let board = |member| system.process::<BlackboardProcess>(member);
    members(system.topology(), bt).find_map(board).map(BlackboardProcess::blackboard)
}

/// Like [`blackboard_in`], but for writing: a robot's driver writes to it where the robot is.
pub fn blackboard_in_mut(system: &mut ChannelSystem, bt: ProcessId) -> Option<&mut Blackboard> {
    if system.process::<TreeProcess>(bt).is_some() {
        return system.process_mut::<TreeProcess>(bt).map(TreeProcess::blackboard_mut);
    }
    let is_board = |member: &ProcessId| system.process::<BlackboardProcess>(*member).is_some();
    let board = members(system.topology(), bt).find(is_board)?;
    system.process_mut::<BlackboardProcess>(board).map(BlackboardProcess::blackboard_mut)
}

/// The processes of a tree: those of its nodes, or the only one.
fn members(topology: &Topology, bt: ProcessId) -> impl Iterator<Item = ProcessId> {
    topology.processes().filter(move |member| topology.whole(*member) == bt)
}

struct Composition<'a> {
    tree: &'a Arc<Tree>,
    topology: &'a mut Topology,
    above_root: ProcessId,
    /// The process to which a node's parent sends: the node's own, or the one that runs its scripts.
    members: Vec<ProcessId>,
    /// The processes that communicate with skills.
    leaves: BTreeMap<NodeId, ProcessId>,
    /// The channels from a process that asks to one that answers, and back.
    pairs: BTreeMap<(ProcessId, ProcessId), ChannelPair>,
    board: Option<ProcessId>,
}

impl Composition<'_> {
    /// Whether a node has its own process: all but leaves without scripts do.
    fn has_process(&self, node: &Node) -> bool {
        !node.kind().is_leaf() || self.flags(node) != Flags::default()
    }

    fn flags(&self, node: &Node) -> Flags {
        self.tree.program.ops[node.id().index()].flags
    }

    fn declare_members(&mut self, whole: ProcessId, bt: &str) -> Result<(), WiringError> {
        for node in self.tree.nodes() {
            let name = match node.kind() {
                Kind::SubTree => node.kind().name(),
                kind if kind.is_leaf() => node.process(),
                _ => node.type_id(),
            };
            let mut member = self.topology.member(whole, &format!("{bt}/{} {name}", node.id()))?;
            if node.kind().is_leaf() {
                self.leaves.insert(node.id(), member);
                if self.has_process(node) {
                    member = self.topology.member(whole, &format!("{bt}/{} scripts of {name}", node.id()))?;
                }
            }
            self.members.push(member);
        }
        if self.tree.program.uses_blackboard() {
            self.board = Some(self.topology.member(whole, &format!("{bt}/blackboard"))?);
        }
        Ok(())
    }

    fn declare_pairs(&mut self) -> Result<(), WiringError> {
        for node in self.tree.nodes() {
            let own = self.member(node);
            self.declare_pair(self.parent(node), own, [node_request_domain(), node_reply_domain()])?;
            let leaf = self.leaf_of(node);
            if let Some(leaf) = leaf.filter(|leaf| *leaf != own) {
                self.declare_pair(own, leaf, [node_request_domain(), node_reply_domain()])?;
            }
            let Some(board) = self.board else { continue };
            if self.flags(node) != Flags::default() {
                self.declare_pair(own, board, [board_question_domain(), board_answer_domain()])?;
            }
            if let Some(leaf) = leaf.filter(|_| has_entries(self.tree, node.id())) {
                self.declare_pair(leaf, board, leaf_domains(self.tree, node.id()))?;
            }
        }
        Ok(())
    }

    fn declare_pair(
        &mut self,
        asking: ProcessId,
        answering: ProcessId,
        [questions, answers]: [Domain; 2],
    ) -> Result<(), WiringError> {
        let requests = self.topology.channel(asking, answering, Capacity::Zero, questions)?;
        let replies = self.topology.channel(answering, asking, Capacity::Zero, answers)?;
        self.pairs.insert((asking, answering), ChannelPair { requests, replies });
        Ok(())
    }

    fn member(&self, node: &Node) -> ProcessId {
        self.members[node.id().index()]
    }

    /// The process of a leaf that communicates with its skill.
    fn leaf_of(&self, node: &Node) -> Option<ProcessId> {
        self.leaves.get(&node.id()).copied()
    }

    /// The channels to the blackboard, if this process has any.
    fn to_board(&self, asking: ProcessId) -> Option<ChannelPair> {
        self.pairs.get(&(asking, self.board?)).copied()
    }

    fn parent(&self, node: &Node) -> ProcessId {
        node.parent().map_or(self.above_root, |parent| self.members[parent.index()])
    }

    fn child(&self, parent: ProcessId, node: &Node) -> Child {
        let is_guarded = node.kind().is_leaf() && self.has_process(node);
        Child { node: node.id(), kind: node.kind(), is_guarded, channels: self.pairs[&(parent, self.member(node))] }
    }

    fn inner_node(&self, node: &Node) -> NodeProcess {
        let own = self.member(node);
        let children = match self.leaf_of(node) {
            Some(leaf) => {
                let channels = self.pairs[&(own, leaf)];
                vec![Child { node: node.id(), kind: node.kind(), is_guarded: false, channels }]
            }
            None => self.tree.children(node.id()).map(|child| self.child(own, child)).collect(),
        };
        let reading = if node.kind().is_leaf() {
            PortReading::Nothing
        } else {
            self.tree.program.setting(node.id().0).constant().unwrap_or(PortReading::Nothing)
        };
        let node = InnerNode {
            id: node.id(),
            kind: node.kind(),
            flags: self.flags(node),
            reading,
            parent: self.pairs[&(self.parent(node), own)],
            board: self.to_board(own),
        };
        NodeProcess::new(Role::Node(node), children)
    }

    fn leaf(&self, leaf: &Node, skill: Skill, timeout: Duration) -> WiredProcess {
        let member = self.leaves[&leaf.id()];
        let asking = if self.has_process(leaf) { self.member(leaf) } else { self.parent(leaf) };
        let wiring = LeafWiring { skill, parent: self.pairs[&(asking, member)], board: self.to_board(member) };
        (member, Box::new(LeafProcess::new(wiring, timeout)))
    }

    fn board_process(&self) -> Option<WiredProcess> {
        let board = self.board?;
        let pairs =
            self.pairs.iter().filter(|((_, answering), _)| *answering == board).map(|(_, pair)| *pair).collect();
        Some((board, Box::new(BlackboardProcess::new(Arc::clone(self.tree), pairs))))
    }
}
