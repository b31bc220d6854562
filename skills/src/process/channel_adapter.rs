//! The adapter between a process with named events and its channels: it tracks which conversation a message belongs
//! to.

use std::collections::VecDeque;
use std::sync::Arc;

use channels::{
    Action, ChannelId, Envelope, NoNormalForm, NormalForm, Offer, Pattern, ProcessId, RequestNumber, Role, Symbol,
    Topology, TransitionId, Use,
};

use super::adapter::Adapter;
use super::check::Constants;
use super::wiring::{CLIENT, Outgoing, Wiring, message, shapes_of};
use crate::Datum;
use crate::chart::{Attribute, CHANNEL_PROCESSOR};
use crate::event::Event;
use crate::machine::{MAX_WAITING, Machine, Undelivered};

/// Turns the messages of a process's channels into events, and what it sends into messages.
///
/// A message of [`Role::Request`] or [`Role::Goal`] opens a conversation and numbers it; everything that belongs to it
/// carries the number. So an answer to an abandoned request is ignored, a request is answered once, and a goal ends
/// once, after it has been accepted or by its rejection. Each channel has at most one open request, and one open goal
/// per action: a client that sends another abandons its earlier one, and a process that serves others takes a client's
/// next request only when it has answered the last one. (The tree is different: its requests are always taken, since a
/// halt must reach a leaf that has not answered. So are those to a component that may never answer. And a
/// [patient](Self::patient) process abandons nothing.)
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct ChannelAdapter {
    pub(super) wiring: Arc<Wiring>,
    /// Messages to be sent, by outgoing channel.
    outboxes: Vec<VecDeque<Envelope>>,
    /// Events of which the process will get one.
    choices: Vec<Event>,
    /// Unanswered requests of this process, by outgoing channel.
    asked: Vec<Open>,
    /// Unanswered requests to this process, by incoming channel.
    pending: Vec<Open>,
    last_request: u64,
    /// Whether a client's next request is taken before the last one has been answered, which is then abandoned.
    abandons: bool,
    /// Whether this process goes on waiting for the answer to a request when it sends another.
    is_patient: bool,
    /// Whether the client has given up waiting for an answer and asked again: an answer to the request that it gave up
    /// may still follow, and there is then one answer too many.
    is_overtaken: bool,
}

/// A request that has not been answered, or a goal that has not ended.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
struct Conversation {
    /// None for a request of a service.
    action: Option<Arc<str>>,
    number: RequestNumber,
    /// Whether it is a goal that this process has accepted.
    is_accepted: bool,
}

type Open = Vec<Conversation>;

/// What `m[1]` ends with if a goal is accepted or rejected: the messages that may follow depend on that.
const ACCEPTED: &str = "accepted";
const REJECTED: &str = "rejected";

/// The newest one.
fn find(open: &Open, action: Option<&str>) -> Option<RequestNumber> {
    open.iter().rfind(|known| known.action.as_deref() == action).map(|known| known.number)
}

/// Returns whether another one of the same kind was open.
fn begin(open: &mut Open, action: Option<&str>, number: RequestNumber) -> bool {
    let was_open = end(open, action).is_some();
    open.push(Conversation { action: action.map(Arc::from), number, is_accepted: false });
    was_open
}

fn end(open: &mut Open, action: Option<&str>) -> Option<RequestNumber> {
    let index = open.iter().position(|known| known.action.as_deref() == action)?;
    Some(open.remove(index).number)
}

/// The action that a message `pick.goal` belongs to; `None` for the messages of services and topics.
fn action(role: Role, head: &str) -> Option<&str> {
    let of_action = matches!(role, Role::Goal | Role::Cancel | Role::Feedback | Role::Result);
    head.rsplit_once('.').map(|(action, _)| action).filter(|_| of_action)
}

impl ChannelAdapter {
    /// The adapter of a process, which numbers its requests from the one after `last_request`.
    #[must_use]
    pub fn new(topology: &Topology, process: ProcessId) -> Self {
        Self::on(Arc::new(Wiring::new(topology, process)), 0)
    }

    pub(super) fn on(wiring: Arc<Wiring>, last_request: u64) -> Self {
        Self {
            outboxes: vec![VecDeque::new(); wiring.outgoing.len()],
            asked: vec![Open::new(); wiring.outgoing.len()],
            pending: vec![Open::new(); wiring.incoming.len()],
            choices: Vec::new(),
            wiring,
            last_request,
            abandons: false,
            is_patient: false,
            is_overtaken: false,
        }
    }

