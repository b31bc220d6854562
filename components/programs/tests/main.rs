//! Programs that exchange messages with a client, outside a run.

#![cfg(unix)]
#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

mod conversation;
mod hostile;
mod machine;
mod stage;
