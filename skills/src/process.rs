//! A machine as a process of a channel system.

mod check;
mod mishap;
mod system;
mod translate;
mod wiring;

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Duration;

use channels::{Action, Envelope, Offer, Pattern, Process, RequestNumber, Topology, TransitionId, Use};
use diagnostics::nearest_or_all;

use crate::chart::{Attribute, CHANNEL_PROCESSOR, Chart};
use crate::machine::{Event, Host, MAX_WAITING, Machine, Note, Outgoing, Undelivered};
use crate::unobserved::Unobserved;
use crate::{Datum, SkillError};
use check::Constants;
pub use mishap::Mishap;
use mishap::Mishaps;
pub use system::{LeafOfSystem, SkillOfSystem, check_system};
pub use wiring::CLIENT;
use wiring::Wiring;

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
}

/// The adapter between the machine and its channels.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct ChannelAdapter {
    wiring: Arc<Wiring>,
    /// Messages to be sent, by outgoing channel.
    outboxes: Vec<VecDeque<Envelope>>,
    /// The numbers of unanswered requests, by outgoing channel.
    asked: Vec<Option<RequestNumber>>,
    /// The client's pending request.
    pending: Option<RequestNumber>,
    last_request: u64,
    notes: Unobserved<VecDeque<Note>>,
    mishaps: Unobserved<Mishaps>,
    chart: Unobserved<Arc<Chart>>,
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
        let wiring = Wiring::new(topology, process);
        let problems = check::problems(&machine, &wiring, topology);
        if !problems.is_empty() {
            return Err(SkillError::Wiring { process: name.to_owned(), text: chart.file().clone(), problems });
        }
        let mut adapter = ChannelAdapter::new(Arc::new(wiring), 0, chart);
        machine.start(Duration::ZERO, &mut adapter);
        Ok(Self { machine, adapter })
    }

    /// A new process with the same machine and parameters that replaces `predecessor`, a process of the same skill. It
    /// starts at `now` from its initial state. It continues the predecessor's request numbers, so that answers to the
    /// predecessor's requests are ignored.
    #[must_use]
    pub fn succeeding(&self, predecessor: &Self, now: Duration) -> Self {
        let mut machine = self.machine.unstarted();
        let mut adapter =
            ChannelAdapter::new(Arc::clone(&self.adapter.wiring), predecessor.adapter.last_request, machine.chart());
        adapter.mishaps = predecessor.adapter.mishaps.clone();
        machine.start(now, &mut adapter);
        Self { machine, adapter }
    }

    /// The machine: its active states, its data, its chart.
    #[must_use]
    pub fn machine(&self) -> &Machine {
        &self.machine
    }

    /// Takes the log lines and errors since the last call, oldest first. They are not part of the process's state.
    pub fn take_notes(&mut self) -> Vec<Note> {
        self.adapter.notes.drain(..).collect()
    }

    /// The errors so far of its machine and of its predecessors. They are not part of the process's state.
    #[must_use]
    pub fn mishaps(&self) -> &[Mishap] {
        self.adapter.mishaps.all()
    }

    fn receive(&mut self, index: usize, envelope: &Envelope, now: Duration) {
        let wiring = Arc::clone(&self.adapter.wiring);
        let incoming = &wiring.incoming[index];
        if incoming.is_client {
            self.adapter.pending = Some(envelope.request);
        } else if let Some(asked_on) = incoming.asked_on {
            if self.adapter.asked[asked_on] != Some(envelope.request) {
                return;
            }
            self.adapter.asked[asked_on] = None;
        }
        let data = incoming.data(&envelope.message);
        if incoming.is_client {
            for port in wiring.inputs() {
                if let Some(value) = data.member(port) {
                    self.machine.put(port, value.clone());
                }
            }
        }
        let event = Event::external(incoming.event_name(&envelope.message))
            .with_data(data)
            .with_origin(Arc::clone(&incoming.peer), CHANNEL_PROCESSOR);
        self.machine.handle(event, now, &mut self.adapter);
    }
}

