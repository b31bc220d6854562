//! Runs in records: what a view of them shows, how files keep them, and how a judge makes them from events.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

mod drive;
mod files;
mod judged;
mod nav2;
mod tree_log;
mod view;
