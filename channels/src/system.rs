//! The channel system, CS = [PG₁ | … | PGₙ].

mod disturb;
mod disturbances;
mod enabled;

use std::hash::{Hash, Hasher};
use std::sync::Arc;
use std::time::Duration;

pub use self::disturbances::DisturbanceId;
use self::disturbances::Disturbances;
pub use self::enabled::{Enabled, EnabledKind};
use crate::process::{Action, Offer, Pattern, Use};
use crate::tick::{TickGenerator, takes_ticks};
use crate::{
    Capacity, ChannelId, Envelope, Event, EventKind, Message, Monitor, NoNormalForm, NormalForm, Process, ProcessId,
    RequestNumber, RunError, Topology, TransitionId, Verdict, WiringError,
};

/// A system of processes that communicate over channels, with the monitors that watch them.
///
/// The state of processes, channels and disturbances is a value: a system can be copied, and states can be compared and
/// hashed ([`same_state`](Self::same_state), [`hash_state`](Self::hash_state)). Monitors are not part of the state: a
/// run is the same with and without them.
#[derive(Debug)]
pub struct ChannelSystem {
    topology: Arc<Topology>,
    /// By process; `None` for composed processes.
    processes: Vec<Option<Box<dyn Process>>>,
    /// By channel; always empty for capacity 0.
    contents: Vec<Option<Envelope>>,
    disturbances: Disturbances,
    /// By process.
    suspended: Vec<bool>,
    monitors: Vec<Attached>,
    clock: RunClock,
    cache: OfferCache,
}

/// A monitor of a system, with the event that decided it.
#[derive(Debug)]
pub struct Attached {
    /// The monitor.
    pub monitor: Box<dyn Monitor>,
    /// The event that made its verdict final.
    pub decided: Option<Event>,
}

impl Attached {
    /// Records the event if it decided the monitor.
    fn note(&mut self, event: &Event) {
        if self.decided.is_none() && self.monitor.verdict() != Verdict::Inconclusive {
            self.decided = Some(event.clone());
        }
    }
}

/// The stamp for the next event.
#[derive(Clone, Debug, Default)]
struct RunClock {
    step: u64,
    ticks: u64,
    time: Duration,
}

/// The offers of each process, updated only after its state may have changed.
#[derive(Clone, Debug, Default)]
struct OfferCache {
    offers: Vec<Vec<Offer>>,
    stale: Vec<bool>,
}

impl ChannelSystem {
    /// Builds a system and checks that every process uses only its own channels, and only for messages that they can
    /// carry.
    ///
    /// # Errors
    /// A [`WiringError`] that names the process and the channel.
    pub fn new(
        topology: Arc<Topology>,
        processes: impl IntoIterator<Item = (ProcessId, Box<dyn Process>)>,
    ) -> Result<Self, WiringError> {
        let count = topology.processes().count();
        let mut by_id: Vec<Option<Box<dyn Process>>> = (0..count).map(|_| None).collect();
        for (id, process) in processes {
            check_uses(&topology, id, process.as_ref())?;
            if by_id[id.0].replace(process).is_some() {
                return Err(WiringError::DuplicateProcess { name: topology.name(id).to_owned() });
            }
        }
        // A process that is composed of others needs no behavior of its own, and one outside the system has none.
        let is_composed = |id| topology.processes().any(|other| other != id && topology.whole(other) == id);
        let has_none = |&id: &ProcessId| by_id[id.0].is_none() && !is_composed(id) && !topology.is_outside(id);
        if let Some(id) = topology.processes().find(has_none) {
            return Err(WiringError::MissingProcess { process: topology.name(id).to_owned() });
        }
        Ok(Self {
            contents: topology.channels().map(|_| None).collect(),
            disturbances: Disturbances::none(topology.channels().count()),
            suspended: vec![false; count],
            topology,
            processes: by_id,
            monitors: Vec::new(),
            clock: RunClock::default(),
            cache: OfferCache { offers: vec![Vec::new(); count], stale: vec![true; count] },
        })
    }

    /// The processes and channels by name.
    #[must_use]
    pub fn topology(&self) -> &Arc<Topology> {
        &self.topology
    }

    /// Adds a monitor. It sees all events from now on.
    pub fn attach(&mut self, monitor: Box<dyn Monitor>) {
        self.monitors.push(Attached { monitor, decided: None });
    }

