//! A component that consists of nodes of ROS 2, as a process of a channel system.

use std::sync::Arc;
use std::time::Duration;

use channels::{
    ChannelId, Envelope, NoNormalForm, NormalForm, Offer, Process, ProcessId, Shared, Topology, TransitionId,
    Unobserved, Use,
};
use interfaces::{ABORTED, ACCEPTED, CANCEL, CANCELED, ERROR, FEEDBACK, GOAL, OK, REASON, REJECTED, SUCCEEDED};
use ros_messages::standard::{CancelRequest, GoalInfo, Time, Uuid};
use ros_messages::{Mismatch, RosType as _};
use skills::{Adapter as _, ChannelAdapter, Datum, Mishap, Undelivered};

use crate::action::{
    self, CANCEL_ACCEPTED, CANCEL_GOAL, CANCEL_KIND, CANCEL_REJECTED, CANCEL_TERMINATED, GET_RESULT, SEND_GOAL,
    STATUS_ABORTED, STATUS_CANCELED, STATUS_SUCCEEDED,
};
use crate::component::{RemoteComponent, RemoteOperation};
use crate::convert;
use crate::message::{Lost, NodeMessage, ServiceRequest};

/// The length of the encapsulation header, which precedes the fields of a message.
const ENCODING: usize = 4;

/// The reason for a failure if there is no server.
const NO_SERVER: &str = "nobody offers it";

/// The most different mishaps.
const MOST_MISHAPS: usize = 100;

/// A component that consists of nodes of ROS 2, in a channel system.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct RemoteProcess {
    component: Shared<RemoteComponent>,
    adapter: ChannelAdapter,
    /// Distinguishes the goals of this run from those of others.
    run: Unobserved<u64>,
    /// The number of the last request, which also distinguishes the goals of this process.
    last_number: u64,
    /// The requests that have not been taken yet.
    requests: Vec<ServiceRequest>,
    /// The responses and messages that have not been passed on yet.
    inbox: Vec<NodeMessage>,
    /// The requests without a response.
    open: Vec<PendingRequest>,
    mishaps: Unobserved<Vec<Mishap>>,
}

/// A request to a node, for a client of this component.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct PendingRequest {
    /// The number of the service request whose response is awaited.
    number: u64,
    /// The process that waits for the reply; `None` if it no longer does.
    client: Option<Arc<str>>,
    /// The index of the operation among those of this kind.
    operation: usize,
    of: PendingKind,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum PendingKind {
    Service,
    Goal {
        id: [u8; 16],
        /// Whether the server has accepted it.
        is_accepted: bool,
        /// Whether it is to be canceled.
        is_to_end: bool,
    },
    /// To cancel the goal with this id.
    Cancel {
        id: [u8; 16],
    },
}

impl RemoteProcess {
    /// The process of this component in a topology. It is to [begin](Self::begin) before its first step.
    #[must_use]
    pub fn new(topology: &Topology, process: ProcessId, component: Arc<RemoteComponent>) -> Self {
        Self {
            component: component.into(),
            adapter: ChannelAdapter::new(topology, process).abandoning(),
            run: Unobserved::default(),
            // No two processes use the same numbers.
            last_number: (process.index() as u64) << 32,
            requests: Vec::new(),
            inbox: Vec::new(),
            open: Vec::new(),
            mishaps: Unobserved::default(),
        }
    }

    /// Begins a run, whose number becomes part of the ids of its goals: servers remember the goals of earlier runs.
    pub fn begin(&mut self, run: u64) {
        *self.run = run;
    }

    /// The requests to send, in order.
    pub fn take_requests(&mut self) -> Vec<ServiceRequest> {
        std::mem::take(&mut self.requests)
    }

    /// What was left out or failed, and why. This is not part of the process's state.
    #[must_use]
    pub fn mishaps(&self) -> &[Mishap] {
        &self.mishaps
    }

