//! Trees as processes of a channel system.
//!
//! Two forms of one semantics: [`TreeProcess`] is the whole tree, [`node_processes`] is a process for every node, with
//! handshakes between them. To everybody else they are the same: both receive `[<tick>, n]` from the tick generator,
//! send `[<tick>]` and `[<halt>]` to the skills on the channels (BT, X), X being the name of a leaf's
//! [process](crate::Node::process), and wait for the answers on (X, BT). What a leaf's ports read from the blackboard
//! comes with each tick, and what they write with each answer ([`request_domain`], [`reply_domain`]). There is one
//! request under way at a time. Requests are numbered from 1 on; a reply with another number, or one that does not
//! answer the request, is received and dropped.
//!
//! A tree does not wait for ever: a leaf that does not answer a tick in time has failed, one that does not say in time
//! that it has halted has halted, and either is a [`Fault`](crate::Fault). The time ([`LEAF_TIMEOUT`] if nothing else
//! is said) runs from the moment at which the request is to be sent; one that could not even be sent is withdrawn.

mod board;
mod composed;
mod leaf;
mod node;
mod patience;
mod protocol;
mod whole;

pub use board::BlackboardProcess;
pub use composed::{WiredProcess, blackboard_in, faults_in, node_processes, states_in};
pub use leaf::LeafProcess;
pub use node::NodeProcess;
pub use patience::LEAF_TIMEOUT;
pub use protocol::{declare_channels, reply_domain, request_domain, tick_domain};
pub use whole::TreeProcess;
