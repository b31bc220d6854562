//! Nodes as objects like BehaviorTree.CPP's, and the tree around them.

use bt::{Kind, Status};

use crate::forest::{Actors, Called, Guard, Script, Spec};

/// A node. Its status is `None` while it is idle. Its memory has the names that BehaviorTree.CPP uses.
pub(super) struct Object {
    pub(super) kind: Kind,
    pub(super) numbers: [i64; 2],
    pub(super) children: Vec<Object>,
    pub(super) status: Option<Status>,
    id: String,
    guard: Option<(Guard, i64)>,
    pub(super) current_child: usize,
    pub(super) skipped: usize,
    /// Children that a parallel node does not tick again.
    pub(super) completed: Vec<usize>,
    pub(super) successes: i64,
    pub(super) failures: i64,
    pub(super) running_child: Option<usize>,
    pub(super) in_catch: bool,
    pub(super) cycles: i64,
    pub(super) once: Option<Status>,
    pub(super) last_child_ticked: usize,
    pub(super) retry_count: i64,
    pub(super) num_failed_children: usize,
    pub(super) triggered: bool,
    /// The number of writes to the entry of its requests that it has seen.
    pub(super) requests: u64,
    pub(super) state: usize,
}

/// The shared state of a tree's nodes.
pub(super) struct Context {
    actors: Actors,
    /// Whether `emitWakeUpSignal` was called and has not been handled yet.
    pub(super) woken: bool,
    /// The only entry of the blackboard.
    pub(super) entry: i64,
    /// The number of times that it has been written.
    pub(super) writes: u64,
}

impl Object {
    fn new(spec: &Spec) -> Self {
        Self {
            kind: spec.kind,
            numbers: spec.numbers,
            children: spec.children.iter().map(Self::new).collect(),
            status: None,
            id: spec.id.clone().unwrap_or_default(),
            guard: spec.guard,
            current_child: 0,
            skipped: 0,
            completed: Vec::new(),
            successes: 0,
            failures: 0,
            running_child: None,
            in_catch: false,
            cycles: 0,
            once: None,
            last_child_ticked: 0,
            retry_count: 0,
            num_failed_children: 0,
            triggered: false,
            requests: 0,
            state: 0,
        }
    }

    /// `executeTick`. A node that is skipped keeps its status.
    pub(super) fn execute_tick(&mut self, context: &mut Context) -> Status {
        let status = match self.check_preconditions(context) {
            Some(status) => status,
            None => self.tick(context),
        };
        if status != Status::Skipped {
            self.status = Some(status);
        }
        if let ([child], true) = (&mut self.children[..], is_decorator(self.kind))
            && matches!(child.status, Some(Status::Success | Status::Failure))
        {
            child.status = None;
        }
        status
    }

    fn check_preconditions(&mut self, context: &mut Context) -> Option<Status> {
        let (guard, number) = self.guard?;
        let holds = context.entry == number;
        match (guard, self.status) {
            (Guard::FailureIf, None) if holds => Some(Status::Failure),
            (Guard::SuccessIf, None) if holds => Some(Status::Success),
            (Guard::SkipIf, None) if holds => Some(Status::Skipped),
            (Guard::While, None) if !holds => Some(Status::Skipped),
            (Guard::While, Some(Status::Running)) if !holds => {
                self.halt_node(context);
                Some(Status::Skipped)
            }
            _ => None,
        }
    }

    fn tick(&mut self, context: &mut Context) -> Status {
        match self.kind {
            Kind::Action | Kind::Condition => context.actors.tick(&self.id),
            Kind::AlwaysSuccess => Status::Success,
            Kind::AlwaysFailure => Status::Failure,
            Kind::Script => {
                context.entry = self.numbers[0];
                context.writes += 1;
                Status::Success
            }
            kind if is_decorator(kind) => self.tick_decorator(context),
            _ => self.tick_control(context),
        }
    }

