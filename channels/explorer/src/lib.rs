//! Model checking of channel systems: every schedule and every environment, against the monitors of a run.
//!
//! A run of a [`ChannelSystem`](channels::ChannelSystem) shows one behavior. [`explore`] searches all of them: every
//! choice of a scheduler, everything that an [`Environment`] may do between the steps, and every loss, repetition or
//! delay of a message that the [`Model`] allows, for any number of ticks. The result is a proof, or a shortest
//! [`Path`] to a violation, which can be [replayed](Path::replay) in the channel system with the ordinary monitor.
//!
//! ```
//! use std::sync::Arc;
//! use channels::{
//!     Capacity, ChannelSystem, Domain, FieldKind, GraphProcess, Message, Process, ProgramGraph, Shape, Topology,
//! };
//! use explorer::{Closed, Environment, Limits, Model, Outcome, explore};
//!
//! let mut topology = Topology::default();
//! let names = ["Anna", "Ben"];
//! let [anna, ben] = [topology.process(names[0])?, topology.process(names[1])?];
//! let domain = || Domain::new([Shape::new([("word", FieldKind::symbols(["hello"]))])]);
//! let to_ben = topology.channel(anna, ben, Capacity::One, domain())?;
//! let to_anna = topology.channel(ben, anna, Capacity::One, domain())?;
//! let hello = Message::symbols(["hello"]);
//! // Each of them answers every message, forever.
//! let polite = |name, from, to, is_first| -> Result<Box<dyn Process>, channels::WiringError> {
//!     let mut graph = ProgramGraph::builder(name);
//!     let [waiting, answering] = ["waiting", "answering"].map(|name| graph.location(name));
//!     graph.receive(waiting, from, hello.clone(), answering);
//!     graph.send(answering, to, hello.clone(), waiting);
//!     let graph = graph.initial(if is_first { answering } else { waiting }).build()?;
//!     Ok(Box::new(GraphProcess::new(Arc::new(graph))))
//! };
//! let [first, second] = [polite(names[0], to_anna, to_ben, true)?, polite(names[1], to_ben, to_anna, false)?];
//! let processes = [(anna, first), (ben, second)];
//! let system = ChannelSystem::new(Arc::new(topology), processes)?;
//!
//! let model = Model::new(&system, None, Closed.erased());
//! let found = explore(&model, None, &Limits::default(), &mut |_| ())?;
//! assert!(matches!(found.outcome, Outcome::Livelock(_))); // time never passes
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # States
//!
//! A state is the [normal form](channels::NormalForm) of all processes, channels and the monitor, of the environment
//! and of the clock. Each state of a process is stored once and has a number, and its transitions are computed once. So
//! a state of the system is a vector of small numbers, packed into a few words.
//!
//! In a state in which no process can move, time passes until the next timer or tick: the environment makes one of its
//! moves, timers that are due fire, and the tick arrives. The tick is lost if the tree has not finished the previous
//! one.
//!
//! A process may keep any number of messages and timers. One in which more than
//! [`NormalForm::QUEUE`](channels::NormalForm::QUEUE) of them wait has no normal form: the step that leads there is a
//! step like any other, so no time passes instead of it, but what follows is not searched. The outcome is
//! [`Outcome::Endless`] then, unless another run violates the property.
//!
//! # What the reduction leaves out
//!
//! With a [`Reduction`], a process that can do nothing but send does so before all others move, provided that its
//! channel is empty, no other process sends on it, and no fault can act on the message. No process can prevent the
//! send, the send prevents nothing else, and no monitor sees it, since monitors see messages when they are received. So
//! a run in which the process sends later is equivalent to one in which it sends now (the send is a persistent set):
//! the same processes take the same steps, and the same messages are received in the same order. No other step is
//! postponed forever, since sends alone never form a cycle: each fills a channel.
//!
//! A state with a single successor, in which no time passes, is passed through: the search goes on to its successor and
//! stores that. Every run of the model is still a run through the stored states, with the same transitions in between:
//! a run that reaches a state that is passed through has no choice, so it goes on as the search does. The monitor sees
//! the same messages in the same order. So the verdicts are the same, and so are the states in which time passes, since
//! these are never passed through. Every 64th state in a row is stored, so every cycle contains a stored state and
//! every walk ends. States that are passed through do not count as layers, so a run that the search finds may not be a
//! shortest one.
//!
//! # Depth first
//!
//! [`Order::Depth`] expands the state that was found last. It stores the same states, so its verdicts are the same. It
//! soon reaches violations that take many steps, such as a missed deadline of many ticks, without first exploring
//! everything that may happen earlier. The runs that it shows are long.
//!
//! # Asking SPIN
//!
//! [`promela`] writes a model as a program for [SPIN](https://spinroot.com). The program has a guarded step for each
//! transition of each process, and SPIN itself composes the steps. Without partial-order reduction and dataflow
//! optimizations (`spin -a -o1 -o2 -o3`, `-DNOREDUCE`), SPIN stores as many states as a search without [`Reduction`].
//!
//! # Inside
//! `model` defines the searched system, and `environment` what drives it; `tables` computes each step of a process
//! once; `semantics` applies the rules of channel systems to those tables; `store` keeps each state in a few packed
//! words; `search` works breadth-first, layer by layer, on several threads; `passage` is the reduction; `path` replays
//! a run that the search found; `substitute` finds whether another process would change nothing in what was explored;
//! `promela` writes the same model for SPIN.

mod environment;
mod error;
mod interner;
mod local;
mod model;
mod passage;
mod path;
mod promela;
mod search;
mod semantics;
mod store;
mod substitute;
mod tables;

pub use environment::{AnyEnvironment, Closed, Environment, EnvironmentState, Instant, Move};
pub use error::Refused;
pub use model::{Damage, MessageFaults, Model, Onlooker, Ticks};
pub use path::{Path, PathStep, Performed, Performer, Replay, ReplayError, Update};
pub use promela::{NotExported, Promela, promela};
pub use search::{Exploration, Limit, Limits, Order, Outcome, Progress, Reduction, explore};
pub use tables::check;
