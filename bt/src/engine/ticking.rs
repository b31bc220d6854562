//! The way down: a node is ticked.

use super::reset::{After, Halting};
use super::{Answers, Context, Next, TreeState};
use crate::hooks::Entrance;
use crate::program::{Flags, Op};
use crate::semantics::{Beginning, PortReading, Then, Which, begin, begin_plain, needs_reading};
use crate::status::Mark;
use crate::{Leaf, NodeId, Status};

impl TreeState {
    /// Ticks a node if its scripts permit. Returns the next action, or `None` if it is a leaf that does not answer at
    /// once.
    #[inline]
    pub(super) fn enter<A: Answers>(&mut self, context: &mut Context<'_, A>, node: u32) -> Option<Next> {
        if context.op(node).flags.has(Flags::ENTRANCE)
            && let Some(next) = self.turned_away(context, node)
        {
            return Some(next);
        }
        self.begin(context, node)
    }

    /// The next action if a node's scripts prevent its tick.
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

    /// Ticks a node. Returns the next action, or `None` if it is a leaf that does not answer at once.
    #[inline]
    pub(super) fn begin<A: Answers>(&mut self, context: &mut Context<'_, A>, node: u32) -> Option<Next> {
        let Op { kind, .. } = context.op(node);
        let was = self.marks[node as usize];
        self.marks[node as usize] = was.entered();
        if kind.is_leaf() {
            let leaf = Leaf { id: NodeId(node), tree: context.tree, board: &mut self.board, now: context.now };
            return Some(Next::Answer(node, context.leaves.tick(leaf)?));
        }
        if kind.has_settings() {
            return Some(self.begin_with_settings(context, node, was));
        }
        // Such a node always ticks a child.
        self.mark(node, was.entered().begun(kind.keeps_answer()));
        let memory = &mut self.memories[context.op(node).place as usize];
        let first = match begin_plain(kind, memory, was == Mark::Idle) {
            Which::Resumed => self.resume[node as usize].max(node + 1),
            _ => node + 1,
        };
        Some(Next::Enter(first))
    }

    /// Ticks a node that may have ports to read.
    #[inline(never)]
    fn begin_with_settings<A>(&mut self, context: &mut Context<'_, A>, node: u32, was: Mark) -> Next {
        let Op { kind, place, end, .. } = context.op(node);
        let memory = &mut self.memories[place as usize];
        let mut reading = PortReading::Nothing;
        if needs_reading(kind, memory, was.was_idle()) {
            match context.program().settings[place as usize].read(&mut self.board, was.was_idle(), kind) {
                Ok(read) => reading = read,
                Err(error) => return self.failed_to_read(context, node, error.to_string()),
            }
        }
        let child_runs = node + 1 < end && self.marks[node as usize + 1].is_running();
        let beginning = Beginning { was: was.status(), reading, now: context.now, child_runs };
        let reaction = begin(kind, memory, beginning);
        if kind.runs_when_begun(reaction) {
            self.mark(node, self.marks[node as usize].begun(kind.keeps_answer()));
        }
        self.carry_out(context, node, 0, reaction)
    }

    /// Makes a node fail because of its ports.
    #[cold]
    fn failed_to_read<A>(&mut self, context: &mut Context<'_, A>, node: u32, message: String) -> Next {
        self.fault(node, message);
        let after = After::Do(node, 0, Then::Answer(Status::Failure));
        self.forget(context.program(), node);
        context.reset(Halting::below(context.program(), node, after))
    }
}
