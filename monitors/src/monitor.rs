//! A running property: the machine, and everything needed to explain its verdicts.

mod possible;
mod record;
mod vacuity;
mod violations;
mod witness;

use std::any::Any;
use std::hash::{Hash, Hasher};
use std::sync::Arc;

use channels::{Event, EventKind, GraphMonitor, LocationId, Monitor, NoNormalForm, ProgramGraph, Topology, Verdict};

use crate::clause::Window;
use crate::describe;
use crate::engine::{CompactRun, Letter, Limits, Obligation, Situation, State, Symbol, combinations};
use crate::export::{Format, MAX_DRAWN_STATES, Picture};
use crate::formula::{EventAtom, Formula, FormulaError};
use crate::outcome::Outcome;
use crate::synthesis::{Choice, Method, RunningMonitor, Synthesis};
use crate::world::OwnWorld;
use record::{Observation, Record};
use vacuity::Watch;
use violations::Recurrence;

pub use possible::PossibleStates;
pub use vacuity::Vacuity;
pub use violations::{Violation, Violations};
pub use witness::{EventTime, OpenObligation, Sighting, Witness};

/// The monitor of a SCOPE property.
///
/// Its verdict never changes once it is true or false. The time per event and the memory depend on the formula and its
/// bounds, never on the length of the run. Events come in the order of their ticks and times: if time goes back, there
/// is no verdict unless there was one, and the outcome is inconclusive.
///
/// ```
/// use std::{sync::Arc, time::Duration};
/// use channels::{Capacity, Domain, Event, EventKind, FieldKind, Message, Monitor, Shape, Topology, Value};
/// use monitors::{Outcome, load};
///
/// let mut topology = Topology::default();
/// let [reader, skill] = [topology.process("BatteryReader")?, topology.process("BatteryLevel")?];
/// let level = Shape::new([("status", FieldKind::symbols(["ok"])), ("level", FieldKind::Real)]);
/// let channel = topology.channel(reader, skill, Capacity::One, Domain::new([level]))?;
/// let text = "property phi1 := always (BatteryReader, BatteryLevel, m.level >= 20)";
/// let file = load("phi1.scope", text, &Arc::new(topology), Duration::from_secs(1))?;
///
/// let mut monitor = file.properties[0].scope_monitor().expect("it is made from a formula").clone();
/// let message = Message::new([Value::symbol("ok"), 15.0.into()]);
/// let kind = EventKind::Received { channel, message };
/// monitor.observe(&Event { step: 1, tick: 0, time: Duration::ZERO, kind });
/// assert_eq!(monitor.outcome(), Outcome::Violated);
/// assert!(monitor.witness().is_some()); // it names the message
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct ScopeMonitor {
    name: String,
    formula: Arc<Formula>,
    topology: Arc<Topology>,
    synthesis: Arc<Synthesis>,
    picture: Option<Arc<Picture>>,
    run: RunningMonitor,
    /// For a machine without rules: the clauses as rules, if they have that form, to name the one that was violated.
    rules: Option<CompactRun>,
    /// τ at the first state; `None` before it.
    start: Option<u64>,
    now: u64,
    /// Time went back: nothing is certain from then on.
    is_disordered: bool,
    verdict: Verdict,
    record: Record,
    watches: Vec<Watch>,
    /// What the formula sees of the world.
    world: OwnWorld,
    /// All violations; none in a normal form.
    recurrence: Option<Box<Recurrence>>,
}

/// An endless continuation of a run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Continuation {
    /// The states that come first, each with its distance in ticks from the previous one.
    pub stem: Vec<(u64, EventKind)>,
    /// The states that then repeat, with τ growing by one at each tick; if empty, there is silence.
    pub cycle: Vec<EventKind>,
}

impl ScopeMonitor {
    /// The monitor of a formula over the channels of a topology.
    ///
    /// # Errors
    /// [`FormulaError`] if the formula has more than 64 different events and operators that look back, its clause form
    /// has more than two thousand parts, an operator that looks ahead is inside one that looks back, or a field has the
    /// number 0.
    pub fn new(name: &str, formula: Formula, topology: &Arc<Topology>) -> Result<Self, FormulaError> {
        Self::with(name, formula, topology, Choice::Best)
    }

    /// The monitor with a given choice of machine.
    ///
    /// # Errors
    /// As [`ScopeMonitor::new`].
    pub fn with(name: &str, formula: Formula, topology: &Arc<Topology>, choice: Choice) -> Result<Self, FormulaError> {
        Self::within(Limits::default(), name, formula, topology, choice)
    }

