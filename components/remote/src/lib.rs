//! Components and nodes of ROS 2, in both directions: what is asked over channels goes out as requests, and what comes
//! back becomes messages of channels; or nodes ask the components of a channel system, and read their topics.
//!
//! - [`RemoteComponent`]: an interface whose services, topics and actions have types of ROS 2, and a namespace.
//! - [`RemoteProcess`]: a component that consists of nodes of ROS 2, in a channel system. What it asks for are
//!   [`Call`]s; somebody else sends them, and tells it of [`FromNode`]s. It knows no middleware.
//! - [`RemoteClients`]: the other side. It hears [`Call`]s, and says [`FromNode`]s.
//! - [`ActionServer`]: the server of an action, which pursues one goal at a time.
//!
//! A service's response is the reply `ok`. It is the reply `error` if a field `success` of the response is false, and
//! this field is not one of the reply's. A goal is sent with an id of its own; once it has been accepted, its result is
//! asked for. What nobody answers remains unanswered, as it is with a component that hangs. A message whose values are
//! not those of its fields (NaN, or an integer that a machine cannot represent) is left out, which is one of the
//! process's [mishaps](RemoteProcess::mishaps).
//!
//! # Inside
//! `action` is what an action of ROS 2 consists of, `component` says which names and types an interface has in ROS 2,
//! `convert` turns fields into messages and back, `process` conducts the conversations of a component that is outside,
//! `clients` those of clients that are, `message` is what passes between both, and `action_server` keeps the goals of
//! an action.

pub mod action;
mod action_server;
mod clients;
mod component;
mod convert;
mod message;
mod process;

pub use action_server::{ActionServer, Demand, Ending};
pub use clients::{Offered, RemoteClients};
pub use component::{RemoteComponent, is_name};
pub use message::{Call, FromNode, GoalId, Loss, Lost};
pub use process::RemoteProcess;
