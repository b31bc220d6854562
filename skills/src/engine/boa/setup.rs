//! Making an engine that no program can change.

use std::collections::BTreeMap;
use std::rc::Rc;

use boa_engine::{Context, JsObject, JsResult, Source};

use super::determinism::{self, Nowhere, SimulatedClock};
use super::{Engine, limits};

impl Engine {
    pub(super) fn new() -> Self {
        let clock = Rc::new(SimulatedClock::default());
        let (context, make_element) =
            prepared(&clock).expect("the engine runs its own setup, which depends on nothing");
        Self { context, clock, make_element, programs: BTreeMap::new() }
    }
}

fn prepared(clock: &Rc<SimulatedClock>) -> JsResult<(Context, JsObject)> {
    let mut context = Context::builder().clock(Rc::clone(clock)).host_hooks(Rc::new(Nowhere)).build()?;
    determinism::install(&mut context)?;
    let make_element = context.eval(Source::from_bytes(ELEMENTS))?;
    context.eval(Source::from_bytes(FREEZE))?;
    let bounds = context.runtime_limits_mut();
    bounds.set_loop_iteration_limit(limits::MAX_ITERATIONS);
    bounds.set_recursion_limit(limits::MAX_RECURSION);
    let make_element = make_element.as_object().expect("the script's value is a function");
    Ok((context, make_element))
}

/// As much of a DOM as data need that are XML (SCXML B.2.1).
const ELEMENTS: &str = include_str!("elements.js");

/// Takes away what could tell one run from another, and freezes everything else: a program that changed `Array.prototype`
/// would change it for all machines. Assigning to a member that an object inherits from a frozen one is no mistake,
/// however: the object gets a member of its own.
const FREEZE: &str = include_str!("freeze.js");
