//! Resetting nodes, and halting running ones.

use super::reset::{After, Halting};
use super::{Answers, Context, Next, TreeState};
use crate::program::{Flags, Op, Program};
use crate::semantics::PortReading;
use crate::status::Mark;
use crate::{Kind, Leaf, NodeId, Outcome, Status};

impl<A> Context<'_, A> {
    /// Halts the whole tree: first the root and then, as BehaviorTree.CPP does as a precaution, every node
    /// individually.
    pub(crate) fn halt_all(&mut self) -> Next {
        self.reset(Halting::forced(self.program(), 0, After::HaltFrom(0)))
    }
}

impl TreeState {
    /// Resets nodes until all are done, or until a leaf does not halt at once (then the cursor is at that leaf).
    /// Nothing below a node that is not running is visited.
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
                    // All children but the last are reset, then the last is ticked, in the middle of this reset. The
                    // reset waits in `outer` until `After::Caught`.
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
                self.mark(node, Mark::Idle);
                halting.cursor = self.climb(context.program(), halting.start, node);
            }
        }
        Some(halting.after)
    }

    /// Whether a node that is being halted must tick its catch block first.
    fn catches(&mut self, program: &Program, node: u32) -> bool {
        let place = program.ops[node as usize].place as usize;
        let wants = program.settings[place].read(&mut self.board, false, Kind::TryCatch);
        let catches =
            matches!(wants, Ok(PortReading::Numbers([1, _]))) && self.memories[place].catches_halts(Kind::TryCatch);
        self.memories[place].catches = catches;
        catches
    }

    /// The position of the cursor after a finished node, in a range that begins at `start`. Ancestors that end with
    /// this node are finished as well: they have been halted with everything below them.
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
            self.end_halt(program, parent);
            below = parent;
        }
    }

    /// Records that a node has been halted, with everything below it.
    pub(super) fn halted(&mut self, program: &Program, node: u32) {
        self.mark_halted(program, node);
        self.end_halt(program, node);
    }

    #[inline]
    fn mark_halted(&mut self, program: &Program, node: u32) {
        let outcomes = &mut self.outcomes[node as usize];
        let mark = self.marks[node as usize];
        // A node that counts as running, but has only been skipped, did not run: no halt is noted.
        let was_skipped = mark == Mark::Lingering && outcomes.last() == Some(Outcome::Answered(Status::Skipped));
        if mark.is_running() && !was_skipped {
            outcomes.note(Outcome::Halted);
        }
        self.marks[node as usize] = Mark::Idle;
        self.forget(program, node);
    }

    pub(super) fn forget(&mut self, program: &Program, node: u32) {
        let Op { kind, place, .. } = program.ops[node as usize];
        if !kind.is_leaf() {
            self.memories[place as usize].forget(kind);
            if kind.forgets() {
                self.resume[node as usize] = 0;
            }
        }
    }

    /// A node becomes idle for loggers after everything below it.
    #[inline]
    fn end_halt(&mut self, program: &Program, node: u32) {
        self.run_halted_script(program, node);
        self.journal.note(node, None);
    }

    #[inline]
    fn run_halted_script(&mut self, program: &Program, node: u32) {
        if program.ops[node as usize].flags.has(Flags::HALTED)
            && let Err(error) = program.hooks(node).halted(&mut self.board)
        {
            self.fault(node, error.to_string());
        }
    }

    #[inline]
    pub(super) fn after_reset<A>(&mut self, context: &mut Context<'_, A>, after: After) -> Next {
        let program = context.program();
        match after {
            After::Do(node, here, then) => self.do_then(context, node, here, then),
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