    /// The same adapter, which takes a client's next request at once. The one before is then abandoned.
    #[must_use]
    pub fn abandoning(self) -> Self {
        Self { abandons: true, ..self }
    }

    /// The same adapter, for a process that sends further requests before it has an answer, and awaits all answers: it
    /// has several clients that are independent of each other.
    #[must_use]
    pub fn patient(self) -> Self {
        Self { is_patient: true, ..self }
    }

    /// The number of the last request or goal that was sent.
    #[must_use]
    pub fn last_request(&self) -> RequestNumber {
        RequestNumber(self.last_request)
    }

    /// The adapter of a process that replaces this one: nothing is open, and answers to earlier requests are ignored.
    #[must_use]
    pub fn succeeding(&self) -> Self {
        let Self { abandons, is_patient, .. } = *self;
        Self { abandons, is_patient, ..Self::on(Arc::clone(&self.wiring), self.last_request) }
    }

    fn first_choice(&self) -> usize {
        self.wiring.incoming.len() + self.wiring.outgoing.len()
    }

    /// Takes one of the transitions. Returns the event that a received message becomes, or that is chosen; `None` for a
    /// message that was sent, and for an answer that is no longer awaited.
    pub fn take(&mut self, transition: TransitionId, received: Option<&Envelope>) -> Option<Event> {
        let index = transition.0 as usize;
        if let Some(choice) = index.checked_sub(self.first_choice()) {
            // The others are gone.
            return Some(std::mem::take(&mut self.choices).swap_remove(choice));
        }
        match index.checked_sub(self.wiring.incoming.len()) {
            Some(out) => {
                self.outboxes[out].pop_front();
                None
            }
            None => self.receive(index, received?),
        }
    }

    fn receive(&mut self, index: usize, envelope: &Envelope) -> Option<Event> {
        let incoming = &self.wiring.incoming[index];
        let (name, role) = incoming.event(&envelope.message);
        let action = action(role, envelope.message.head().unwrap_or_default());
        match (role, incoming.back.map(|out| &mut self.asked[out])) {
            (Role::Request | Role::Goal, Some(_)) => {
                let is_overtaken = begin(&mut self.pending[index], action, envelope.request);
                self.is_overtaken |= is_overtaken && incoming.is_client;
            }
            (Role::Cancel, Some(_)) if find(&self.pending[index], action) != Some(envelope.request) => return None,
            (Role::Reply | Role::Feedback | Role::Result, Some(asked)) => {
                let is_its_own =
                    |known: &Conversation| known.action.as_deref() == action && known.number == envelope.request;
                let place = asked.iter().position(is_its_own)?;
                if role != Role::Feedback {
                    asked.remove(place);
                }
            }
            _ => {}
        }
        let event = Event::external(name).with_data(incoming.data(&envelope.message));
        Some(event.with_origin(Arc::clone(&incoming.peer), CHANNEL_PROCESSOR))
    }

    /// The channels that carry messages of this process which begin with the symbol `head`.
    #[must_use]
    pub fn carriers(&self, head: &str) -> Vec<ChannelId> {
        let carries = |out: &&Outgoing| shapes_of(&out.domain, head).next().is_some();
        self.wiring.outgoing.iter().filter(carries).map(|out| out.channel).collect()
    }

    /// The channel to a process.
    #[must_use]
    pub fn channel_to(&self, peer: &str) -> Option<ChannelId> {
        self.wiring.outgoing_to(peer).map(|out| self.wiring.outgoing[out].channel)
    }

    /// Whether no message waits to be sent.
    #[must_use]
    pub fn has_sent_all(&self) -> bool {
        self.outboxes.iter().all(VecDeque::is_empty)
    }

    fn check_room(&self, out: usize) -> Result<(), Undelivered> {
        let peer = &self.wiring.outgoing[out].peer;
        let full = || Undelivered::Unfit(format!("{MAX_WAITING} messages to {peer} are already waiting"));
        if self.outboxes[out].len() < MAX_WAITING { Ok(()) } else { Err(full()) }
    }

