//! Tests of behavior trees from outside the crate: on files, random trees and whole channel systems.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

mod answers;
mod broken;
#[path = "../../diagnostics/tests/xml/disturbed.rs"]
mod disturbed;
mod doubtful;
mod entries;
mod forest;
mod kinds;
mod layout;
mod leaves;
mod loading;
#[path = "../../channels/tests/system/lockstep.rs"]
mod lockstep;
mod nav2_trees;
mod nodes;
mod oracle;
mod processes;
mod refusals;
mod scaling;
mod stage;
mod timeouts;

use std::time::Duration;

/// The time of a tick in tests where it does not matter.
const NOW: Duration = Duration::ZERO;
