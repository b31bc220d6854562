//! The ticks of control nodes.

use bt::{Kind, Status};

use super::object::{Context, Object};

use Status::{Failure, Running, Skipped, Success};

impl Object {
    pub(super) fn tick_control(&mut self, context: &mut Context) -> Status {
        match self.kind {
            Kind::ReactiveSequence => self.tick_reactive(context, Success, Failure),
            Kind::ReactiveFallback => self.tick_reactive(context, Failure, Success),
            Kind::Fallback | Kind::AsyncFallback => self.tick_in_order(context, Failure, Success),
            Kind::Parallel => self.tick_parallel(context),
            Kind::ParallelAll => self.tick_parallel_all(context),
            Kind::IfThenElse => self.tick_if_then_else(context),
            Kind::WhileDoElse => self.tick_while_do_else(context),
            Kind::Switch(_) => self.tick_switch(context),
            Kind::TryCatch => self.tick_try_catch(context),
            Kind::PipelineSequence => self.tick_pipeline(context),
            Kind::NonblockingSequence => self.tick_nonblocking(context),
            Kind::RecoveryNode => self.tick_recovery(context),
            Kind::RoundRobin => self.tick_round_robin(context),
            Kind::PauseResumeController => self.tick_pausable(context),
            _ => self.tick_in_order(context, Success, Failure),
        }
    }

    /// Sequences and fallbacks that continue where they were: `go_on` moves to the next child, `stop` ends the node.
    fn tick_in_order(&mut self, context: &mut Context, go_on: Status, stop: Status) -> Status {
        let is_asynchronous = !matches!(self.kind, Kind::Sequence | Kind::Fallback);
        if self.status.is_none() {
            self.skipped = 0;
        }
        self.status = Some(Running);
        while self.current_child < self.children.len() {
            let was_idle = self.children[self.current_child].status.is_none();
            let status = self.children[self.current_child].execute_tick(context);
            if status == Running {
                return Running;
            }
            if status == stop {
                return self.stop(context, stop);
            }
            self.current_child += 1;
            self.skipped += usize::from(status == Skipped);
            if is_asynchronous && status == go_on && was_idle && self.current_child < self.children.len() {
                context.woken = true;
                return Running;
            }
        }
        let all_skipped = self.skipped == self.children.len();
        self.reset_children(context);
        (self.current_child, self.skipped) = (0, 0);
        if all_skipped { Skipped } else { go_on }
    }

    /// A child has ended the node. A node with memory keeps its position, and its successful children.
    fn stop(&mut self, context: &mut Context, status: Status) -> Status {
        if self.kind == Kind::SequenceWithMemory {
            for child in self.current_child..self.children.len() {
                self.halt_child(child, context);
            }
        } else {
            self.reset_children(context);
            self.current_child = 0;
        }
        status
    }

    fn tick_reactive(&mut self, context: &mut Context, go_on: Status, stop: Status) -> Status {
        self.status = Some(Running);
        let mut all_skipped = true;
        for index in 0..self.children.len() {
            let status = self.children[index].execute_tick(context);
            all_skipped &= status == Skipped;
            if status == Running {
                for other in (0..self.children.len()).filter(|other| *other != index) {
                    self.halt_child(other, context);
                }
                return Running;
            }
            if status == stop {
                self.reset_children(context);
                return stop;
            }
            if status == Skipped {
                self.halt_child(index, context);
            }
        }
        self.reset_children(context);
        if all_skipped { Skipped } else { go_on }
    }

    /// A number of children: −1 means all of them, −2 all but one, and so on.
    fn threshold(&self, number: i64) -> i64 {
        if number < 0 { (self.children.len() as i64 + number + 1).max(0) } else { number }
    }

    fn tick_parallel(&mut self, context: &mut Context) -> Status {
        let children = self.children.len() as i64;
        let [needed, too_many] = self.numbers.map(|number| self.threshold(number));
        self.status = Some(Running);
        let mut skipped = 0;
        for index in 0..self.children.len() {
            if !self.completed.contains(&index) {
                let status = self.children[index].execute_tick(context);
                skipped += i64::from(status == Skipped);
                self.successes += i64::from(status == Success);
                self.failures += i64::from(status == Failure);
                if matches!(status, Success | Failure) {
                    self.completed.push(index);
                }
            }
            let counted = self.successes + if self.numbers[0] < 0 { skipped } else { 0 };
            if counted >= needed {
                return self.settle(context, Success);
            }
            if children - self.failures < needed || self.failures == too_many {
                return self.settle(context, Failure);
            }
        }
        if skipped == children { Skipped } else { Running }
    }

