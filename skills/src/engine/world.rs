//! The environment of the engine.

use std::time::Duration;

use crate::datum::Memory;
use crate::expression::Scope;
use crate::steps::Steps;

/// The world that code can see and change.
#[cfg_attr(not(feature = "ecmascript"), expect(dead_code, reason = "only an engine looks at it"))]
pub(crate) struct World<'a> {
    /// Without data.
    pub(crate) scope: Scope<'a>,
    pub(crate) memory: &'a mut Memory,
    pub(crate) now: Duration,
    /// The position in the sequence of `Math.random`.
    pub(crate) random: &'a mut u64,
    /// The budget of steps.
    pub(crate) steps: &'a Steps,
}
