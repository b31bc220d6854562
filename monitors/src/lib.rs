//! Runtime monitors over the channels of a system, made from properties in the SCOPE language.
//!
//! A property file is text:
//!
//! ```text
//! const theta := 10
//! property phi1 := always (BatteryReader, BatteryLevel, m[1] = <ok> implies m[2] >= 20)
//! ```
//!
//! [`load`] reads it, says everything that is wrong with it at once, and makes a [`ScopeMonitor`] of each property. A
//! monitor is shown what happens, event by event, by the channel system that it is attached to, or from a recorded log
//! by [`verify`]. Its verdicts are three-valued and final; [`Outcome`] is what a run that has ended says. The two
//! properties of the paper also exist built by hand, as the program graphs of its monitor figure: [`phi1`] and
//! [`phi2`], against which the synthesised ones are held.
//!
//! # The language
//!
//! The grammar is the one of the paper's figure, in full in the comment on top of `syntax/parse.rs`:
//!
//! ```text
#![doc = include_str!("grammar.txt")]
//! ```
//!
//! with the abbreviations `false`, `implies`, `eventually α` (`true until α`) and `always α` (`not eventually not α`).
//! `not`, `next`, `always` and `eventually` bind tightest, then `until`, `and`, `or` and `implies`; `until` and
//! `implies` group to the right. Operators may be signs: `¬ ! ∧ ∨ → -> ⇒ □ ◇ ○ ⊤ ⊥ ≤ ≥ ≠`. Fields are `m[1]`, `m[2]`, …
//! or the names that the channel's domain gives them, `m.level` or just `level`. A bound is a number of ticks or a
//! duration (`< 30 s`; ms, s, min, h). `//` begins a comment. A parenthesis that opens right behind `always`,
//! `eventually`, `next` or `not` and is never closed counts as closed at the property's end, with a warning: the paper
//! prints φ2 so.
//!
//! # The semantics
//!
//! The paper gives SCOPE the meaning of TPTL on timed state sequences and leaves open what matters in a system of
//! channels, where two channels never carry a message at the same step. This is how it is settled.
//!
//! *States.* There is one state for each message received between processes, and one for each tick *generated*, taken
//! or not. τi is the number of the last tick generated at state i; the tick's own state already has it. A formula sees
//! the ticks and the messages on the channels that it mentions; i = 0 is the first of those states. So a message on
//! another channel before the first tick is no state: the sequence has not begun.
//!
//! *Atoms.* An event (p, q, c) holds at i if the **last** message that q received from p, up to and including i,
//! satisfies c. Before the first message it is false, whatever c. In c, a field that is absent or of another type makes
//! `=`, `<`, `<=`, `>` and `>=` false, and `m[k] != v` means `not (m[k] = v)`. Integers and reals compare as numbers.
//!
//! *Timed events.* `time_until (e) ⋈ θ` holds at i if a message that satisfies e **passes** at some j ≥ i with
//! τj − τi ⋈ θ. It speaks of some e, not of the first, and j = i counts: x. ◇ y. (e ∧ y − x ⋈ θ) in TPTL. It is an atom
//! whatever its bound: `time_until (e) < 0` is never true, but what it stands in is asked as with any other bound.
//!
//! *Clause form.* `not` is pushed to the atoms. The operand of `always` and the left of `until` are written as clauses
//! (an `and` of `or`s), the operand of `eventually` and the right of `until` as products (an `or` of `and`s); a part
//! that another part contains is dropped. A part's *own* atoms are its events that are not inside a further temporal
//! operator or `time_until`; its own channels are theirs.
//!
//! *When a part is asked.* At states where one of its own channels carries a message; a part without own atoms at every
//! tick. Then, at state i:
//!
//! | formula | holds at i if |
//! |---|---|
//! | `next α` | α holds at the first j > i at which one of α's own channels carries a message |
//! | `always α` | each clause of α holds at every j ≥ i at which it is asked |
//! | `eventually α` | some product of α is asked and holds at some j ≥ i |
//! | `α until β` | some product of β is asked and holds at a j ≥ i, each clause of α wherever asked at i ≤ k < j |
//!
//! For an α without own atoms, `next` looks at the first tick generated after i.
//!
//! A property holds on a sequence if it holds at 0. An event outside every temporal operator would be asked at a state
//! where nothing has been said yet, and is refused.
//!
//! *Laws.* The connectives are those of Boolean logic: De Morgan's laws, distribution, absorption, currying and the
//! rest rewrite a formula under any operator without changing a verdict; `always` and `eventually` are each other's
//! duals, and idempotent; `always (f and g)` is `always f and always g`, as long as no clause of one subsumes a clause
//! of the other. (`always ((a or b) and a)` is `always a` by absorption. `always (a or b)` alone is also asked when b's
//! channel speaks and a's has never spoken, and can fail there.)
//!
//! *The end of a run.* A finite sequence is judged as it stands: a `next` for which nothing comes any more, an
//! `until` or `eventually` not reached and a `time_until` whose message has not passed are false, their negations true.
//! [`holds`] is this definition, written out; it is slow, plain, and the oracle for everything else here.
//!
//! *Endless runs.* While a run goes on, it is taken to go on for ever. An endless continuation is any infinite sequence
//! of ticks and of messages on all channels, within their domains. Time goes on with ticks alone: each raises τ by one
//! (only the first tick that is seen may leave it where it is), no message does. Nothing has to come again, not even a
//! tick. What a property sees of an endless run may therefore end: this is silence, and the formula is then judged as
//! at the end of a run. [`holds_endlessly`] is the definition on sequences that repeat themselves.
//!
//! *Verdicts.* A monitor is three-valued, as in LTL3. After a prefix of a run it says *false* if the formula is false
//! on every endless continuation, *true* if it is true on all of them, and else that it depends. `always (Q implies
//! time_until Q > 0)` and every other recurrence is open as long as the run goes on: Q may come again and again, or
//! not. At the end of the run the property is *violated* if the verdict is false, else *satisfied* if it holds on the
//! run as it stands, else *inconclusive*: something is still owed ([`ScopeMonitor::open_obligations`]).
//!
//! Verdicts suppose what endless runs are. After a message outside its channel's domain, or if ticks are missing in a
//! log, a formula that is still open is judged as it stands; a verdict that had fallen before stays.
//!
//! # The monitors
//!
//! Formulas that are `always` of clauses of the present, or of one clause with a deadline, become program graphs of the
//! shape of the paper's figure, with one number for the oldest open obligation ([`Method::Graph`]). Others become
//! automata over the letters that messages can be, as far as a formula can tell them apart, with at most
//! [`MAX_AUTOMATON_STATES`] states ([`Method::Automaton`]). Both give each verdict as early as it can be given: from
//! each state of an automaton it is worked out whether an endless word leads to either outcome. What is too large is
//! said so at load, and carried along as a formula ([`Method::Progression`]) or, if it is several clauses
//! with deadlines, as their graphs side by side ([`Method::Graphs`]): never wrong, but late where it takes two
//! obligations to see that they contradict each other.
//!
//! An automaton is not minimised: its states are the different things that can be owed, and the limit counts those.
//! They have a unique form where no windows are involved. What exceeds the limit in practice is windows that do not
//! begin now (`= 30` after each of many messages: two to the power of 30 states, minimised or not) and products of long
//! deadlines; a formula that only a minimised automaton would fit within the limit is monitored as one too large.
//!
//! The paper's response monitor arms its timer with θ and fails on the tick that finds it at 0, one tick later than
//! `< θ` says. The formula is the requirement, and the synthesised monitor keeps to it.
//!
//! # Why a property is violated
//!
//! A [`Witness`] names the clause, the messages that made its antecedent hold or that must not have come, the deadline
//! and what was missing. Where a verdict falls early, since clauses contradict each other, it names those without any
//! one of which the others could still be kept. Where clauses cannot be told apart (`until`, `next`, nested operators)
//! it names the whole formula, the messages when something began to be owed and the last ones, and a deadline if one
//! has passed. Messages are remembered one a channel and clause, so memory does not grow with the run: of overlapping
//! obligations with windows that do not begin now, only the antecedent of the first is at hand.
//!
//! # What is tried
//!
//! - `cargo test -p steward-monitors`: ten thousand random pairs of a formula and a sequence, on which the oracle,
//!   automaton, progression, program graph and [`ScopeMonitor::run_symbols`] agree at every prefix; wherever an
//!   automaton gives no verdict it names an endless word for either outcome, and the oracle confirms both; what has a
//!   verdict has it on random endless words, too. Every formula that is printed reads back as the same formula. The
//!   definition by examples, the laws of logic, the paper's monitors against the synthesised ones, and snapshots of
//!   everything that is said.
//! - `cargo run --release -p steward-monitors --example agree -- 1000000`: a million such pairs.
//! - `cargo run --release -p steward-monitors --example anticipation -- 100000`: a hundred thousand formulas, each
//!   verdict on hundreds of random endless words: none too early, none wrong, and how many are late.
//! - `cargo run --release -p steward-monitors --example fuzz_parser -- 10000000`: ten million broken files.
//! - `cargo run --release -p steward-monitors --example scxml_traces -- 300`: exported machines with runs and verdicts,
//!   for an ECMAScript SCXML engine (`examples/scxml_traces.mjs` runs them in SCION).
//! - `cargo run --release -p steward-monitors --example log_speed -- 10000000 log.jsonl`: a log of ten million events.
//! - `tests/monitors.rs` of the workspace: exported machines in the SCXML engine of the skills, on random runs.
//! - `FEWER_CASES=20 cargo mutants -p steward-monitors`: semantics and synthesis, broken in hundreds of places;
//!   MUTANTS.md lists what survives and why.
//! - `cargo bench -p steward-monitors`: φ1, φ2 and the classic timed patterns, on letters and on messages.

/// The grammar of the SCOPE language, as the paper's Figure 3 has it.
pub const GRAMMAR: &str = include_str!("grammar.txt");

mod clause;
mod describe;
mod engine;
mod explain;
mod export;
mod formula;
mod load;
mod log;
mod monitor;
mod occurrence;
mod oracle;
mod outcome;
mod paper;
mod problem;
mod resolve;
mod shipped;
pub mod syntax;
mod synthesis;
mod wording;

pub use engine::Symbol;
pub use explain::explain;
pub use export::Format;
pub use formula::{EventAtom, Formula, MessageCondition};
pub use load::{Property, PropertyFile, formulas, load, scope_monitor};
pub use log::{Channels, EventLog, LogEnd, LogError, topology_of_log, verify};
pub use monitor::{
    Continuation, EventTime, MAX_AUTOMATON_STATES, OpenObligation, ScopeMonitor, Sighting, Vacuity, Witness,
};
pub use occurrence::occurrences;
pub use oracle::{FormulaTooLarge, holds, holds_endlessly};
pub use outcome::Outcome;
pub use paper::{PhiTwo, phi1, phi2};
pub use problem::{ScopeError, Warnings};
pub use shipped::SHIPPED;
pub use synthesis::{Choice, Method};
