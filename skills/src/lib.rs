//! Skills: an SCXML processor, and the machines of the shipped tree.
//!
//! A skill carries out what a leaf of the behavior tree decides. It is a state machine in an SCXML 1.0 file. This crate
//! compiles the file and runs it, alone or as a process of a channel system. It does not depend on trees, robots or the
//! simulation.
//!
//! - [`Chart`]: a machine as it was written, compiled once and shared. [`Chart::load`] reports all problems of a file
//!   at once, each with its location ([`SkillError`], [`diagnostics::Problem`]).
//! - [`Machine`]: a running chart. It follows the interpretation algorithm of the recommendation (Appendix D), gets
//!   events and time from its caller, and is a value that can be copied, compared and hashed.
//! - [`SkillProcess`]: a machine that communicates over channels.
//! - [`SHIPPED`]: the seven machines of the shipped tree, by the names of its leaves; [`ORIGINAL`]: those of the
//!   paper's published system.
//!
//! # What runs
//! All of SCXML 1.0 except the optional event I/O processor for HTTP: compound, parallel and final states, `<initial>`,
//! shallow and deep history; transitions with any number of events and targets, including internal ones; `<raise>`,
//! `<if>`, `<foreach>`, `<log>`, `<assign>`, `<script>`, `<send>` with delays, `<cancel>`, `<donedata>`; `<invoke>` of
//! machines inside the file, beside it ([`Chart::open`]) or computed, with `<finalize>` and `autoforward`; early and
//! late binding; `In()` and the system variables, including `_event.raw`, which contains all parameters, even several
//! with the same name; the data models `ecmascript` and `null`. Elements of other namespaces are ignored with a
//! warning. All mandatory W3C tests pass; the 12 optional ones that fail all need the BasicHTTP event I/O processor.
//!
//! ECMAScript runs at two speeds. Literals, data, `_event`, member access, operators, `?:` and assignments are compiled
//! here, and an event takes a few hundred nanoseconds and no memory. With the cargo feature `ecmascript`, everything
//! else goes to a real engine, QuickJS, which takes about a millisecond: functions, methods, loops, regular
//! expressions, `Math`, XML as objects. Without the feature, such an expression is refused, with its location, when the
//! file is loaded. Either way the state of a machine is a value. Data hold plain values: a function is kept as its
//! source and sees data but no variables around it, an object loses its class, and `Map` and similar classes are
//! refused.
//!
//! The engine uses the time of the run, random numbers seeded from the session's name ([`Machine::set_seed`]), and the
//! mathematics of libm. Each evaluation has its own engine, so errors leave no trace. A script's resources are counted
//! in the same way in every thread and on every computer: 200,000 calls and loop iterations, 4 MiB of memory, 256 KiB
//! of stack; the work of built-in functions is counted too. A block of executable content may take a million steps, and
//! a machine that takes four million without coming to rest is stopped. At most 4,096 events, including delayed ones,
//! may wait in a machine; raising or sending more is an error. `Proxy`, `BigInt`, typed arrays and `WeakRef` are not
//! available, because their work could not be counted.
//!
//! [`rehearse`] runs a machine alone, [`check_system`] checks a tree's skills against their channels, [`mutate`] puts a
//! mistake into a machine to test whether properties detect it.
//!
//! # Messages and events
//! A [`SkillProcess`] turns messages into events and events into messages:
//!
//! - The message `[<ok>, 83.2]` from the process BatteryReader becomes the external event `BatteryReader.ok`: the name
//!   of the sender, a dot, and the symbol with which the message begins (without such a symbol, only the name of the
//!   sender). Its `_event.data` has one member per field, with the names that the channel's domain gives them:
//!   `_event.data.level` is 83.2, `_event.data.status` is `"ok"`. Symbols are strings. `_event.origin` is
//!   `"BatteryReader"`.
//! - `<send type="channel" target="Navigation" event="get_status"><param name="place" expr="place"/></send>` sends
//!   `[<get_status>, <Destination>]` to the process Navigation: first the symbol that `event` names, then the
//!   parameters, each in the field with its name and converted to the field's kind. A string becomes a symbol or a
//!   text, a number an integer or a real; nothing else is converted. Literal parts are checked against the channels
//!   when the process is created. Computed parts are checked when the message is sent; a message that its channel
//!   cannot carry is `error.communication`.
//! - Each message has a [role](channels::Role). A *request* has a number, which its *reply* repeats. A machine answers
//!   each request once: an answer without a request is `error.communication`, and an error of the machine. Only the
//!   answer to the last request on a channel counts: other answers, and repeated ones, are received and dropped.
//! - A request from another machine becomes an event with its own name: the request `[<say>, "hello"]` is the event
//!   `say`, from any sender, and `<send type="channel" targetexpr="_event.origin" event="ok"/>` answers it. A client's
//!   next request is received when the last one has been answered. Requests of the tree are always received, and are
//!   the events `BT.tick` and `BT.halt`.
//! - An *action* takes time. The client sends the goal `pick.goal`, and may send `pick.cancel` while it is pursued. The
//!   other machine receives these events, and answers with `pick.rejected`, or with `pick.accepted`, any number of
//!   `pick.feedback`, and finally one of `pick.succeeded`, `pick.aborted` or `pick.canceled`; anything else is an error
//!   like an answer without a request. The client receives them with the name of the sender: `Arm.pick.feedback`. All
//!   messages of a goal carry its number. A cancel is answered by the end of its goal, whatever that is; one that
//!   arrives after the end is dropped.
//! - A *choice* is open: of the events that a machine sends with `<send type="choice" event="opens"/>` and that are
//!   due at the same time, it gets one, with the parameters as `_event.data`, before anything else happens to it. The
//!   others are gone. Whatever schedules the processes chooses.
//! - A *topic* is published by a `<send>` without a target, and is received by every process with a channel that
//!   carries it. While a message waits, a newer one of the same topic takes its place.
//! - The values that a leaf's ports read from the tree's blackboard come with each request: `_event.data.place` is the
//!   value of the port `place`, if it has one yet. If the machine has a datum `place`, it gets this value before the
//!   event is processed. The values that the ports write go with an answer: `<param name="found" expr="…"/>` in the
//!   `<send>` to BT. A port whose value is literal in the tree's file gets it when the machine starts
//!   ([`SkillProcess::new`]).
//! - A skill is always ready to receive. Its messages wait in order until their channel is free, and do not delay
//!   messages on other channels: a component that no longer listens does not keep its skill from answering the tree.
//! - `delay` is simulated time.
//!
//! ```
//! use channels::{Capacity, Domain, FieldKind, Process, Role, Shape, Topology};
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
//! topology.channel(skill, tree, Capacity::One, result.in_role(Role::Reply))?;
//! topology.channel(skill, reader, Capacity::One, request)?;
//! topology.channel(reader, skill, Capacity::One, reply.in_role(Role::Reply))?;
//!
//! let text = shipped("BatteryLevel").ok_or("not shipped")?;
//! let chart = Chart::load("BatteryLevel.scxml", text)?;
//! let process = SkillProcess::new("BatteryLevel", &chart, &topology, [("threshold", 25.0.into())])?;
//! assert_eq!(process.location(), "idle");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Inside
//! `load` reads a file into a `chart`, which `machine` runs: `machine/select` chooses transitions, `machine/macrostep`
//! takes them. `load/dialect` recognizes files that only look like SCXML. `expression` is the compiled subset of
//! ECMAScript; the rest goes to `engine`, which uses QuickJS with the feature `ecmascript` and refuses everything
//! without it. `rehearsal` runs a machine alone; `process` makes it a process of a channel system, and checks that all
//! machines fit their channels when a scenario is loaded. `mutation` introduces a mistake into a machine's text without
//! moving any line.

