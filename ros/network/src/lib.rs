//! Messages of robots that run, as they come.
//!
//! A [`Bridge`] is a client of Foxglove's WebSocket protocol, which `foxglove_bridge` and others speak: it reaches any
//! middleware and any host, with nothing but the bridge on the robot. A bridge drops messages when it, or whoever reads
//! from it, is too slow, and need not say so. Verdicts rest on what it forwards.
//!
//! A `Domain` (with the feature `dds`) is a participant in a DDS domain, beside the robot's own nodes. Publishers
//! number their messages there, so it is known which are missing.
//!
//! Both only listen, unless a domain is joined as a node. They are [`Live`] [sources](bags::Source), so that
//! [`bags::Events`] makes events of their messages as it does of those of a bag.

mod bridge;
mod clock;
#[cfg(feature = "dds")]
mod domain;
mod error;
mod protocol;
mod robot;

pub use bridge::Bridge;
#[cfg(feature = "dds")]
pub use domain::{Client, Domain, Options, Publication, Reply, Request, Response, Served, Voice, listen, obstacles};
pub use error::Error;
pub use robot::{Level, Live, Publish, Robot, Standing};
