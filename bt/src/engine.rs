//! The engine: how ticks and halts go through a tree.
//!
//! Nodes are in one array in document order, so that a node's children, and all that is below it, are a stretch behind
//! it. There is no stack: the way back up is each node's parent. The engine can stop at any leaf call, and what it needs
//! to go on is the statuses of the nodes and one [`Point`].

mod halting;

use std::time::Duration;

use halting::{After, Halting};

use crate::blackboard::Blackboard;
use crate::program::{Flags, Op, Program};
use crate::semantics::{
    Answer, Beginning, Memory, Reaction, Reading, Reset, Resume, Then, Which, begin, needs_reading, react,
};
use crate::settings::Entrance;
use crate::status::Mark;
use crate::{Call, Fault, Kind, Leaf, Leaves, NodeId, NodeState, Outcome, Reply, Request, Status, Step, Tree};

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

/// The leaves as the engine sees them: an answer may be a long time coming.
pub(crate) trait Answers {
    fn tick(&mut self, leaf: Leaf<'_>) -> Option<Status>;
    fn halt(&mut self, leaf: Leaf<'_>) -> Option<()>;
}

/// Leaves that answer at once.
pub(crate) struct Now<'a, L>(pub(crate) &'a mut L);

impl<L: Leaves> Answers for Now<'_, L> {
    #[inline]
    fn tick(&mut self, leaf: Leaf<'_>) -> Option<Status> {
        Some(self.0.tick(leaf))
    }

    #[inline]
    fn halt(&mut self, leaf: Leaf<'_>) -> Option<()> {
        self.0.halt(leaf);
        Some(())
    }
}

/// Leaves whose every call suspends the execution.
pub(crate) struct Later;

impl Answers for Later {
    fn tick(&mut self, _: Leaf<'_>) -> Option<Status> {
        None
    }

    fn halt(&mut self, _: Leaf<'_>) -> Option<()> {
        None
    }
}

/// What a run of the engine is about.
pub(crate) struct Context<'a, A> {
    tree: &'a Tree,
    now: Duration,
    leaves: A,
    /// The halting that is going on, if one is.
    halting: Halting,
}

impl<'a, A> Context<'a, A> {
    pub(crate) fn new(tree: &'a Tree, now: Duration, leaves: A) -> Self {
        Self { tree, now, leaves, halting: Halting::NONE }
    }