    /// The monitors, in the order they were attached.
    #[must_use]
    pub fn monitors(&self) -> &[Attached] {
        &self.monitors
    }

    /// Informs the monitors of more than events, after the event `last`. A monitor that this decides counts as decided
    /// by that event.
    pub fn inform_monitors(&mut self, last: &Event, mut inform: impl FnMut(&mut dyn Monitor)) {
        for attached in &mut self.monitors {
            inform(attached.monitor.as_mut());
            attached.note(last);
        }
    }

    /// Shows the monitors a message between two processes [outside](Topology::outside) the system. It is an event
    /// between two communications; no process receives it.
    ///
    /// # Panics
    /// If the channel is one of the system's, or cannot carry the message.
    pub fn show(&mut self, channel: ChannelId, message: Message) -> Event {
        assert!(self.topology.is_outside(self.topology.get(channel).source), "a channel outside the system");
        assert!(self.topology.carries(channel, &message), "{message} is in the channel's domain");
        let event = self.event(EventKind::Received { channel, message });
        self.show_monitors(&event);
        event
    }

    /// What a channel holds.
    #[must_use]
    pub fn content(&self, channel: ChannelId) -> Option<&Envelope> {
        self.contents[channel.0].as_ref()
    }

    pub(crate) fn time(&self) -> Duration {
        self.clock.time
    }

    /// The number of communications so far.
    #[must_use]
    pub fn steps(&self) -> u64 {
        self.clock.step
    }

    /// The number of ticks generated so far.
    #[must_use]
    pub fn ticks(&self) -> u64 {
        self.clock.ticks
    }

    /// The process as a `P`, if it is one.
    #[must_use]
    pub fn process<P: Process>(&self, id: ProcessId) -> Option<&P> {
        self.any_process(id)?.as_any().downcast_ref()
    }

    /// The process; `None` for a composed process.
    #[must_use]
    pub fn any_process(&self, id: ProcessId) -> Option<&dyn Process> {
        self.processes[id.0].as_deref()
    }

    /// The process as a `P`, if it is one, so that its driver can give it data between steps.
    pub fn process_mut<P: Process>(&mut self, id: ProcessId) -> Option<&mut P> {
        self.cache.stale[id.0] = true;
        self.processes[id.0].as_mut()?.as_any_mut().downcast_mut()
    }

    /// The current location of a process; `None` for a composed process.
    #[must_use]
    pub fn location(&self, id: ProcessId) -> Option<String> {
        self.processes[id.0].as_ref().map(|process| process.location())
    }

    /// A copy of a process in its current state, which [`replace`](Self::replace) can restore later; `None` for a
    /// composed process.
    #[must_use]
    pub fn clone_process(&self, id: ProcessId) -> Option<Box<dyn Process>> {
        self.processes[id.0].clone()
    }

    /// Replaces a process's behavior from now on. Messages in transit to it stay in their channels.
    ///
    /// # Errors
    /// [`WiringError::ForeignChannel`] or [`WiringError::OutsideDomain`] if the new behavior does not fit the process's
    /// channels, [`WiringError::Composed`] if the process is composed.
    pub fn replace(&mut self, id: ProcessId, process: Box<dyn Process>) -> Result<(), WiringError> {
        if self.processes[id.0].is_none() {
            return Err(WiringError::Composed { process: self.topology.name(id).to_owned() });
        }
        check_uses(&self.topology, id, process.as_ref())?;
        self.processes[id.0] = Some(process);
        self.cache.stale[id.0] = true;
        Ok(())
    }

    /// Suspends a process with all its members, or wakes it. A suspended process offers nothing and its timers wait:
    /// timers that fall due meanwhile fire with the first [`advance`](Self::advance) after it wakes.
    pub fn suspend(&mut self, id: ProcessId, suspended: bool) {
        for part in self.topology.processes().filter(|&part| self.topology.is_part_of(part, id)) {
            self.suspended[part.0] = suspended;
            self.cache.stale[part.0] = true;
        }
    }

    /// Whether a process is suspended.
    #[must_use]
    pub fn is_suspended(&self, id: ProcessId) -> bool {
        self.suspended[id.0]
    }