    /// Queues a response or message, if it is for this component. It takes effect when the process next
    /// [acts](Self::act): until then, a newer message on a topic replaces an older one.
    pub fn receive(&mut self, message: &NodeMessage) {
        match message {
            NodeMessage::Response { number, .. } if number >> 32 != self.last_number >> 32 => {}
            NodeMessage::Message { topic, .. } if !self.component.topics().any(|(name, _)| name == *topic) => {}
            _ => message.clone().enqueue_in(&mut self.inbox),
        }
    }

    /// The channels on which messages may be missing after a loss.
    #[must_use]
    pub fn channels_of(&self, lost: &Lost) -> Vec<ChannelId> {
        match lost {
            Lost::Topic(name) => self.component.head(name).map_or_else(Vec::new, |head| self.adapter.carriers(&head)),
            Lost::Response(number) => {
                let open = self.open.iter().filter(|open| open.number == *number);
                open.filter_map(|open| self.adapter.channel_to(open.client.as_deref()?)).collect()
            }
        }
    }

    /// Whether everything that was received has been passed on.
    #[must_use]
    pub fn has_passed_on_all(&self) -> bool {
        self.inbox.is_empty() && self.adapter.has_sent_all()
    }

    fn note(&mut self, message: String) {
        let has_room = self.mishaps.len() < MOST_MISHAPS;
        match self.mishaps.iter_mut().find(|mishap| mishap.message == message) {
            Some(mishap) => mishap.times += 1,
            None if has_room => self.mishaps.push(Mishap { state: None, message, times: 1 }),
            None => {}
        }
    }

    /// Passes on to its clients what was received. Returns whether there was anything.
    pub fn act(&mut self) -> bool {
        let inbox = std::mem::take(&mut self.inbox);
        let has_come = !inbox.is_empty();
        for message in inbox {
            match message {
                NodeMessage::Response { number, body } => self.receive_response(number, &body),
                NodeMessage::Message { topic, body } => self.receive_message(&topic, &body),
            }
        }
        has_come
    }

    /// Crashes and restarts the component: it forgets its requests and what it has received. The nodes go on.
    pub fn restart(&mut self) {
        self.adapter = self.adapter.succeeding();
        self.open.clear();
        self.requests.clear();
        self.inbox.clear();
    }

    /// Handles a response. An empty body means that no server can respond.
    fn receive_response(&mut self, number: u64, body: &[u8]) {
        // No request waits for a second response.
        let Some(place) = self.open.iter().position(|open| open.number == number) else { return };
        let open = self.open.remove(place);
        match open.of {
            PendingKind::Service if body.is_empty() => self.fail(&open.client, ERROR, NO_SERVER),
            PendingKind::Service => {
                let operation = &self.component.services[open.operation];
                match convert::outcome(&operation.wire.parts[1], &operation.fields[1], body) {
                    Ok(Ok(data)) => self.reply(&open.client, OK, &data, ERROR),
                    Ok(Err(why)) => self.fail(&open.client, ERROR, &why),
                    Err(why) => self.fail(&open.client, ERROR, &format!("the response cannot be read: {why}")),
                }
            }
            PendingKind::Goal { id, is_accepted: false, is_to_end } => self.begin_goal(open, id, is_to_end, body),
            PendingKind::Goal { .. } => self.end_goal(&open, body),
            PendingKind::Cancel { id } => self.end_cancel(&open, id, body),
        }
    }

