//! The engine against an oracle that shares nothing with it: one object a node, with the methods that BehaviorTree.CPP
//! documents (`executeTick`, `haltNode`, `resetStatus`), calling each other recursively.

use bt::{Execution, Kind, Leaves, NodeState, Reply, Request, Status, Step};
use std::time::Duration;

use proptest::prelude::*;

use crate::NOW;
use crate::forest::{Actors, Cast, Spec, script, spec, wild_tree};

/// A node. Its status is none while it is idle.
struct Object {
    kind: Kind,
    id: String,
    children: Vec<Object>,
    status: Option<Status>,
    current: usize,
}

/// What the nodes of a tree share.
struct Context {
    actors: Actors,
    woken: bool,
}

impl Object {
    fn new(spec: &Spec) -> Self {
        let children = spec.children.iter().map(Self::new).collect();
        Self { kind: spec.kind, id: spec.id.clone().unwrap_or_default(), children, status: None, current: 0 }
    }

    fn execute_tick(&mut self, context: &mut Context) -> Status {
        let status = self.tick(context);
        self.status = Some(status);
        status
    }

    fn tick(&mut self, context: &mut Context) -> Status {
        use Status::{Failure, Success};
        match self.kind {
            Kind::Action | Kind::Condition => context.actors.tick(&self.id),
            Kind::AlwaysSuccess => Success,
            Kind::AlwaysFailure => Failure,
            Kind::Sequence => self.tick_with_memory_of_running(context, Success, Failure),
            Kind::Fallback => self.tick_with_memory_of_running(context, Failure, Success),
            Kind::SequenceWithMemory => self.tick_sequence_with_memory(context),
            Kind::ReactiveSequence => self.tick_reactive(context, Success, Failure),
            Kind::ReactiveFallback => self.tick_reactive(context, Failure, Success),
            Kind::Inverter => self.decorate(context, |status| if status == Success { Failure } else { Success }),
            Kind::ForceSuccess => self.decorate(context, |_| Success),
            Kind::ForceFailure => self.decorate(context, |_| Failure),
            _ => self.decorate(context, |status| status),
        }
    }

    /// Sequence and Fallback: `go_on` moves to the next child, `stop` ends the node.
    fn tick_with_memory_of_running(&mut self, context: &mut Context, go_on: Status, stop: Status) -> Status {
        self.status = Some(Status::Running);
        while self.current < self.children.len() {
            let status = self.children[self.current].execute_tick(context);
            if status == Status::Running {
                return status;
            }
            if status == stop {
                self.reset_children(context);
                self.current = 0;
                return stop;
            }
            self.current += 1;
        }
        self.reset_children(context);
        self.current = 0;
        go_on
    }

    fn tick_sequence_with_memory(&mut self, context: &mut Context) -> Status {
        self.status = Some(Status::Running);
        while self.current < self.children.len() {
            let was_idle = self.children[self.current].status.is_none();
            match self.children[self.current].execute_tick(context) {
                Status::Running => return Status::Running,
                Status::Failure => {
                    for child in self.current..self.children.len() {
                        self.halt_child(child, context);
                    }
                    return Status::Failure;
                }
                Status::Skipped => unreachable!("nothing is skipped in these trees"),
                Status::Success => {
                    self.current += 1;
                    if was_idle && self.current < self.children.len() {
                        context.woken = true;
                        return Status::Running;
                    }
                }
            }
        }
        self.reset_children(context);
        self.current = 0;
        Status::Success
    }

    fn tick_reactive(&mut self, context: &mut Context, go_on: Status, stop: Status) -> Status {
        self.status = Some(Status::Running);
        for index in 0..self.children.len() {
            let status = self.children[index].execute_tick(context);
            if status == Status::Running {
                for other in (0..self.children.len()).filter(|other| *other != index) {
                    self.halt_child(other, context);
                }
                return status;
            }
            if status == stop {
                self.reset_children(context);
                return stop;
            }
        }
        self.reset_children(context);
        go_on
    }

    fn decorate(&mut self, context: &mut Context, change: impl Fn(Status) -> Status) -> Status {
        self.status = Some(Status::Running);
        let status = self.children[0].execute_tick(context);
        if status == Status::Running {
            return status;
        }
        self.reset_children(context);
        change(status)
    }

    fn halt_child(&mut self, child: usize, context: &mut Context) {
        let child = &mut self.children[child];
        if child.status == Some(Status::Running) {
            child.halt_node(context);
        }
        child.status = None;
    }

    fn reset_children(&mut self, context: &mut Context) {
        for child in 0..self.children.len() {
            self.halt_child(child, context);
        }
    }

    fn halt_node(&mut self, context: &mut Context) {
        match self.kind {
            // onHalted() is called of a running action only, and never of a condition.
            Kind::Action if self.status == Some(Status::Running) => context.actors.halt(&self.id),
            Kind::Sequence | Kind::Fallback => self.current = 0,
            _ => {}
        }
        self.reset_children(context);
        self.status = None;
    }

    /// haltTree() calls haltNode() of the root, and then of every node, for safety.
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

/// Tree::tickOnce and Tree::haltTree.
struct Oracle {
    root: Object,
    context: Context,
}

impl Oracle {
    fn tick_once(&mut self) -> Status {
        loop {
            let status = self.root.execute_tick(&mut self.context);
            let woken = std::mem::take(&mut self.context.woken);
            if status != Status::Running {
                self.root.status = None;
            }
            if status != Status::Running || !woken {
                return status;
            }
        }
    }

    fn halt_tree(&mut self) {
        self.root.halt_every_node(&mut self.context);
    }