    /// The number of the conversation that a message to this channel begins, continues or ends.
    fn request_number(&mut self, out: usize, head: &str, role: Role) -> Result<RequestNumber, Undelivered> {
        let action = action(role, head);
        let peer = &self.wiring.outgoing[out].peer;
        match role {
            Role::Request | Role::Goal => {
                self.last_request += 1;
                if !self.is_patient {
                    end(&mut self.asked[out], action);
                }
                let number = self.last_request();
                self.asked[out].push(Conversation { action: action.map(Arc::from), number, is_accepted: false });
                Ok(number)
            }
            Role::Cancel => {
                let nothing = || Undelivered::Late(format!("{peer} has no goal of this process to cancel"));
                find(&self.asked[out], action).ok_or_else(nothing)
            }
            Role::Reply | Role::Feedback | Role::Result => self.answer(out, head, role),
            Role::Topic => Ok(RequestNumber::default()),
        }
    }

    /// The number of the conversation to which an answer belongs.
    fn answer(&mut self, out: usize, head: &str, role: Role) -> Result<RequestNumber, Undelivered> {
        let action = action(role, head);
        let Wiring { outgoing, incoming, .. } = &*self.wiring;
        let peer = &outgoing[out].peer;
        let is_open = |open: &Open| open.iter().position(|known| known.action.as_deref() == action);
        let back = incoming.iter().position(|incoming| incoming.peer == *peer);
        let Some((open, place)) = back.and_then(|back| Some((back, is_open(&self.pending[back])?))) else {
            let is_client = &**peer == CLIENT;
            if is_client && std::mem::take(&mut self.is_overtaken) {
                return Err(Undelivered::Late(format!("{peer} is not waiting for an answer")));
            }
            let why = if is_client { "has had its answer" } else { "is not waiting for an answer" };
            return Err(Undelivered::Unfit(format!("<{head}> answers nothing: {peer} {why}")));
        };
        let open = &mut self.pending[open];
        let Some(action) = action else { return Ok(open.remove(place).number) };
        let goal = &mut open[place];
        let decides = [ACCEPTED, REJECTED].iter().any(|part| head.strip_prefix(action) == Some(&format!(".{part}")));
        if decides == goal.is_accepted {
            let is = if decides { "is already" } else { "is not" };
            return Err(Undelivered::Unfit(format!("<{head}> does not fit: the goal of {peer} {is} accepted")));
        }
        goal.is_accepted = true;
        let number = goal.number;
        if role == Role::Result {
            open.remove(place);
        }
        Ok(number)
    }

    /// Everything that the process may receive.
    pub fn receives(&self) -> impl Iterator<Item = Use> {
        self.wiring.incoming.iter().map(|incoming| Use::Receives(incoming.channel, None))
    }

    /// Everything that the process may send, if it can send anything.
    pub fn sends(&self) -> impl Iterator<Item = Use> {
        self.wiring.outgoing.iter().map(|out| Use::Sends(out.channel, None))
    }
}

/// The rules for skills and components: see the crate's documentation.
impl Adapter for ChannelAdapter {
    /// Offers to receive on every channel, and to send what waits; or else to choose, if there is a choice. Transitions
    /// are numbered by channel: incoming ones first, then outgoing ones, then the choices.
    fn offers(&self, offers: &mut Vec<Offer>) {
        if !self.choices.is_empty() {
            let first = self.first_choice();
            let numbers = (first..).take(self.choices.len()).map(|number| TransitionId(number as u32));
            offers.extend(numbers.map(|transition| Offer { transition, action: Action::Internal }));
            return;
        }
        for (index, (incoming, pending)) in self.wiring.incoming.iter().zip(&self.pending).enumerate() {
            let pattern = if pending.is_empty() || incoming.is_client || self.abandons {
                Pattern::Any
            } else {
                let waits = |&&(ref head, _, role): &&(Symbol, Arc<str>, Role)| match role {
                    Role::Request => find(pending, None).is_some(),
                    Role::Goal => find(pending, action(role, head.name())).is_some(),
                    _ => false,
                };
                Pattern::Except(incoming.events.iter().filter(waits).map(|(head, ..)| head.clone()).collect())
            };
            let action = Action::Receive(incoming.channel, pattern);
            offers.push(Offer { transition: TransitionId(index as u32), action });
        }
        for (index, (out, waiting)) in self.wiring.outgoing.iter().zip(&self.outboxes).enumerate() {
            if let Some(envelope) = waiting.front() {
                let transition = TransitionId((self.wiring.incoming.len() + index) as u32);
                offers.push(Offer { transition, action: Action::Send(out.channel, envelope.clone()) });
            }
        }
    }

