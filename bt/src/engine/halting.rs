//! Resetting nodes, and halting those that run.

use super::{Answers, Context, Next, State};
use crate::program::{Flags, Op, Program};
use crate::semantics::{Reading, Then};
use crate::status::Mark;
use crate::{Kind, Leaf, NodeId, Outcome, Status};

/// The resetting of a stretch of nodes, in document order: a node, or some neighbouring children of one node, with all
/// that is below.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Halting {
    pub(super) cursor: u32,
    /// Where the stretch starts.
    pub(super) start: u32,
    pub(super) end: u32,
    /// A node that is left alone, with all below it; zero is none.
    pub(super) spared: u32,
    /// The node at the start is halted even if it is not running.
    pub(super) forced: bool,
    pub(super) after: After,
}

/// What comes after a resetting.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum After {
    /// This node goes on, because of that child.
    Do(u32, u32, Then),
    /// This node, which has been halted, is skipped.
    Skip(u32),
    /// This node, which is being halted, ticks its catch block.
    Catch(u32),
    /// The catch block of this node is done, and the node is halted.
    Caught(u32),
    /// The next node of the whole tree is halted.
    HaltFrom(u32),
    /// The whole tree has been halted.
    Halted,
}

impl After {
    /// The node that is in the middle of its tick.
    pub(super) fn node(self) -> Option<u32> {
        match self {
            Self::Do(node, ..) | Self::Skip(node) => Some(node),
            Self::Catch(_) | Self::Caught(_) | Self::HaltFrom(_) | Self::Halted => None,
        }
    }
}

impl Halting {
    /// Resets nothing.
    pub(super) const NONE: Self = Self { cursor: 0, start: 0, end: 0, spared: 0, forced: false, after: After::Halted };

    /// Resets a node.
    pub(super) fn of_node(program: &Program, node: u32, after: After) -> Self {
        let end = program.ops[node as usize].end;
        Self { cursor: node, start: node, end, spared: 0, forced: false, after }
    }

    /// Resets neighbouring children of a node, but for one.
    pub(super) fn of_children(start: u32, end: u32, spared: u32, after: After) -> Self {
        Self { cursor: start, start, end, spared, forced: false, after }
    }

    /// Resets all children of a node.
    #[inline]
    pub(super) fn below(program: &Program, node: u32, after: After) -> Self {
        let end = program.ops[node as usize].end;
        Self { cursor: node + 1, start: node + 1, end, spared: 0, forced: false, after }
    }

    fn forced(program: &Program, node: u32, after: After) -> Self {
        Self { forced: true, ..Self::of_node(program, node, after) }
    }
}

impl<A> Context<'_, A> {
    /// Halting the whole tree: the root, and then, as BehaviorTree.CPP does it to make sure, every single node.
    pub(crate) fn halt_all(&mut self) -> Next {
        self.reset(Halting::forced(self.program(), 0, After::HaltFrom(0)))
    }
}

impl State {
    /// Resets nodes until all are done, or until a leaf that is to halt does not do so at once (then the cursor is at
    /// that leaf). Nothing below a node that is not running is looked at.
    #[inline]
    pub(super) fn reset<A: Answers>(&mut self, context: &mut Context<'_, A>) -> Option<After> {
        let mut halting = context.halting;
        while halting.cursor < halting.end {
            let node = halting.cursor;
            let is_running = self.marks[node as usize].is_running();
            if node == halting.spared && node != 0 {
                halting.cursor = context.op(node).end;
            } else if is_running || (halting.forced && node == halting.start) {
                let Op { kind, end, .. } = context.op(node);
                if is_running && kind == Kind::Action {
                    let leaf = Leaf { id: NodeId(node), tree: context.tree, board: &mut self.board, now: context.now };
                    if context.leaves.halt(leaf).is_none() {
                        context.halting = halting;
                        return None;
                    }
                }
                if is_running && kind == Kind::TryCatch && self.catches(context.program(), node) {
                    self.outer.push(halting);
                    halting = Halting::below(context.program(), node, After::Catch(node));
                    halting.end = context.program().children(node).last().unwrap_or(halting.end);
                    continue;
                }
                if end > node + 1 {
                    self.mark_halted(context.program(), node);
                    halting.cursor += 1;
                } else {
                    self.halted(context.program(), node);
                    halting.cursor = self.climb(context.program(), halting.start, node);
                }
            } else {
                self.marks[node as usize] = Mark::Idle;
                halting.cursor = self.climb(context.program(), halting.start, node);
            }
        }
        Some(halting.after)
    }