mod answers;
mod bit_set;
mod chart;
mod datum;
mod delay;
mod engine;
mod error;
mod event;
mod expression;
mod folder;
mod ids;
mod load;
mod machine;
mod mutation;
mod process;
mod quantity;
mod random;
mod rehearsal;
mod shipped;
mod steps;
mod texts;

pub use chart::{CHANNEL_PROCESSOR, CHOICE_PROCESSOR, Chart, HistoryKind, State, StateKind, Transition};
pub use datum::{Array, Datum, Object, TooLarge};
pub use error::{Concerns, SkillError};
pub use event::{Event, EventKind, Outgoing, Params};
pub use ids::{StateId, TransitionId};
pub use load::{attributes_of, elements_in, layout};
pub use machine::{Host, Machine, Note, Status, Transcript, Undelivered};
pub use mutation::{Mutation, SendPlace, TransitionPlace, find_mutation, mutate, mutate_all, mutations};
pub use process::{
    Adapter, AdapterState, CLIENT, ChannelAdapter, EventFields, LeafOfSystem, MessageForm, Mishap, SkillOfSystem,
    SkillProcess, Vocabulary, check_system, field_value,
};
pub use rehearsal::{Cue, Cues, Ending, RehearsalLine, RehearsalLineKind, rehearse};
pub use shipped::{ORIGINAL, SHIPPED, shipped};
pub use texts::{PassedText, ReceivedEvent, TextSources, TextUse};

/// How to treat an expression that cannot be compiled, an unknown name, or an invalid delay.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Strictness {
    /// The file is refused: an error that is known when the file is loaded should not wait until the robot drives.
    #[default]
    Strict,
    /// As in the recommendation: a warning, and `error.execution` when the machine gets there.
    Standard,
}
