//! Receives messages from running robots.
//!
//! A [`Bridge`] is a client of Foxglove's WebSocket protocol, which `foxglove_bridge` and others implement. It works
//! with any middleware and any host, and only the bridge has to run on the robot. A bridge drops messages when it or
//! its client is too slow, and may not report that. So verdicts rest on the messages that it forwards.
//!
//! A `Domain` (with the feature `dds`) is a participant in a DDS domain, beside the robot's own nodes. Publishers
//! number their messages there, so missing ones are known.
//!
//! Both only subscribe, unless a domain is joined as a node. Both are [`Live`] [sources](bags::Source):
//! [`bags::Events`] makes events of their messages, as it does of the messages of a bag.
//!
//! # Inside
//! `bridge` is the client. `domain` starts a `listener`, a process of its own with the participant; they `exchange`
//! messages and commands. Its `reception` discovers publishers and compares the numbers of their messages
//! (`sequence_gaps`). `robot` is what both report of a robot, and `protocol` what the bridge's messages are.

mod bridge;
mod clock;
#[cfg(feature = "dds")]
mod domain;
mod error;
mod protocol;
mod robot;

pub use bridge::Bridge;
pub use clock::now;
#[cfg(feature = "dds")]
pub use domain::{
    Client, Domain, IncomingRequest, Options, Publication, Publisher, Reply, Request, Response, listen, obstacles,
};
pub use error::Error;
pub use robot::{Level, Live, PropertyStatus, Publish, Robot};