    /// The monitor with a given choice of machine, computed within other limits: its verdicts may come later or
    /// earlier.
    ///
    /// # Errors
    /// As [`ScopeMonitor::new`].
    pub fn within(
        limits: Limits,
        name: &str,
        formula: Formula,
        topology: &Arc<Topology>,
        choice: Choice,
    ) -> Result<Self, FormulaError> {
        let mut is_counted_from_0 = false;
        formula.events(&mut |event| event.condition.fields(&mut |field| is_counted_from_0 |= field.number == 0));
        if is_counted_from_0 {
            return Err(FormulaError::NoSuchField);
        }
        let synthesis = Synthesis::new(&formula, topology, choice, limits)?;
        let picture = Picture::of(name, &synthesis, topology, MAX_DRAWN_STATES).map(Arc::new);
        let run = synthesis.start();
        let rules = synthesis.rules.as_ref().filter(|_| synthesis.compact().is_none());
        Ok(Self {
            name: name.to_owned(),
            topology: Arc::clone(topology),
            picture,
            rules: rules.map(|rules| CompactRun::new(Arc::clone(rules))),
            start: None,
            now: 0,
            is_disordered: false,
            verdict: run.verdict(),
            record: Record::new(&synthesis),
            watches: Watch::of(&synthesis, &formula, topology),
            formula: Arc::new(formula),
            world: OwnWorld::of_events(
                synthesis.vocabulary.ids().map(|event| synthesis.vocabulary.get(event)),
                topology,
            ),
            recurrence: Some(Box::new(Recurrence::new(&synthesis))),
            run,
            synthesis: Arc::new(synthesis),
        })
    }

    /// Gives it another name.
    pub(crate) fn rename(&mut self, name: &str) {
        name.clone_into(&mut self.name);
    }

    /// The monitored formula.
    #[must_use]
    pub fn formula(&self) -> &Formula {
        &self.formula
    }

    /// The topology of the formula.
    #[must_use]
    pub fn topology(&self) -> &Arc<Topology> {
        &self.topology
    }

    /// Whether this monitor of the same formula over other domains can see the same messages come, as far as the
    /// formula distinguishes them. Then both always have the same verdict.
    #[must_use]
    pub fn foresees_as(&self, other: &Self) -> bool {
        self.synthesis.alphabet.foresees_as(&other.synthesis.alphabet)
    }

    /// The kind of machine in use.
    #[must_use]
    pub fn method(&self) -> Method {
        self.synthesis.method()
    }

    /// Whether the formula holds on the run so far: open `until`, `eventually`, `next` and `time_until` count as false,
    /// and their negations as true.
    #[must_use]
    pub fn holds_so_far(&self) -> bool {
        self.run.holds()
    }

    /// The outcome if the run ends now.
    #[must_use]
    pub fn outcome(&self) -> Outcome {
        Outcome::of(self)
    }

    /// Why the property is violated; `None` if it is not.
    #[must_use]
    pub fn witness(&self) -> Option<&Witness> {
        self.record.witness.as_deref()
    }

    /// Every violation so far; `None` if there was none, or in a [normal form](Monitor::normalize).
    #[must_use]
    pub fn violations(&self) -> Option<&Violations> {
        self.recurrence.as_ref().filter(|_| self.verdict == Verdict::False)?.violations()
    }

    /// This monitor, judging only what begins from here on: what is owed, and a violation, are given up; the last
    /// messages still count. Whatever happened before, a violation from then on is one of the whole run. `None` unless
    /// the property demands that clauses `always` hold which do not look back.
    #[must_use]
    pub fn anew(&self) -> Option<Self> {
        if self.verdict == Verdict::True || !self.synthesis.can_begin_anew() {
            return None;
        }
        let memory = self.record.memory.clone();
        let recurrence = Some(Box::new(Recurrence::new(&self.synthesis)));
        let mut anew = Self { verdict: Verdict::Inconclusive, recurrence, ..self.clone() };
        anew.run = self.synthesis.resume(&memory, self.now);
        let rules = self.rules.as_ref();
        anew.rules = rules.map(|rules| CompactRun::resume(Arc::clone(&rules.compact), memory.clone(), self.now));
        anew.record.begin_anew(memory);
        Some(anew)
    }

