//! A machine as a process.

use std::collections::{BTreeMap, VecDeque};
use std::hash::{Hash, Hasher};
use std::sync::Arc;
use std::time::Duration;

use channels::{
    Action, ChannelId, Domain, Envelope, FieldKind, Message, Offer, Pattern, Process, RequestNumber, TransitionId, Use,
    Value,
};
use skills::{Datum, Event, Host, Machine, Note, Outgoing, Undelivered};

use crate::instance::Fields;
use crate::machine::{Kind, PortDirection, TREE, Way, input_datum, output_datum};

/// More messages than this may not wait for one channel, and more errors than this are not kept.
const MAX_WAITING: usize = 4096;
const MAX_ERRORS: usize = 20;

/// What connects a machine with the other processes.
#[derive(Debug, Default)]
pub(super) struct Wiring {
    pub(super) name: String,
    /// Its channels from other processes, and to them.
    pub(super) incoming: Vec<Incoming>,
    pub(super) outgoing: Vec<ChannelId>,
    /// The index of the channel to the process that properties listen to.
    pub(super) recorder: Option<usize>,
    pub(super) routes: BTreeMap<String, Route>,
    /// The fields of all events of the model.
    pub(super) events: Arc<BTreeMap<String, Fields>>,
    /// A leaf's connection with the tree.
    pub(super) leaf: Option<Leaf>,
}

#[derive(Debug)]
pub(super) struct Incoming {
    pub(super) channel: ChannelId,
    pub(super) from_tree: bool,
    /// The number of the sender among the clients of an event's interface.
    pub(super) client: BTreeMap<String, usize>,
}

/// Where an event goes: the indices of outgoing channels.
#[derive(Debug)]
pub(super) struct Route {
    pub(super) way: Way,
    /// For [`Way::Response`], [`Way::Client`] and [`Way::Thread`], by number; else all receive it.
    pub(super) receivers: Vec<Option<usize>>,
    /// Whether a property is about it.
    pub(super) is_recorded: bool,
}

#[derive(Debug)]
pub(super) struct Leaf {
    pub(super) ports: BTreeMap<String, (PortDirection, Kind)>,
    pub(super) requests: Domain,
    pub(super) replies: Domain,
    /// The index of the channel to the tree.
    pub(super) out: usize,
}

/// A machine of a model as a process. It always receives; what it sends waits in order until its channel is free.
#[derive(Clone, Debug)]
pub(crate) struct Automaton {
    wiring: Arc<Wiring>,
    machine: Machine,
    post: Post,
}

/// The messages of a machine on their way.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Post {
    outboxes: Vec<VecDeque<Envelope>>,
    /// The client that each service answers next, by the service's events without their last word.
    serving: BTreeMap<String, usize>,
    /// Requests that came meanwhile.
    waiting: VecDeque<(String, usize, Datum)>,
    /// The tree's request that has no answer yet.
    pending: Option<RequestNumber>,
    /// The answer to the tree's request, still without the values of ports.
    answer: Option<(String, RequestNumber)>,
    errors: Vec<String>,
}

impl Automaton {
    /// The machine at its start.
    pub(super) fn new(wiring: Wiring, mut machine: Machine, seed: u64) -> Self {
        let post = Post {
            outboxes: vec![VecDeque::new(); wiring.outgoing.len()],
            serving: BTreeMap::new(),
            waiting: VecDeque::new(),
            pending: None,
            answer: None,
            errors: Vec::new(),
        };
        machine.set_seed(seed);
        let mut automaton = Self { wiring: Arc::new(wiring), machine, post };
        automaton.with_machine(|machine, host| machine.start(Duration::ZERO, host));
        automaton
    }

    /// What went wrong in it so far, in words.
    pub(crate) fn errors(&self) -> &[String] {
        &self.post.errors
    }

