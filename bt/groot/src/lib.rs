//! Speaks Groot2's protocol, over which a program with BehaviorTree.CPP (4.6.2 and later) shows a tree that it runs.
//!
//! A [`Client`] asks such a program for its tree, the status of all nodes, the transitions since it asked the last
//! time, and its blackboards. It never asks for a hook, which could stop the tree or replace its answers. A
//! [`TreeWatch`] asks again and again, and knows what is missing.
//!
//! A [`Server`] answers such clients about a tree that is run here.
//!
//! # Inside
//! `protocol` has the requests and replies, and `zmtp` what carries them: the part of ZeroMQ's protocol that is needed
//! for that. A library for the latter reserves as much memory as a stranger says that a frame has; here, all that a
//! peer can do is bounded in size and time.

mod boards;
mod client;
mod error;
mod protocol;
mod server;
mod watch;
mod zmtp;

pub use boards::{Blackboards, BoardValue};
pub use client::{Client, MOST_TRANSITIONS, Statuses};
pub use error::GrootError;
pub use protocol::{PORT, RequestHeader, RequestKind, TreeId, reply_header};
/// The value of an entry of a blackboard.
pub use rmpv::Value;
pub use server::Server;
pub use watch::{FoundStatuses, Standing, TreeNews, TreeWatch};
pub use zmtp::{Connection, SocketType, ZmtpError};
