//! An engine and its limits.

use std::cell::Cell;
use std::rc::Rc;

use rquickjs::context::intrinsic;
use rquickjs::{Context, Error, Runtime};

/// The memory limit of an evaluation, including the engine's own objects.
const MAX_MEMORY_BYTES: usize = 4 << 20;

/// The stack limit. A thread has at least 2 MiB.
const MAX_STACK_BYTES: usize = 256 << 10;

/// The engine counts 10,000 calls and loop iterations before it checks whether it may continue. Each may take as much
/// work as several of a machine's own steps.
pub(super) const STEPS_PER_TURN: u64 = 50_000;

/// The available parts of ECMAScript. Proxies, typed arrays and weak references are missing ([`builtins`] explains
/// why).
type Intrinsics = (
    intrinsic::Eval,
    intrinsic::Date,
    intrinsic::RegExpCompiler,
    intrinsic::RegExp,
    intrinsic::Json,
    intrinsic::MapSet,
    intrinsic::Promise,
);

/// The number of times that the engine has asked whether it may continue.
#[derive(Clone)]
pub(super) struct Turns {
    pub(super) taken: Rc<Cell<u64>>,
    allowed: u64,
}

impl Turns {
    pub(super) fn new(steps: u64) -> Self {
        Self { taken: Rc::default(), allowed: (steps / STEPS_PER_TURN).max(1) }
    }

    pub(super) fn take(&self) {
        self.taken.set(self.taken.get() + 1);
    }

    pub(super) fn are_over(&self) -> bool {
        self.taken.get() > self.allowed
    }
}

pub(super) fn engine(turns: &Turns) -> Result<Context, Error> {
    let runtime = Runtime::new()?;
    runtime.set_max_stack_size(MAX_STACK_BYTES);
    // Nothing lives long enough to be worth collecting. Besides, QuickJS 0.16 crashes if memory runs out during a
    // change and the resulting error triggers a collection.
    runtime.set_gc_threshold(usize::MAX);
    let context = Context::custom::<Intrinsics>(&runtime)?;
    runtime.set_memory_limit(MAX_MEMORY_BYTES);
    let turns = turns.clone();
    runtime.set_interrupt_handler(Some(Box::new(move || {
        turns.take();
        turns.are_over()
    })));
    Ok(context)
}
