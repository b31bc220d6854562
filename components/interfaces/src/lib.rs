//! Interfaces of components: services, topics and actions.
//!
//! An [`Interface`] has typed fields. It comes from a TOML file, which may take fields from ROS 2 definitions, or is
//! built in code. It defines the messages on the channels between a component and its clients.
//!
//! ```
//! use std::path::Path;
//!
//! use interfaces::Interface;
//!
//! let text = r#"
//! [services.say]
//! request = { text = "text", loud = "bool?" }
//! reply = { seconds = "real" }
//!
//! [actions.pick]
//! goal = { object = ["cup", "box"] }
//! feedback = { height_m = "real" }
//! result = { weight_kg = "real" }
//! "#;
//! let read = |_: &Path| Ok(text.as_bytes().to_vec());
//! let helper = Interface::load(Path::new("helper.toml"), &[], &read)?;
//! let requests: Vec<String> = helper.requests().iter().map(ToString::to_string).collect();
//! assert_eq!(
//!     requests,
//!     [
//!         "[request: <say>, text: text, loud: bool | <none>]",
//!         "[request: <pick.goal>, object: <cup> | <box>]",
//!         "[request: <pick.cancel>]",
//!     ]
//! );
//! # Ok::<(), diagnostics::Error>(())
//! ```
//!
//! The keys of such a file are [`Interface::keys`]; [`Interface::load`] documents what it accepts. The crate
//! `steward-ros-messages` reads the ROS 2 definitions.
//!
//! # Inside
//! `file` reads an interface from TOML, `keys` lists the keys of the file. `packages` finds ROS 2 definitions, and
//! `flatten` turns them into tuples, since messages cannot be nested; `wire` is the way back.

mod field_path;
mod file;
mod flatten;
mod interface;
mod kind;
mod name;
mod packages;
mod wire;

pub use interface::{
    ABORTED, ACCEPTED, Action, CANCEL, CANCELED, ERROR, FEEDBACK, Field, GOAL, Interface, MAX_FIELDS, OK, Operation,
    REASON, REJECTED, REQUEST, RESERVED, STATUS, SUCCEEDED, Service, TOPIC, Topic,
};
pub use kind::KINDS;
pub use wire::{Wire, WirePart};