    /// Where BehaviorTree.CPP throws an exception, which ends the program, the node fails and starts over.
    pub(super) fn throw(&mut self, context: &mut Context) -> Status {
        self.reset_children(context);
        self.forget();
        Status::Failure
    }

    /// `haltChild`.
    pub(super) fn halt_child(&mut self, child: usize, context: &mut Context) {
        let child = &mut self.children[child];
        if child.status == Some(Status::Running) {
            child.halt_node(context);
        }
        child.status = None;
    }

    /// `resetChildren`, `haltChildren` and `resetChild`.
    pub(super) fn reset_children(&mut self, context: &mut Context) {
        for child in 0..self.children.len() {
            self.halt_child(child, context);
        }
    }

    /// `haltNode`, which calls `halt`.
    fn halt_node(&mut self, context: &mut Context) {
        match self.kind {
            // onHalted() is called only for a running action, and never for a condition.
            Kind::Action if self.status == Some(Status::Running) => context.actors.halt(&self.id),
            Kind::TryCatch => self.catch_halt(context),
            _ => {}
        }
        self.forget();
        self.reset_children(context);
        self.status = None;
    }

    /// State that a node forgets when it is halted.
    fn forget(&mut self) {
        match self.kind {
            // Neither starts over when it is halted.
            Kind::SequenceWithMemory | Kind::RunOnce => {}
            _ => {
                (self.current_child, self.running_child, self.in_catch, self.cycles) = (0, None, false, 0);
                self.completed.clear();
                (self.successes, self.failures) = (0, 0);
                (self.last_child_ticked, self.retry_count, self.num_failed_children, self.state) = (0, 0, 0, 0);
            }
        }
    }

    /// haltTree() calls haltNode() on the root, and then on every node, for safety.
    fn halt_every_node(&mut self, context: &mut Context) {
        self.halt_node(context);
        for child in &mut self.children {
            child.halt_every_node(context);
        }
    }

    fn statuses(&self, out: &mut Vec<Option<Status>>) {
        out.push(self.status);
        self.children.iter().for_each(|child| child.statuses(out));
    }
}

fn is_decorator(kind: Kind) -> bool {
    matches!(
        kind,
        Kind::Inverter
            | Kind::ForceSuccess
            | Kind::ForceFailure
            | Kind::Repeat
            | Kind::RetryUntilSuccessful
            | Kind::KeepRunningUntilFailure
            | Kind::RunOnce
            | Kind::SingleTrigger
    )
}

/// Trees of this size need fewer repetitions, if they ever finish.
const MANY: u32 = 200;

/// Tree::tickOnce and Tree::haltTree.
pub(super) struct Oracle {
    root: Object,
    context: Context,
}

impl Oracle {
    pub(super) fn new(spec: &Spec, script: &Script) -> Self {
        let context = Context { actors: Actors::new(script), woken: false, entry: 0, writes: 1 };
        Self { root: Object::new(spec), context }
    }

    /// The tree's answer; `None` if it keeps asking to be ticked again.
    pub(super) fn tick_once(&mut self) -> Option<Status> {
        for _ in 0..MANY {
            let status = self.root.execute_tick(&mut self.context);
            if status == Status::Running && std::mem::take(&mut self.context.woken) {
                continue;
            }
            if matches!(status, Status::Success | Status::Failure) {
                self.root.status = None;
            }
            return Some(status);
        }
        None
    }

    /// Writes the blackboard's entry.
    pub(super) fn write(&mut self, number: i64) {
        self.context.entry = number;
        self.context.writes += 1;
    }

    pub(super) fn halt_tree(&mut self) {
        self.root.halt_every_node(&mut self.context);
    }

    pub(super) fn statuses(&self) -> Vec<Option<Status>> {
        let mut statuses = Vec::new();
        self.root.statuses(&mut statuses);
        statuses
    }

    pub(super) fn calls(&self) -> Vec<Called> {
        self.context.actors.calls.clone()
    }
}
