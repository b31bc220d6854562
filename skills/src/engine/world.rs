//! What the engine works on.

use std::time::Duration;

use crate::datum::Memory;
use crate::expression::Scope;
use crate::steps::Steps;

/// What code can see and change.
#[cfg_attr(not(feature = "ecmascript"), expect(dead_code, reason = "only an engine looks at it"))]
pub(crate) struct World<'a> {
    /// Without data.
    pub(crate) scope: Scope<'a>,
    pub(crate) memory: &'a mut Memory,
    pub(crate) now: Duration,
    /// Where the sequence of `Math.random` stands.
    pub(crate) random: &'a mut u64,
    /// What running may cost.
    pub(crate) steps: &'a Steps,
}