    fn tick_parallel_all(&mut self, context: &mut Context) -> Status {
        let too_many = self.threshold(self.numbers[0]);
        self.status = Some(Running);
        let mut skipped = 0;
        for index in 0..self.children.len() {
            if self.completed.contains(&index) {
                continue;
            }
            let status = self.children[index].execute_tick(context);
            skipped += usize::from(status == Skipped);
            self.failures += i64::from(status == Failure);
            if matches!(status, Success | Failure) {
                self.completed.push(index);
            }
        }
        if skipped == self.children.len() {
            return Skipped;
        }
        if skipped + self.completed.len() < self.children.len() {
            return Running;
        }
        let status = if self.failures >= too_many { Failure } else { Success };
        self.settle(context, status)
    }

    /// A parallel node is done.
    fn settle(&mut self, context: &mut Context, status: Status) -> Status {
        self.completed.clear();
        (self.successes, self.failures) = (0, 0);
        self.reset_children(context);
        status
    }

    fn tick_if_then_else(&mut self, context: &mut Context) -> Status {
        self.status = Some(Running);
        if self.current_child == 0 {
            match self.children[0].execute_tick(context) {
                Running => return Running,
                Success => self.current_child = 1,
                Failure if self.children.len() == 3 => self.current_child = 2,
                // The condition keeps its status: nothing is reset here.
                Failure => return Failure,
                Skipped => return self.throw(context),
            }
        }
        let status = self.children[self.current_child].execute_tick(context);
        if status != Running {
            self.reset_children(context);
            self.current_child = 0;
        }
        status
    }

    fn tick_while_do_else(&mut self, context: &mut Context) -> Status {
        self.status = Some(Running);
        let has_else = self.children.len() == 3;
        let (chosen, other) = match self.children[0].execute_tick(context) {
            Running => return Running,
            Success => (1, 2),
            Failure if has_else => (2, 1),
            Failure => {
                self.reset_children(context);
                return Failure;
            }
            Skipped => return self.throw(context),
        };
        if has_else {
            self.halt_child(other, context);
        }
        let status = self.children[chosen].execute_tick(context);
        if status != Running {
            self.reset_children(context);
        }
        status
    }

    /// Its cases are 0 and 1; the third child is the default. It is not running before its child is.
    fn tick_switch(&mut self, context: &mut Context) -> Status {
        let chosen = usize::try_from(context.entry).unwrap_or(2).min(2);
        if let Some(running) = self.running_child.filter(|running| *running != chosen) {
            self.halt_child(running, context);
        }
        let status = self.children[chosen].execute_tick(context);
        self.running_child = (status == Running).then_some(chosen);
        if matches!(status, Success | Failure) {
            self.reset_children(context);
        }
        status
    }

    fn tick_try_catch(&mut self, context: &mut Context) -> Status {
        let catch = self.children.len() - 1;
        if self.status.is_none() {
            (self.skipped, self.in_catch) = (0, false);
        }
        self.status = Some(Running);
        while !self.in_catch && self.current_child < catch {
            match self.children[self.current_child].execute_tick(context) {
                Running => return Running,
                Failure => {
                    self.reset_children(context);
                    (self.current_child, self.in_catch) = (0, true);
                }
                Success => self.current_child += 1,
                Skipped => (self.current_child, self.skipped) = (self.current_child + 1, self.skipped + 1),
            }
        }
        if self.in_catch && self.children[catch].execute_tick(context) == Running {
            return Running;
        }
        let all_skipped = self.skipped == catch;
        self.reset_children(context);
        self.current_child = 0;
        if std::mem::take(&mut self.in_catch) {
            return Failure;
        }
        self.skipped = 0;
        if all_skipped { Skipped } else { Success }
    }