    /// Handles the response to a cancel request. A restarted server does not know the goal.
    fn end_cancel(&mut self, open: &PendingRequest, id: [u8; 16], body: &[u8]) {
        let is_goal = |goal: &PendingRequest| matches!(goal.of, PendingKind::Goal { id: of, .. } if of == id);
        let Some(place) = self.open.iter().position(is_goal) else { return };
        match i8::decode(body) {
            // It ends, or has ended: the response with its result contains how.
            Ok(CANCEL_ACCEPTED | CANCEL_TERMINATED) => {}
            Ok(CANCEL_REJECTED) => {
                if let PendingKind::Goal { is_to_end, .. } = &mut self.open[place].of {
                    *is_to_end = false;
                }
                self.note(format!("{} is not canceled: the server refused", self.name_of(open)));
            }
            _ => {
                let goal = self.open.remove(place);
                let why = if body.is_empty() { NO_SERVER } else { "the server does not know the goal" };
                self.fail(&goal.client, &format!("{}.{ABORTED}", self.component.actions[goal.operation].name), why);
            }
        }
    }

    /// The full name of the action of a goal.
    fn name_of(&self, open: &PendingRequest) -> String {
        self.component.full_name(&self.component.actions[open.operation])
    }

    /// Handles the response to a goal: the server has accepted or rejected it.
    fn begin_goal(&mut self, open: PendingRequest, id: [u8; 16], is_to_end: bool, body: &[u8]) {
        let action = self.component.actions[open.operation].name.clone();
        match bool::decode(body) {
            Ok(true) => {}
            Ok(false) => {
                return self.fail(&open.client, &format!("{action}.{REJECTED}"), "the server rejected the goal");
            }
            Err(_) => {
                let why = if body.is_empty() { NO_SERVER } else { "the response cannot be read" };
                return self.fail(&open.client, &format!("{action}.{REJECTED}"), why);
            }
        }
        let failed = format!("{action}.{REJECTED}");
        self.reply(&open.client, &format!("{action}.{ACCEPTED}"), &convert::nothing(), &failed);
        if is_to_end {
            self.cancel(&open, id);
        }
        let kind = format!("{}_GetResult", self.component.actions[open.operation].wire.kind);
        let number = self.send_request(action::service(&self.name_of(&open), GET_RESULT), kind, id.encode());
        self.open.push(PendingRequest { number, of: PendingKind::Goal { id, is_accepted: true, is_to_end }, ..open });
    }

    /// Handles the result of a goal.
    fn end_goal(&mut self, open: &PendingRequest, body: &[u8]) {
        let operation = &self.component.actions[open.operation];
        let action = operation.name.clone();
        let aborted = format!("{action}.{ABORTED}");
        match i8::decode(body) {
            Ok(STATUS_SUCCEEDED) => match convert::data(&operation.wire.parts[2], &operation.fields[2], body) {
                Ok(data) => self.reply(&open.client, &format!("{action}.{SUCCEEDED}"), &data, &aborted),
                Err(why) => self.fail(&open.client, &aborted, &format!("the result cannot be read: {why}")),
            },
            Ok(STATUS_CANCELED) => {
                self.reply(&open.client, &format!("{action}.{CANCELED}"), &convert::nothing(), &aborted)
            }
            Ok(STATUS_ABORTED) => self.fail(&open.client, &aborted, "the server aborted the goal"),
            Ok(_) => self.fail(&open.client, &aborted, "the server does not know the goal"),
            Err(_) if body.is_empty() => self.fail(&open.client, &aborted, NO_SERVER),
            Err(_) => self.fail(&open.client, &aborted, "the result cannot be read"),
        }
    }