    fn take(&mut self, transition: TransitionId, received: Option<&Envelope>, machine: &mut Machine) -> Option<Event> {
        let event = self.take(transition, received)?;
        let incoming = self.wiring.incoming.get(transition.0 as usize);
        for port in incoming.filter(|incoming| incoming.is_client).iter().flat_map(|_| self.wiring.inputs()) {
            if let Some(value) = event.data.member(port) {
                machine.put(port, value.clone());
            }
        }
        Some(event)
    }

    fn send(&mut self, target: Option<&str>, head: &str, data: &Datum) -> Result<(), Undelivered> {
        let wiring = Arc::clone(&self.wiring);
        let Some(peer) = target else {
            let (message, _) = message(&wiring.topics, head, data)
                .map_err(|problem| problem.undelivered(&format!("{} cannot publish <{head}>", wiring.name)))?;
            for out in wiring.subscribers(head) {
                // A newer message replaces an older one here as it does in the channel.
                let is_older = |older: &&mut Envelope| older.message.head() == Some(head);
                let replaced = self.outboxes[out].iter_mut().find(is_older).filter(|_| !wiring.outgoing[out].takes_all);
                match replaced {
                    Some(older) => *older = message.clone().into(),
                    None => {
                        self.check_room(out)?;
                        self.outboxes[out].push_back(message.clone().into());
                    }
                }
            }
            return Ok(());
        };
        let out = wiring.outgoing_to(peer);
        let out = out.ok_or_else(|| Undelivered::Unfit(format!("there is no channel {} → {peer}", wiring.name)))?;
        let (message, role) = message(&wiring.outgoing[out].domain, head, data)
            .map_err(|problem| problem.undelivered(&format!("<{head}> cannot be sent to {peer}")))?;
        self.check_room(out)?;
        let request = self.request_number(out, head, role)?;
        self.outboxes[out].push_back(Envelope { message, request });
        Ok(())
    }

    fn choose(&mut self, event: Event) -> Result<(), Undelivered> {
        if self.choices.len() >= MAX_WAITING {
            return Err(Undelivered::Unfit(format!("{MAX_WAITING} events are already to be chosen from")));
        }
        self.choices.push(event);
        Ok(())
    }

    fn choice(&self, transition: TransitionId) -> Option<&Event> {
        self.choices.get((transition.0 as usize).checked_sub(self.first_choice())?)
    }

    fn succeeding(&self) -> Box<dyn Adapter> {
        Box::new(self.succeeding())
    }

    fn awaits(&self, requests: &mut Vec<(ChannelId, RequestNumber)>) {
        for (out, asked) in self.wiring.outgoing.iter().zip(&self.asked) {
            let mut asked = asked.clone();
            asked.sort();
            requests.extend(asked.into_iter().map(|asked| (out.channel, asked.number)));
        }
    }

    fn normalize(&mut self, form: &NormalForm<'_>) -> Result<(), NoNormalForm> {
        let wiring = Arc::clone(&self.wiring);
        for (out, waiting) in wiring.outgoing.iter().zip(&mut self.outboxes) {
            form.queue(waiting.len(), || {
                format!("more than {} messages from {} to {} are waiting", NormalForm::QUEUE, wiring.name, out.peer)
            })?;
            waiting.iter_mut().for_each(|envelope| form.envelope(out.channel, envelope));
        }
        let requests = wiring.outgoing.iter().map(|out| out.channel).zip(&mut self.asked);
        let others = wiring.incoming.iter().map(|incoming| incoming.channel).zip(&mut self.pending);
        for (channel, open) in requests.chain(others) {
            open.iter_mut().for_each(|known| form.number(channel, &mut known.number));
            open.sort();
        }
        self.last_request = self.asked.iter().flatten().map(|asked| asked.number.0).max().unwrap_or_default();
        Ok(())
    }

    fn uses(&self, machine: &Machine) -> Vec<Use> {
        let mut uses: Vec<Use> = self.receives().collect();
        let constants = Constants::of(machine, &self.wiring);
        machine.chart().visit_sends(&mut |send| {
            if !send.goes_by_channel() {
                return;
            }
            let literal = |attribute: &Option<Attribute>| attribute.as_ref()?.literal().cloned();
            match literal(&send.target) {
                Some(peer) => uses.extend(self.wiring.outgoing_to(&peer).map(|out| {
                    let out = &self.wiring.outgoing[out];
                    let message = literal(&send.event).and_then(|head| constants.message(&head, send, out));
                    Use::Sends(out.channel, message)
                })),
                // The target is computed, or there is none: it may be any process.
                None => uses.extend(self.sends()),
            }
        });
        uses
    }
}
