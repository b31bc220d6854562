//! The adapter between a machine and its channels: the rules of ROS.

use std::collections::{BTreeMap, VecDeque};
use std::hash::{Hash, Hasher};
use std::sync::Arc;

use channels::{
    Action, ChannelId, Domain, Envelope, FieldKind, Message, NoNormalForm, NormalForm, Offer, Pattern, RequestNumber,
    TransitionId, Use, Value,
};
use skills::{Adapter, Datum, Event, Machine, Undelivered};

use crate::instance::Fields;
use crate::machine::{DataKind, PortDirection, TREE, Way, input_datum, nested, output_datum};

/// The maximum number of messages that may wait for one channel: as many as may wait in a machine. Chosen, not
/// measured.
const MAX_WAITING: usize = 4096;

/// A machine's connections to the other processes.
#[derive(Debug, Default)]
pub(super) struct AdapterWiring {
    pub(super) name: String,
    /// Its channels from and to other processes.
    pub(super) incoming: Vec<Incoming>,
    pub(super) outgoing: Vec<ChannelId>,
    /// The index of the channel to the process that properties observe.
    pub(super) recorder: Option<usize>,
    pub(super) routes: BTreeMap<String, Route>,
    pub(super) events: Arc<BTreeMap<String, Fields>>,
    pub(super) leaf: Option<LeafConnection>,
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
    /// By number for [`Way::Response`], [`Way::Client`] and [`Way::Thread`]; otherwise, all of them receive it.
    pub(super) receivers: Vec<Option<usize>>,
    /// Whether a property is about it.
    pub(super) is_recorded: bool,
}

#[derive(Debug)]
pub(super) struct LeafConnection {
    pub(super) ports: BTreeMap<String, (PortDirection, DataKind)>,
    pub(super) requests: Domain,
    pub(super) replies: Domain,
    /// The index of the channel to the tree.
    pub(super) out: usize,
}

/// Passes messages between a machine and its channels. It always receives; what the machine sends waits in order until
/// its channel is free.
#[derive(Clone, Debug)]
pub(super) struct RosAdapter {
    /// The wiring is constant: in one run, adapters with the same name have the same wiring.
    wiring: Arc<AdapterWiring>,
    post: Post,
}

/// The state of an adapter.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
struct Post {
    outboxes: Vec<VecDeque<Envelope>>,
    /// The client that each service answers next, by the common part of the service's event names.
    serving: BTreeMap<String, usize>,
    /// Requests that came in the meantime.
    waiting: VecDeque<(String, usize, Datum)>,
    /// The tree's request that has not been answered yet.
    pending: Option<RequestNumber>,
    /// The answer to the tree's request, still without the values of ports.
    answer: Option<(String, RequestNumber)>,
}

impl RosAdapter {
    pub(super) fn new(wiring: Arc<AdapterWiring>) -> Self {
        let outboxes = vec![VecDeque::new(); wiring.outgoing.len()];
        Self { wiring, post: Post { outboxes, ..Post::default() } }
    }

    fn receive(&mut self, index: usize, envelope: &Envelope, machine: &mut Machine) -> Option<Event> {
        let wiring = Arc::clone(&self.wiring);
        let incoming = &wiring.incoming[index];
        let head = envelope.message.head()?;
        if incoming.from_tree {
            return Some(self.take_request(&wiring, head, envelope, machine));
        }
        let fields = wiring.events.get(head).into_iter().flatten();
        let values = envelope.message.fields().get(1..).unwrap_or_default();
        let values = fields.zip(values).map(|((name, kind), value)| (name.clone(), kind.datum(value)));
        let client = incoming.client.get(head).copied();
        // A goal arrives with the number of its client; a free thread with its own number.
        let number = client.filter(|_| head.starts_with("action_")).map(|client| {
            let name = if head.ends_with("_thread_free") { "thread_id" } else { "goal_id" };
            (name.to_owned(), (client as f64).into())
        });
        let data = nested(values.chain(number).collect());
        match (head.strip_prefix("srv_").and_then(|name| name.strip_suffix("_request")), client) {
            (Some(service), Some(client)) if self.post.serving.contains_key(service) => {
                self.post.waiting.push_back((service.to_owned(), client, data));
                None
            }
            (Some(service), Some(client)) => Some(self.serve(service, client, data)),
            _ => Some(Event::external(head).with_data(data)),
        }
    }