    /// Messages may be missing: from now on, no antecedent is known never to have held.
    pub fn give_up_vacuity(&mut self) {
        self.watches.clear();
    }

    /// The pending obligations if the run ends now, each with its beginning and deadline; empty unless the outcome is
    /// inconclusive.
    #[must_use]
    pub fn open_obligations(&self) -> Vec<OpenObligation> {
        if self.outcome() != Outcome::Inconclusive {
            return Vec::new();
        }
        let start = self.start.unwrap_or(0);
        let is_timed = self.synthesis.vocabulary.is_timed;
        match self.run.rules().or(self.rules.as_ref()) {
            Some(run) => {
                let rules = &run.compact.rules;
                let owed = run.owed().map(|(rule, due)| {
                    let clause = describe::clause(&rules[rule].clause, &self.synthesis.vocabulary, &self.topology);
                    self.record.open(rule, None, clause, Some(start.saturating_add(due).saturating_sub(1)), is_timed)
                });
                owed.collect()
            }
            None => {
                let owed = self.run.owed().map(|(owed, since)| owed.at(since));
                self.open_clauses(owed.as_ref(), start)
            }
        }
    }

    fn open_clauses(&self, owed: Option<&crate::engine::Obligations>, start: u64) -> Vec<OpenObligation> {
        let operators = &self.synthesis.operators;
        let words = &self.synthesis.vocabulary;
        let open = owed
            .into_iter()
            .flat_map(|owed| owed.clauses())
            .filter(|clause| !clause.iter().any(|obligation| operators.met_by_silence(obligation)));
        let open = open.map(|clause| {
            let parts = clause.iter().map(|obligation| match *obligation {
                Obligation::Goes(operator, ref values) | Obligation::Waits(operator, ref values) => {
                    describe::operator(operators.literal_of(operator), words).instantiated(values)
                }
                Obligation::Passes { event, first, last, ref values, .. } => {
                    let from_now = |tick: u64| if tick == u64::MAX { tick } else { tick.saturating_sub(self.now) };
                    let window = Window { first: from_now(first), last: from_now(last) };
                    describe::awaited(event, window, &self.synthesis.form, words).instantiated(values)
                }
            });
            let what = describe::text(Formula::Or(parts.collect()), words, &self.topology);
            // One obligation of a clause is enough: it is due with the last of them, or never if one of them has no
            // end.
            let ends = clause.iter().map(|obligation| match obligation {
                Obligation::Passes { last, .. } if *last < u64::MAX => Some(*last),
                _ => None,
            });
            let until = ends.clone().collect::<Option<Vec<u64>>>().and_then(|ends| ends.into_iter().max());
            let until = until.map(|until| until.saturating_add(start));
            let open = self.record.open(0, Some(clause), what, until, words.is_timed);
            OpenObligation { has_deadline: ends.flatten().next().is_some(), ..open }
        });
        open.collect()
    }

    /// The demands whose condition never occurred where they were checked; none if the property is violated.
    #[must_use]
    pub fn vacuous(&self) -> Vec<Vacuity> {
        if self.verdict == Verdict::False {
            return Vec::new();
        }
        self.watches.iter().filter_map(Watch::vacuity).collect()
    }

    /// Whether messages are letters to it: the formula measures no time, remembers no values and does not calculate.
    pub(crate) fn has_letters(&self) -> bool {
        self.synthesis.has_graph() && !self.synthesis.vocabulary.has_data()
    }

    /// Whether the conditions on a channel have too many combinations to foresee which of them can hold together.
    pub(crate) fn is_cut_off(&self) -> bool {
        self.synthesis.alphabet.is_cut_off()
    }

    /// Whether some message within its channel's domain may satisfy this event.
    pub(crate) fn can_hold(&self, event: &EventAtom) -> bool {
        let (domain, condition) = (&self.topology.get(event.channel).domain, std::slice::from_ref(&event.condition));
        let messages = combinations(domain, condition, self.synthesis.alphabet.limits.combinations);
        !event.condition.is_simple()
            || messages.is_none_or(|messages| messages.iter().any(|message| event.condition.holds(message)))
    }

    /// Whether the very first tick violates the formula: then no run satisfies it.
    pub(crate) fn is_violated_by_a_tick(&self) -> bool {
        let mut run = self.synthesis.start();
        run.read(Letter::TICK, None, &self.synthesis.alphabet) == Verdict::False
    }

