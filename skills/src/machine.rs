//! A running machine: the interpretation algorithm of SCXML (Appendix D).

mod entry;
mod events;
mod execute;
mod host;
mod input;
mod invoke;
mod macrostep;
mod normal;
mod select;
mod send;
mod timer;

use std::sync::Arc;

use channels::Unobserved;
use diagnostics::nearest_or_all;

pub use host::{Host, Note, Transcript, Undelivered};

use crate::bit_set::BitSet;
use crate::chart::{ADDRESS, Chart, SCXML_PROCESSOR};
use crate::datum::Memory;
use crate::event::{Event, EventKind, Outgoing};
use crate::ids::{DataId, StateId, TransitionId};
use crate::random::RandomSequence;
use crate::{Datum, SkillError};
use events::{MachineEvents, Queued};

/// A machine that runs a [`Chart`]: its active states, its data, and its pending events and timers.
///
/// It is a value: copies continue independently from the same state, and equal machines behave equally. It runs when it
/// gets an event or when a timer is due, and comes to rest before the call returns. Its messages and notes go to the
/// [`Host`] that the caller passes in.
///
/// ```
/// use std::time::Duration;
/// use skills::{Chart, Event, Machine, Transcript};
///
/// let text = r#"<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0">
///   <state id="off"><transition event="press" target="on"/></state>
///   <state id="on">
///     <onentry><send event="dim" delay="10s"/></onentry>
///     <transition event="press dim" target="off"/>
///   </state>
/// </scxml>"#;
/// let mut machine = Machine::new(Chart::load("Lamp.scxml", text)?);
/// let mut host = Transcript::default();
/// machine.start(Duration::ZERO, &mut host);
/// machine.handle(Event::external("press"), Duration::from_secs(1), &mut host);
/// assert!(machine.is_in("on"));
/// machine.fire_timers(Duration::from_secs(11), &mut host);
/// assert_eq!(machine.active_ids().collect::<Vec<_>>(), ["off"]);
/// # Ok::<(), skills::SkillError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Machine {
    chart: Arc<Chart>,
    session: Arc<Session>,
    /// Values that replace the initial values of data.
    given: Vec<(DataId, Datum)>,
    status: Status,
    configuration: BitSet,
    /// The states that history states remember; empty for a machine without history states.
    remembered: Vec<Option<BitSet>>,
    /// States whose data have been initialized; empty with early binding.
    initialised: BitSet,
    data: Memory,
    events: MachineEvents,
    generated_ids: u32,
    /// The number of machines it has invoked so far.
    children: u32,
    /// States that were entered and whose machines must be invoked; empty for a machine that invokes none.
    to_invoke: BitSet,
    invoked: Vec<Invoked>,
    /// Its invoke id in the machine that invoked it.
    under: Option<Arc<str>>,
    /// The number of machines around it.
    generation: u32,
    /// The sequence of `Math.random`.
    random: RandomSequence,
    /// The data of the final state in which it ended.
    result: Datum,
    scratch: Unobserved<Scratch>,
}

/// The identity of a machine.
#[derive(Debug, PartialEq, Eq, Hash)]
struct Session {
    /// `_sessionid`
    id: Arc<str>,
    /// The address to which others send events to it.
    location: Arc<str>,
    /// The event I/O processor that delivers its own events.
    processor: Arc<str>,
    /// `_ioprocessors`
    io_processors: Datum,
}

impl Session {
    fn new(id: &str) -> Arc<Self> {
        let location: Arc<str> = format!("{ADDRESS}{id}").into();
        let processor = Datum::object([("location", Datum::Text(Arc::clone(&location)))]);
        let io_processors =
            processor.and_then(|processor| Datum::object([(SCXML_PROCESSOR, processor.clone()), ("scxml", processor)]));
        let io_processors = io_processors.unwrap_or_default();
        Arc::new(Self { id: id.into(), location, processor: SCXML_PROCESSOR.into(), io_processors })
    }

    /// A number derived from the session's id (FNV-1a).
    fn seed(&self) -> u64 {
        self.id
            .bytes()
            .fold(0xCBF2_9CE4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01B3))
    }
}

/// The status of a machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Status {
    /// It has not been started.
    Ready,
    /// It waits for events.
    Running,
    /// It reached a final state of the whole machine.
    Done,
    /// It did not come to rest and was stopped: see [`Note::Stuck`].
    Stuck,
}

/// The maximum number of events that may wait in a machine, including delayed ones, and of messages in a skill. A
/// machine can process more than twice as many before it must be at rest. Chosen, not measured.
pub(crate) const MAX_WAITING: usize = 4096;

/// A machine that another one has invoked, and from where. After its end it stays until the state is exited: its events
/// may still have to be taken and finalized.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Invoked {
    state: StateId,
    /// The index of the `<invoke>` in the state.
    index: usize,
    /// Its id in the parent.
    id: Arc<str>,
    machine: Machine,
}

/// Why an event is not sent.
fn no_room() -> String {
    format!("{MAX_WAITING} events are already waiting")
}

/// Working memory of a microstep, kept so that steps need no allocation.
#[derive(Clone, Debug, Default)]
struct Scratch {
    enabled: Vec<TransitionId>,
    filtered: Vec<TransitionId>,
    /// For each transition in `enabled`, its domain.
    domains: Vec<Option<StateId>>,
    leaving: Vec<StateId>,
    entering: BitSet,
    by_default: BitSet,
    /// History states whose default is entered.
    histories: Vec<StateId>,
    /// The transitions that were taken since the state was last brought into normal form.
    taken: BitSet,
    /// The states that were entered since then.
    entered: BitSet,
}

