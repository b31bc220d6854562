//! Reads and checks RoAML, the models of AS2FM, and turns them into processes of a channel system.
//!
//! A model is a main file, `<roaml>`, which names a behavior tree, machines in `.ascxml` files (ROS nodes, and plugins
//! for the leaves of the tree), and properties in JANI. [`Model::load`] reads it all and reports everything that is
//! wrong, with its location. [`Wiring`] makes processes and channels from it, and [`Model::monitors`] makes the
//! monitors of its properties. A scenario runs them.
//!
//! # From RoAML to channels
//! - Every ROS node is a process with the name of its machine, and every leaf of the tree is a process with the name of
//!   the leaf. A thread of an action server is a process, too: `server thread 0`.
//! - Each element that RoAML adds to SCXML stands for a transition or a `<send>`. The events have AS2FM's names:
//!   `topic_level_msg`, `srv_adder_request`, `action_go_to_goal_result`, `timer_my_timer`. A message on a channel is
//!   the event's name and its fields: `[<topic_level_msg>, 99]`. Arrays and structures are JSON texts.
//! - A message on a topic goes to each subscriber; none is lost. A server gets the next request once it has answered.
//!   An action server identifies its clients by `goal_id`.
//! - A machine is a [`skills::SkillProcess`] with its own kind of adapter. It never blocks: it always receives, and
//!   drops messages for which the current state has no transition.
//! - The process `Clock` has the timers. The process `Recorder` gets a copy of each message that a property is about.
//!
//! # Chance
//! A transition with several `<target prob="…">` draws from the random stream of its process, which the seed of the run
//! determines ([`skills::Machine::set_seed`]). The position in the stream is part of the machine's state, so the state
//! of a process is still a value.
//!
//! # Properties
//! The value of a JANI property is the probability of a formula `F`, `G`, `U` or `W` about conditions on the latest
//! messages, so in one run the formula is true or false. At the end of a run, anything that has not been reached is
//! false.
//!
//! # Inside
//! `machine/translate` rewrites an `.ascxml` file as SCXML, keeping the location of each piece (`machine/plain`), so
//! that `skills` compiles it and every message points into the original; `machine/vocabulary` is the table of RoAML's
//! elements. `system` declares the processes and channels; the machines are `skills::SkillProcess`es, with an adapter
//! between machine and channels that follows ROS's rules (`system/adapter`). `property` evaluates JANI's formulas on
//! the latest messages.

mod instance;
mod machine;
mod model;
mod property;
mod system;

pub use machine::Machine;
pub use model::{Model, ModelProcess, Parameters, is_model};
pub use property::{Property, PropertyMonitor};
pub use system::Wiring;