    /// Whether a node that is being halted is to tick its catch block first.
    fn catches(&mut self, program: &Program, node: u32) -> bool {
        let place = program.ops[node as usize].place as usize;
        let wants = program.settings[place].read(&mut self.board, false, Kind::TryCatch);
        let catches =
            matches!(wants, Ok(Reading::Numbers([1, _]))) && self.memories[place].catches_halts(Kind::TryCatch);
        self.memories[place].catches = catches;
        catches
    }

    /// Where the cursor goes after a node that is done with, in a stretch that starts there. Nodes above it whose last
    /// child it was are finished: they have been halted with all that is below them.
    #[inline]
    pub(super) fn climb(&mut self, program: &Program, start: u32, node: u32) -> u32 {
        let Op { parent, end, .. } = program.ops[node as usize];
        if parent >= start && node > start {
            self.finish_above(program, start, node);
        }
        end
    }

    fn finish_above(&mut self, program: &Program, start: u32, node: u32) {
        let cursor = program.ops[node as usize].end;
        let mut below = node;
        while below > start {
            let parent = program.ops[below as usize].parent;
            if parent < start || program.ops[parent as usize].end != cursor {
                break;
            }
            self.run_halted_script(program, parent);
            below = parent;
        }
    }

    /// A node has been halted, and nothing is below it that has to be.
    pub(super) fn halted(&mut self, program: &Program, node: u32) {
        self.mark_halted(program, node);
        self.run_halted_script(program, node);
    }

    #[inline]
    fn mark_halted(&mut self, program: &Program, node: u32) {
        let outcome = &mut self.outcomes[node as usize];
        // A node that was skipped counts as running for BehaviorTree.CPP once it has begun. It did not run.
        if self.marks[node as usize].is_running() && *outcome != Some(Outcome::Answered(Status::Skipped)) {
            *outcome = Some(Outcome::Halted);
        }
        self.marks[node as usize] = Mark::Idle;
        self.forget(program, node);
    }

    /// A node starts over, as far as it does after a halt.
    pub(super) fn forget(&mut self, program: &Program, node: u32) {
        let Op { kind, place, .. } = program.ops[node as usize];
        if !kind.is_leaf() {
            self.memories[place as usize].forget(kind);
            if kind.forgets() {
                self.resume[node as usize] = 0;
            }
        }
    }

    #[inline]
    fn run_halted_script(&mut self, program: &Program, node: u32) {
        if program.ops[node as usize].flags.has(Flags::HALTED)
            && let Err(error) = program.hooks(node).halted(&mut self.board)
        {
            self.fault(node, error.to_string());
        }
    }

    /// What comes after a resetting that is done.
    #[inline]
    pub(super) fn after_reset<A>(&mut self, context: &mut Context<'_, A>, after: After) -> Next {
        let program = context.program();
        match after {
            After::Do(node, here, then) => self.do_then(program, node, here, then),
            After::Skip(node) => Next::Answer(node, Status::Skipped),
            After::Catch(node) => Next::Enter(program.children(node).last().unwrap_or(node + 1)),
            After::Caught(node) => {
                self.halted(program, node);
                let outer = self.outer.pop().expect("a node catches a halt only while it is being halted");
                let cursor = self.climb(program, outer.start, node);
                context.reset(Halting { cursor, ..outer })
            }
            After::HaltFrom(node) if (node as usize) < program.ops.len() => {
                context.reset(Halting::forced(program, node, After::HaltFrom(node + 1)))
            }
            After::HaltFrom(_) | After::Halted => context.reset(Halting::NONE),
        }
    }
}
