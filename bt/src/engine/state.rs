//! How a tree stands.

use super::reset::Halting;
use crate::blackboard::Blackboard;
use crate::program::{Op, Program};
use crate::semantics::Memory;
use crate::status::Mark;
use crate::{Call, Fault, NodeId, NodeState, Outcome, Request, Status};

/// How the nodes of a tree stand, and where in a tick the tree is.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct State {
    pub(super) marks: Box<[Mark]>,
    /// What happened to each node in the last tick.
    pub(super) outcomes: Box<[Option<Outcome>]>,
    /// The child that the next tick of a node starts with; zero is the first.
    pub(super) resume: Box<[u32]>,
    /// What nodes remember, by their place.
    pub(super) memories: Box<[Memory]>,
    pub(crate) board: Blackboard,
    /// Somebody wants the tree ticked again at once.
    pub(super) again: bool,
    /// How often that has been done in this tick.
    pub(super) repeats: u32,
    pub(super) point: Point,
    /// Haltings that wait for a catch block.
    pub(super) outer: Vec<Halting>,
    pub(super) last: Option<Status>,
    pub(super) faults: Vec<Fault>,
}

/// Where an execution is suspended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Point {
    /// Between ticks.
    Idle,
    /// At the tick of this leaf.
    Ticking(u32),
    /// At the halt of the leaf at the cursor.
    Halting(Halting),
}

/// What the engine does next.
#[derive(Clone, Copy)]
pub(crate) enum Next {
    /// Ticks a node, if its scripts let it.
    Enter(u32),
    /// Ticks a node.
    Begin(u32),
    /// Passes over a child that is done.
    Pass(u32),
    Answer(u32, Status),
    /// Goes on with the [`Context`]'s halting.
    Reset,
}

impl State {
    /// A tree before its first tick.
    pub(crate) fn new(program: &Program) -> Self {
        let count = program.ops.len();
        let inner = (0..).zip(&program.ops).filter(|(_, op)| !op.kind.is_leaf());
        let memory = |(node, _)| Memory::new(u32::try_from(program.children(node).count()).unwrap_or(u32::MAX));
        Self {
            marks: vec![Mark::Idle; count].into(),
            outcomes: vec![None; count].into(),
            resume: vec![0; count].into(),
            memories: inner.map(memory).collect(),
            board: program.blackboard(),
            again: false,
            repeats: 0,
            point: Point::Idle,
            outer: Vec::new(),
            last: None,
            faults: Vec::new(),
        }
    }

    pub(crate) fn last_status(&self) -> Option<Status> {
        self.last
    }

    pub(crate) fn faults(&self) -> &[Fault] {
        &self.faults
    }

    pub(crate) fn pending(&self) -> Option<Call> {
        let (leaf, request) = match self.point {
            Point::Idle => return None,
            Point::Ticking(leaf) => (leaf, Request::Tick),
            Point::Halting(halting) => (halting.cursor, Request::Halt),
        };
        Some(Call { leaf: NodeId(leaf), request })
    }

    /// How all nodes stand. Those that are in the middle of their tick count as running.
    pub(crate) fn states(&self, ops: &[Op]) -> Vec<NodeState> {
        let state = |(mark, outcome): (&Mark, &Option<Outcome>)| NodeState { status: mark.status(), outcome: *outcome };
        let mut states: Vec<NodeState> = self.marks.iter().zip(&self.outcomes).map(state).collect();
        let under_way = match self.point {
            Point::Ticking(leaf) => Some(leaf),
            Point::Halting(halting) => halting.after.node(),
            Point::Idle => None,
        };
        let above = |node: &u32| (*node > 0).then(|| ops[*node as usize].parent);
        for node in std::iter::successors(under_way, above) {
            states[node as usize].outcome = Some(Outcome::Answered(Status::Running));
        }
        states
    }

    /// The start of a new tick.
    pub(crate) fn new_tick(&mut self) -> Next {
        self.outcomes.fill(None);
        self.faults.clear();
        self.repeats = 0;
        Next::Enter(0)
    }

    #[cold]
    pub(crate) fn fault(&mut self, node: u32, message: String) {
        self.faults.push(Fault { node: NodeId(node), message });
    }
}