    fn receive_message(&mut self, topic: &str, body: &[u8]) {
        let component = Shared::clone(&self.component);
        let is = |operation: &&RemoteOperation| component.full_name(operation) == topic;
        if let Some(operation) = component.topics.iter().find(is) {
            match convert::data(&operation.wire.parts[0], &operation.fields[0], body) {
                Ok(data) => {
                    if let Err(why) = self.adapter.send(None, &operation.name, &data) {
                        self.note(format!("a message on {topic} is left out: {}", without_values(&why)));
                    }
                }
                Err(why) => self.note(format!("a message on {topic} is left out: {why}")),
            }
            return;
        }
        // Feedback begins with the id of its goal.
        let Some(own) = body.get(ENCODING..ENCODING + 16) else { return };
        let open = self.open.iter().find(|open| {
            matches!(&open.of, PendingKind::Goal { id, is_accepted: true, .. } if id == own)
                && action::feedback(&self.name_of(open)) == topic
        });
        let Some(PendingRequest { client, operation, .. }) = open.cloned() else { return };
        let operation = &component.actions[operation];
        match convert::data(&operation.wire.parts[1], &operation.fields[1], body) {
            Ok(data) => self.send(client.as_deref(), &format!("{}.{FEEDBACK}", operation.name), &data),
            Err(why) => self.note(format!("feedback on {topic} is left out: {why}")),
        }
    }

    /// Adds a request to those to send. Returns its number.
    fn send_request(&mut self, service: String, kind: String, body: Vec<u8>) -> u64 {
        self.last_number += 1;
        self.requests.push(ServiceRequest { service, kind, number: self.last_number, body });
        self.last_number
    }

    fn cancel(&mut self, goal: &PendingRequest, id: [u8; 16]) {
        // Without a time, the request means this goal alone.
        let goal_info = GoalInfo { goal_id: Uuid { uuid: id }, stamp: Time::default() };
        let body = CancelRequest { goal_info }.encode();
        let number = self.send_request(action::service(&self.name_of(goal), CANCEL_GOAL), CANCEL_KIND.to_owned(), body);
        self.open.push(PendingRequest {
            number,
            client: None,
            operation: goal.operation,
            of: PendingKind::Cancel { id },
        });
    }

    /// Forwards a client's request to the nodes. The client has abandoned its earlier request to the same operation.
    fn forward(&mut self, client: &Arc<str>, head: &str, data: &Datum) {
        let component = Shared::clone(&self.component);
        if let Some(operation) = component.services.iter().position(|service| service.name == head) {
            let service = &component.services[operation];
            let own = |open: &PendingRequest| open.of == PendingKind::Service && open.is_of(client, operation);
            self.open.iter_mut().filter(|open| own(open)).for_each(|open| open.client = None);
            let message = convert::message(&service.wire.parts[0], &service.fields[0], data);
            return match message.and_then(|message| service.wire.parts[0].layout.encode(&message)) {
                Ok(body) => {
                    let number = self.send_request(component.full_name(service), service.wire.kind.clone(), body);
                    self.open.push(PendingRequest {
                        number,
                        client: Some(client.clone()),
                        operation,
                        of: PendingKind::Service,
                    });
                }
                Err(why) => self.fail(&Some(client.clone()), ERROR, &unsendable(why)),
            };
        }
        let Some((name, part)) = head.rsplit_once('.') else { return };
        let Some(operation) = component.actions.iter().position(|action| action.name == name) else { return };
        match part {
            GOAL => {
                self.cancel_of(client, operation, true);
                let action = &component.actions[operation];
                let id = goal_id(*self.run, self.last_number + 1);
                let message = convert::message(&action.wire.parts[0], &action.fields[0], data);
                match message.and_then(|goal| action.wire.parts[0].layout.encode(&convert::identified(goal, id))) {
                    Ok(body) => {
                        let service = action::service(&component.full_name(action), SEND_GOAL);
                        let number = self.send_request(service, format!("{}_SendGoal", action.wire.kind), body);
                        let of = PendingKind::Goal { id, is_accepted: false, is_to_end: false };
                        self.open.push(PendingRequest { number, client: Some(client.clone()), operation, of });
                    }
                    Err(why) => self.fail(&Some(client.clone()), &format!("{name}.{REJECTED}"), &unsendable(why)),
                }
            }
            CANCEL => self.cancel_of(client, operation, false),
            _ => {}
        }
    }

