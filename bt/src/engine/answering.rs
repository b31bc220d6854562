//! The way up: a node answers, and its parent reacts.

use super::reset::{After, Halting};
use super::{Context, MAX_REPEATS, Next, Point, TOO_MANY_REPEATS, TreeState};
use crate::program::{Flags, Op, Program};
use crate::semantics::{
    Answer, PortReading, Reaction, Reset, Resume, Then, Which, needs_reading_after, react, react_plain,
};
use crate::status::Mark;
use crate::{Category, Kind, Outcome, Status};

impl TreeState {
    /// Handles the root's answer: returns the next action, or the tree's answer.
    pub(super) fn finish(&mut self, status: Status) -> Result<Next, Status> {
        if status.is_completed() {
            self.mark(0, Mark::Idle);
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

    /// Passes a node's answer to its parent, which reacts.
    #[inline]
    pub(super) fn answer<A>(
        &mut self,
        context: &mut Context<'_, A>,
        node: u32,
        mut status: Status,
    ) -> Result<Next, Status> {
        let Op { kind, flags, parent, end: sibling, .. } = context.op(node);
        if flags.has(Flags::EXIT) {
            status = self.run_exit_scripts(context.program(), node, status);
        }
        let mark = self.marks[node as usize];
        self.mark(node, mark.answered(status));
        self.outcomes[node as usize].note(Outcome::Answered(status));
        // As in BehaviorTree.CPP: unless it has done so itself, before it answered.
        if kind.category() == Category::Decorator && self.marks[node as usize + 1].is_completed() {
            self.mark(node + 1, Mark::Idle);
        }
        if node == 0 {
            return self.finish(status);
        }
        let Op { kind, end, .. } = context.op(parent);
        let is_last = sibling == end;
        // The most frequent step by far, from one child of a sequence or fallback to the next, needs no memory.
        if !is_last && Some(status) == kind.goes_on_after() {
            return Ok(Next::Enter(sibling));
        }
        let was_idle = mark.was_idle();
        if kind.has_settings() {
            let (reading, now) = (PortReading::Nothing, context.now);
            let answer = Answer { status: Some(status), was_idle, is_last, reading, now };
            return Ok(self.react_with_settings(context, parent, node, answer));
        }
        let memory = &mut self.memories[context.op(parent).place as usize];
        let reaction = react_plain(kind, memory, status, was_idle, is_last);
        Ok(self.carry_out(context, parent, node, reaction))
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

    /// Lets a node that may have ports to read react to the answer of a child.
    #[inline(never)]
    fn react_with_settings<A>(
        &mut self,
        context: &mut Context<'_, A>,
        node: u32,
        child: u32,
        mut answer: Answer,
    ) -> Next {
        let Op { kind, place, flags, .. } = context.op(node);
        if kind == Kind::TryCatch && self.memories[place as usize].catches {
            return context.reset(Halting::below(context.program(), node, After::Caught(node)));
        }
        if flags.has(Flags::READS) && answer.status.is_some_and(|status| needs_reading_after(kind, status)) {
            answer.reading = self.read_after(context.program(), node, answer.status.unwrap_or(Status::Failure));
        }
        let memory = &mut self.memories[place as usize];
        let reaction = react(kind, memory, answer);
        self.carry_out(context, node, child, reaction)
    }

    /// Reads a node's inputs again after this answer of a child. If they cannot be read, the node fails.
    #[inline(never)]
    fn read_after(&mut self, program: &Program, node: u32, status: Status) -> PortReading {
        let kind = program.ops[node as usize].kind;
        program.setting(node).read_after(status, &mut self.board, kind).unwrap_or_else(|error| {
            self.fault(node, error.to_string());
            PortReading::Status(Status::Failure)
        })
    }

    /// Skips a child that is done; its parent reacts to that.
    pub(super) fn pass<A>(&mut self, context: &mut Context<'_, A>, node: u32) -> Next {
        let Op { parent, end: sibling, .. } = context.op(node);
        let is_last = sibling == context.op(parent).end;
        let answer = Answer { status: None, was_idle: false, is_last, reading: PortReading::Nothing, now: context.now };
        self.react_with_settings(context, parent, node, answer)
    }

    /// Carries out a node's reaction; `here` is the child that answered.
    #[inline]
    pub(super) fn carry_out<A>(
        &mut self,
        context: &mut Context<'_, A>,
        node: u32,
        here: u32,
        reaction: Reaction,
    ) -> Next {
        let program = context.program();
        let Reaction::Do { reset, resume, then } = reaction else {
            return self.do_then(context, node, here, Then::Tick(Which::Next));
        };
        match resume {
            Resume::Same => {}
            Resume::First => self.resume[node as usize] = 0,
            Resume::Here => self.resume[node as usize] = here,
            Resume::Next => self.resume[node as usize] = program.ops[here as usize].end,
        }
        let (start, end, spared) = match reset {
            Reset::None => return self.do_then(context, node, here, then),
            Reset::All => (node + 1, program.ops[node as usize].end, 0),
            Reset::Others => (node + 1, program.ops[node as usize].end, here),
            Reset::FromHere => (here, program.ops[node as usize].end, 0),
            Reset::Here => (here, program.ops[here as usize].end, 0),
            Reset::Nth(child) => match program.children(node).nth(child as usize) {
                Some(child) => (child, program.ops[child as usize].end, 0),
                None => return self.do_then(context, node, here, then),
            },
        };
        // Most resets find only idle children. Only from the first running one on can a leaf suspend the reset.
        match self.reset_idle(program, start, end, spared) {
            None => self.do_then(context, node, here, then),
            Some(cursor) => context.reset(Halting::of_children(cursor, end, spared, After::Do(node, here, then))),
        }
    }

    /// Resets children up to the first running one, and returns that one.
    #[inline]
    fn reset_idle(&mut self, program: &Program, start: u32, end: u32, spared: u32) -> Option<u32> {
        let mut child = start;
        while child < end {
            if child != spared {
                if self.marks[child as usize].is_running() {
                    return Some(child);
                }
                self.mark(child, Mark::Idle);
            }
            child = program.ops[child as usize].end;
        }
        None
    }

    #[inline]
    pub(super) fn do_then<A>(&mut self, context: &mut Context<'_, A>, node: u32, here: u32, then: Then) -> Next {
        let program = context.program();
        match then {
            Then::Tick(which) => {
                let child = match which {
                    Which::First => node + 1,
                    // A zero, which means the first child, is less than any child.
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
            Then::Finish(status) => self.carry_out(context, node, here, Reaction::finish(status)),
            Then::Skip => {
                self.mark(node, Mark::Started);
                Next::Answer(node, Status::Skipped)
            }
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
