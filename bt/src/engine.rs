//! The engine: how ticks and halts go through a tree.
//!
//! Nodes are in one array in document order, so that a node's children, and all that is below it, are a stretch behind
//! it. There is no stack: the way back up is each node's parent. The engine can stop at any leaf call, and what it needs
//! to go on is the statuses of the nodes and one [`Point`].

use crate::reaction::{Answer, Reaction, Reset, Resume, react};
use crate::status::Mark;
use crate::tree::Op;
use crate::{Call, Kind, Leaves, NodeId, NodeState, Outcome, Reply, Request, Status, Step};

/// How the nodes of a tree stand, and where in a tick the tree is.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct State {
    marks: Box<[Mark]>,
    /// What happened to each node in the last tick.
    outcomes: Box<[Option<Outcome>]>,
    /// The child that the next tick of a node starts with; zero is the first.
    resume: Box<[u32]>,
    /// Somebody wants the tree ticked again at once.
    again: bool,
    point: Point,
    last: Option<Status>,
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

/// The resetting of a stretch of nodes, in document order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Halting {
    cursor: u32,
    end: u32,
    /// A node that is left alone, with all below it; zero is none.
    spared: u32,
    then: Then,
}

/// What comes after a resetting.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Then {
    /// This node answers that.
    Answer(u32, Status),
    /// The whole tree has been reset.
    Halted,
}

/// What the engine does next.
#[derive(Clone, Copy)]
pub(crate) enum Next {
    Enter(u32),
    Answer(u32, Status),
    Reset(Halting),
}

/// The leaves as the engine sees them: an answer may be a long time coming.
pub(crate) trait Answers {
    fn tick(&mut self, leaf: NodeId) -> Option<Status>;
    fn halt(&mut self, leaf: NodeId) -> Option<()>;
}

/// Leaves that answer at once.
pub(crate) struct Now<'a, L>(pub(crate) &'a mut L);

impl<L: Leaves> Answers for Now<'_, L> {
    #[inline]
    fn tick(&mut self, leaf: NodeId) -> Option<Status> {
        Some(self.0.tick(leaf))
    }

    #[inline]
    fn halt(&mut self, leaf: NodeId) -> Option<()> {
        self.0.halt(leaf);
        Some(())
    }
}

/// Leaves whose every call suspends the execution.
pub(crate) struct Later;

impl Answers for Later {
    fn tick(&mut self, _: NodeId) -> Option<Status> {
        None
    }

    fn halt(&mut self, _: NodeId) -> Option<()> {
        None
    }
}

impl Next {
    /// Halting the whole tree.
    pub(crate) fn reset_all(ops: &[Op]) -> Self {
        Self::Reset(Halting { cursor: 0, end: ops[0].end, spared: 0, then: Then::Halted })
    }
}