    /// Cancels a client's goal, which it may have abandoned: at once if the server has accepted it, and otherwise when
    /// it does, since it may not know the goal yet.
    fn cancel_of(&mut self, client: &Arc<str>, operation: usize, is_abandoned: bool) {
        let is_goal =
            |open: &&mut PendingRequest| matches!(open.of, PendingKind::Goal { .. }) && open.is_of(client, operation);
        let Some(goal) = self.open.iter_mut().find(is_goal) else { return };
        if is_abandoned {
            goal.client = None;
        }
        let PendingKind::Goal { id, is_accepted, is_to_end } = &mut goal.of else { return };
        let is_new = !std::mem::replace(is_to_end, true);
        if *is_accepted && is_new {
            let (id, goal) = (*id, goal.clone());
            self.cancel(&goal, id);
        }
    }

    /// Cancels all goals, at the end of a run.
    pub fn conclude(&mut self) {
        let goals: Vec<PendingRequest> = self.open.clone();
        for goal in goals {
            if let PendingKind::Goal { id, is_accepted: true, is_to_end: false } = goal.of {
                self.cancel(&goal, id);
            }
        }
    }

    /// Replies to a client. If the reply does not fit, it is `failed`, with the reason.
    fn reply(&mut self, client: &Option<Arc<str>>, head: &str, data: &Datum, failed: &str) {
        let Some(to) = client else { return };
        match self.adapter.send(Some(to), head, data) {
            Ok(()) | Err(Undelivered::Late(_)) => {}
            Err(why) => self.fail(client, failed, &format!("the answer does not fit: {why}")),
        }
    }

    fn fail(&mut self, client: &Option<Arc<str>>, head: &str, why: &str) {
        let data = Datum::object([(REASON, Datum::text(why))]).unwrap_or_default();
        self.send(client.as_deref(), head, &data);
    }

    fn send(&mut self, client: Option<&str>, head: &str, data: &Datum) {
        let Some(client) = client else { return };
        match self.adapter.send(Some(client), head, data) {
            Ok(()) | Err(Undelivered::Late(_)) => {}
            Err(why) => self.note(format!("<{head}> is left out: {why}")),
        }
    }
}

impl PendingRequest {
    fn is_of(&self, client: &Arc<str>, operation: usize) -> bool {
        self.operation == operation && self.client.as_ref() == Some(client)
    }
}

/// The reason why a message does not fit a channel, without the message's values: it is the same for each message.
fn without_values(why: &Undelivered) -> String {
    match why {
        Undelivered::Value { refusal, .. } => refusal.clone(),
        why => why.to_string(),
    }
}

fn unsendable(why: Mismatch) -> String {
    format!("it cannot be sent: {why}")
}

fn goal_id(run: u64, number: u64) -> [u8; 16] {
    let mut id = [0; 16];
    id[..8].copy_from_slice(&run.to_le_bytes());
    id[8..].copy_from_slice(&number.to_le_bytes());
    id
}

impl Process for RemoteProcess {
    fn offers(&self, offers: &mut Vec<Offer>) {
        self.adapter.offers(offers);
    }

    fn take(&mut self, transition: TransitionId, received: Option<Envelope>, _: Duration) {
        let Some(event) = self.adapter.take(transition, received.as_ref()) else { return };
        if let Some(client) = &event.origin {
            self.forward(client, &event.name, &event.data);
        }
    }

    fn uses(&self) -> Vec<Use> {
        self.adapter.receives().chain(self.adapter.sends()).collect()
    }

    fn normalize(&mut self, _: &NormalForm<'_>) -> Result<(), NoNormalForm> {
        Err(NoNormalForm::Unsupported {
            reason: "it consists of nodes of ROS 2, whose states are unknown".to_owned(),
            help: Some("replace it with a machine for the proof: an SCXML file with the same interface".to_owned()),
        })
    }

    /// Whether any request is without a response.
    fn location(&self) -> String {
        if self.open.is_empty() { "idle" } else { "asked" }.to_owned()
    }
}