    /// Sets the time of the run, releases messages held until then, and fires timers that are due, process by process.
    /// Returns whether any did.
    pub fn advance(&mut self, now: Duration) -> bool {
        self.clock.time = now;
        self.disturbances.release(now);
        let mut fired = false;
        for (id, process) in self.processes.iter_mut().enumerate() {
            if let Some(process) = process
                && !self.suspended[id]
                && process.next_timer().is_some_and(|due| due <= now)
            {
                process.fire_timers(now);
                self.cache.stale[id] = true;
                fired = true;
            }
        }
        fired
    }

    /// When the next timer is or was due, among those of all processes that are not suspended.
    #[must_use]
    pub fn next_timer(&self) -> Option<Duration> {
        let processes = self.processes.iter().zip(&self.suspended).filter(|(_, suspended)| !**suspended);
        processes.filter_map(|(process, _)| process.as_ref()?.next_timer()).min()
    }

    /// Generates a tick: its event, and a message if `generator` can deliver it now. If the previous tick is
    /// unfinished, nothing waits for a tick, so this one is lost, and the result is `false`.
    ///
    /// # Panics
    /// If `generator` is not a [`TickGenerator`].
    pub fn generate_tick(&mut self, generator: ProcessId) -> (Event, bool) {
        let tick = self.clock.ticks;
        self.clock.ticks += 1;
        let event = self.event(EventKind::Tick);
        self.show_monitors(&event);
        let taken = !self.suspended[generator.0] && self.is_ready_for_tick(generator);
        if taken && let Some(process) = self.process_mut::<TickGenerator>(generator) {
            process.generate(tick);
        }
        (event, taken)
    }

    /// Whether the tree has finished the last tick, and waits for the next one from this generator.
    ///
    /// # Panics
    /// If `generator` is not a [`TickGenerator`].
    pub fn is_ready_for_tick(&mut self, generator: ProcessId) -> bool {
        let process = self.process::<TickGenerator>(generator).expect("ticks come from a TickGenerator");
        let (channel, pending) = (process.output(), process.is_pending());
        self.refresh();
        let mut offers = self.cache.offers.iter().flatten();
        !pending && self.contents[channel.0].is_none() && offers.any(|offer| takes_ticks(offer, channel))
    }

    /// The transitions that can be taken now, in an order that depends only on the state. If there are none, the system
    /// is quiet.
    pub fn enabled(&mut self) -> Vec<Enabled> {
        let mut enabled = Vec::new();
        self.list_enabled(&mut enabled);
        enabled
    }

    pub(crate) fn list_enabled(&mut self, enabled: &mut Vec<Enabled>) {
        self.refresh();
        enabled.clear();
        for (index, offers) in self.cache.offers.iter().enumerate() {
            let process = ProcessId(index);
            for offer in offers {
                let kind = match &offer.action {
                    Action::Internal => Some(EnabledKind::Internal),
                    Action::Send(channel, envelope) => match self.topology.get(*channel).capacity {
                        Capacity::One if self.has_room(*channel, envelope) => Some(EnabledKind::Send(*channel)),
                        Capacity::One => None,
                        Capacity::Zero => {
                            self.push_handshakes(process, offer, enabled);
                            None
                        }
                    },
                    Action::Receive(channel, pattern) => {
                        self.may_receive(*channel, pattern).then_some(EnabledKind::Receive(*channel))
                    }
                };
                enabled.extend(kind.map(|kind| Enabled { process, transition: offer.transition, kind }));
            }
        }
        self.push_disturbances(enabled);
    }

    fn may_receive(&self, channel: ChannelId, pattern: &Pattern) -> bool {
        let is_accepted = |envelope: &Envelope| pattern.accepts(&envelope.message);
        self.contents[channel.0].as_ref().is_some_and(is_accepted) && self.disturbances.let_pass(channel)
    }

    /// Whether a message can be sent: the channel is empty, or holds an older message of the same topic that no
    /// disturbance is acting on.
    fn has_room(&self, channel: ChannelId, envelope: &Envelope) -> bool {
        let gives_way = |waiting: &Envelope| {
            let domain = &self.topology.get(channel).domain;
            domain.gives_way(&waiting.message, &envelope.message) && self.disturbances.let_pass(channel)
        };
        self.contents[channel.0].as_ref().is_none_or(gives_way)
    }

