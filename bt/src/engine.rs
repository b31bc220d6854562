//! The engine: how ticks and halts pass through a tree.
//!
//! Nodes are in one array in document order, so a node's descendants directly follow it. There is no stack: the way
//! back up is each node's parent. The engine can stop at any leaf call; to continue, it needs only the statuses of the
//! nodes and one [`Point`].

mod answering;
mod context;
mod halting;
mod reset;
mod state;
mod ticking;

pub(crate) use context::{Answers, Context, Later, Now};
use reset::{After, Halting};
use state::Point;
pub(crate) use state::{Next, TreeState};

use crate::{Call, NodeId, Progress, Reply, Request};

/// The maximum number of repeated ticks of a tree within one tick. BehaviorTree.CPP has no limit: such a tree never
/// returns. The number is chosen, not measured.
pub(crate) const MAX_REPEATS: u32 = 10_000;
/// The message if the limit is exceeded.
pub(crate) const TOO_MANY_REPEATS: &str = "the tree keeps asking to be ticked again";

impl TreeState {
    /// The pending call, to be repeated.
    pub(crate) fn pending_again<A>(&self, context: &mut Context<'_, A>) -> Option<Next> {
        match self.point {
            Point::Idle => None,
            Point::Ticking(leaf) => Some(Next::Begin(leaf)),
            Point::Halting(halting) => Some(context.reset(halting)),
        }
    }

    /// The continuation after this reply to the pending call, if it is one.
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

    /// Continues until the tick is finished or a leaf does not answer at once.
    #[inline]
    pub(crate) fn run<A: Answers>(&mut self, context: &mut Context<'_, A>, mut next: Next) -> Progress {
        // One loop for the way down, the way up and resets: when a leaf suspends it, no call is under way.
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
                    Err(status) => return Progress::Done(status),
                },
                Next::Pass(node) => self.pass(context, node),
                Next::Reset => match self.reset(context) {
                    Some(After::Halted) => {
                        self.point = Point::Idle;
                        return Progress::Halted;
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

    fn suspend(&mut self, point: Point, leaf: u32, request: Request) -> Progress {
        self.point = point;
        Progress::Call(Call { leaf: NodeId(leaf), request })
    }
}
