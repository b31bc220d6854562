//! Trees as processes of a channel system.
//!
//! There are two forms with the same semantics: [`TreeProcess`] is the whole tree, [`node_processes`] is one process
//! per node with handshakes between them. To other processes they look the same. Both receive `[<tick>, n]` from the
//! tick generator, send `[<tick>]` and `[<halt>]` to the skills on the channels (BT, X), where X is the name of a
//! leaf's [process](crate::Node::process), and wait for the answers on (X, BT). The values that a leaf's ports read
//! from the blackboard come with each tick, and the values that they write with each answer ([`request_domain`],
//! [`reply_domain`]). There is one pending request at a time. The requests to each skill are numbered from 1; a reply
//! with another number, or one that does not answer the request, is received and dropped.
//!
//! A tree does not wait forever: a leaf that does not answer a tick in time has failed, and one that does not confirm a
//! halt in time has halted; both are a [`Fault`](crate::Fault). The timeout ([`LEAF_TIMEOUT`] by default) begins when
//! the request is ready to be sent; a request that could not even be sent is withdrawn.

mod board;
mod composed;
mod leaf;
mod node;
mod patience;
mod protocol;
mod whole;

pub use board::BlackboardProcess;
pub use composed::{
    WiredProcess, blackboard_in, blackboard_in_mut, faults_in, faults_known_to, node_processes, note_transitions_in,
    outcomes_known_to, states_in, take_transitions_in,
};
pub use leaf::LeafProcess;
pub use node::NodeProcess;
pub use patience::LEAF_TIMEOUT;
pub use protocol::{declare_channels, reply_domain, request_domain, tick_domain};
pub use whole::TreeProcess;
