//! Skills: an SCXML processor and the machines of the shipped tree.
//!
//! A skill carries out what a leaf of the behavior tree decides. It is a state machine that an engineer writes as an
//! SCXML 1.0 file; this crate compiles the file and runs it, alone or as a process of a channel system. It knows nothing
//! of trees, robots or simulation.
//!
//! - [`Chart`]: a machine as it was written, compiled once and shared. [`Chart::load`] says everything that is wrong
//!   with a file at once, each thing at its place ([`SkillError`], [`diagnostics::Problem`]).
//! - [`Machine`]: a chart at work. It follows the interpretation algorithm of the recommendation (Appendix D), takes
//!   events and time from its caller, and is a value that can be copied, compared and hashed.
//! - [`SkillProcess`]: a machine that talks over channels.
//! - [`SHIPPED`]: the seven machines of the shipped tree, by the names of its leaves; [`ORIGINAL`]: those of the paper's
//!   published system.
//!
//! # What runs
//! All of SCXML 1.0 but the optional event I/O processor of HTTP: compound, parallel and final states, `<initial>`, shallow
//! and deep history; transitions with any number of events and targets, internal ones too; `<raise>`, `<if>`, `<foreach>`,
//! `<log>`, `<assign>`, `<script>`, `<send>` with delays, `<cancel>`, `<donedata>`; `<invoke>` of machines that stand in the
//! file, beside it ([`Chart::open`]) or are computed, with `<finalize>` and `autoforward`; early and late binding; `In()`
//! and the system variables, with `_event.raw`, which tells all parameters, those of one name too; the data models
//! `ecmascript` and `null`. Elements of other namespaces are ignored with a warning. Of W3C's tests the mandatory ones pass;
//! the 12 optional ones that fail all need the BasicHTTP event I/O processor.
//!
//! ECMAScript runs at two speeds. Literals, data, `_event`, member access, operators, `?:` and assignments are compiled here,
//! and an event costs a few hundred nanoseconds and no memory. With the cargo feature `ecmascript` everything else goes to
//! a real engine, QuickJS, which costs about a millisecond: functions, methods, loops, regular expressions, `Math`, XML as
//! objects. Without it, such an expression is refused with its place when the file is loaded. Either way the state of a
//! machine is a value. Data hold what is plain: a function is kept as its source and sees data but no variables around it,
//! an object loses its class, `Map` and its kin are refused.
//!
//! The engine's time is that of the run, its chance begins with the session's name ([`Machine::set_seed`]), its mathematics
//! is libm's. Each evaluation has an engine of its own, so that nothing is left of an error. What a script may take is
//! counted, alike in every thread and on every machine: 200,000 calls and rounds of loops, 4 MiB of memory, 256 KiB of
//! stack; what its built-in functions do is counted too. A block of executable content may take a million steps, and a
//! machine that has taken four million without coming to rest is stopped; 4,096 events may wait in it, delayed ones
//! included, and what it raises or sends beyond is an error. `Proxy`, `BigInt`, typed arrays and `WeakRef` are
//! not there, for what they do could not be counted.
//!
//! [`rehearse`] runs a machine alone, [`check_system`] holds a tree's skills against their channels, [`mutate`] puts a
//! mistake into a machine to see who notices.
//!
//! # Messages and events
//! A [`SkillProcess`] turns messages into events and events into messages:
//!
//! - The message `[<ok>, 83.2]` from the process BatteryReader becomes the external event `BatteryReader.ok`: the name
//!   of the sender, a dot, the symbol that the message begins with (without one, the name of the sender alone). Its
//!   `_event.data` has a member per field, by the names that the channel's domain gives them: `_event.data.level` is 83.2,
//!   `_event.data.status` is `"ok"`. Symbols are strings. `_event.origin` is `"BatteryReader"`.
//! - `<send type="channel" target="Navigation" event="get_status"><param name="place" expr="place"/></send>` sends
//!   `[<get_status>, <Destination>]` to the process Navigation: first the symbol that `event` names, then the parameters,
//!   each in the field of its name and as what the field holds. A string becomes a symbol where a symbol belongs and text
//!   where text does, a number an integer or a real; nothing else is converted. What is written out in the file is checked
//!   against the channels when the process is made; what is computed, when it is sent, and then a message that its channel
//!   cannot carry is `error.communication`.
//! - What comes from the process BT is a request, and what goes to BT answers the last one and echoes its number. One
//!   request is answered once: an answer without a request is `error.communication`. What goes to any other process is a
//!   request with a number of its own, and of what comes back only the answer to the last one counts: others, and the
//!   same one again, are received and dropped. Who sends without being asked is always heard.
//! - What the ports of a leaf read from the tree's blackboard comes with each request: `_event.data.place` is the value of
//!   the port `place`, if there is one yet, and the datum `place` of the machine, if it has one, gets it before the event
//!   comes. What the ports write goes with an answer: `<param name="found" expr="…"/>` in the `<send>` to BT. A port whose
//!   value stands in the tree's file is given when the machine starts ([`SkillProcess::new`]).
//! - A skill is always ready to receive. What it sends waits until the channel is free, in order, and does not keep
//!   messages on other channels waiting: a component that has stopped listening does not keep its skill from answering
//!   the tree.
//! - `delay` is simulated time.
//!
//! ```
//! use channels::{Capacity, Domain, FieldKind, Process, Shape, Topology};
//! use skills::{Chart, SkillProcess, shipped};
//!
//! let mut topology = Topology::default();
//! let [tree, skill, reader] = ["BT", "BatteryLevel", "BatteryReader"].map(|name| topology.process(name));
//! let (tree, skill, reader) = (tree?, skill?, reader?);
//! let symbols = |name, symbols| Shape::new([(name, symbols)]);
//! let call = Domain::new([symbols("call", FieldKind::symbols(["tick", "halt"]))]);
//! let result = Domain::new([symbols("result", FieldKind::symbols(["success", "failure", "halted"]))]);
//! let request = Domain::new([symbols("request", FieldKind::symbols(["get_level"]))]);
//! let reply = Domain::new([
//!     Shape::new([("status", FieldKind::symbols(["ok"])), ("level", FieldKind::Real)]),
//!     Shape::new([("status", FieldKind::symbols(["error"])), ("reason", FieldKind::Text)]),
//! ]);
//! topology.channel(tree, skill, Capacity::One, call)?;
//! topology.channel(skill, tree, Capacity::One, result)?;
//! topology.channel(skill, reader, Capacity::One, request)?;
//! topology.channel(reader, skill, Capacity::One, reply)?;
//!
//! let text = shipped("BatteryLevel").ok_or("not shipped")?;
//! let chart = Chart::load("BatteryLevel.scxml", text)?;
//! let process = SkillProcess::new("BatteryLevel", &chart, &topology, [("threshold", 25.0.into())])?;
//! assert_eq!(process.location(), "idle");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod chart;
mod datum;
mod delay;
mod engine;
mod error;
mod expression;
mod load;
mod machine;
mod mutation;
mod process;
mod rehearsal;
mod shipped;
mod steps;
mod unobserved;

pub use chart::{CHANNEL_PROCESSOR, Chart, HistoryKind, State, StateId, StateKind, Transition, TransitionId};
pub use datum::{Array, Datum, Object, TooLarge};
pub use error::{Concerns, SkillError};
pub use machine::{Event, EventKind, Host, Machine, Note, Outgoing, Params, Status, Transcript, Undelivered};
pub use mutation::{Mutation, SendPlace, TransitionPlace, mutate, mutate_all, mutations};
pub use process::{CLIENT, LeafOfSystem, Mishap, SkillOfSystem, SkillProcess, check_system};
pub use rehearsal::{Cue, Cues, Ending, Line, LineKind, rehearse};
pub use shipped::{ORIGINAL, SHIPPED, shipped};

/// What becomes of an expression that cannot be compiled, a name that stands for nothing, a delay that is none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Strictness {
    /// The file is refused: what can be known to fail when it is loaded need not wait until the robot drives.
    #[default]
    Strict,
    /// As the recommendation has it: there is a warning, and `error.execution` when the machine gets there.
    Standard,
}