impl ChannelAdapter {
    fn new(wiring: Arc<Wiring>, last_request: u64, chart: &Arc<Chart>) -> Self {
        let channels = wiring.outgoing.len();
        Self {
            wiring,
            outboxes: vec![VecDeque::new(); channels],
            asked: vec![None; channels],
            pending: None,
            last_request,
            notes: Unobserved::default(),
            mishaps: Unobserved::default(),
            chart: Unobserved(Arc::clone(chart)),
        }
    }

    fn request_number(&mut self, out: usize, peer: &str) -> Result<RequestNumber, Undelivered> {
        if self.wiring.outgoing[out].is_client {
            return self.pending.take().ok_or_else(|| Undelivered(format!("{peer} does not wait for an answer")));
        }
        self.last_request += 1;
        self.asked[out] = Some(RequestNumber(self.last_request));
        Ok(RequestNumber(self.last_request))
    }
}

impl Host for ChannelAdapter {
    fn send(&mut self, outgoing: &Outgoing) -> Result<(), Undelivered> {
        let peer = outgoing.target.as_deref().unwrap_or_default();
        let head = outgoing.event.as_deref().unwrap_or_default();
        let out = self.wiring.outgoing_to(peer);
        let out = out.ok_or_else(|| Undelivered(format!("there is no channel {} → {peer}", self.wiring.name)))?;
        let message = self.wiring.outgoing[out]
            .message(head, &outgoing.data)
            .map_err(|problem| Undelivered(format!("<{head}> cannot be sent to {peer}: {problem}")))?;
        if self.outboxes[out].len() >= MAX_WAITING {
            return Err(Undelivered(format!("{MAX_WAITING} messages to {peer} are waiting already")));
        }
        let request = self.request_number(out, peer)?;
        self.outboxes[out].push_back(Envelope { message, request });
        Ok(())
    }

    fn note(&mut self, note: Note) {
        let chart = Arc::clone(&self.chart);
        self.mishaps.note(&note, &chart);
        if self.notes.len() == MAX_NOTES {
            self.notes.pop_front();
        }
        self.notes.push_back(note);
    }
}

/// Transitions are numbered by channel: incoming ones first, then outgoing ones.
impl Process for SkillProcess {
    fn offers(&self, offers: &mut Vec<Offer>) {
        let wiring = &self.adapter.wiring;
        for (index, incoming) in wiring.incoming.iter().enumerate() {
            let action = Action::Receive(incoming.channel, Pattern::Any);
            offers.push(Offer { transition: TransitionId(index as u32), action });
        }
        for (index, (out, waiting)) in wiring.outgoing.iter().zip(&self.adapter.outboxes).enumerate() {
            if let Some(envelope) = waiting.front() {
                let transition = TransitionId((wiring.incoming.len() + index) as u32);
                offers.push(Offer { transition, action: Action::Send(out.channel, envelope.clone()) });
            }
        }
    }

    fn take(&mut self, transition: TransitionId, received: Option<Envelope>, now: Duration) {
        let index = transition.0 as usize;
        match index.checked_sub(self.adapter.wiring.incoming.len()) {
            Some(out) => {
                self.adapter.outboxes[out].pop_front();
            }
            None => {
                if let Some(envelope) = received {
                    self.receive(index, &envelope, now);
                }
            }
        }
    }

    fn next_timer(&self) -> Option<Duration> {
        self.machine.next_timer()
    }

    fn fire_timers(&mut self, now: Duration) {
        self.machine.fire_timers(now, &mut self.adapter);
    }

    fn uses(&self) -> Vec<Use> {
        let wiring = &self.adapter.wiring;
        let mut uses: Vec<Use> = wiring.incoming.iter().map(|incoming| Use::Receives(incoming.channel, None)).collect();
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
                // The target is computed: it may be any process.
                None => uses.extend(wiring.outgoing.iter().map(|out| Use::Sends(out.channel, None))),
            }
        });
        uses
    }

    /// The ids of the active states that have no children.
    fn location(&self) -> String {
        self.machine.active_ids().collect::<Vec<_>>().join(", ")
    }
}
