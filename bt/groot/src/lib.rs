//! Groot2's protocol, over which a program with BehaviorTree.CPP (4.6.2 and later) shows a tree that it runs.
//!
//! A [`Client`] requests the tree of such a program, the status of all nodes, the transitions since its last request,
//! and the blackboards. It never requests a hook, which could stop the tree or replace its answers. A [`TreeWatch`]
//! polls a program, and detects missing transitions.
//!
//! A [`Server`] answers such clients about a tree that runs in this process.
//!
//! # Inside
//! `protocol` contains the requests and replies, and `zmtp` the part of ZeroMQ's protocol that carries them. A library
//! for the latter reserves as much memory as the header of a frame announces; here, the size and the duration of
//! everything that a peer sends are bounded.

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
pub use watch::{NodeSnapshot, TreeSnapshot, TreeUpdate, TreeWatch};
pub use zmtp::{Connection, SocketType, ZmtpError};