impl State {
    /// A tree of that many nodes before its first tick.
    pub(crate) fn new(count: usize) -> Self {
        Self {
            marks: vec![Mark::Idle; count].into(),
            outcomes: vec![None; count].into(),
            resume: vec![0; count].into(),
            again: false,
            point: Point::Idle,
            last: None,
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

    /// How all nodes stand. Those that are in the middle of their tick count as running.
    pub(crate) fn states(&self, ops: &[Op]) -> Vec<NodeState> {
        let state = |(mark, outcome): (&Mark, &Option<Outcome>)| NodeState { status: mark.status(), outcome: *outcome };
        let mut states: Vec<NodeState> = self.marks.iter().zip(&self.outcomes).map(state).collect();
        let under_way = match self.point {
            Point::Ticking(leaf) => Some(leaf),
            Point::Halting(Halting { then: Then::Answer(node, _), .. }) => Some(node),
            Point::Halting(_) | Point::Idle => None,
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
        Next::Enter(0)
    }

    /// The pending call, to be made again.
    pub(crate) fn pending_again(&self) -> Option<Next> {
        match self.point {
            Point::Idle => None,
            Point::Ticking(leaf) => Some(Next::Enter(leaf)),
            Point::Halting(halting) => Some(Next::Reset(halting)),
        }
    }

    /// What comes after that reply to the pending call, if it is one.
    pub(crate) fn replied(&mut self, reply: Reply) -> Option<Next> {
        match (self.point, reply) {
            (Point::Ticking(leaf), Reply::Status(status)) => Some(Next::Answer(leaf, status)),
            (Point::Halting(halting), Reply::Halted) => {
                self.halt_node(Kind::Action, halting.cursor);
                Some(Next::Reset(Halting { cursor: halting.cursor + 1, ..halting }))
            }
            _ => None,
        }
    }

    /// Goes on until the tick is over or a leaf does not answer at once.
    pub(crate) fn run(&mut self, ops: &[Op], mut next: Next, leaves: &mut impl Answers) -> Step {
        loop {
            next = match next {
                Next::Enter(node) => match self.enter(ops, node, leaves) {
                    Some(next) => next,
                    None => return self.suspend(Point::Ticking(node), node, Request::Tick),
                },
                Next::Answer(0, status) => match self.finish(status) {
                    Some(next) => next,
                    None => return Step::Done(status),
                },
                Next::Answer(node, status) => self.answer(ops, node, status),
                Next::Reset(halting) => match self.reset(ops, halting, leaves) {
                    Ok(Then::Answer(node, status)) => Next::Answer(node, status),
                    Ok(Then::Halted) => {
                        self.point = Point::Idle;
                        return Step::Halted;
                    }
                    Err(halting) => return self.suspend(Point::Halting(halting), halting.cursor, Request::Halt),
                },
            };
        }
    }

    fn suspend(&mut self, point: Point, leaf: u32, request: Request) -> Step {
        self.point = point;
        Step::Call(Call { leaf: NodeId(leaf), request })
    }

    /// Ticks a node: what comes next, or none if it is a leaf that does not answer at once.
    #[inline]
    fn enter(&mut self, ops: &[Op], node: u32, leaves: &mut impl Answers) -> Option<Next> {
        let mark = &mut self.marks[node as usize];
        *mark = mark.entered();
        Some(match ops[node as usize].kind {
            Kind::Condition | Kind::Action => Next::Answer(node, leaves.tick(NodeId(node))?),
            Kind::AlwaysSuccess => Next::Answer(node, Status::Success),
            Kind::AlwaysFailure => Next::Answer(node, Status::Failure),
            _ => Next::Enter(self.resume[node as usize].max(node + 1)),
        })
    }

    /// The root answers: what comes next, or none if the tick is over.
    fn finish(&mut self, status: Status) -> Option<Next> {
        self.outcomes[0] = Some(Outcome::Answered(status));
        self.marks[0] = if status == Status::Running { Mark::Running } else { Mark::Idle };
        let again = std::mem::take(&mut self.again);
        if again && status == Status::Running {
            return Some(Next::Enter(0));
        }
        self.point = Point::Idle;
        self.last = Some(status);
        None
    }

    /// A node answers, and its parent reacts.
    #[inline]
    fn answer(&mut self, ops: &[Op], node: u32, status: Status) -> Next {
        let mark = &mut self.marks[node as usize];
        let was_idle = *mark == Mark::Started;
        *mark = status.into();
        self.outcomes[node as usize] = Some(Outcome::Answered(status));

        let Op { parent, end: sibling, .. } = ops[node as usize];
        let Op { kind, end, .. } = ops[parent as usize];
        let (status, reset, resume) = match react(kind, Answer { status, was_idle, is_last: sibling == end }) {
            Reaction::Next => return Next::Enter(sibling),
            Reaction::Again => {
                self.again = true;
                self.resume[parent as usize] = sibling;
                return Next::Answer(parent, Status::Running);
            }
            Reaction::Answer { status, reset, resume } => (status, reset, resume),
        };
        self.resume[parent as usize] = match resume {
            Resume::First => 0,
            Resume::Here => node,
        };
        let (cursor, spared) = match reset {
            Reset::None => return Next::Answer(parent, status),
            Reset::All => (parent + 1, 0),
            Reset::Others => (parent + 1, node),
            Reset::FromHere => (node, 0),
        };
        Next::Reset(Halting { cursor, end, spared, then: Then::Answer(parent, status) })
    }

    /// Resets nodes until all are done, or until a leaf that is to halt does not do so at once (then the cursor is at
    /// that leaf). Nothing below a node that is not running is looked at, but when the whole tree is halted.
    #[inline]
    fn reset(&mut self, ops: &[Op], mut halting: Halting, leaves: &mut impl Answers) -> Result<Then, Halting> {
        while halting.cursor < halting.end {
            let node = halting.cursor;
            let Op { kind, end, .. } = ops[node as usize];
            if node == halting.spared && node != 0 {
                halting.cursor = end;
            } else if self.marks[node as usize].is_running() {
                if kind == Kind::Action && leaves.halt(NodeId(node)).is_none() {
                    return Err(halting);
                }
                self.halt_node(kind, node);
                halting.cursor += 1;
            } else {
                self.marks[node as usize] = Mark::Idle;
                halting.cursor = if halting.then == Then::Halted { node + 1 } else { end };
            }
        }
        Ok(halting.then)
    }

    fn halt_node(&mut self, kind: Kind, node: u32) {
        self.marks[node as usize] = Mark::Idle;
        self.outcomes[node as usize] = Some(Outcome::Halted);
        if kind.forgets() {
            self.resume[node as usize] = 0;
        }
    }
}
