//! Messages of robots that run, as they come.
//!
//! A [`Bridge`] is a client of Foxglove's WebSocket protocol, which `foxglove_bridge` and others speak: it reaches any
//! middleware and any host, with nothing but the bridge on the robot. It only listens. It is a [`bags::Source`], so
//! that [`bags::Events`] makes events of its messages as it does of those of a bag.
//!
//! A bridge drops messages when it, or whoever reads from it, is too slow, and need not say so. Verdicts rest on what
//! it forwards.

mod bridge;
mod clock;
mod protocol;

pub use bridge::{Bridge, Error, Robot};
