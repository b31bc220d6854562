//! A machine as a process of a channel system.

mod adapter;
mod channel_adapter;
mod check;
mod mishap;
mod misreadings;
mod system;
mod translate;
mod vocabulary;
mod wiring;

use std::collections::VecDeque;
use std::hash::{Hash, Hasher};
use std::sync::Arc;
use std::time::Duration;

use channels::{
    ChannelId, Envelope, NoNormalForm, NormalForm, Offer, Process, RequestNumber, Topology, TransitionId, Unobserved,
    Use,
};
use diagnostics::nearest_or_all;

use crate::chart::{CHOICE_PROCESSOR, Chart};
use crate::event::{Event, Outgoing};
use crate::machine::{Host, Machine, Note, Undelivered};
use crate::{Datum, SkillError};
pub use adapter::{Adapter, AdapterState};
pub use channel_adapter::ChannelAdapter;
pub use mishap::Mishap;
use mishap::Mishaps;
pub use misreadings::EventFields;
pub use system::{LeafOfSystem, SkillOfSystem, check_system};
pub use translate::field_value;
pub use vocabulary::{MessageForm, Vocabulary};
pub use wiring::CLIENT;

/// The maximum number of notes kept until they are taken; older ones are dropped. Chosen, not measured.
const MAX_NOTES: usize = 1_000;

/// A machine that communicates over channels. The crate's documentation describes how messages become events and events
/// become messages; a process with [another adapter](Self::connected) follows other rules.
///
/// A machine that has reached a final state, or was stopped because it did not come to rest, continues to receive and
/// answers nothing.
#[derive(Clone, Debug)]
pub struct SkillProcess {
    machine: Machine,
    adapter: Box<dyn Adapter>,
    journal: Unobserved<Journal>,
}

/// A note of a machine. It is not part of the process's state.
#[derive(Clone, Debug)]
struct Journal {
    notes: VecDeque<Note>,
    mishaps: Mishaps,
    chart: Arc<Chart>,
}

/// The recipient of a machine's events and notes while it runs.
struct Outside<'a> {
    adapter: &'a mut dyn Adapter,
    journal: &'a mut Journal,
}

impl SkillProcess {
    /// The skill `name` of the topology, which runs `chart` from its initial state, with `parameters` in place of the
    /// initial values of its data (as a parent machine would pass them with `<invoke>` and `<param>`).
    ///
    /// # Errors
    /// [`SkillError::UnknownProcess`] and [`SkillError::UnknownParameter`] for unknown names, [`SkillError::Wiring`]
    /// with everything in the file that does not fit the skill's channels: processes that it cannot reach, messages and
    /// fields that a channel does not carry, events that no process sends, fields of events that no message has.
    pub fn new<'a>(
        name: &str,
        chart: &Arc<Chart>,
        topology: &Topology,
        parameters: impl IntoIterator<Item = (&'a str, Datum)>,
    ) -> Result<Self, SkillError> {
        let Some(process) = topology.find_process(name) else {
            let known: Vec<&str> = topology.processes().map(|process| topology.name(process)).collect();
            let help = nearest_or_all(name, "processes", &known);
            return Err(SkillError::UnknownProcess {
                name: name.to_owned(),
                file: chart.file().name().to_owned(),
                help,
            });
        };
        let mut machine = Machine::with_parameters(Arc::clone(chart), parameters)?;
        machine.set_session(name);
        let adapter = ChannelAdapter::new(topology, process);
        let mut problems = check::problems(&machine, &adapter.wiring, topology);
        problems.extend(chart.misreadings(&misreadings::received(&adapter.wiring)));
        if !problems.is_empty() {
            return Err(SkillError::Wiring { process: name.to_owned(), text: chart.file().clone(), problems });
        }
        Ok(Self::started(machine, Box::new(adapter), Mishaps::default(), Duration::ZERO))
    }

    /// The process `name`, which runs a machine from its initial state and has this adapter between the machine and its
    /// channels. A message that does not fit the channels is an error of the run.
    #[must_use]
    pub fn connected(name: &str, mut machine: Machine, adapter: impl Adapter) -> Self {
        machine.set_session(name);
        Self::started(machine, Box::new(adapter), Mishaps::default(), Duration::ZERO)
    }

    /// The same process with another machine, at its start.
    #[must_use]
    pub fn with_chart(&self, chart: &Arc<Chart>) -> Self {
        let machine = self.machine.unstarted_with(chart);
        Self::started(machine, self.adapter.succeeding(), Mishaps::default(), Duration::ZERO)
    }