    fn serve(&mut self, service: &str, client: usize, data: Datum) -> Event {
        self.post.serving.insert(service.to_owned(), client);
        Event::external(format!("srv_{service}_request")).with_data(data)
    }

    /// Takes a tick or a halt from the tree, with the values of input ports.
    fn take_request(
        &mut self,
        wiring: &AdapterWiring,
        head: &str,
        envelope: &Envelope,
        machine: &mut Machine,
    ) -> Event {
        self.post.pending = Some(envelope.request);
        if let Some(leaf) = &wiring.leaf
            && let Some(shape) = leaf.requests.shape_of(&envelope.message)
        {
            for ((port, _), value) in shape.fields().iter().zip(envelope.message.fields()).skip(1) {
                let Some((_, kind)) = leaf.ports.get(port) else { continue };
                let datum = match value {
                    Value::Text(text) if *kind != DataKind::Text => kind.parse(text),
                    Value::Symbol(_) => None,
                    value => Some(kind.datum(value)),
                };
                datum.into_iter().for_each(|datum| machine.put(&input_datum(port), datum));
            }
        }
        Event::external(if head == "halt" { "bt_halt" } else { "bt_tick" })
    }

    fn message(&self, event: &str, data: &Datum) -> Result<Message, Undelivered> {
        let mut values = vec![Value::symbol(event)];
        for (field, kind) in self.wiring.events.get(event).into_iter().flatten() {
            values.push(match data.member(field) {
                None => kind.default(),
                Some(datum) => kind.value(datum).ok_or_else(|| {
                    Undelivered::Unfit(format!("the field {field} of {event} is {}", kind.unfit(datum)))
                })?,
            });
        }
        Ok(Message::new(values))
    }
}

impl Adapter for RosAdapter {
    /// Transitions are numbered by channel: incoming ones first, then outgoing ones.
    fn offers(&self, offers: &mut Vec<Offer>) {
        for (index, incoming) in self.wiring.incoming.iter().enumerate() {
            let action = Action::Receive(incoming.channel, Pattern::Any);
            offers.push(Offer { transition: TransitionId(index as u32), action });
        }
        // A property sees a sent message first, before the message has any effect.
        let first = self.wiring.recorder.filter(|recorder| !self.post.outboxes[*recorder].is_empty());
        for (index, (out, waiting)) in self.wiring.outgoing.iter().zip(&self.post.outboxes).enumerate() {
            if let Some(envelope) = waiting.front().filter(|_| first.is_none_or(|first| first == index)) {
                let transition = TransitionId((self.wiring.incoming.len() + index) as u32);
                offers.push(Offer { transition, action: Action::Send(*out, envelope.clone()) });
            }
        }
    }

    fn take(&mut self, transition: TransitionId, received: Option<&Envelope>, machine: &mut Machine) -> Option<Event> {
        let index = transition.0 as usize;
        match index.checked_sub(self.wiring.incoming.len()) {
            Some(out) => {
                self.post.outboxes[out].pop_front();
                None
            }
            None => self.receive(index, received?, machine),
        }
    }

    /// The next request for a service that is free again.
    fn waiting(&mut self) -> Option<Event> {
        let serving = &self.post.serving;
        let next = self.post.waiting.iter().position(|(service, ..)| !serving.contains_key(service))?;
        let (service, client, data) = self.post.waiting.remove(next)?;
        Some(self.serve(&service, client, data))
    }

