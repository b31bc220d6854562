//! Connects a channel system with nodes of ROS 2, in both directions. A component can consist of nodes: requests over
//! channels become service requests, and the nodes' responses and topics become channel messages. Or nodes can be
//! clients of the system's components: they send requests to these, and read their topics.
//!
//! - [`RemoteComponent`]: an interface whose services, topics and actions have types of ROS 2, and a namespace.
//! - [`RemoteProcess`]: a component that consists of nodes of ROS 2, in a channel system. It makes [`ServiceRequest`]s
//!   and receives [`NodeMessage`]s; the caller transports both. It depends on no middleware.
//! - [`RemoteClients`]: the counterpart, for nodes that are clients. It receives [`ServiceRequest`]s and makes
//!   [`NodeMessage`]s.
//! - [`ActionServer`]: the server of an action, which pursues one goal at a time.
//!
//! A service's response becomes the reply `ok`; or `error` if it has a field `success` that is false and not part of
//! the reply. Each goal has an id of its own. Once the server has accepted it, the process requests its result. A
//! request without a response gets no reply, as with a component that hangs. A message with a value that does not fit
//! its field (NaN, or an integer that a machine cannot represent) is left out, and is one of the process's
//! [mishaps](RemoteProcess::mishaps).
//!
//! # Inside
//! `action` has the parts of an action in ROS 2, `component` the names and types of an interface there, and `message`
//! the requests, responses and topic messages. `convert` turns fields into messages and back. `process` is the process
//! of a remote component, `clients` that of remote clients, and `action_server` keeps the goals of an action.

pub mod action;
mod action_server;
mod clients;
mod component;
mod convert;
mod message;
mod process;

pub use action_server::{ActionServer, Demand, Ending};
pub use clients::{Offered, RemoteClients};
pub use component::RemoteComponent;
pub use message::{GoalId, Loss, Lost, NodeMessage, ServiceRequest};
pub use process::RemoteProcess;
pub use ros_messages::is_name;
