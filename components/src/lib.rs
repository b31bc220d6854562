//! The components: BatteryReader, Localization and Navigation.
//!
//! A component has two parts: a process of the channel system that answers skills' requests, and a driver outside the
//! system that connects it with the robot. [`Software`] holds the drivers and what they drive: it reads the robot's
//! sensors, updates the pose estimate and the navigation, exchanges data with the three processes between steps, and
//! commands the base. It sees only the [`robot::Robot`] that it is given.
//!
//! [`operations`] lists the requests that the components understand. [`Blackboard`] and [`StopRule::AnyTrip`] belong to
//! the paper's published system, for skills that follow its protocol.
//!
//! In this example, a client requests the battery's level once:
//!
//! ```
//! use std::{sync::Arc, time::Duration};
//! use channels::{Capacity, ChannelSystem, Domain, GraphProcess, Message, Process, ProgramGraph, RoundRobin, Topology};
//! use components::{BATTERY_READER, BatteryReader, operations};
//! use maps::Places;
//! use robot::BatteryState;
//!
//! let mut topology = Topology::default();
//! let [client, reader] = [topology.process("Client")?, topology.process(BATTERY_READER)?];
//! let mut operations = operations(&Places::default());
//! operations.retain(|operation| operation.component == BATTERY_READER);
//! let requests = Domain::new(operations.iter().map(|operation| operation.request.clone()));
//! let replies = Domain::new(operations.iter().flat_map(|operation| operation.replies.clone()));
//! let request = topology.channel(client, reader, Capacity::One, requests)?;
//! let reply = topology.channel(reader, client, Capacity::One, replies)?;
//!
//! let mut graph = ProgramGraph::builder("Client");
//! let [start, waiting, done] = ["start", "waiting", "done"].map(|name| graph.location(name));
//! let level = graph.variable("level");
//! graph.send(start, request, Message::symbols(["get_level"]), waiting);
//! graph.receive(waiting, reply, level, done);
//! let graph = GraphProcess::new(Arc::new(graph.initial(start).build()?));
//!
//! let mut battery = BatteryReader::new(&topology, reader)?;
//! battery.update(&BatteryState { time: Duration::ZERO, charge_pct: 83.2, charging: false }); // `Software` does that
//! let processes = [(client, Box::new(graph) as _), (reader, Box::new(battery) as _)];
//! let mut system = ChannelSystem::new(Arc::new(topology), processes)?;
//! assert_eq!(system.run(&mut RoundRobin::default(), 100).count(), 2);
//! assert_eq!(system.process::<GraphProcess>(client).map(Process::location).as_deref(), Some("done"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Inside
//! A driver can be frozen (`Software::freeze`) and a component can be restarted.
//! docs/src/explanation/published-system.md explains how much of the published system is modeled
//! (`skills/machines/original/`). The scenario `late_halt` shows its flaw.

mod battery_reader;
mod blackboard;
mod component;
mod localization;
mod navigation;
mod operations;
mod service;
mod software;

pub use battery_reader::{BatteryHandler, BatteryReader};
pub use blackboard::{Blackboard, LockedValue};
pub use component::Component;
pub use localization::{AtPlaces, Localization};
pub use navigation::{Navigation, Order, StopRule, TripStatus, Trips};
pub use operations::{BATTERY_READER, BLACKBOARD, LOCALIZATION, NAVIGATION, Operation, operations};
pub use service::{Handler, Service};
pub use software::{Processes, Software};
