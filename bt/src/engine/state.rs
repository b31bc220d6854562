//! The state of a tree.

use channels::NormalForm;

use super::reset::Halting;
use crate::blackboard::Blackboard;
use crate::journal::Journal;
use crate::program::{Op, Program};
use crate::semantics::Memory;
use crate::status::{Mark, Outcomes};
use crate::{Call, Fault, NodeId, NodeState, NodeTransition, Outcome, Request, Status};

/// The state of a tree's nodes, and the position within a tick.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct TreeState {
    pub(super) marks: Box<[Mark]>,
    /// What happened to each node in the last tick.
    pub(super) outcomes: Box<[Outcomes]>,
    /// The child with which a node's next tick begins; zero is the first.
    pub(super) resume: Box<[u32]>,
    /// The memories of nodes, by their index among nodes with memory.
    pub(super) memories: Box<[Memory]>,
    pub(crate) board: Blackboard,
    /// Whether a node has asked for another tick of the tree.
    pub(super) again: bool,
    /// The number of such repetitions in this tick.
    pub(super) repeats: u32,
    pub(super) point: Point,
    /// Halts that wait for a catch block.
    pub(super) outer: Vec<Halting>,
    pub(super) last: Option<Status>,
    pub(crate) faults: Vec<Fault>,
    pub(super) journal: Journal,
}

/// The point at which an execution is suspended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Point {
    /// Between ticks.
    Idle,
    /// At the tick of this leaf.
    Ticking(u32),
    /// At the halt of the leaf at the cursor.
    Halting(Halting),
}

/// The engine's next action.
#[derive(Clone, Copy)]
pub(crate) enum Next {
    /// Tick a node, if its scripts permit.
    Enter(u32),
    /// Tick a node.
    Begin(u32),
    /// Skip a child that is done.
    Pass(u32),
    Answer(u32, Status),
    /// Continue the [`Context`]'s halt.
    Reset,
}

impl TreeState {
    /// A tree before its first tick.
    pub(crate) fn new(program: &Program) -> Self {
        let count = program.ops.len();
        let inner = (0..).zip(&program.ops).filter(|(_, op)| !op.kind.is_leaf());
        let memory = |(node, _)| Memory::new(u32::try_from(program.children(node).count()).unwrap_or(u32::MAX));
        Self {
            marks: vec![Mark::Idle; count].into(),
            outcomes: vec![Outcomes::default(); count].into(),
            resume: vec![0; count].into(),
            memories: inner.map(memory).collect(),
            board: program.blackboard(),
            again: false,
            repeats: 0,
            point: Point::Idle,
            outer: Vec::new(),
            last: None,
            faults: Vec::new(),
            journal: Journal::default(),
        }
    }

    pub(crate) fn last_status(&self) -> Option<Status> {
        self.last
    }

    pub(crate) fn pending(&self) -> Option<Call> {
        let (leaf, request) = match self.point {
            Point::Idle => return None,
            Point::Ticking(leaf) => (leaf, Request::Tick),
            Point::Halting(halting) => (halting.cursor, Request::Halt),
        };
        Some(Call { leaf: NodeId(leaf), request })
    }

    /// The states of all nodes. Nodes within their tick count as running.
    pub(crate) fn states(&self, ops: &[Op]) -> Vec<NodeState> {
        let state =
            |(mark, outcomes): (&Mark, &Outcomes)| NodeState { status: mark.status(), outcome: outcomes.last() };
        let mut states: Vec<NodeState> = self.marks.iter().zip(&self.outcomes).map(state).collect();
        for node in self.under_way(ops) {
            states[node as usize].outcome = Some(Outcome::Answered(Status::Running));
        }
        states
    }

    /// Everything that has happened to nodes in this tick. Nodes within their tick count as running.
    pub(crate) fn outcomes(&self, ops: &[Op]) -> Vec<(NodeId, Outcome)> {
        let known = (0..).zip(&self.outcomes).flat_map(|(node, outcomes)| outcomes.iter().map(move |it| (node, it)));
        let under_way = self.under_way(ops).map(|node| (node, Outcome::Answered(Status::Running)));
        known.chain(under_way).map(|(node, outcome)| (NodeId(node), outcome)).collect()
    }

    /// From now on, changes of status are noted.
    pub(crate) fn begin_journal(&mut self) {
        self.journal.begin(self.marks.iter().map(|mark| mark.reported()));
    }

    /// The changes of status since the last call.
    pub(crate) fn take_transitions(&mut self) -> Vec<NodeTransition> {
        self.journal.take()
    }

    /// Gives a node a mark, and notes its status.
    #[inline]
    pub(super) fn mark(&mut self, node: u32, mark: Mark) {
        self.marks[node as usize] = mark;
        self.journal.note(node, mark.reported());
    }

    /// The nodes within their tick.
    fn under_way<'a>(&self, ops: &'a [Op]) -> impl Iterator<Item = u32> + use<'a> {
        let deepest = match self.point {
            Point::Ticking(leaf) => Some(leaf),
            Point::Halting(halting) => halting.after.node(),
            Point::Idle => None,
        };
        std::iter::successors(deepest, |node| (*node > 0).then(|| ops[*node as usize].parent))
    }

    pub(crate) fn new_tick(&mut self) -> Next {
        self.outcomes.fill(Outcomes::default());
        self.faults.clear();
        self.repeats = 0;
        Next::Enter(0)
    }

    /// Brings the state into [normal form](NormalForm): what happened to nodes, the answer of the last tick and faults
    /// are only reported.
    pub(crate) fn normalize(&mut self, program: &Program, form: &NormalForm<'_>) {
        self.outcomes.fill(Outcomes::default());
        self.faults.clear();
        self.last = None;
        if matches!(self.point, Point::Idle) {
            self.repeats = 0;
        }
        for (op, node) in program.ops.iter().zip(0..).filter(|(op, _)| !op.kind.is_leaf()) {
            self.memories[op.place as usize].normalize(form, op.kind, program.setting(node).constant());
        }
        self.board.normalize(program.can_unset());
    }

    #[cold]
    pub(crate) fn fault(&mut self, node: u32, message: String) {
        self.faults.push(Fault { node: NodeId(node), message });
    }
}
