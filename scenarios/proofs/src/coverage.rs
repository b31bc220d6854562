//! Everything that is never reached: nodes of the tree, states and transitions of machines; and the errors that occur.

use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, PoisonError};

use bt::{Fault, Node, NodeId, Outcome, Status, Tree, faults_known_to, outcomes_known_to};
use channels::{ChannelSystem, Process, ProcessId};
use diagnostics::Span;
use explorer::Onlooker;
use skills::{Chart, SkillProcess, StateId, TransitionId};

use super::faults::inside;

/// Something that never happens in any run.
#[derive(Clone, Debug)]
pub struct Unreached {
    /// Its kind.
    pub kind: Unreachable,
    /// The event that never happens: `GoToDestination never fails`.
    pub words: String,
    /// The location of the node, state or transition in its file.
    pub place: Span,
}

/// Items that may never be reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unreachable {
    /// A node of the tree, or a status that it returns.
    Node,
    /// A state of a machine.
    State,
    /// A transition of a machine.
    Transition,
}

impl Unreachable {
    /// In a word.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Node => "node",
            Self::State => "state",
            Self::Transition => "transition",
        }
    }
}

/// An error of the tree or of a machine, in some of the runs that were explored. What follows it is explored, too: a
/// property can be proved in spite of it.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Mistake {
    /// The node or the process, with the state if it is known: `BatteryLevel, state get`.
    pub place: String,
    /// The error, in words.
    pub message: String,
}

/// Observes everything that happens in a system.
#[derive(Debug)]
pub(super) struct Coverage {
    tree: Option<Arc<Tree>>,
    /// The processes that run a machine, by name.
    machines: Vec<(ProcessId, String, Arc<Chart>)>,
    seen: Mutex<Seen>,
}

/// Past events: nodes, states and transitions by their indices.
#[derive(Debug, Default)]
struct Seen {
    outcomes: BTreeSet<(usize, &'static str)>,
    states: BTreeSet<(ProcessId, usize)>,
    transitions: BTreeSet<(ProcessId, usize)>,
    mistakes: BTreeSet<Mistake>,
}

impl Coverage {
    pub(super) fn new(tree: Option<&Arc<Tree>>, system: &ChannelSystem) -> Self {
        let topology = system.topology();
        let machine = |id| {
            let chart = system.process::<SkillProcess>(id)?.machine().chart();
            Some((id, topology.name(id).to_owned(), Arc::clone(chart)))
        };
        let machines = topology.processes().filter_map(machine).collect();
        Self { tree: tree.cloned(), machines, seen: Mutex::default() }
    }

    /// Events that have never happened, in the order of the tree and the machines. Nodes below one that is never
    /// ticked, and states inside one that is never entered, are left out.
    pub(super) fn unreached(&self) -> Vec<Unreached> {
        let seen = self.seen.lock().unwrap_or_else(PoisonError::into_inner);
        let mut unreached: Vec<Unreached> = self.tree.iter().flat_map(|tree| of_tree(tree, &seen)).collect();
        for (process, name, chart) in &self.machines {
            of_machine(*process, name, chart, &seen, &mut unreached);
        }
        unreached
    }

    pub(super) fn mistakes(&self) -> Vec<Mistake> {
        self.seen.lock().unwrap_or_else(PoisonError::into_inner).mistakes.iter().cloned().collect()
    }