    fn tick_pipeline(&mut self, context: &mut Context) -> Status {
        let mut skipped = 0;
        for index in 0..self.children.len() {
            match self.children[index].execute_tick(context) {
                Failure => {
                    self.reset_children(context);
                    self.last_child_ticked = 0;
                    return Failure;
                }
                Running if index >= self.last_child_ticked => {
                    self.last_child_ticked = index;
                    return Running;
                }
                Skipped => skipped += 1,
                Running | Success => {}
            }
        }
        self.reset_children(context);
        self.last_child_ticked = 0;
        if skipped == self.children.len() { Skipped } else { Success }
    }

    fn tick_nonblocking(&mut self, context: &mut Context) -> Status {
        let mut all_success = true;
        for index in 0..self.children.len() {
            match self.children[index].execute_tick(context) {
                Failure => {
                    self.reset_children(context);
                    return Failure;
                }
                Skipped => return self.throw(context),
                Running => all_success = false,
                Success => {}
            }
        }
        if !all_success {
            return Running;
        }
        self.reset_children(context);
        Success
    }

    /// `halt` of the node alone, and its answer.
    fn end(&mut self, context: &mut Context, status: Status) -> Status {
        self.reset_children(context);
        self.status = None;
        (self.current_child, self.retry_count, self.num_failed_children) = (0, 0, 0);
        status
    }

    fn tick_recovery(&mut self, context: &mut Context) -> Status {
        let retries = self.numbers[0].abs();
        self.status = Some(Running);
        while self.retry_count <= retries {
            match (self.current_child, self.children[self.current_child].execute_tick(context)) {
                (_, Running) => return Running,
                (0, Failure) if self.retry_count < retries => {
                    self.halt_child(0, context);
                    self.current_child = 1;
                }
                (0, status) => return self.end(context, status),
                (_, Success) => {
                    self.halt_child(1, context);
                    (self.current_child, self.retry_count) = (0, self.retry_count + 1);
                }
                (_, Skipped) => {
                    self.current_child = 0;
                    self.halt_child(1, context);
                    return Failure;
                }
                (_, Failure) => break,
            }
        }
        self.end(context, Failure)
    }

    fn tick_round_robin(&mut self, context: &mut Context) -> Status {
        let (count, wraps) = (self.children.len(), self.numbers[0] > 0);
        self.status = Some(Running);
        let mut skipped = 0;
        while self.num_failed_children + skipped < count {
            let status = self.children[self.current_child].execute_tick(context);
            if status == Running {
                return Running;
            }
            self.current_child += 1;
            skipped += usize::from(status == Skipped);
            self.num_failed_children += usize::from(status == Failure);
            if self.current_child == count {
                if !wraps {
                    break;
                }
                self.current_child = 0;
            }
            if status == Success {
                self.num_failed_children = 0;
                self.reset_children(context);
                return Success;
            }
        }
        self.end(context, if skipped == count { Skipped } else { Failure })
    }

    /// Both services are the same entry. The states are the indices of the children.
    fn tick_pausable(&mut self, context: &mut Context) -> Status {
        const FOLLOWING: [usize; 4] = [0, 1, 1, 0];
        if self.status.is_none() {
            self.state = 0;
        }
        self.status = Some(Running);
        if std::mem::replace(&mut self.requests, context.writes) != context.writes {
            self.reset_children(context);
            self.state = if self.state == 1 { 3 } else { 2 };
        }
        if self.state >= self.children.len() {
            self.state = FOLLOWING[self.state];
            return Running;
        }
        match self.children[self.state].execute_tick(context) {
            status @ (Running | Failure) => status,
            Success | Skipped if self.state == 0 => Success,
            Success | Skipped => {
                self.state = FOLLOWING[self.state];
                Running
            }
        }
    }

    /// A TryCatch that is halted while it runs may tick its catch block once.
    pub(super) fn catch_halt(&mut self, context: &mut Context) {
        let catch = self.children.len() - 1;
        if self.numbers[0] > 0 && !self.in_catch && self.status == Some(Running) {
            for child in 0..catch {
                self.halt_child(child, context);
            }
            self.children[catch].execute_tick(context);
        }
    }
}