    /// Lists the possible handshakes for a send over a channel of capacity 0.
    fn push_handshakes(&self, sender: ProcessId, sending: &Offer, enabled: &mut Vec<Enabled>) {
        let Action::Send(channel, envelope) = &sending.action else { return };
        for (index, offers) in self.cache.offers.iter().enumerate() {
            for offer in offers {
                let Action::Receive(on, pattern) = &offer.action else { continue };
                if on == channel && pattern.accepts(&envelope.message) {
                    let (receiver, receiving) = (ProcessId(index), offer.transition);
                    let kind = EnabledKind::Handshake { channel: *channel, receiver, receiving };
                    enabled.push(Enabled { process: sender, transition: sending.transition, kind });
                }
            }
        }
    }

    fn refresh(&mut self) {
        for (index, process) in self.processes.iter().enumerate() {
            if std::mem::take(&mut self.cache.stale[index]) {
                let offers = &mut self.cache.offers[index];
                offers.clear();
                if let Some(process) = process.as_ref().filter(|_| !self.suspended[index]) {
                    process.offers(offers);
                }
            }
        }
    }

    /// Takes an enabled transition. A receive, alone or in a handshake, is an event of the timed state sequence unless
    /// it happens between members of one process.
    ///
    /// # Errors
    /// [`RunError::OutsideDomain`] if a process sends a message that its channel cannot carry, [`RunError::Corrupted`]
    /// if a disturbance produces one.
    ///
    /// # Panics
    /// If the transition is not enabled.
    pub fn take(&mut self, enabled: &Enabled) -> Result<Option<Event>, RunError> {
        let Enabled { process, transition, ref kind } = *enabled;
        match *kind {
            EnabledKind::Internal => {
                self.follow(process, transition, None);
                Ok(None)
            }
            EnabledKind::Send(channel) => {
                let envelope = self.sent(process, transition, channel)?;
                self.disturbances.arm(channel, 0, &envelope.message, self.clock.time);
                self.contents[channel.0] = Some(envelope);
                self.follow(process, transition, None);
                Ok(None)
            }
            EnabledKind::Receive(channel) => {
                let envelope = self.contents[channel.0].take().expect("an enabled receive finds a message");
                // A disturbance repeats the message: what is delivered is a copy.
                if self.disturbances.leave(channel) {
                    self.contents[channel.0] = Some(envelope.clone());
                }
                Ok(self.deliver(channel, envelope, process, transition))
            }
            EnabledKind::Handshake { channel, receiver, receiving } => {
                let envelope = self.sent(process, transition, channel)?;
                self.follow(process, transition, None);
                Ok(self.deliver(channel, envelope, receiver, receiving))
            }
            EnabledKind::Disturb(channel) => self.take_disturbance(channel).map(|()| None),
        }
    }

    /// The envelope that a transition sends, checked against the channel's domain.
    fn sent(&self, process: ProcessId, transition: TransitionId, channel: ChannelId) -> Result<Envelope, RunError> {
        let offer = self.cache.offers[process.0].iter().find(|offer| offer.transition == transition);
        let Some(Action::Send(_, envelope)) = offer.map(|offer| &offer.action) else {
            unreachable!("a transition that sends was offered as one");
        };
        if self.topology.carries(channel, &envelope.message) {
            return Ok(envelope.clone());
        }
        Err(RunError::OutsideDomain {
            process: self.topology.name(process).to_owned(),
            message: envelope.message.clone(),
            channel: self.topology.describe(channel),
            domain: self.topology.get(channel).domain.to_string(),
        })
    }

    /// The monitored transition: the receiver and every monitor that watches the channel move in the same step.
    fn deliver(
        &mut self,
        channel: ChannelId,
        envelope: Envelope,
        receiver: ProcessId,
        receiving: TransitionId,
    ) -> Option<Event> {
        let message = envelope.message.clone();
        self.follow(receiver, receiving, Some(envelope));
        if self.topology.is_internal(channel) {
            return None;
        }
        self.clock.step += 1;
        let event = self.event(EventKind::Received { channel, message });
        self.show_monitors(&event);
        Some(event)
    }

    fn follow(&mut self, id: ProcessId, transition: TransitionId, received: Option<Envelope>) {
        let process = self.processes[id.0].as_mut().expect("only processes with a behavior offer transitions");
        process.take(transition, received, self.clock.time);
        self.cache.stale[id.0] = true;
    }

    fn event(&self, kind: EventKind) -> Event {
        Event { step: self.clock.step, tick: self.clock.ticks.saturating_sub(1), time: self.clock.time, kind }
    }

