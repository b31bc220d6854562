//! Channel systems of program graphs: messages, processes, schedulers, monitored transitions.

mod domain;
mod error;
mod message;
mod process;
mod topology;
mod value;

pub use domain::{Domain, FieldKind, Shape};
pub use error::{RunError, WiringError};
pub use message::{Envelope, Message, RequestNumber};
pub use process::{Action, Offer, Pattern, Process, ProcessState, TransitionId, Use};
pub use topology::{Capacity, Channel, ChannelId, ProcessId, Topology};
pub use value::{Symbol, Value};