    fn of_node(&self, Fault { node, message }: Fault) -> Mistake {
        let label = self.tree.as_ref().map_or("", |tree| tree.node(node).process());
        Mistake { place: format!("{label} (node {node})"), message }
    }
}

impl Onlooker for Coverage {
    fn see(&self, id: ProcessId, process: &dyn Process) {
        let mut seen = self.seen.lock().unwrap_or_else(PoisonError::into_inner);
        let outcomes = outcomes_known_to(process);
        seen.outcomes.extend(outcomes.into_iter().map(|(node, outcome)| (node.index(), outcome.name())));
        seen.mistakes.extend(faults_known_to(process).into_iter().map(|fault| self.of_node(fault)));
        let Some(skill) = inside(process).as_any().downcast_ref::<SkillProcess>() else { return };
        let machine = skill.machine();
        seen.mistakes.extend(skill.mishaps().iter().map(|mishap| {
            let of = self.machines.iter().find(|(known, ..)| *known == id).map_or("", |(_, name, _)| name);
            Mistake { place: mishap.place(of), message: mishap.message.clone() }
        }));
        // A fault may have replaced its machine.
        if self.machines.iter().any(|(known, _, chart)| *known == id && Arc::ptr_eq(chart, machine.chart())) {
            seen.states.extend(machine.entered().map(|state| (id, state.index())));
            seen.transitions.extend(machine.taken().map(|transition| (id, transition.index())));
        }
    }
}

/// The skills, and the nodes of the tree, whose errors a system still has: a tree begins each tick without those of
/// the last one. After every step of the system, a caller sees them all.
pub(super) fn failed(tree: Option<&Arc<Tree>>, system: &ChannelSystem) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    for id in system.topology().processes() {
        let Some(process) = system.any_process(id) else { continue };
        let nodes = faults_known_to(process).into_iter().zip(tree.into_iter().cycle());
        names.extend(nodes.map(|(Fault { node, .. }, tree)| tree.node(node).process().to_owned()));
        let skill = inside(process).as_any().downcast_ref::<SkillProcess>();
        names.extend(skill.filter(|skill| !skill.mishaps().is_empty()).map(|_| system.topology().name(id).to_owned()));
    }
    names
}

fn of_tree(tree: &Tree, seen: &Seen) -> Vec<Unreached> {
    let has = |node: NodeId, outcome: Outcome| seen.outcomes.contains(&(node.index(), outcome.name()));
    let answers = |node, status| has(node, Outcome::Answered(status));
    // A node that is only skipped is not ticked: a script prevents it, or all its children are skipped.
    let is_ticked = |node| {
        has(node, Outcome::Halted)
            || [Status::Running, Status::Success, Status::Failure].iter().any(|status| answers(node, *status))
    };
    let mut unreached = Vec::new();
    for node in tree.nodes() {
        let id = node.id();
        let mut add = |what: &str| {
            let source = &tree.sources()[node.file()];
            let span = node.span();
            let place = source.span(span.offset()..span.offset() + span.len());
            unreached.push(Unreached { kind: Unreachable::Node, words: format!("{} {what}", named(node)), place });
        };
        if !is_ticked(id) {
            if node.parent().is_none_or(is_ticked) {
                add("is never ticked");
            }
            continue;
        }
        for (status, what) in [(Status::Success, "never succeeds"), (Status::Failure, "never fails")] {
            if node.kind().may_answer(status) && !answers(id, status) {
                add(what);
            }
        }
    }
    unreached
}

fn named(node: &Node) -> String {
    if node.kind().is_leaf() { node.process().to_owned() } else { format!("{} ({})", node.label(), node.id()) }
}

fn of_machine(process: ProcessId, name: &str, chart: &Chart, seen: &Seen, unreached: &mut Vec<Unreached>) {
    let is_entered = |state: StateId| state == chart.root() || seen.states.contains(&(process, state.index()));
    for state in chart.states().filter(|state| *state != chart.root()) {
        let written = chart.state(state);
        if matches!(written.kind(), skills::StateKind::History(_)) || !written.parent().is_none_or(is_entered) {
            continue;
        }
        let place = |range| chart.file().span(range);
        if !is_entered(state) {
            let words = format!("{name}: the state `{}` is never entered", written.id());
            unreached.push(Unreached { kind: Unreachable::State, words, place: place(written.span()) });
            continue;
        }
        let is_taken = |id: &TransitionId| seen.transitions.contains(&(process, id.index()));
        for id in written.transitions().iter().filter(|id| !is_taken(id)) {
            let transition = chart.transition(*id);
            let label = chart.label(transition);
            let words = format!("{name}: in `{}`, the transition {label} is never taken", written.id());
            unreached.push(Unreached { kind: Unreachable::Transition, words, place: place(transition.span()) });
        }
    }
}
