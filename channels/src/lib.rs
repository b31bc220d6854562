//! Channel systems of program graphs, after the paper's sections "Representation of BTs" and "Runtime verification".
//!
//! A system is made of processes that move on their own and talk over channels that hold at most one message.
//!
//! - A [`Topology`] says which processes and channels there are, and which messages ([`Domain`]) a channel carries.
//! - A [`Process`] offers transitions and takes one of them: a [`ProgramGraph`] at work is one ([`GraphProcess`]), and
//!   so are behavior trees, SCXML machines and components, which live in crates of their own.
//! - A [`ChannelSystem`] puts processes together. At each step a [`Scheduler`] picks one of the enabled transitions. A
//!   channel of capacity 1 takes a message when it is empty and gives it when it is full; over a channel of capacity
//!   0, sender and receiver move together.
//! - What comes out is the timed state sequence: an [`Event`] for each message received and each tick generated.
//! - A [`Disturbance`] lets a channel lose, hold back, repeat or change what it carries; a process can be suspended or
//!   given another behaviour. So a system can be watched while something is wrong with it.
//! - A [`Monitor`] moves in the very step in which the message it waits for is received, and changes nothing.
//!
//! A system that asks a reader for a level, once, and a monitor that watches the answer:
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
mod message;
mod monitor;
mod process;
mod scheduler;
mod system;
mod tick;
mod topology;
mod value;

pub use condition::{Assignment, Condition, Content, Evaluation, Relation, Term, VariableId};
pub use disturbance::{Chance, Concern, Corruption, Disturbance, Effect};
pub use domain::{Domain, FieldKind, Shape};
pub use error::{RunError, WiringError};
pub use event::{Event, EventKind};
pub use graph::{GraphBuilder, GraphProcess, GraphTransition, Label, LocationId, ProgramGraph, Slot};
pub use message::{Envelope, Message, RequestNumber};
pub use monitor::{GraphMonitor, Monitor, Verdict};
pub use process::{Action, Offer, Pattern, Process, ProcessState, TransitionId, Use};
pub use scheduler::{Delivery, Ordered, Precedence, Random, RoundRobin, Scheduler, Scripted, Starving};
pub use system::{Attached, ChannelSystem, DisturbanceId, Enabled, EnabledKind, Run};
pub use tick::TickGenerator;
pub use topology::{Capacity, Channel, ChannelId, ProcessId, Topology};
pub use value::{Symbol, Value};
