//! Runs of scenarios: the simulated world, the channel system and its monitors, step by step.
//!
//! A [`Run`] advances step by step and describes itself in records; [`conduct`](recording::conduct) takes one from
//! start to end, and a [`Session`] is one in which a person intervenes.
//!
//! # Inside
//! `wiring` makes the processes of a scenario and chooses the scheduler. `injector` applies the faults that `timetable`
//! begins and ends: in the simulated world (`sim::Faults`), on a channel (`channels::Disturbance`), in a component
//! (`components::Software::freeze`), in a skill (`skills::Mutation`), in the ticks (`tick_clock`). `switched` has those
//! that a proof or a schedule begins and ends. `world` is the simulated robot with its software, and what devices sense
//! and move; a scenario without a map has a `World` that is only the time. `schedule_replay` performs the steps of a
//! schedule instead of drivers and physics. `partners` are the other programs that take part: a `controller` drives the
//! robot, and `remote_components` connects to components that are nodes of ROS 2. `ending` decides when a run ends.

mod controller;
mod end_is_final;
mod ending;
mod injector;
mod machines;
mod partners;
mod remote_components;
mod run;
mod schedule_replay;
mod session;
mod skill_errors;
mod source;
mod switched;
mod tick_clock;
mod timetable;
mod tree_watch;
mod truth;
mod wiring;
mod world;

pub use controller::{Controller, ControllerInput, ControllerOutput, Touched, TripCommand};
pub use injector::opposite;
pub use machines::record as machine_record;
pub use partners::Partners;
pub use remote::NodeMessage;
pub use remote_components::{Delivery, RemoteComponents};
pub use run::Run;
pub use session::Session;
pub use switched::{Switched, SwitchedEffect, restart};
pub use wiring::{Ids, Wired, topology, topology_for_properties, wire};
