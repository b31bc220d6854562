//! A machine as a process of a channel system.

mod adapter;
mod check;
mod mishap;
mod system;
mod translate;
mod wiring;

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Duration;

use channels::{Envelope, Offer, Process, Topology, TransitionId, Use};
use diagnostics::nearest_or_all;

use crate::chart::{Attribute, Chart};
use crate::machine::{Host, Machine, Note, Outgoing, Undelivered};
use crate::unobserved::Unobserved;
use crate::{Datum, SkillError};
pub use adapter::ChannelAdapter;
use check::Constants;
pub use mishap::Mishap;
use mishap::Mishaps;
pub use system::{LeafOfSystem, SkillOfSystem, check_system};
pub use wiring::CLIENT;

/// The maximum number of notes kept until they are taken; older ones are dropped.
const MAX_NOTES: usize = 1_000;

/// A machine that communicates over channels. The crate's documentation describes how messages become events and events
/// become messages.
///
/// A machine that has reached a final state, or was stopped because it did not come to rest, continues to receive and
/// answers nothing.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct SkillProcess {
    machine: Machine,
    adapter: ChannelAdapter,
    journal: Unobserved<Journal>,
}

/// What a machine has noted. It is not part of the process's state.
#[derive(Clone, Debug)]
struct Journal {
    notes: VecDeque<Note>,
    mishaps: Mishaps,
    chart: Arc<Chart>,
}

/// What a machine sends to and notes while it runs.
struct Outside<'a> {
    adapter: &'a mut ChannelAdapter,
    journal: &'a mut Journal,
}

impl SkillProcess {
    /// The skill `name` of the topology, which runs `chart` from its initial state, with `parameters` in place of the
    /// initial values of its data (as a parent machine would pass them with `<invoke>` and `<param>`).
    ///
    /// # Errors
    /// [`SkillError::UnknownProcess`] and [`SkillError::UnknownParameter`] for unknown names, [`SkillError::Wiring`]
    /// with everything in the file that does not fit the skill's channels: processes that it cannot reach, messages and
    /// fields that a channel does not carry, events that no process sends.
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
        let problems = check::problems(&machine, &adapter.wiring, topology);
        if !problems.is_empty() {
            return Err(SkillError::Wiring { process: name.to_owned(), text: chart.file().clone(), problems });
        }
        Ok(Self::started(machine, adapter, Mishaps::default(), Duration::ZERO))
    }

    fn started(machine: Machine, adapter: ChannelAdapter, mishaps: Mishaps, now: Duration) -> Self {
        let journal = Journal { notes: VecDeque::new(), mishaps, chart: Arc::clone(machine.chart()) };
        let mut skill = Self { machine, adapter, journal: Unobserved(journal) };
        let (machine, mut outside) = skill.parts();
        machine.start(now, &mut outside);
        skill
    }

    fn parts(&mut self) -> (&mut Machine, Outside<'_>) {
        (&mut self.machine, Outside { adapter: &mut self.adapter, journal: &mut self.journal })
    }

    /// A new process with the same machine and parameters that replaces `predecessor`, a process of the same skill. It
    /// starts at `now` from its initial state. It continues the predecessor's request numbers, so that answers to the
    /// predecessor's requests are ignored.
    #[must_use]
    pub fn succeeding(&self, predecessor: &Self, now: Duration) -> Self {
        let adapter = predecessor.adapter.succeeding();
        Self::started(self.machine.unstarted(), adapter, predecessor.journal.mishaps.clone(), now)
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
        let Some(event) = self.adapter.take(transition, received.as_ref()) else { return };
        let ports = self.adapter.is_client(transition).then(|| Arc::clone(&self.adapter.wiring));
        for port in ports.iter().flat_map(|wiring| wiring.inputs()) {
            if let Some(value) = event.data.member(port) {
                self.machine.put(port, value.clone());
            }
        }
        let (machine, mut outside) = self.parts();
        machine.handle(event, now, &mut outside);
    }

    fn next_timer(&self) -> Option<Duration> {
        self.machine.next_timer()
    }

    fn fire_timers(&mut self, now: Duration) {
        let (machine, mut outside) = self.parts();
        machine.fire_timers(now, &mut outside);
    }

    fn uses(&self) -> Vec<Use> {
        let wiring = &self.adapter.wiring;
        let mut uses: Vec<Use> = self.adapter.receives().collect();
        let constants = Constants::of(&self.machine, wiring);
        self.machine.chart().visit_sends(&mut |send| {
            if !check::goes_by_channel(send) {
                return;
            }
            let literal = |attribute: &Option<Attribute>| attribute.as_ref()?.literal().cloned();
            match literal(&send.target) {
                Some(peer) => uses.extend(wiring.outgoing_to(&peer).map(|out| {
                    let out = &wiring.outgoing[out];
                    let message = literal(&send.event).and_then(|head| constants.message(&head, send, out));
                    Use::Sends(out.channel, message)
                })),
                // The target is computed, or there is none: it may be any process.
                None => uses.extend(self.adapter.sends()),
            }
        });
        uses
    }

    /// The ids of the active states that have no children.
    fn location(&self) -> String {
        self.machine.active_ids().collect::<Vec<_>>().join(", ")
    }
}