    fn send(&mut self, target: Option<&str>, event: &str, data: &Datum) -> Result<(), Undelivered> {
        if target == Some(TREE) {
            let request = self.post.pending.take();
            let request =
                request.ok_or_else(|| Undelivered::Late("the tree is not waiting for an answer".to_owned()))?;
            self.post.answer = Some((event.to_owned(), request));
            return Ok(());
        }
        let wiring = Arc::clone(&self.wiring);
        let Some(route) = wiring.routes.get(event) else { return Ok(()) };
        let message = self.message(event, data)?;
        let number = |name| match data.member(name) {
            Some(Datum::Number(number)) if *number >= 0.0 => Some(*number as usize),
            _ => None,
        };
        let receivers: Vec<Option<usize>> = match route.way {
            Way::Everyone | Way::Request | Way::Goal | Way::Server => route.receivers.clone(),
            Way::Response => {
                let service = event.strip_prefix("srv_").and_then(|name| name.strip_suffix("_response"));
                // With its response, the service is free for the next request.
                let client = service.and_then(|service| self.post.serving.remove(service));
                let client = client.ok_or_else(|| Undelivered::Late("no client waits for this response".to_owned()))?;
                vec![route.receivers.get(client).copied().flatten()]
            }
            Way::Client | Way::Thread => {
                let name = if route.way == Way::Client { "goal_id" } else { "thread_id" };
                let receiver = number(name).and_then(|number| route.receivers.get(number));
                let receiver = receiver.ok_or_else(|| Undelivered::Unfit(format!("there is no such `{name}`")))?;
                vec![*receiver]
            }
        };
        // The recorder's copy is added last, but delivered first: `offers` holds back all others until then.
        for out in receivers.into_iter().flatten().chain(wiring.recorder.filter(|_| route.is_recorded)) {
            if self.post.outboxes[out].len() >= MAX_WAITING {
                return Err(Undelivered::Unfit(format!("{MAX_WAITING} messages are already waiting")));
            }
            self.post.outboxes[out].push_back(Envelope { message: message.clone(), request: RequestNumber::default() });
        }
        Ok(())
    }

    /// Completes the answer to the tree with the values of output ports.
    fn complete(&mut self, machine: &mut Machine) {
        let Some((head, request)) = self.post.answer.take() else { return };
        let Some(leaf) = &self.wiring.leaf else { return };
        let Some(shape) = leaf.replies.shapes().first() else { return };
        let mut fields = vec![Value::symbol(&head)];
        for (port, kind) in shape.fields().iter().skip(1) {
            let datum = output_datum(port);
            let value = machine.datum(&datum).cloned().unwrap_or_default();
            fields.push(port_value(&value, kind));
            machine.put(&datum, Datum::Undefined);
        }
        self.post.outboxes[leaf.out].push_back(Envelope { message: Message::new(fields), request });
    }

    fn succeeding(&self) -> Box<dyn Adapter> {
        Box::new(Self::new(Arc::clone(&self.wiring)))
    }

    fn normalize(&mut self, form: &NormalForm<'_>) -> Result<(), NoNormalForm> {
        let name = &self.wiring.name;
        for (out, waiting) in self.wiring.outgoing.iter().zip(&mut self.post.outboxes) {
            form.queue(waiting.len(), || format!("more than {} messages from {name} are waiting", NormalForm::QUEUE))?;
            waiting.iter_mut().for_each(|envelope| form.envelope(*out, envelope));
        }
        form.queue(self.post.waiting.len(), || {
            format!("more than {} requests to {name} are waiting", NormalForm::QUEUE)
        })?;
        if let (Some(tree), Some(number)) =
            (self.wiring.incoming.iter().find(|incoming| incoming.from_tree), &mut self.post.pending)
        {
            form.number(tree.channel, number);
        }
        Ok(())
    }

    fn uses(&self, _: &Machine) -> Vec<Use> {
        let receives = self.wiring.incoming.iter().map(|incoming| Use::Receives(incoming.channel, None));
        receives.chain(self.wiring.outgoing.iter().map(|out| Use::Sends(*out, None))).collect()
    }
}

impl PartialEq for RosAdapter {
    fn eq(&self, other: &Self) -> bool {
        self.wiring.name == other.wiring.name && self.post == other.post
    }
}

impl Eq for RosAdapter {}

impl Hash for RosAdapter {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.wiring.name.hash(state);
        self.post.hash(state);
    }
}

fn port_value(datum: &Datum, kind: &FieldKind) -> Value {
    let FieldKind::Optional(kind) = kind else { return Value::symbol(FieldKind::NONE) };
    let value = match (&**kind, datum) {
        (FieldKind::Text, Datum::Undefined) => None,
        (FieldKind::Text, Datum::Text(text)) => Some(Value::Text(Arc::clone(text))),
        (FieldKind::Text, other) => Some(Value::Text(other.to_json().into())),
        (FieldKind::Bool, datum) => DataKind::Bool.value(datum),
        (FieldKind::Int, datum) => DataKind::Int.value(datum),
        (FieldKind::Real, datum) => DataKind::Real.value(datum),
        _ => None,
    };
    value.unwrap_or_else(|| Value::symbol(FieldKind::NONE))
}