impl Machine {
    /// The machine before its start.
    #[must_use]
    pub fn new(chart: Arc<Chart>) -> Self {
        let states = chart.states.len();
        let has_history = chart.states.iter().any(|state| !state.histories.is_empty());
        let invokes = chart.states.iter().any(|state| !state.invokes.is_empty());
        let session = Session::new(&chart.ids.machine);
        let scratch = Scratch {
            entering: BitSet::new(states),
            by_default: BitSet::new(states),
            taken: BitSet::new(chart.transitions().count()),
            entered: BitSet::new(states),
            ..Scratch::default()
        };
        Self {
            random: RandomSequence::of(session.seed()),
            session,
            given: Vec::new(),
            status: Status::Ready,
            configuration: BitSet::new(states),
            // Sets of states that the machine never needs are empty: a search copies and compares it for every state.
            remembered: if has_history { vec![None; states] } else { Vec::new() },
            initialised: BitSet::new(states),
            data: Memory::new(chart.data.len()),
            events: MachineEvents::default(),
            generated_ids: 0,
            children: 0,
            to_invoke: if invokes { BitSet::new(states) } else { BitSet::default() },
            invoked: Vec::new(),
            under: None,
            generation: 0,
            result: Datum::Undefined,
            scratch: Unobserved(scratch),
            chart,
        }
    }

    /// The machine before its start, with values from the caller as the initial values of these data. Only data of the
    /// whole machine can be given ([`Chart::parameters`]).
    ///
    /// # Errors
    /// [`SkillError::UnknownParameter`] if the machine has no such datum.
    pub fn with_parameters<'a>(
        chart: Arc<Chart>,
        parameters: impl IntoIterator<Item = (&'a str, Datum)>,
    ) -> Result<Self, SkillError> {
        let mut machine = Self::new(chart);
        for (name, value) in parameters {
            let chart = &machine.chart;
            let id = chart.find_parameter(name).ok_or_else(|| {
                let known: Vec<&str> = chart.parameters().collect();
                let help = nearest_or_all(name, "its parameters", &known);
                SkillError::UnknownParameter { name: name.to_owned(), file: chart.file.name().to_owned(), help }
            })?;
            machine.given.push((id, value));
        }
        Ok(machine)
    }

    /// Sets `_sessionid`, which is the chart's name otherwise.
    pub(crate) fn set_session(&mut self, session: &str) {
        self.session = Session::new(session);
        self.random.restart_unless_set(self.session.seed());
    }

    /// Whether it has room for another event. Events from the caller and errors are always accepted.
    fn has_room(&self) -> bool {
        self.events.waiting() < MAX_WAITING
    }

    /// Another machine before its start, with the same chart, parameters and session.
    pub(crate) fn unstarted(&self) -> Self {
        Self { given: self.given.clone(), ..self.unstarted_with(&self.chart) }
    }

    /// Another machine before its start, with another chart and the same session.
    pub(crate) fn unstarted_with(&self, chart: &Arc<Chart>) -> Self {
        let session = Arc::clone(&self.session);
        Self { random: RandomSequence::of(session.seed()), session, ..Self::new(Arc::clone(chart)) }
    }

    /// Sets the seed of `Math.random`; by default it is derived from the session's name.
    pub fn set_seed(&mut self, seed: u64) {
        self.random.set_seed(seed);
    }

    /// Continues the sequence of a machine whose seed was set.
    pub(crate) fn draw_after(&mut self, other: &Self) {
        self.random.draw_after(&other.random);
    }

    /// Stores a value in the datum of the whole machine with this id, if there is one.
    pub fn put(&mut self, id: &str, value: Datum) {
        if let Some(id) = self.chart.find_parameter(id) {
            self.data.set(id, value);
        }
    }

    /// The machine's status.
    #[must_use]
    pub fn status(&self) -> Status {
        self.status
    }

    /// The chart that it runs.
    #[must_use]
    pub fn chart(&self) -> &Arc<Chart> {
        &self.chart
    }

    /// The active states, in document order. A machine that is done stays in those in which it ended.
    pub fn configuration(&self) -> impl Iterator<Item = StateId> + '_ {
        self.configuration.iter().map(StateId::new)
    }

    /// The active states without children, in document order: they determine all others.
    pub fn active(&self) -> impl Iterator<Item = StateId> + '_ {
        self.configuration().filter(|state| self.chart.state(*state).is_atomic())
    }

    /// The ids of the active states without children, in document order.
    pub fn active_ids(&self) -> impl Iterator<Item = &str> + '_ {
        self.active().map(|state| self.chart.state(state).id())
    }

    /// The transitions that it has taken since its start, or since it was last brought into
    /// [normal form](Self::normalize). They are not part of its state.
    pub fn taken(&self) -> impl Iterator<Item = TransitionId> + '_ {
        self.scratch.taken.iter().map(TransitionId::new)
    }

    /// The states that it has entered since its start, or since it was last brought into
    /// [normal form](Self::normalize). They are not part of its state.
    pub fn entered(&self) -> impl Iterator<Item = StateId> + '_ {
        self.scratch.entered.iter().map(StateId::new)
    }

    /// Whether the state with this id is active.
    #[must_use]
    pub fn is_in(&self, id: &str) -> bool {
        self.configuration().any(|state| self.chart.state(state).id() == id)
    }

    /// The value of a datum; `None` if there is no such datum.
    #[must_use]
    pub fn datum(&self, id: &str) -> Option<&Datum> {
        self.chart.find_data(id).map(|id| &self.data[id.index()])
    }

    /// The data of the final state in which the machine ended (`<donedata>`); undefined before its end.
    #[must_use]
    pub fn result(&self) -> &Datum {
        &self.result
    }
}
