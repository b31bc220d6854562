//! Programs that talk to a client, without a run around them.

#![cfg(unix)]
#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

mod conversation;
mod hostile;
mod machine;
mod stage;