    fn started(machine: Machine, adapter: Box<dyn Adapter>, mishaps: Mishaps, now: Duration) -> Self {
        let journal = Journal { notes: VecDeque::new(), mishaps, chart: Arc::clone(machine.chart()) };
        let mut skill = Self { machine, adapter, journal: Unobserved(journal) };
        skill.run(|machine, outside| machine.start(now, outside));
        skill
    }

    /// Lets the machine do something, and completes what it has sent.
    fn run(&mut self, act: impl FnOnce(&mut Machine, &mut Outside<'_>)) {
        act(&mut self.machine, &mut Outside { adapter: self.adapter.as_mut(), journal: &mut self.journal });
        self.adapter.complete(&mut self.machine);
    }

    /// A new process with the same machine and parameters that replaces `predecessor`, a process of the same skill. It
    /// starts at `now` from its initial state. It continues the predecessor's request numbers, so that answers to the
    /// predecessor's requests are ignored.
    #[must_use]
    pub fn succeeding(&self, predecessor: &Self, now: Duration) -> Self {
        let adapter = predecessor.adapter.succeeding();
        let mut machine = self.machine.unstarted();
        machine.draw_after(&predecessor.machine);
        Self::started(machine, adapter, predecessor.journal.mishaps.clone(), now)
    }

    /// The machine: its active states, its data, its chart.
    #[must_use]
    pub fn machine(&self) -> &Machine {
        &self.machine
    }

    /// Takes the log lines and errors since the last call, oldest first. They are not part of the process's state.
    pub fn take_notes(&mut self) -> Vec<Note> {
        self.journal.notes.drain(..).collect()
    }

    /// The errors so far of its machine and of its predecessors. They are not part of the process's state.
    #[must_use]
    pub fn mishaps(&self) -> &[Mishap] {
        self.journal.mishaps.all()
    }
}

impl Host for Outside<'_> {
    fn send(&mut self, outgoing: &Outgoing) -> Result<(), Undelivered> {
        let head = outgoing.event.as_deref().unwrap_or_default();
        if &*outgoing.processor == CHOICE_PROCESSOR {
            return self.adapter.choose(Event::external(head).with_data(outgoing.data.clone()));
        }
        self.adapter.send(outgoing.target.as_deref(), head, &outgoing.data)
    }

    fn note(&mut self, note: Note) {
        let Journal { notes, mishaps, chart } = self.journal;
        mishaps.note(&note, chart);
        if notes.len() == MAX_NOTES {
            notes.pop_front();
        }
        notes.push_back(note);
    }
}

impl Process for SkillProcess {
    fn offers(&self, offers: &mut Vec<Offer>) {
        self.adapter.offers(offers);
    }

    fn take(&mut self, transition: TransitionId, received: Option<Envelope>, now: Duration) {
        let mut event = self.adapter.take(transition, received.as_ref(), &mut self.machine);
        while let Some(next) = event {
            self.run(|machine, outside| machine.handle(next, now, outside));
            event = self.adapter.waiting();
        }
    }

    fn next_timer(&self) -> Option<Duration> {
        self.machine.next_timer()
    }

    fn fire_timers(&mut self, now: Duration) {
        self.run(|machine, outside| machine.fire_timers(now, outside));
    }

    fn uses(&self) -> Vec<Use> {
        self.adapter.uses(&self.machine)
    }

    fn awaits(&self, requests: &mut Vec<(ChannelId, RequestNumber)>) {
        self.adapter.awaits(requests);
    }

    fn normalize(&mut self, form: &NormalForm<'_>) -> Result<(), NoNormalForm> {
        self.journal.notes.clear();
        self.journal.mishaps = Mishaps::default();
        self.machine.normalize(form)?;
        self.adapter.normalize(form)
    }

    fn in_words(&self, transition: TransitionId) -> Option<String> {
        self.adapter.choice(transition).map(|event| format!("chooses `{}`", event.name))
    }

    /// The ids of the active states that have no children.
    fn location(&self) -> String {
        self.machine.active_ids().collect::<Vec<_>>().join(", ")
    }
}

impl PartialEq for SkillProcess {
    fn eq(&self, other: &Self) -> bool {
        self.machine == other.machine && *self.adapter == *other.adapter
    }
}

impl Eq for SkillProcess {}

impl Hash for SkillProcess {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.machine.hash(state);
        self.adapter.hash(state);
    }
}
