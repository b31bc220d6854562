//! Runtime monitors over the channels of a system, made from properties in the SCOPE language.
//!
//! A property file is text:
//!
//! ```text
//! const theta := 10
//! property phi1 := always (BatteryReader, BatteryLevel, m[1] = <ok> implies m[2] >= 20)
//! ```
//!
//! [`load`] reads it, reports all its problems at once, and makes a [`ScopeMonitor`] of each property. A monitor sees
//! the events of a run one by one, either from the channel system that it is attached to or, through [`verify`], from a
//! recorded log. Its verdicts are three-valued, and true and false are final; [`Outcome`] is the result at the end of a
//! run. The two properties of the paper also exist as hand-built program graphs after its monitor figure, [`phi1`] and
//! [`phi2`]; tests compare the synthesized monitors with them.
//!
//! # The language
//!
//! This is the grammar of the paper's figure, extended by operators that look back; the comment at the top of
//! `syntax/parse.rs` gives it in full:
//!
//! ```text
#![doc = include_str!("grammar.txt")]
//! ```
//!
//! with the abbreviations `false`, `implies`, `eventually α` (`true until α`) and `always α` (`not eventually not α`).
//! `not`, `next`, `always`, `eventually`, `once`, `historically`, `previous` and `becomes` bind tightest, then `until`
//! and `since`, `and`, `or` and `implies`; `until`, `since` and `implies` group to the right. Operators can also be
//! written as signs: `¬ ! ∧ ∨ → -> ⇒ □ ◇ ○ ⊤ ⊥ ≤ ≥ ≠`. Fields are `m[1]`, `m[2]`, … or the names that the channel's
//! domain gives them, `m.level` or just `level`: such a field is missing in every message that has no field with that
//! name, whatever else the message has at its position, and whatever it is compared with. A bound is a number of ticks
//! or a duration (`< 30 s`; ms, s, min, h). `//` begins a comment. A parenthesis that opens right after `always`,
//! `eventually`, `next` or `not` and is never closed is read as closed at the property's end, with a warning, because
//! the paper prints φ2 this way.
//!
//! # The semantics
//!
//! The paper defines SCOPE as TPTL on timed state sequences. This leaves open some questions that matter in a system of
//! channels, where two channels never carry a message in the same step; this section settles them.
//!
//! *States.* There is one state for each message received between processes, and one for each tick *generated*, whether
//! or not a process takes it. τi is the number of the last tick generated at state i; the tick's own state already has
//! it. A formula sees the ticks and the messages on the channels that its clause form mentions; i = 0 is the first of
//! those states. So a message on another channel before the first tick is not a state: the sequence has not begun. In
//! `next (E implies true)`, the clause form of which is `next true`, E is such a channel. The world shows what is true
//! to all properties at once: of its messages, a formula sees only those in which a field that it mentions has changed.
//!
//! *Atoms.* An event (p, q, c) holds at i if the **last** message that q received from p, up to and including i,
//! satisfies c. Before the first message it is false for any c. In c, a field that is missing or of another type makes
//! `=`, `<`, `<=`, `>` and `>=` false, and `m[k] != v` means `not (m[k] = v)`. Integers and reals compare as numbers,
//! without rounding.
//!
//! With `*` for a process, an event stands for the disjunction of the events on all channels that fit, and whose
//! messages the condition can be about: the last message on *one* of them satisfies c. `becomes α` is `α and not
//! previous α`.
//!
//! `fresh (p, q, c)` holds at i if state i *is* a message that q receives from p, and it satisfies c. It is an own atom
//! (see below), as the event is.
//!
//! *Timed events.* `time_until (e) ⋈ θ` holds at i if a message that satisfies e **passes** at some j ≥ i with
//! τj − τi ⋈ θ. It refers to any such message, not only to the first, and j = i counts: x. ◇ y. (e ∧ y − x ⋈ θ) in
//! TPTL. It is an atom for any bound: `time_until (e) < 0` is never true, but the part that contains it is checked as
//! with any other bound.
//!
//! *Clause form.* `not` is pushed to the atoms. The operand of `always` and the left of `until` become clauses (an
//! `and` of `or`s), the operand of `eventually` and the right of `until` become products (an `or` of `and`s). A part
//! that contains another part is dropped. A part's *own* atoms are its events, fresh or not, outside any further
//! temporal operator or `time_until`; its own channels are the channels of these events.
//!
//! *When a part is checked.* A part is checked in the states in which one of its own channels carries a message. A part
//! without own atoms is checked at every tick, and at the messages on the channels of its literals about the past.
//! Then, at state i:
//!
//! | formula | holds at i if |
//! |---|---|
//! | `next α` | α holds at the first j > i at which one of α's own channels carries a message |
//! | `always α` | each clause of α holds at every j ≥ i at which it is checked |
//! | `eventually α` | some product of α is checked and holds at some j ≥ i |
//! | `α until β` | a product of β is checked and holds at a j ≥ i; each clause of α, where it is checked at i ≤ k < j |
//!
//! For an α without atoms of its own, `next` looks at the first state after i at which such a part is checked: the next
//! tick, if α does not look back.
//!
//! *Operators that look back* are defined by the same clauses and products, and describe at state i what has happened
//! up to it:
//!
//! | formula | holds at i if |
//! |---|---|
//! | `once[⋈ θ] α` | some product of α was checked and held at some j ≤ i with τi − τj ⋈ θ |
//! | `historically[⋈ θ] α` | each clause of α held at every j ≤ i with τi − τj ⋈ θ at which it was checked |
//! | `previous[⋈ θ] α` | α held at the last j < i at which one of α's own channels carried a message, if τi − τj ⋈ θ |
//! | `α since[⋈ θ] β` | a product of β held at a checked j ≤ i, τi − τj ⋈ θ; each clause of α at checked j < k ≤ i |
//! | `at most n e in θ` | at no more than n states j ≤ i with τi − τj < θ a message passed that satisfies e |
//! | `at least n e in θ` | at no fewer |
//!
//! `at least 0` is `true`, and is checked as `true` is. Without `[⋈ θ]`, any distance will do. j = i counts, except for
//! `previous`, which is false where nothing was checked before. The atoms inside these operators are not own atoms of
//! any part. They cannot contain operators that look ahead. The window `in θ` is half-open: with one tick per second,
//! `in 10 s` covers the last ten ticks, including this one.
//!
//! A property holds on a sequence if it holds at 0. An event outside every temporal operator is refused: it would be
//! checked in a state before any message.
//!
//! *Timed properties.* In a `timed property`, τi is the time of state i instead, and θ a duration, exact to the
//! nanosecond. Ticks and messages are the states as before; time passes between any of them. A deadline that passes in
//! silence is noticed at the first event after it, at the next tick at the latest; the witness names the moment itself.
//! Nothing else changes, except that there are no automata, since time has no letters.
//!
//! *Remembered values.* `m[k] as x` in an event holds if the message has the field, and x is then the value of that
//! field in the last message on the event's channel. In the state in which a part is checked, it assigns values to the
//! names in its own events (the freeze quantifier of TPTL, on data); the whole part can compare with them, including
//! all operators inside it, at any depth. So `always (A with m[2] as x implies time_until B with m[2] = x < 5)` waits,
//! for each A, for a B with the same value. A name must have exactly one value wherever it is used, and must not be
//! that of a constant.
//!
//! *Terms.* `+`, `-` and `*` of two integers give an integer; all other arithmetic gives a real. A term with a
//! missing field, a value that is not a number, a division by zero or an infinite result has no value,
//! and compares like a missing field: only `!=` holds.
//!
//! *Laws.* De Morgan's laws, distribution, absorption, currying, double negation and the laws of `true` and `false`
//! rewrite a formula under any operator without changing a verdict. The excluded middle does not: `next (A or not A)`
//! waits for a message on A's channel, `next true` for a tick. `always` and `eventually` are each other's
//! duals, and idempotent; `always (f and g)` is `always f and always g` unless a clause of one subsumes a clause of the
//! other. (`always ((a or b) and a)` is `always a` by absorption. `always (a or b)` alone is also checked at a message
//! on b's channel before the first message on a's, and can fail there.)
//!
//! *The end of a run.* A finite sequence is judged as if nothing followed: a `next` without a next state, an `until` or
//! `eventually` that was not reached and a `time_until` whose message has not passed are false, and their negations are
//! true. [`holds`] implements this definition literally. It is slow and simple, and it is the oracle for everything
//! else in this crate.
//!
//! *Endless runs.* A run that has not ended is assumed to continue forever. An endless continuation is any infinite
//! sequence of ticks and of messages on all channels, within their domains. Only ticks advance time: each tick raises τ
//! by one (the first tick seen may leave it unchanged), messages do not. Nothing has to occur again, not even a tick.
//! The visible part of an endless run may therefore be finite; this is called silence, and the formula is then judged
//! as at the end of a run. [`holds_endlessly`] is the definition on sequences that repeat themselves.
//!
//! *Verdicts.* A monitor is three-valued, as in LTL3. After a prefix of a run the verdict is *false* if the formula is
//! false on every endless continuation, *true* if it is true on all of them, and open otherwise. `always (Q implies
//! time_until Q > 0)`, like every other recurrence, stays open while the run continues: Q may or may not occur again
//! and again. At the end of the run the property is *violated* if the verdict is false, otherwise *satisfied* if it
//! holds on the finished run, otherwise *inconclusive*: an obligation is still pending
//! ([`ScopeMonitor::open_obligations`]).
//!
//! Verdicts rely on these assumptions about endless runs. After a message outside its channel's domain, or if ticks are
//! missing in a log, a formula whose verdict is open is judged by what has happened; an earlier verdict stays.
//!
//! # The monitors
//!
//! Formulas that are `always` of clauses of the present, or of one clause with a deadline, become program graphs in the
//! shape of the paper's figure, with one number for the oldest open obligation ([`Method::Graph`]). Others become
//! automata whose letters are the classes of messages that the formula distinguishes, with at most
//! [`Limits::automaton_states`] states ([`Method::Automaton`]). Both give each verdict as early as possible: for each
//! state of an automaton, the possible outcomes of all endless words are computed in advance. A formula that is too
//! large causes a warning when it is loaded. It is monitored by progression ([`Method::Progression`]) or, if it
//! consists of several clauses with deadlines, by their graphs side by side ([`Method::Graphs`]). These are never
//! wrong, but late when several obligations contradict each other.
//!
//! An operator that looks back keeps how long ago its operand held, and only as precisely as its bound can distinguish:
//! the last time for `once[<= 5]`, the first for `once[>= 5]`, each time within 5 ticks for `once[= 5]`, and the last
//! four messages for `at most 3`. So it has finitely many states, and they are part of an automaton's: its verdicts are
//! as early with them as without. If the automaton would be too large, the clauses become rules ([`Method::Rules`]): a
//! violation is noticed as early, but if the formula can no longer be violated (because `once` has held, say), this is
//! noticed only at the end.
//!
//! Time and remembered values have no letters. Rules with times are as exact as rules with ticks. A formula that
//! remembers values is monitored by progression, with the values in its obligations: one for each value that is waited
//! for. An operator that looks back at values keeps the messages within its bound, so it must have a bound (except
//! `previous`). Both are [`Method::Rules`] if the formula has the form of rules: a violation then comes as early as
//! possible. Conditions on several fields or with arithmetic are judged exactly, but not foreseen: which of them
//! contradict each other is unknown.
//!
//! A monitor's normal form, for proofs, contains the ages and values that matter. A timed formula has no normal form,
//! nor has one that looks back at values; both report that.
//!
//! An automaton is not minimized: its states are the possible sets of obligations, and the limit applies to their
//! number. Without windows they have a unique form. In practice, two things exceed the limit: windows that do not begin
//! now (`= 30` after each of many messages: two to the power of 30 states, minimized or not) and products of long
//! deadlines. A formula whose automaton would fit the limit only after minimization counts as too large.
//!
//! The paper's response monitor starts its timer at θ and fails on the tick that finds it at 0, one tick later than `<
//! θ` demands. The formula is the requirement, and the synthesized monitor follows it.
//!
//! # Why a property is violated
//!
//! A [`Witness`] names the clause, the messages that made its antecedent hold or that were forbidden, the deadline, and
//! what was missing. If a verdict comes early because clauses contradict each other, it names a minimal set of such
//! clauses. If clauses cannot be distinguished (`until`, `next`, nested operators), it names the whole formula, the
//! messages from which an obligation began, the last messages, and a deadline if one has passed. One message is
//! remembered per channel and clause, so memory does not grow with the run. For overlapping obligations with windows
//! that do not begin now, only the antecedent of the first is known.
//!
//! # How this is tested
//!
//! - `cargo test -p steward-monitors`: on ten thousand random pairs of a formula and a sequence, the oracle, automaton,
//!   progression and program graph agree at every prefix with a second definition, which shares no code with them and
//!   compares numbers as integers of 128 bits. Wherever an automaton gives no verdict, it names an endless word for
//!   either outcome, and the definition confirms both. Verdicts also agree with random endless words. Every printed
//!   formula reads back as the same formula. Proofs about random systems agree with an enumeration of their runs.
//!   Further tests check the definition by examples, the laws of logic, the paper's monitors against the synthesized
//!   ones, and snapshots of all messages.
//! - `cargo test --release -p steward-monitors on_demand -- --ignored --nocapture`: the same from the first `SEED` on,
//!   with the number of cases in these variables.
//!   - `PAIRS=1000000`: a million pairs of seven classes, among them extreme numbers, operators that look back,
//!     remembered values and time. It prints which verdicts come late, and why.
//!   - `FORMULAS=100000`: the verdicts of a hundred thousand formulas, on hundreds of random endless words each. None
//!     is too early, none is wrong; the late ones are counted.
//!   - `SYSTEMS=10000`: proofs about ten thousand systems.
//!   - `INPUTS=10000000`: ten million broken files.
//! - `cargo run --release -p tools --bin reelay_cases -- 100000 > cases.jsonl`: formulas that look back, with runs and
//!   verdicts, for reelay (`tests/tools/reelay_cases.py` runs them).
//! - `cargo run --release -p tools --bin scxml_traces -- 300`: exported machines with runs and verdicts, for an
//!   ECMAScript SCXML engine (`tests/tools/scxml_traces.mjs` runs them in SCION).
//! - `cargo bench -p steward-monitors --bench log -- 10000000`: a log of ten million events.
//! - `tests/monitors.rs` of the workspace: exported machines in the SCXML engine of the skills, on random runs.
//! - `FEWER_CASES=20 cargo mutants -p steward-monitors`: mutates semantics and synthesis in hundreds of places;
//!   MUTANTS.md lists the surviving mutants and why they survive.
//! - `cargo bench -p steward-monitors`: φ1, φ2 and the classic timed patterns.

