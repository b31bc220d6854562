//! Behavior trees: the XML files of BehaviorTree.CPP and Groot, run with the semantics of BehaviorTree.CPP, and those
//! of Nav2.
//!
//! A behavior tree decides at every tick what a robot does. Ticks go down from the root. A *leaf* answers a tick with a
//! [`Status`]: success, failure, or running if it needs more ticks. A *control node* ticks its children in order and
//! combines their answers: a sequence succeeds if all of them do, a fallback if one of them does. A *reactive* control
//! node ticks all its children again at every tick, so a condition that no longer holds takes effect at once: the
//! running action is *halted*. [`Kind`] defines the semantics of each kind of node.
//!
//! - A [`Tree`] is the checked content of a file: nodes in document order, with labels and symbols for drawing, and
//!   with their places in the file for diagnostics. [`Loader`] reads it and reports all problems of a file at once.
//! - An [`Execution`] is a running tree. Its leaves implement [`Leaves`]; or, if answers take time, it runs from one
//!   leaf [`Call`] to the next.
//! - In a channel system, leaves are skills: processes that answer on channels. The tree communicates with them as one
//!   process ([`TreeProcess`]) or as one process per node with handshakes between them ([`node_processes`]), as the
//!   paper defines it. Both send the same messages.
//!
//! This example runs the paper's tree with a robot whose battery is low:
//!
//! ```
//! use std::sync::Arc;
//! use std::time::Duration;
//! use bt::{Execution, Leaf, Leaves, Outcome, Status, Tree};
//!
//! struct LowBattery;
//!
//! impl Leaves for LowBattery {
//!     fn tick(&mut self, leaf: Leaf<'_>) -> Status {
//!         match leaf.node().type_id() {
//!             "GotoRechargingStation" | "GoToDestination" | "WaitForUser" => Status::Running,
//!             "BatteryNotCharging" => Status::Success,
//!             _ => Status::Failure, // the level is not above 30 %, and the robot is at neither place
//!         }
//!     }
//!
//!     fn halt(&mut self, _: Leaf<'_>) {}
//! }
//!
//! let tree = Arc::new(Tree::from_xml("recharge.xml", bt::RECHARGE)?);
//! let mut execution = Execution::new(tree.clone());
//! assert_eq!(execution.tick(Duration::ZERO, &mut LowBattery), Status::Running);
//!
//! let reached: Vec<String> = tree
//!     .leaves()
//!     .zip(tree.leaves().map(|leaf| execution.states()[leaf.id().index()].outcome))
//!     .filter_map(|(leaf, outcome)| Some(format!("{}: {}", leaf.label(), outcome?)))
//!     .collect();
//! assert_eq!(reached, ["BatteryLevel: failure", "AtRechargingStation: failure", "GotoRechargingStation: running"]);
//! # Ok::<(), bt::TreeError>(())
//! ```
//!
//! # Inside
//! `library` has the contents of files, as data; `xml` reads and writes them. `semantics` defines what each kind of
//! node does, and both forms follow it: `engine`, which traverses a whole tree without a stack and can stop at any
//! leaf, and `process::node`, whose nodes synchronize and ask another process, `process::board`, for the contents of
//! the blackboard. `rehearsal` ticks a tree whose leaves answer from a script; `mutation` introduces a mistake into a
//! tree. A leaf that does not answer in time counts as failed or halted, and is a fault of the tree. Every leaf node
//! has its own process (`Node::process`); `ports` defines what passes between its ports and the blackboard.

mod blackboard;
mod call;
mod direction;
mod engine;
mod error;
mod execution;
mod hooks;
mod journal;
mod kind;
mod leaf;
mod library;
mod mutation;
mod node;
mod ports;
mod process;
mod program;
mod rehearsal;
mod script;
mod semantics;
mod settings;
mod status;
mod texts;
mod tree;
mod xml;

pub use blackboard::{Blackboard, Type, Value, ValueError};
pub use call::{Call, Fault, Progress, Reply, Request};
pub use direction::Direction;
pub use error::TreeError;
pub use execution::Execution;
pub use journal::NodeTransition;
pub use kind::{Category, Item, Kind};
pub use leaf::{Leaf, Leaves, PortError};
pub use mutation::{Mutant, mutants};
pub use node::{Node, NodeId, one_line, process_names};
pub use ports::{Port, Source};
pub use process::{
    BlackboardProcess, LEAF_TIMEOUT, LeafProcess, NodeProcess, TreeProcess, WiredProcess, blackboard_in,
    blackboard_in_mut, declare_channels, faults_in, faults_known_to, node_processes, note_transitions_in,
    outcomes_known_to, reply_domain, request_domain, states_in, take_transitions_in, tick_domain,
};
pub use rehearsal::{Cue, Inputs, LeafBehavior, Rehearsal, RehearsedTick, table};
pub use status::{NodeState, Outcome, Status};
pub use texts::TextsOfTree;
pub use tree::Tree;
pub use xml::{BuiltinPort, Loader, PortForm, attributes_of, builtin_ports, elements_in, layout, node_attributes};

/// The paper's tree: drive to the destination, interrupt the trip to recharge when the battery is low, and resume it.
/// This is the text of `trees/recharge.xml`, format 4.
pub const RECHARGE: &str = include_str!("../trees/recharge.xml");