    #[inline]
    fn program(&self) -> &'a Program {
        &self.tree.program
    }

    #[inline]
    fn reset(&mut self, halting: Halting) -> Next {
        self.halting = halting;
        Next::Reset
    }

    fn op(&self, node: u32) -> Op {
        self.tree.program.ops[node as usize]
    }
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

    /// Ticks a node, if its scripts let it: what comes next, or none if it is a leaf that does not answer at once.
    #[inline]
    fn enter<A: Answers>(&mut self, context: &mut Context<'_, A>, node: u32) -> Option<Next> {
        if context.op(node).flags.has(Flags::ENTRANCE)
            && let Some(next) = self.turned_away(context, node)
        {
            return Some(next);
        }
        self.begin(context, node)
    }

    /// What comes next if a node's scripts say that it is not ticked.
    #[inline(never)]
    fn turned_away<A>(&mut self, context: &mut Context<'_, A>, node: u32) -> Option<Next> {
        let was = self.marks[node as usize].status();
        match context.program().hooks(node).enter(was, &mut self.board) {
            Ok(Entrance::Open) => None,
            Ok(Entrance::Closed(status)) => Some(Next::Answer(node, status)),
            Ok(Entrance::Left) => Some(context.reset(Halting::of_node(context.program(), node, After::Skip(node)))),
            Err(error) => {
                self.fault(node, error.to_string());
                Some(Next::Answer(node, Status::Failure))
            }
        }
    }

    /// Ticks a node: what comes next, or none if it is a leaf that does not answer at once.
    #[inline]
    fn begin<A: Answers>(&mut self, context: &mut Context<'_, A>, node: u32) -> Option<Next> {
        let Op { kind, .. } = context.op(node);
        let mark = &mut self.marks[node as usize];
        let was = *mark;
        *mark = was.entered();
        if kind.is_leaf() {
            let leaf = Leaf { id: NodeId(node), tree: context.tree, board: &mut self.board, now: context.now };
            return Some(Next::Answer(node, context.leaves.tick(leaf)?));
        }
        if kind.has_settings() {
            return Some(self.begin_with_settings(context, node, was));
        }
        // Such a node ticks a child in any case.
        self.marks[node as usize] = was.entered().begun();
        let memory = &mut self.memories[context.op(node).place as usize];
        let reading = Reading::Nothing;
        let beginning = Beginning { was: was.status(), reading, now: context.now, child_runs: false };
        Some(match begin(kind, memory, beginning) {
            Reaction::Do { then: Then::Tick(Which::Resumed), .. } => {
                Next::Enter(self.resume[node as usize].max(node + 1))
            }
            _ => Next::Enter(node + 1),
        })
    }

    /// Ticks a node that may have something to read.
    #[inline(never)]
    fn begin_with_settings<A>(&mut self, context: &mut Context<'_, A>, node: u32, was: Mark) -> Next {
        let Op { kind, place, end, .. } = context.op(node);
        let memory = &mut self.memories[place as usize];
        let mut reading = Reading::Nothing;
        if needs_reading(kind, memory, was.was_idle()) {
            match context.program().settings[place as usize].read(&mut self.board, was.was_idle(), kind) {
                Ok(read) => reading = read,
                Err(error) => return self.failed_to_read(context, node, error.to_string()),
            }
        }
        let child_runs = node + 1 < end && self.marks[node as usize + 1].is_running();
        let beginning = Beginning { was: was.status(), reading, now: context.now, child_runs };
        let reaction = begin(kind, memory, beginning);
        if kind.runs_when_begun() && matches!(reaction, Reaction::Do { then: Then::Tick(_), .. }) {
            self.marks[node as usize] = self.marks[node as usize].begun();
        }
        self.carry_out(context, node, 0, reaction)
    }

    /// A node fails because of its ports.
    #[cold]
    fn failed_to_read<A>(&mut self, context: &mut Context<'_, A>, node: u32, message: String) -> Next {
        self.fault(node, message);
        let after = After::Do(node, 0, Then::Answer(Status::Failure));
        self.forget(context.program(), node);
        context.reset(Halting::below(context.program(), node, after))
    }

    #[cold]
    fn fault(&mut self, node: u32, message: String) {
        self.faults.push(Fault { node: NodeId(node), message });
    }

    /// The root answers: what comes next, or the tree's answer.
    fn finish(&mut self, status: Status) -> Result<Next, Status> {
        if status.is_completed() {
            self.marks[0] = Mark::Idle;
        }
        if status == Status::Running && std::mem::take(&mut self.again) {
            if self.repeats < MAX_REPEATS {
                self.repeats += 1;
                return Ok(Next::Enter(0));
            }
            self.fault(0, TOO_MANY_REPEATS.to_owned());
        }
        self.point = Point::Idle;
        self.last = Some(status);
        Err(status)
    }

    /// A node answers, and its parent reacts.
    #[inline]
    fn answer<A>(&mut self, context: &mut Context<'_, A>, node: u32, mut status: Status) -> Result<Next, Status> {
        let Op { flags, parent, end: sibling, .. } = context.op(node);
        if flags.has(Flags::EXIT) {
            status = self.run_exit_scripts(context.program(), node, status);
        }
        let mark = self.marks[node as usize];
        self.marks[node as usize] = mark.answered(status);
        self.outcomes[node as usize] = Some(Outcome::Answered(status));
        if node == 0 {
            return self.finish(status);
        }
        let Op { kind, end, .. } = context.op(parent);
        let is_last = sibling == end;
        if !is_last && Some(status) == kind.goes_on_after() {
            return Ok(Next::Enter(sibling));
        }
        let answer = Answer { status: Some(status), was_idle: mark.was_idle(), is_last };
        Ok(self.react(context, parent, node, answer))
    }

    fn run_exit_scripts(&mut self, program: &Program, node: u32, status: Status) -> Status {
        match program.hooks(node).leave(status, &mut self.board) {
            Ok(()) => status,
            Err(error) => {
                self.fault(node, error.to_string());
                Status::Failure
            }
        }
    }

    /// A node reacts to what a child has answered.
    #[inline]
    fn react<A>(&mut self, context: &mut Context<'_, A>, node: u32, child: u32, answer: Answer) -> Next {
        let Op { kind, place, flags, .. } = context.op(node);
        let memory = &mut self.memories[place as usize];
        if kind == Kind::TryCatch && memory.catches {
            return context.reset(Halting::below(context.program(), node, After::Caught(node)));
        }
        if kind == Kind::RetryUntilSuccessful && answer.status == Some(Status::Failure) && flags.has(Flags::READS) {
            // The child may have changed the number of attempts.
            let setting = &context.program().settings[place as usize];
            if let Ok(Reading::Numbers(limits)) = setting.read(&mut self.board, false, kind) {
                memory.limits = limits;
            }
        }
        let reaction = react(kind, memory, answer);
        self.carry_out(context, node, child, reaction)
    }

    /// A child that is done is passed over, and its parent reacts to that.
    fn pass<A>(&mut self, context: &mut Context<'_, A>, node: u32) -> Next {
        let Op { parent, end: sibling, .. } = context.op(node);
        let answer = Answer { status: None, was_idle: false, is_last: sibling == context.op(parent).end };
        self.react(context, parent, node, answer)
    }

    /// Does what a node wants done; `here` is the child that answered.
    #[inline]
    fn carry_out<A>(&mut self, context: &mut Context<'_, A>, node: u32, here: u32, reaction: Reaction) -> Next {
        let program = context.program();
        let Reaction::Do { reset, resume, then } = reaction else {
            return self.do_then(program, node, here, Then::Tick(Which::Next));
        };
        match resume {
            Resume::Same => {}
            Resume::First => self.resume[node as usize] = 0,
            Resume::Here => self.resume[node as usize] = here,
            Resume::Next => self.resume[node as usize] = program.ops[here as usize].end,
        }
        let (start, end, spared) = match reset {
            Reset::None => return self.do_then(program, node, here, then),
            Reset::All => (node + 1, program.ops[node as usize].end, 0),
            Reset::Others => (node + 1, program.ops[node as usize].end, here),
            Reset::FromHere => (here, program.ops[node as usize].end, 0),
            Reset::Here => (here, program.ops[here as usize].end, 0),
            Reset::Nth(child) => match program.children(node).nth(child as usize) {
                Some(child) => (child, program.ops[child as usize].end, 0),
                None => return self.do_then(program, node, here, then),
            },
        };
        match self.reset_idle(program, start, end, spared) {
            None => self.do_then(program, node, here, then),
            Some(cursor) => context.reset(Halting::of_children(cursor, end, spared, After::Do(node, here, then))),
        }
    }

    /// Resets children up to the first that is running, and says which that is.
    #[inline]
    fn reset_idle(&mut self, program: &Program, start: u32, end: u32, spared: u32) -> Option<u32> {
        let mut child = start;
        while child < end {
            let mark = &mut self.marks[child as usize];
            if child != spared {
                if mark.is_running() {
                    return Some(child);
                }
                *mark = Mark::Idle;
            }
            child = program.ops[child as usize].end;
        }
        None
    }

    #[inline]
    fn do_then(&mut self, program: &Program, node: u32, here: u32, then: Then) -> Next {
        match then {
            Then::Tick(which) => {
                let child = match which {
                    Which::First => node + 1,
                    Which::Resumed => self.resume[node as usize].max(node + 1),
                    Which::Next => program.ops[here as usize].end,
                    Which::Nth(child) => program.children(node).nth(child as usize).unwrap_or(node + 1),
                    Which::Last => program.children(node).last().unwrap_or(node + 1),
                };
                let passes = program.ops[node as usize].kind.passes_over_completed();
                let is_done = passes && self.marks[child as usize].is_completed();
                if is_done { Next::Pass(child) } else { Next::Enter(child) }
            }
            Then::Answer(status) => Next::Answer(node, status),
            Then::Again => {
                self.again = true;
                Next::Answer(node, Status::Running)
            }
            Then::Fault(why) => {
                self.fault(node, why.to_owned());
                self.forget(program, node);
                Next::Answer(node, Status::Failure)
            }
        }
    }
}