/// The grammar of the SCOPE language: that of the paper's Figure 3, extended by operators that look back.
pub const GRAMMAR: &str = include_str!("grammar.txt");

mod clause;
mod data;
mod describe;
mod engine;
mod explain;
mod export;
mod formula;
mod given;
mod load;
mod location;
mod log;
mod monitor;
mod occurrence;
mod operator;
mod oracle;
mod outcome;
mod paper;
mod patterns;
mod problem;
mod resolve;
mod shipped;
pub mod syntax;
mod synthesis;
mod wording;
mod world;

pub use engine::{Limits, samples};
pub use explain::explain;
pub use export::Format;
pub use formula::{
    Arithmetic, Bound, EventAtom, Formula, FormulaError, Function, MessageCondition, MessageField, Term, Unit,
    ValueType,
};
pub use load::{Property, PropertyFile, check, formulas, load, scope_monitor};
pub use location::location_meaning;
pub use log::{Channels, EventLog, ForeignMessage, GapMark, LogEnd, LogError, admit, topology_of_log, verify};
pub use monitor::{
    Continuation, EventTime, OpenObligation, PossibleStates, ScopeMonitor, Sighting, Vacuity, Violation, Violations,
    Witness,
};
pub use occurrence::occurrences;
pub use operator::{Infix, Need, Prefix, Role};
pub use oracle::{holds, holds_endlessly};
pub use outcome::Outcome;
pub use paper::{PhiTwo, phi1, phi2};
pub use patterns::{Pattern, PatternEvents, Scope};
pub use problem::{ScopeError, Warnings};
pub use shipped::SHIPPED;
pub use syntax::{OPERATORS, Operator, layout};
pub use synthesis::{Choice, Method};
pub use world::OwnWorld;

/// The process that shows monitors what is true, by convention: `(World, Monitors, level_pct < 20)` is about what was
/// true, and every other event about a message that a process received.
pub const WORLD: &str = "World";

/// The process that [`WORLD`] shows it to.
pub const MONITORS: &str = "Monitors";
