//! What takes part in a run from ROS 2, in a DDS domain: nodes that drive the simulated robot, and nodes that are
//! components of its scenario. All of it needs the feature `dds`.
//!
//! - `Robots`: a scenario's robot as a node, or one in each of several namespaces. In its run, each is the
//!   [`Controller`](runs::Controller): it publishes what the robot senses, and passes on the commands of other nodes.
//!   If its own software navigates, it serves Nav2's action `navigate_to_pose`. It also serves the scenario's
//!   components.
//! - `ComponentNodes`: the components of a scenario that are nodes. In a run, they are its
//!   [`RemoteComponents`](runs::RemoteComponents).
//!
//! Both are made from a scenario, which checks their names, and then join a domain. Both read the clock: other nodes
//! live in real time. A function that the caller gives is called with what a user should know.
//!
//! # Inside
//! A robot is a `RosRobot`. Its names are `topics` and `frames`; its messages come and go at a `Station` of the `hub`,
//! which all robots of a process share and which keeps their steps together. `pace` decides when a step is due and
//! which of the `commands` is obeyed, `navigation` is the action's server, and `lifecycle` has the states of the nodes
//! of Nav2 that it replaces. An `exchange` passes the requests of other nodes on. For `remote_components`, `time` is
//! the run's time, and `losses` are the messages that DDS has lost.

#[cfg(feature = "dds")]
mod remote_components;
#[cfg(feature = "dds")]
mod robots;

#[cfg(feature = "dds")]
pub use remote_components::ComponentNodes;
#[cfg(feature = "dds")]
pub use robots::{BoxedController, PaceConfig, RobotConfig, Robots};
