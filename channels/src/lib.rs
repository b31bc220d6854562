//! Channel systems of program graphs, after the paper's sections "Representation of BTs" and "Runtime verification".
//!
//! A system consists of processes that move independently and communicate over channels that hold at most one message.
//!
//! - A [`Topology`] declares the processes and channels, and the messages ([`Domain`]) that each channel carries.
//! - A [`Process`] offers transitions and takes one of them. A running [`ProgramGraph`] is a process
//!   ([`GraphProcess`]); so are behavior trees, SCXML machines and components, which have their own crates.
//! - A [`ChannelSystem`] combines processes. At each step a [`Scheduler`] picks one of the enabled transitions. A
//!   channel of capacity 1 accepts a message when it is empty and delivers it when it is full. Over a channel of
//!   capacity 0, sender and receiver move together.
//! - The result is the timed state sequence: one [`Event`] per message received and per tick generated.
//! - A [`Disturbance`] makes a channel lose, delay, repeat or change messages. A process can be suspended, or its
//!   behavior replaced. This shows how a system reacts to faults.
//! - A [`Monitor`] moves in the very step in which the message it waits for is received, and changes nothing.
//!
//! In this example, a skill asks a reader once for a level, and a monitor checks the answer:
//!
//! ```
//! use std::sync::Arc;
//! use channels::{
//!     Capacity, ChannelSystem, Domain, FieldKind, GraphMonitor, GraphProcess, Message, ProgramGraph, Relation,
//!     RoundRobin, Shape, Topology, Value, Verdict,
//! };
//!
//! let mut topology = Topology::default();
//! let [skill, reader] = [topology.process("BatteryLevel")?, topology.process("BatteryReader")?];
//! let get_level = Shape::new([("request", FieldKind::symbols(["get_level"]))]);
//! let level = Shape::new([("status", FieldKind::symbols(["ok"])), ("level", FieldKind::Real)]);
//! let requests = topology.channel(skill, reader, Capacity::One, Domain::new([get_level]))?;
//! let replies = topology.channel(reader, skill, Capacity::One, Domain::new([level]))?;
//!
//! let mut ask = ProgramGraph::builder("BatteryLevel");
//! let [start, wait, done] = ["start", "wait", "done"].map(|name| ask.location(name));
//! let answer = ask.variable("answer");
//! ask.send(start, requests, Message::symbols(["get_level"]), wait);
//! ask.receive(wait, replies, answer, done);
//!
//! let mut read = ProgramGraph::builder("BatteryReader");
//! let [idle, asked] = ["idle", "asked"].map(|name| read.location(name));
//! read.receive(idle, requests, Message::symbols(["get_level"]), asked);
//! read.send(asked, replies, Message::new([Value::symbol("ok"), 10.0.into()]), idle);
//!
//! let mut phi1 = ProgramGraph::builder("phi1");
//! let [watching, get, failure] = ["idle", "get", "failure"].map(|name| phi1.location(name));
//! let m = phi1.variable("m");
//! phi1.receive(watching, replies, m, get);
//! phi1.internal(get, m.field(2).compare(Relation::GreaterOrEqual, 20), [], watching);
//! phi1.internal(get, m.field(2).compare(Relation::Less, 20), [], failure);
//!
//! let ask = GraphProcess::new(Arc::new(ask.initial(start).build()?));
//! let read = GraphProcess::new(Arc::new(read.initial(idle).build()?));
//! let processes = [(skill, Box::new(ask) as _), (reader, Box::new(read) as _)];
//! let mut system = ChannelSystem::new(Arc::new(topology), processes)?;
//! system.attach(Box::new(GraphMonitor::new(Arc::new(phi1.initial(watching).build()?), [failure])));
//!
//! let events = system.run(&mut RoundRobin::default(), 100).collect::<Result<Vec<_>, _>>()?;
//! assert_eq!(events.len(), 2); // get_level was received, and so was its answer
//! assert_eq!(system.monitors()[0].monitor.verdict(), Verdict::False); // 10 % is less than 20 %
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod condition;
mod disturbance;
mod domain;
mod error;
mod event;
mod graph;
mod ground;
mod message;
mod monitor;
mod normal;
mod possible;
mod process;
mod run;
mod scheduler;
mod shared;
mod subscriber;
mod system;
mod tick;
mod topology;
mod unobserved;
mod value;

pub use condition::{Assignment, Condition, Content, Evaluation, Relation, Term, VariableId};
pub use disturbance::{Chance, Concern, Corruption, Disturbance, Effect};
pub use domain::{Domain, FieldKind, Role, Shape};
pub use error::{RunError, WiringError};
pub use event::{Event, EventKind, Flaw, Gap};
pub use graph::{GraphBuilder, GraphProcess, GraphTransition, Label, LocationId, ProgramGraph, Slot};
pub use ground::Ground;
pub use message::{Envelope, Message, RequestNumber};
pub use monitor::{GraphMonitor, Monitor, Verdict};
pub use normal::{NoNormalForm, NormalForm};
pub use possible::{Beyond, Choice, Comparisons, Possible};
pub use process::{Action, Offer, Pattern, Process, ProcessState, TransitionId, Use};
pub use run::Run;
pub use scheduler::{Delivery, Ordered, Precedence, Random, RoundRobin, Scheduler, Starving};
pub use shared::Shared;
pub use subscriber::Subscriber;
pub use system::{Attached, ChannelSystem, DisturbanceId, Enabled, EnabledKind};
pub use tick::TickGenerator;
pub use topology::{Capacity, Channel, ChannelId, ProcessId, Topology};
pub use unobserved::Unobserved;
pub use value::{Symbol, Value};
