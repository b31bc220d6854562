//! An engine and its bounds.

use std::cell::Cell;
use std::rc::Rc;

use rquickjs::context::intrinsic;
use rquickjs::{Context, Error, Runtime};

/// What an evaluation may keep in memory, its own objects and the engine's.
const MAX_MEMORY_BYTES: usize = 4 << 20;

/// Calls may lie in each other so deeply. A thread has 2 MiB at least.
const MAX_STACK_BYTES: usize = 256 << 10;

/// The engine counts 10,000 calls and rounds of loops before it asks whether it may go on. Each may be as much work as
/// several of a machine's own steps.
pub(super) const STEPS_PER_TURN: u64 = 50_000;

/// What of ECMAScript there is. Proxies, typed arrays and weak references are not ([`builtins`] says why).
type Intrinsics = (
    intrinsic::Eval,
    intrinsic::Date,
    intrinsic::RegExpCompiler,
    intrinsic::RegExp,
    intrinsic::Json,
    intrinsic::MapSet,
    intrinsic::Promise,
);

/// How often the engine has asked whether it may go on.
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

/// An engine that has run nothing yet.
pub(super) fn engine(turns: &Turns) -> Result<Context, Error> {
    let runtime = Runtime::new()?;
    runtime.set_max_stack_size(MAX_STACK_BYTES);
    // Nothing lives long enough to be worth collecting, and QuickJS 0.16 crashes if memory ends in the middle of a change and
    // the error that is then made has it collect.
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
