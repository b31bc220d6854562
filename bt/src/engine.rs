//! The engine: how ticks and halts go through a tree.
//!
//! Nodes are in one array in document order, so that a node's children, and all that is below it, are a stretch behind
//! it. There is no stack: the way back up is each node's parent. The engine can stop at any leaf call, and what it needs
//! to go on is the statuses of the nodes and one [`Point`].

mod answering;
mod context;
mod halting;
mod ticking;

pub(crate) use context::{Answers, Context, Later, Now};
use halting::{After, Halting};

use crate::blackboard::Blackboard;
use crate::program::{Op, Program};
use crate::semantics::Memory;
use crate::status::Mark;
use crate::{Call, Fault, NodeId, NodeState, Outcome, Reply, Request, Status, Step};

/// How often a tree is ticked again at most as part of one tick.
pub(crate) const MAX_REPEATS: u32 = 10_000;
/// What is said when it would be ticked more often.
pub(crate) const TOO_MANY_REPEATS: &str = "the tree wants to be ticked again and again, without end";

/// How the nodes of a tree stand, and where in a tick the tree is.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct State {
    marks: Box<[Mark]>,
    /// What happened to each node in the last tick.
    outcomes: Box<[Option<Outcome>]>,
    /// The child that the next tick of a node starts with; zero is the first.
    resume: Box<[u32]>,
    /// What nodes remember, by their place.
    memories: Box<[Memory]>,
    pub(crate) board: Blackboard,
    /// Somebody wants the tree ticked again at once.
    again: bool,
    /// How often that has been done in this tick.
    repeats: u32,
    point: Point,
    /// Haltings that wait for a catch block.
    outer: Vec<Halting>,
    last: Option<Status>,
    faults: Vec<Fault>,
}

/// Where an execution is suspended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Point {
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

    /// The pending call, to be made again.
    pub(crate) fn pending_again<A>(&self, context: &mut Context<'_, A>) -> Option<Next> {
        match self.point {
            Point::Idle => None,
            Point::Ticking(leaf) => Some(Next::Begin(leaf)),
            Point::Halting(halting) => Some(context.reset(halting)),
        }
    }

    /// What comes after that reply to the pending call, if it is one.
    pub(crate) fn replied<A>(&mut self, context: &mut Context<'_, A>, reply: Reply) -> Option<Next> {
        match (self.point, reply) {
            (Point::Ticking(leaf), Reply::Status(status)) => Some(Next::Answer(leaf, status)),
            (Point::Halting(halting), Reply::Halted) => {
                self.halted(context.program(), halting.cursor);
                let cursor = self.climb(context.program(), halting.start, halting.cursor);
                Some(context.reset(Halting { cursor, ..halting }))
            }
            _ => None,
        }
    }

    /// Goes on until the tick is over or a leaf does not answer at once.
    #[inline]
    pub(crate) fn run<A: Answers>(&mut self, context: &mut Context<'_, A>, mut next: Next) -> Step {
        loop {
            next = match next {
                Next::Enter(node) => match self.enter(context, node) {
                    Some(next) => next,
                    None => return self.suspend(Point::Ticking(node), node, Request::Tick),
                },
                Next::Begin(node) => match self.begin(context, node) {
                    Some(next) => next,
                    None => return self.suspend(Point::Ticking(node), node, Request::Tick),
                },
                Next::Answer(node, status) => match self.answer(context, node, status) {
                    Ok(next) => next,
                    Err(status) => return Step::Done(status),
                },
                Next::Pass(node) => self.pass(context, node),
                Next::Reset => match self.reset(context) {
                    Some(After::Halted) => {
                        self.point = Point::Idle;
                        return Step::Halted;
                    }
                    Some(after) => self.after_reset(context, after),
                    None => {
                        let halting = context.halting;
                        return self.suspend(Point::Halting(halting), halting.cursor, Request::Halt);
                    }
                },
            };
        }
    }

    fn suspend(&mut self, point: Point, leaf: u32, request: Request) -> Step {
        self.point = point;
        Step::Call(Call { leaf: NodeId(leaf), request })
    }

    #[cold]
    pub(crate) fn fault(&mut self, node: u32, message: String) {
        self.faults.push(Fault { node: NodeId(node), message });
    }
}