    fn show_monitors(&mut self, event: &Event) {
        for attached in &mut self.monitors {
            attached.monitor.observe(event);
            attached.note(event);
        }
    }

    /// Whether processes, channels and disturbances are in the same state in both systems. Between systems copied from
    /// one another, disturbances are identified by number. Monitors and counters are not part of the state.
    #[must_use]
    pub fn same_state(&self, other: &Self) -> bool {
        self.processes == other.processes
            && self.contents == other.contents
            && self.disturbances == other.disturbances
            && self.suspended == other.suspended
    }

    /// Feeds the state of processes, channels and disturbances to a hasher.
    pub fn hash_state(&self, hasher: &mut impl Hasher) {
        self.processes.hash(hasher);
        self.contents.hash(hasher);
        self.disturbances.hash(hasher);
        self.suspended.hash(hasher);
    }

    /// Brings the state into [normal form](NormalForm): afterwards, [`same_state`](Self::same_state) holds between
    /// situations that continue alike, and the next tick has the number 0. Monitors are not changed.
    ///
    /// # Errors
    /// The first process that has no normal form.
    pub fn normalize(&mut self) -> Result<(), (ProcessId, NoNormalForm)> {
        let mut awaited = Vec::new();
        self.processes.iter().flatten().for_each(|process| process.awaits(&mut awaited));
        let numbers = |channel, number| number_among(&awaited, channel, number);
        let topology = Arc::clone(&self.topology);
        let form = NormalForm::new(&topology, self.clock.time, &numbers);
        for (id, process) in self.processes.iter_mut().enumerate() {
            process.as_mut().map_or(Ok(()), |process| process.normalize(&form)).map_err(|why| (ProcessId(id), why))?;
        }
        for (channel, envelope) in topology.channels().zip(&mut self.contents) {
            envelope.iter_mut().for_each(|envelope| form.envelope(channel, envelope));
        }
        for generator in self.processes.iter().flatten().filter_map(|process| process.as_any().downcast_ref()) {
            let tick = &mut self.contents[TickGenerator::output(generator).0];
            tick.iter_mut().for_each(|tick| *tick = TickGenerator::tick(0));
        }
        self.disturbances.normalize(&form);
        self.clock = RunClock { time: NormalForm::NOW, ..RunClock::default() };
        self.cache.stale.fill(true);
        Ok(())
    }

    /// A copy without monitors.
    #[must_use]
    pub fn fork(&self) -> Self {
        Self {
            topology: Arc::clone(&self.topology),
            processes: self.processes.clone(),
            contents: self.contents.clone(),
            disturbances: self.disturbances.clone(),
            suspended: self.suspended.clone(),
            monitors: Vec::new(),
            clock: self.clock.clone(),
            cache: self.cache.clone(),
        }
    }
}

/// The number of a request in normal form, among those that await an answer.
fn number_among(awaited: &[(ChannelId, RequestNumber)], channel: ChannelId, number: RequestNumber) -> RequestNumber {
    let on_channel = awaited.iter().filter(|(on, _)| *on == channel).map(|(_, awaited)| *awaited);
    let position = (1..).zip(on_channel).find(|(_, awaited)| *awaited == number);
    RequestNumber(position.map_or(0, |(position, _)| position))
}

/// Checks at wiring that a process uses only its own channels, and only for messages that they can carry.
fn check_uses(topology: &Topology, id: ProcessId, process: &dyn Process) -> Result<(), WiringError> {
    for used in process.uses() {
        let (channel, message, sends) = match used {
            Use::Sends(channel, message) => (channel, message, true),
            Use::Receives(channel, message) => (channel, message, false),
        };
        let ends = topology.get(channel);
        let (end, verb) = if sends { (ends.source, "send on") } else { (ends.target, "receive from") };
        if !topology.is_part_of(id, end) {
            let process = topology.name(id).to_owned();
            return Err(WiringError::ForeignChannel { process, verb, channel: topology.describe(channel) });
        }
        if let Some(message) = message.filter(|message| !topology.carries(channel, message)) {
            return Err(WiringError::OutsideDomain {
                process: topology.name(id).to_owned(),
                message,
                channel: topology.describe(channel),
                domain: ends.domain.to_string(),
            });
        }
    }
    Ok(())
}