    /// One message for each letter that messages within the domains can have.
    pub fn samples(&self) -> impl Iterator<Item = EventKind> + '_ {
        let received = |channel, message: &channels::Message| EventKind::Received { channel, message: message.clone() };
        self.synthesis.alphabet.letters().map(move |(_, channel, message)| received(channel, message))
    }

    /// An endless continuation of the run on which the formula holds (or does not), if there is one. Always `None`
    /// without an automaton.
    #[must_use]
    pub fn continuation(&self, holds: bool) -> Option<Continuation> {
        let RunningMonitor::Automaton(run) = &self.run else { return None };
        let alphabet = &self.synthesis.alphabet;
        let next = |symbol: &Symbol| match *symbol {
            Symbol::TICK => Some((0, EventKind::Tick)),
            Symbol::NEXT_TICK => Some((1, EventKind::Tick)),
            message => {
                let letter = alphabet.letter(message);
                let (_, channel, message) = alphabet.letters().find(|(sample, ..)| *sample == letter)?;
                Some((0, EventKind::Received { channel, message: message.clone() }))
            }
        };
        let (stem, cycle) = run.lasso(holds, alphabet)?;
        let cycle = cycle.iter().map(|symbol| next(symbol).map(|(_, kind)| kind));
        Some(Continuation { stem: stem.iter().map(next).collect::<Option<_>>()?, cycle: cycle.collect::<Option<_>>()? })
    }

    /// The program graph as a [`GraphMonitor`], for code that runs program graphs. It gives the same verdicts, but no
    /// reasons, and is slower.
    #[must_use]
    pub fn to_graph_monitor(&self) -> Option<GraphMonitor> {
        let picture = self.picture_of_any_size()?;
        let graph = GraphMonitor::new(Arc::clone(&picture.graph), picture.failures.iter().copied());
        Some(graph.with_open(picture.owing.iter().copied()))
    }

    /// The monitor's program graph in the given format; `None` for a monitor by progression, which has no graph.
    ///
    /// An automaton as a graph treats a tick with number 0 as the first of the run, and any other as one that follows
    /// another tick. It is correct on runs whose ticks are numbered from 0 without gaps.
    #[must_use]
    pub fn export(&self, format: Format) -> Option<String> {
        Some(self.picture_of_any_size()?.export(format, &self.topology))
    }

    fn picture_of_any_size(&self) -> Option<Picture> {
        Picture::of(&self.name, &self.synthesis, &self.topology, usize::MAX)
    }

    /// The state that determines how it continues: the verdict if it is final, else that of the machine, and whether τ
    /// has begun.
    fn situation(&self) -> (Verdict, Option<(bool, &OwnWorld, Situation<'_>)>) {
        let is_open = self.verdict == Verdict::Inconclusive;
        let open = is_open.then(|| (self.start.is_some(), &self.world, self.run.situation()));
        (self.verdict, open)
    }

    #[inline]
    fn read(&mut self, event: &Event, letter: Letter) {
        let tau = self.synthesis.vocabulary.tau(event);
        let start = *self.start.get_or_insert(tau);
        if tau < start + self.now {
            self.is_disordered = true;
            return;
        }
        let now = tau - start;
        self.record.see(event, letter, &self.synthesis.past, now - self.now);
        let before = self.verdict;
        if before != Verdict::False {
            self.watches.iter_mut().for_each(|watch| watch.see(event, letter, &self.record.memory, now));
        }
        if before == Verdict::Inconclusive {
            self.step(event, letter, now);
        }
        self.now = now;
        if before == Verdict::True {
            // Only the antecedents are still of interest.
            return;
        }
        let owes_anew = self.rules.as_mut().map_or_else(|| self.run.owes_anew(), CompactRun::owes_anew);
        if owes_anew || self.verdict == Verdict::False {
            self.note(event, letter, start, before);
        }
        let Some(recurrence) = self.recurrence.as_mut().filter(|recurrence| recurrence.owes) else { return };
        if self.verdict != Verdict::False {
            let observation = Observation { event, synthesis: &self.synthesis, topology: &self.topology, start };
            recurrence.keep(&observation, State::present(letter, &self.record.memory, now));
        }
    }

    /// Notes what else is owed than before an event, and how the property was violated.
    #[inline(never)]
    fn note(&mut self, event: &Event, letter: Letter, start: u64, before: Verdict) {
        let observation = Observation { event, synthesis: &self.synthesis, topology: &self.topology, start };
        let rules = self.run.rules().or(self.rules.as_ref());
        if before == Verdict::Inconclusive {
            if rules.is_none() {
                self.record.note_beginnings(&observation, &self.run, letter, self.now);
            }
            self.record.follow(&observation, &self.run, rules, self.verdict);
        }
        let Some(recurrence) = &mut self.recurrence else { return };
        match &self.record.witness {
            Some(witness) => {
                let state = State::present(letter, &self.record.memory, self.now);
                recurrence.follow(&observation, state, witness.settled);
            }
            None => recurrence.note(&self.run, rules),
        }
    }

    /// Moves the machine to the state of an event with this letter at τ = `now`.
    fn step(&mut self, event: &Event, letter: Letter, now: u64) {
        if now > self.now {
            if let Some(rules) = &mut self.rules {
                rules.advance(now);
            }
            // Everything else that time decides is decided at the tick itself.
            if self.run.advance(now) {
                self.verdict = Verdict::False;
                return;
            }
        }
        if let Some(rules) = &mut self.rules {
            rules.read(letter, &self.synthesis.alphabet);
        }
        self.verdict = self.run.read(letter, Some(&event.kind), &self.synthesis.alphabet);
    }
}