    fn with_machine(&mut self, act: impl FnOnce(&mut Machine, &mut Sender<'_>)) {
        let Self { wiring, machine, post } = self;
        act(machine, &mut Sender { wiring, post });
        self.answer();
    }

    /// Completes the answer to the tree with the values of output ports.
    fn answer(&mut self) {
        let Some((head, request)) = self.post.answer.take() else { return };
        let Some(leaf) = &self.wiring.leaf else { return };
        let Some(shape) = leaf.replies.shapes().first() else { return };
        let mut fields = vec![Value::symbol(&head)];
        for (port, kind) in shape.fields().iter().skip(1) {
            let datum = output_datum(port);
            let value = self.machine.datum(&datum).cloned().unwrap_or_default();
            fields.push(port_value(&value, kind));
            self.machine.put(&datum, Datum::Undefined);
        }
        self.post.outboxes[leaf.out].push_back(Envelope { message: Message::new(fields), request });
    }

    fn receive(&mut self, index: usize, envelope: &Envelope, now: Duration) {
        let wiring = Arc::clone(&self.wiring);
        let incoming = &wiring.incoming[index];
        let Some(head) = envelope.message.head() else { return };
        if incoming.from_tree {
            self.take_request(&wiring, head, envelope, now);
            return;
        }
        let fields = wiring.events.get(head).into_iter().flatten();
        let values = envelope.message.fields().get(1..).unwrap_or_default();
        let values = fields.zip(values).map(|((name, kind), value)| (name.clone(), kind.datum(value)));
        let client = incoming.client.get(head).copied();
        // A goal arrives with the number of its client; a thread that is free says which one it is.
        let number = client.filter(|_| head.starts_with("action_")).map(|client| {
            let name = if head.ends_with("_thread_free") { "thread_id" } else { "goal_id" };
            (name.to_owned(), (client as f64).into())
        });
        let data = nested(values.chain(number).collect());
        match (head.strip_prefix("srv_").and_then(|name| name.strip_suffix("_request")), client) {
            (Some(service), Some(client)) if self.post.serving.contains_key(service) => {
                self.post.waiting.push_back((service.to_owned(), client, data));
            }
            (Some(service), Some(client)) => self.serve(service, client, data, now),
            _ => {
                self.handle(head, data, now);
                self.serve_waiting(now);
            }
        }
    }

    /// Gives the machine a client's request.
    fn serve(&mut self, service: &str, client: usize, data: Datum, now: Duration) {
        self.post.serving.insert(service.to_owned(), client);
        self.handle(&format!("srv_{service}_request"), data, now);
        self.serve_waiting(now);
    }

    /// Gives the machine the next request of a service that has answered.
    fn serve_waiting(&mut self, now: Duration) {
        let serving = &self.post.serving;
        let next = self.post.waiting.iter().position(|(service, ..)| !serving.contains_key(service));
        if let Some((service, client, data)) = next.and_then(|index| self.post.waiting.remove(index)) {
            self.serve(&service, client, data, now);
        }
    }

    /// A tick or a halt from the tree, with the values of input ports.
    fn take_request(&mut self, wiring: &Wiring, head: &str, envelope: &Envelope, now: Duration) {
        self.post.pending = Some(envelope.request);
        if let Some(leaf) = &wiring.leaf
            && let Some(shape) = leaf.requests.shape_of(&envelope.message)
        {
            for ((port, _), value) in shape.fields().iter().zip(envelope.message.fields()).skip(1) {
                let Some((_, kind)) = leaf.ports.get(port) else { continue };
                let datum = match value {
                    Value::Text(text) if *kind != Kind::Text => kind.parse(text),
                    Value::Symbol(_) => None,
                    value => Some(kind.datum(value)),
                };
                datum.into_iter().for_each(|datum| self.machine.put(&input_datum(port), datum));
            }
        }
        self.handle(if head == "halt" { "bt_halt" } else { "bt_tick" }, Datum::Undefined, now);
        self.serve_waiting(now);
    }

    fn handle(&mut self, event: &str, data: Datum, now: Duration) {
        let event = Event::external(event).with_data(data);
        self.with_machine(|machine, host| machine.handle(event, now, host));
    }
}

/// The machine's side of its channels.
struct Sender<'p> {
    wiring: &'p Arc<Wiring>,
    post: &'p mut Post,
}

impl Host for Sender<'_> {
    fn send(&mut self, outgoing: &Outgoing) -> Result<(), Undelivered> {
        let event = outgoing.event.as_deref().unwrap_or_default();
        if outgoing.target.as_deref() == Some(TREE) {
            let request = self.post.pending.take();
            let request = request.ok_or_else(|| Undelivered("the tree does not wait for an answer".to_owned()))?;
            self.post.answer = Some((event.to_owned(), request));
            return Ok(());
        }
        let wiring = Arc::clone(self.wiring);
        let Some(route) = wiring.routes.get(event) else { return Ok(()) };
        let message = self.message(event, &outgoing.data)?;
        let number = |name| match outgoing.data.member(name) {
            Some(Datum::Number(number)) if *number >= 0.0 => Some(*number as usize),
            _ => None,
        };
        let receivers: Vec<Option<usize>> = match route.way {
            Way::Everyone | Way::Request | Way::Goal | Way::Server => route.receivers.clone(),
            Way::Response => {
                let service = event.strip_prefix("srv_").and_then(|name| name.strip_suffix("_response"));
                let client = service.and_then(|service| self.post.serving.remove(service));
                let client = client.ok_or_else(|| Undelivered("no client waits for this response".to_owned()))?;
                vec![route.receivers.get(client).copied().flatten()]
            }
            Way::Client | Way::Thread => {
                let name = if route.way == Way::Client { "goal_id" } else { "thread_id" };
                let receiver = number(name).and_then(|number| route.receivers.get(number));
                let receiver = receiver.ok_or_else(|| Undelivered(format!("there is no such `{name}`")))?;
                vec![*receiver]
            }
        };
        for out in receivers.into_iter().flatten().chain(wiring.recorder.filter(|_| route.is_recorded)) {
            if self.post.outboxes[out].len() >= MAX_WAITING {
                return Err(Undelivered(format!("{MAX_WAITING} messages are waiting already")));
            }
            self.post.outboxes[out].push_back(Envelope { message: message.clone(), request: RequestNumber::default() });
        }
        Ok(())
    }

    fn note(&mut self, note: Note) {
        let error = match note {
            Note::Error { reason, .. } => reason,
            Note::Stuck { microsteps } => format!("the machine did not come to rest in {microsteps} microsteps"),
            _ => return,
        };
        if self.post.errors.len() < MAX_ERRORS && !self.post.errors.contains(&error) {
            self.post.errors.push(error);
        }
    }
}

