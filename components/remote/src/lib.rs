//! Components that are nodes of ROS 2: what is asked of them over channels goes out as requests, and what comes back
//! becomes messages of channels.
//!
//! - [`RemoteComponent`]: an interface whose services, topics and actions have types of ROS 2, and a namespace.
//! - [`RemoteProcess`]: such a component in a channel system. What it asks for are [`Call`]s; somebody else sends them,
//!   and tells it of [`FromNode`]s. It knows no middleware.
//!
//! A service's response is the reply `ok`. A goal is sent with an id of its own; once it has been accepted, its result
//! is asked for. What nobody answers remains unanswered, as it is with a component that hangs. A message whose values
//! are not those of its fields (NaN, or an integer that a machine cannot represent) is left out, which is one of the
//! process's [mishaps](RemoteProcess::mishaps).
//!
//! # Inside
//! `action` is what an action of ROS 2 consists of, `component` says which names and types an interface has in ROS 2,
//! `convert` turns fields into messages and back, `process` conducts the conversations.

pub mod action;
mod component;
mod convert;
mod process;

pub use component::RemoteComponent;
pub use process::{Call, FromNode, RemoteProcess};