impl Monitor for ScopeMonitor {
    fn name(&self) -> &str {
        &self.name
    }

    fn boxed_clone(&self) -> Box<dyn Monitor> {
        Box::new(self.clone())
    }

    fn observe(&mut self, event: &Event) {
        if self.is_disordered || !self.world.sees(&event.kind) {
            return;
        }
        match self.verdict {
            Verdict::False if self.record.witness.is_none() => {
                let observation =
                    Observation { event, synthesis: &self.synthesis, topology: &self.topology, start: event.tick };
                return self.record.doom(&observation);
            }
            Verdict::False if !self.violations().is_some_and(|violations| violations.goes_on) => return,
            Verdict::True if self.watches.iter().all(Watch::is_settled) => return,
            _ => {}
        }
        let letter = match &event.kind {
            EventKind::Tick => Some(Letter::TICK),
            EventKind::Received { channel, message } => self.synthesis.alphabet.read(*channel, message),
        };
        if let Some(letter) = letter {
            self.read(event, letter);
        }
    }

    fn verdict(&self) -> Verdict {
        self.verdict
    }

    fn location(&self) -> String {
        if let Some(picture) = &self.picture {
            return picture.graph.locations()[picture.location(&self.run, self.verdict).index()].clone();
        }
        match self.verdict {
            Verdict::True => "satisfied",
            Verdict::False => "violated",
            Verdict::Inconclusive if self.is_open() => "waiting",
            Verdict::Inconclusive => "watching",
        }
        .to_owned()
    }

    fn is_open(&self) -> bool {
        self.verdict == Verdict::Inconclusive && (self.is_disordered || !self.run.holds())
    }

    fn graph(&self) -> Option<(&ProgramGraph, LocationId)> {
        self.picture.as_ref().map(|picture| (&*picture.graph, picture.location(&self.run, self.verdict)))
    }

    /// Also forgets the messages that would explain the verdict.
    fn normalize(&mut self) -> Result<(), NoNormalForm> {
        if self.synthesis.past.keeps_messages() {
            return Err(NoNormalForm::Unsupported {
                reason: format!(
                    "`{}` looks back at remembered values, so it keeps all messages for a while",
                    self.name
                ),
                help: Some("remember the value in the earlier message, and look ahead from there".to_owned()),
            });
        }
        if self.synthesis.vocabulary.is_timed {
            return Err(NoNormalForm::Unsupported {
                reason: format!("`{}` is a timed property, and a proof has no notion of time between ticks", self.name),
                help: Some("without `timed`, its durations are counted in ticks".to_owned()),
            });
        }
        self.run.normalize();
        self.start = self.start.map(|_| 0);
        self.now = 0;
        self.record = Record::new(&self.synthesis);
        (self.rules, self.recurrence) = (None, None);
        self.watches.clear();
        Ok(())
    }

    fn same_state(&self, other: &dyn Monitor) -> bool {
        (other as &dyn Any).downcast_ref::<Self>().is_some_and(|other| self.situation() == other.situation())
    }

    fn hash_state(&self, mut hasher: &mut dyn Hasher) {
        self.situation().hash(&mut hasher);
    }

    fn failures(&self) -> &[LocationId] {
        self.picture.as_ref().map_or(&[], |picture| picture.failures.as_slice())
    }
}