impl Sender<'_> {
    /// The message of an event with these data.
    fn message(&self, event: &str, data: &Datum) -> Result<Message, Undelivered> {
        let mut values = vec![Value::symbol(event)];
        for (field, kind) in self.wiring.events.get(event).into_iter().flatten() {
            values.push(match data.member(field) {
                None => kind.default(),
                Some(datum) => kind.value(datum).ok_or_else(|| {
                    Undelivered(format!("the field {field} of {event} is {}, and {datum} is not", kind.field()))
                })?,
            });
        }
        Ok(Message::new(values))
    }
}

/// Fields whose names have dots, as objects in objects: `pose.x` is the member `x` of `pose`.
pub(crate) fn nested(fields: Vec<(String, Datum)>) -> Datum {
    let mut members: Vec<(String, Datum)> = Vec::new();
    let mut inner: Vec<(String, Vec<(String, Datum)>)> = Vec::new();
    for (name, value) in fields {
        match name.split_once('.') {
            None => members.push((name, value)),
            Some((outer, rest)) => match inner.iter_mut().find(|(known, _)| known == outer) {
                Some((_, fields)) => fields.push((rest.to_owned(), value)),
                None => inner.push((outer.to_owned(), vec![(rest.to_owned(), value)])),
            },
        }
    }
    members.extend(inner.into_iter().map(|(name, fields)| (name, nested(fields))));
    Datum::object(members).unwrap_or_default()
}

/// The value of an output port in an answer.
fn port_value(datum: &Datum, kind: &FieldKind) -> Value {
    let FieldKind::Optional(kind) = kind else { return Value::symbol(FieldKind::NONE) };
    let value = match (&**kind, datum) {
        (FieldKind::Text, Datum::Undefined) => None,
        (FieldKind::Text, Datum::Text(text)) => Some(Value::Text(Arc::clone(text))),
        (FieldKind::Text, other) => Some(Value::Text(other.to_json().into())),
        (FieldKind::Bool, datum) => Kind::Bool.value(datum),
        (FieldKind::Int, datum) => Kind::Int.value(datum),
        (FieldKind::Real, datum) => Kind::Real.value(datum),
        _ => None,
    };
    value.unwrap_or_else(|| Value::symbol(FieldKind::NONE))
}

/// Transitions are numbered by channel: incoming ones first, then outgoing ones.
impl Process for Automaton {
    fn offers(&self, offers: &mut Vec<Offer>) {
        for (index, incoming) in self.wiring.incoming.iter().enumerate() {
            let action = Action::Receive(incoming.channel, Pattern::Any);
            offers.push(Offer { transition: TransitionId(index as u32), action });
        }
        // A property sees what is sent at once, before anything follows from it.
        let first = self.wiring.recorder.filter(|recorder| !self.post.outboxes[*recorder].is_empty());
        for (index, (out, waiting)) in self.wiring.outgoing.iter().zip(&self.post.outboxes).enumerate() {
            if let Some(envelope) = waiting.front().filter(|_| first.is_none_or(|first| first == index)) {
                let transition = TransitionId((self.wiring.incoming.len() + index) as u32);
                offers.push(Offer { transition, action: Action::Send(*out, envelope.clone()) });
            }
        }
    }

    fn take(&mut self, transition: TransitionId, received: Option<Envelope>, now: Duration) {
        let index = transition.0 as usize;
        match index.checked_sub(self.wiring.incoming.len()) {
            Some(out) => {
                self.post.outboxes[out].pop_front();
            }
            None => received.iter().for_each(|envelope| self.receive(index, envelope, now)),
        }
    }

    fn next_timer(&self) -> Option<Duration> {
        self.machine.next_timer()
    }

    fn fire_timers(&mut self, now: Duration) {
        self.with_machine(|machine, host| machine.fire_timers(now, host));
    }

    fn uses(&self) -> Vec<Use> {
        let receives = self.wiring.incoming.iter().map(|incoming| Use::Receives(incoming.channel, None));
        receives.chain(self.wiring.outgoing.iter().map(|out| Use::Sends(*out, None))).collect()
    }

    /// The ids of the active states that have no children.
    fn location(&self) -> String {
        self.machine.active_ids().collect::<Vec<_>>().join(", ")
    }
}

/// The wiring is constant: two processes of one run with the same name have the same.
impl PartialEq for Automaton {
    fn eq(&self, other: &Self) -> bool {
        self.wiring.name == other.wiring.name && self.machine == other.machine && self.post == other.post
    }
}

impl Eq for Automaton {}

impl Hash for Automaton {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.wiring.name.hash(state);
        self.machine.hash(state);
        self.post.hash(state);
    }
}