    fn statuses(&self) -> Vec<Option<Status>> {
        let mut statuses = Vec::new();
        self.root.statuses(&mut statuses);
        statuses
    }
}

#[derive(Clone, Copy, Debug)]
enum Order {
    Tick,
    HaltTree,
}

fn orders() -> impl Strategy<Value = Vec<Order>> {
    prop::collection::vec(prop_oneof![8 => Just(Order::Tick), 1 => Just(Order::HaltTree)], 1..30)
}

fn statuses(execution: &Execution) -> Vec<Option<Status>> {
    execution.states().into_iter().map(|NodeState { status, .. }| status).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn the_engine_does_what_the_oracle_does(spec in spec(), script in script(), orders in orders()) {
        let tree = spec.tree();
        let context = Context { actors: Actors::new(&script), woken: false };
        let mut oracle = Oracle { root: Object::new(&spec), context };
        let mut cast = Cast::new(&tree, &script);
        let mut execution = Execution::new(tree);
        for order in orders {
            match order {
                Order::Tick => prop_assert_eq!(execution.tick(NOW, &mut cast), oracle.tick_once()),
                Order::HaltTree => {
                    execution.halt(NOW, &mut cast);
                    oracle.halt_tree();
                }
            }
            prop_assert_eq!(cast.calls(), oracle.context.actors.calls.clone());
            prop_assert_eq!(statuses(&execution), oracle.statuses());
        }
    }

    #[test]
    fn a_tick_from_call_to_call_is_the_same_tick(spec in spec(), script in script(), orders in orders()) {
        let tree = spec.tree();
        let (mut cast, mut others) = (Cast::new(&tree, &script), Cast::new(&tree, &script));
        let (mut whole, mut split) = (Execution::new(tree.clone()), Execution::new(tree));
        for order in orders {
            let mut step = match order {
                Order::Tick => split.start_tick(NOW),
                Order::HaltTree => split.start_halt(NOW),
            };
            while let Some(Step::Call(call)) = step {
                prop_assert_eq!(split.start_tick(NOW), None);
                let (wrong, reply) = match call.request {
                    Request::Tick => (Reply::Halted, Reply::Status(others.tick(split.leaf(call.leaf, NOW)))),
                    Request::Halt => {
                        others.halt(split.leaf(call.leaf, NOW));
                        (Reply::Status(Status::Success), Reply::Halted)
                    }
                };
                prop_assert_eq!(split.resume(NOW, wrong), None);
                // A copy taken here goes on alone, and as the original does.
                let mut copy = split.clone();
                prop_assert_eq!(&copy, &split);
                step = split.resume(NOW, reply);
                prop_assert_eq!(copy.resume(NOW, reply), step);
                prop_assert_eq!(&copy, &split);
            }
            let done = match order {
                Order::Tick => Step::Done(whole.tick(NOW, &mut cast)),
                Order::HaltTree => {
                    whole.halt(NOW, &mut cast);
                    Step::Halted
                }
            };
            prop_assert_eq!(step, Some(done));
            prop_assert_eq!(&whole, &split);
            prop_assert_eq!(cast.calls(), others.calls());
        }
    }

    #[test]
    fn a_wild_tree_does_the_same_from_call_to_call(
        tree in wild_tree(), script in script(), orders in orders(),
    ) {
        let (mut cast, mut others) = (Cast::new(&tree, &script), Cast::new(&tree, &script));
        let mut whole = Execution::new(tree.clone());
        let mut split = Execution::new(tree);
        for (count, order) in (0..).zip(orders) {
            let now = Duration::from_millis(100 * count);
            let mut step = match order {
                Order::Tick => split.start_tick(now),
                Order::HaltTree => split.start_halt(now),
            };
            while let Some(Step::Call(call)) = step {
                prop_assert_eq!(split.pending(), Some(call));
                let reply = match call.request {
                    Request::Tick => Reply::Status(others.tick(split.leaf(call.leaf, now))),
                    Request::Halt => {
                        others.halt(split.leaf(call.leaf, now));
                        Reply::Halted
                    }
                };
                let mut copy = split.clone();
                step = split.resume(now, reply);
                prop_assert_eq!(copy.resume(now, reply), step);
                prop_assert_eq!(&copy, &split);
            }
            match order {
                Order::Tick => prop_assert_eq!(step, Some(Step::Done(whole.tick(now, &mut cast)))),
                Order::HaltTree => {
                    whole.halt(now, &mut cast);
                    prop_assert_eq!(step, Some(Step::Halted));
                }
            }
            prop_assert_eq!(&whole, &split);
            prop_assert_eq!(cast.calls(), others.calls());
        }
    }

    #[test]
    fn a_tick_that_is_under_way_can_be_finished_at_once(spec in spec(), script in script(), stop in 0..6_usize) {
        let tree = spec.tree();
        let mut cast = Cast::new(&tree, &script);
        let mut execution = Execution::new(tree);
        for _ in 0..4 {
            let mut expected = execution.clone();
            let mut expected_cast = cast.understudy();
            let status = expected.tick(NOW, &mut expected_cast);

            let mut step = execution.start_tick(NOW);
            for _ in 0..stop {
                let Some(Step::Call(call)) = step else { break };
                let reply = match call.request {
                    Request::Tick => Reply::Status(cast.tick(execution.leaf(call.leaf, NOW))),
                    Request::Halt => {
                        cast.halt(execution.leaf(call.leaf, NOW));
                        Reply::Halted
                    }
                };
                step = execution.resume(NOW, reply);
            }
            if let Some(Step::Call(_)) = step {
                prop_assert_eq!(execution.tick(NOW, &mut cast), status);
            }
            prop_assert_eq!(cast.calls(), expected_cast.calls());
            prop_assert_eq!(&execution, &expected);
        }
    }
}
