//! A component that is elsewhere, as a process of a channel system.

use std::hash::{Hash, Hasher};
use std::sync::Arc;
use std::time::Duration;

use channels::{ChannelId, Envelope, NoNormalForm, NormalForm, Offer, Process, ProcessId, Topology, TransitionId, Use};
use interfaces::{ABORTED, ACCEPTED, CANCEL, CANCELED, ERROR, FEEDBACK, GOAL, OK, REASON, REJECTED, SUCCEEDED};
use ros_messages::{CdrReader, CdrWriter, Mismatch};
use skills::{ChannelAdapter, Datum, Mishap, Undelivered};

use crate::action::{
    self, CANCEL_ACCEPTED, CANCEL_GOAL, CANCEL_KIND, CANCEL_REJECTED, CANCEL_TERMINATED, GET_RESULT, SEND_GOAL,
    STATUS_ABORTED, STATUS_CANCELED, STATUS_SUCCEEDED,
};
use crate::component::{RemoteComponent, RemoteOperation};
use crate::convert;
use crate::message::{Call, FromNode, Lost};

/// The bytes before the fields of a message: how it is encoded.
const ENCODING: usize = 4;

/// Why nothing was answered.
const NOBODY: &str = "nobody offers it";

/// The most mishaps of different kinds.
const MOST_MISHAPS: usize = 100;

/// A component that consists of nodes of ROS 2, in a channel system.
#[derive(Clone, Debug)]
pub struct RemoteProcess {
    component: Arc<RemoteComponent>,
    adapter: ChannelAdapter,
    /// What tells the goals of this run from those of others, and what tells those of this process from each other.
    run: u64,
    last_number: u64,
    calls: Vec<Call>,
    /// What has come and has not been heard yet.
    heard: Vec<FromNode>,
    open: Vec<Conversation>,
    mishaps: Vec<Mishap>,
}

/// Somebody who waits for an answer from outside.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Conversation {
    /// The number of the call whose response comes next.
    number: u64,
    /// None if it does not wait any more.
    client: Option<Arc<str>>,
    /// Its index among the operations of this kind.
    operation: usize,
    of: Asked,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Asked {
    Service,
    /// A goal: its id, whether it has been accepted, and whether it is to be canceled.
    Goal {
        id: [u8; 16],
        is_accepted: bool,
        is_to_end: bool,
    },
    /// That the goal with this id is canceled.
    Cancel {
        id: [u8; 16],
    },
}

impl RemoteProcess {
    /// The process of a topology that is this component. Nothing of it is known before it has [begun](Self::begin).
    #[must_use]
    pub fn new(topology: &Topology, process: ProcessId, component: Arc<RemoteComponent>) -> Self {
        Self {
            component,
            adapter: ChannelAdapter::new(topology, process).abandoning(),
            run: 0,
            // No two processes give the same numbers.
            last_number: (process.index() as u64) << 32,
            calls: Vec::new(),
            heard: Vec::new(),
            open: Vec::new(),
            mishaps: Vec::new(),
        }
    }

    /// From here on, its goals belong to this run: servers remember the goals of earlier ones.
    pub fn begin(&mut self, run: u64) {
        self.run = run;
    }

    /// What is to be sent, in order.
    pub fn take_calls(&mut self) -> Vec<Call> {
        std::mem::take(&mut self.calls)
    }

    /// What was left out, or could not be done, and why. It is not part of the process's state.
    #[must_use]
    pub fn mishaps(&self) -> &[Mishap] {
        &self.mishaps
    }

    /// Takes what has come from outside, if it is for this component. It has an effect when the process next
    /// [acts](Self::act): until then, a newer message on a topic replaces an older one.
    pub fn hear(&mut self, answer: &FromNode) {
        match answer {
            FromNode::Response { number, .. } if number >> 32 != self.last_number >> 32 => {}
            FromNode::Message { topic, .. } if !self.component.topics().any(|(name, _)| name == *topic) => {}
            _ => answer.clone().wait_in(&mut self.heard),
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

    /// Whether everything that has come has been passed on.
    #[must_use]
    pub fn has_passed_on_all(&self) -> bool {
        self.heard.is_empty() && self.adapter.has_sent_all()
    }

    fn note(&mut self, message: String) {
        let has_room = self.mishaps.len() < MOST_MISHAPS;
        match self.mishaps.iter_mut().find(|mishap| mishap.message == message) {
            Some(mishap) => mishap.times += 1,
            None if has_room => self.mishaps.push(Mishap { state: None, message, times: 1 }),
            None => {}
        }
    }

    /// Tells its clients what has come. Returns whether anything had.
    pub fn act(&mut self) -> bool {
        let heard = std::mem::take(&mut self.heard);
        let has_come = !heard.is_empty();
        for answer in heard {
            match answer {
                FromNode::Response { number, body } => self.respond(number, &body),
                FromNode::Message { topic, body } => self.publish(&topic, &body),
            }
        }
        has_come
    }

    /// Crashes and restarts it: it forgets its requests, and what has come. The nodes go on.
    pub fn restart(&mut self) {
        self.adapter = self.adapter.succeeding();
        self.open.clear();
        self.calls.clear();
        self.heard.clear();
    }

    /// A response has come; without a body, nobody can respond.
    fn respond(&mut self, number: u64, body: &[u8]) {
        // Nobody waits for a second response.
        let Some(place) = self.open.iter().position(|open| open.number == number) else { return };
        let open = self.open.remove(place);
        match open.of {
            Asked::Service if body.is_empty() => self.fail(&open.client, ERROR, NOBODY),
            Asked::Service => {
                let operation = &self.component.services[open.operation];
                match convert::outcome(&operation.wire.parts[1], &operation.fields[1], body) {
                    Ok(Ok(data)) => self.tell(&open.client, OK, &data, ERROR),
                    Ok(Err(why)) => self.fail(&open.client, ERROR, &why),
                    Err(why) => self.fail(&open.client, ERROR, &format!("the response cannot be read: {why}")),
                }
            }
            Asked::Goal { id, is_accepted: false, is_to_end } => self.begin_goal(open, id, is_to_end, body),
            Asked::Goal { .. } => self.end_goal(&open, body),
            Asked::Cancel { id } => self.end_cancel(&open, id, body),
        }
    }

    /// A server has said whether it cancels a goal. One that has been started again does not know it.
    fn end_cancel(&mut self, open: &Conversation, id: [u8; 16], body: &[u8]) {
        let code = CdrReader::new(body).and_then(|mut reader| reader.number()).map(i8::from_le_bytes);
        let is_goal = |goal: &Conversation| matches!(goal.of, Asked::Goal { id: of, .. } if of == id);
        let Some(place) = self.open.iter().position(is_goal) else { return };
        match code {
            // It will end, or has ended: its result says how.
            Ok(CANCEL_ACCEPTED | CANCEL_TERMINATED) => {}
            Ok(CANCEL_REJECTED) => {
                if let Asked::Goal { is_to_end, .. } = &mut self.open[place].of {
                    *is_to_end = false;
                }
                self.note(format!("{} is not canceled: the server refused", self.name_of(open)));
            }
            _ => {
                let goal = self.open.remove(place);
                let why = if body.is_empty() { NOBODY } else { "the server does not know the goal" };
                self.fail(&goal.client, &format!("{}.{ABORTED}", self.component.actions[goal.operation].name), why);
            }
        }
    }

    /// The full name of the action of a goal.
    fn name_of(&self, open: &Conversation) -> String {
        self.component.full_name(&self.component.actions[open.operation])
    }

    /// The response to a goal has come: it is accepted, or not.
    fn begin_goal(&mut self, open: Conversation, id: [u8; 16], is_to_end: bool, body: &[u8]) {
        let action = self.component.actions[open.operation].name.clone();
        match CdrReader::new(body).and_then(|mut reader| reader.number()) {
            Ok([1]) => {}
            Ok([0]) => return self.fail(&open.client, &format!("{action}.{REJECTED}"), "the server rejected the goal"),
            _ => {
                let why = if body.is_empty() { NOBODY } else { "the response cannot be read" };
                return self.fail(&open.client, &format!("{action}.{REJECTED}"), why);
            }
        }
        let failed = format!("{action}.{REJECTED}");
        self.tell(&open.client, &format!("{action}.{ACCEPTED}"), &convert::nothing(), &failed);
        if is_to_end {
            self.cancel(&open, id);
        }
        let kind = format!("{}_GetResult", self.component.actions[open.operation].wire.kind);
        let number = self.call(action::service(&self.name_of(&open), GET_RESULT), kind, with_id(id, &[]));
        self.open.push(Conversation { number, of: Asked::Goal { id, is_accepted: true, is_to_end }, ..open });
    }

    /// The result of a goal has come.
    fn end_goal(&mut self, open: &Conversation, body: &[u8]) {
        let operation = &self.component.actions[open.operation];
        let action = operation.name.clone();
        let status = CdrReader::new(body).and_then(|mut reader| reader.number()).map(i8::from_le_bytes);
        let aborted = format!("{action}.{ABORTED}");
        match status {
            Ok(STATUS_SUCCEEDED) => match convert::data(&operation.wire.parts[2], &operation.fields[2], body) {
                Ok(data) => self.tell(&open.client, &format!("{action}.{SUCCEEDED}"), &data, &aborted),
                Err(why) => self.fail(&open.client, &aborted, &format!("the result cannot be read: {why}")),
            },
            Ok(STATUS_CANCELED) => {
                self.tell(&open.client, &format!("{action}.{CANCELED}"), &convert::nothing(), &aborted)
            }
            Ok(STATUS_ABORTED) => self.fail(&open.client, &aborted, "the server aborted the goal"),
            Ok(_) => self.fail(&open.client, &aborted, "the server does not know the goal"),
            Err(_) if body.is_empty() => self.fail(&open.client, &aborted, NOBODY),
            Err(_) => self.fail(&open.client, &aborted, "the result cannot be read"),
        }
    }

    fn publish(&mut self, topic: &str, body: &[u8]) {
        let component = Arc::clone(&self.component);
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
            matches!(&open.of, Asked::Goal { id, is_accepted: true, .. } if id == own)
                && action::feedback(&self.name_of(open)) == topic
        });
        let Some(Conversation { client, operation, .. }) = open.cloned() else { return };
        let operation = &component.actions[operation];
        match convert::data(&operation.wire.parts[1], &operation.fields[1], body) {
            Ok(data) => self.send(client.as_deref(), &format!("{}.{FEEDBACK}", operation.name), &data),
            Err(why) => self.note(format!("feedback on {topic} is left out: {why}")),
        }
    }

    /// Sends a request out. Returns the number of the call.
    fn call(&mut self, service: String, kind: String, body: Vec<u8>) -> u64 {
        self.last_number += 1;
        self.calls.push(Call { service, kind, number: self.last_number, body });
        self.last_number
    }

    fn cancel(&mut self, goal: &Conversation, id: [u8; 16]) {
        // No time: this goal alone.
        let body = with_id(id, &[0; 8]);
        let number = self.call(action::service(&self.name_of(goal), CANCEL_GOAL), CANCEL_KIND.to_owned(), body);
        self.open.push(Conversation { number, client: None, operation: goal.operation, of: Asked::Cancel { id } });
    }

    /// A client asks for something. What it asked of the same operation before, it has abandoned.
    fn ask(&mut self, client: &Arc<str>, head: &str, data: &Datum) {
        let component = Arc::clone(&self.component);
        if let Some(operation) = component.services.iter().position(|service| service.name == head) {
            let service = &component.services[operation];
            let own = |open: &Conversation| open.of == Asked::Service && open.is_of(client, operation);
            self.open.iter_mut().filter(|open| own(open)).for_each(|open| open.client = None);
            let message = convert::message(&service.wire.parts[0], &service.fields[0], data);
            return match message.and_then(|message| service.wire.parts[0].layout.encode(&message)) {
                Ok(body) => {
                    let number = self.call(component.full_name(service), service.wire.kind.clone(), body);
                    self.open.push(Conversation {
                        number,
                        client: Some(client.clone()),
                        operation,
                        of: Asked::Service,
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
                let id = goal_id(self.run, self.last_number + 1);
                let message = convert::message(&action.wire.parts[0], &action.fields[0], data);
                match message.and_then(|goal| action.wire.parts[0].layout.encode(&convert::identified(goal, id))) {
                    Ok(body) => {
                        let service = action::service(&component.full_name(action), SEND_GOAL);
                        let number = self.call(service, format!("{}_SendGoal", action.wire.kind), body);
                        let of = Asked::Goal { id, is_accepted: false, is_to_end: false };
                        self.open.push(Conversation { number, client: Some(client.clone()), operation, of });
                    }
                    Err(why) => self.fail(&Some(client.clone()), &format!("{name}.{REJECTED}"), &unsendable(why)),
                }
            }
            CANCEL => self.cancel_of(client, operation, false),
            _ => {}
        }
    }

    /// Cancels a client's goal, which it may have abandoned. A server that has not accepted it yet may not know it.
    fn cancel_of(&mut self, client: &Arc<str>, operation: usize, is_abandoned: bool) {
        let is_goal = |open: &&mut Conversation| matches!(open.of, Asked::Goal { .. }) && open.is_of(client, operation);
        let Some(goal) = self.open.iter_mut().find(is_goal) else { return };
        if is_abandoned {
            goal.client = None;
        }
        let Asked::Goal { id, is_accepted, is_to_end } = &mut goal.of else { return };
        let is_new = !std::mem::replace(is_to_end, true);
        if *is_accepted && is_new {
            let (id, goal) = (*id, goal.clone());
            self.cancel(&goal, id);
        }
    }

    /// Cancels all goals, at the end of a run.
    pub fn conclude(&mut self) {
        let goals: Vec<Conversation> = self.open.clone();
        for goal in goals {
            if let Asked::Goal { id, is_accepted: true, is_to_end: false } = goal.of {
                self.cancel(&goal, id);
            }
        }
    }

    /// Answers a client; if it cannot be told that, `failed` says why.
    fn tell(&mut self, client: &Option<Arc<str>>, head: &str, data: &Datum, failed: &str) {
        let Some(to) = client else { return };
        if let Err(Undelivered::Unfit(why)) = self.adapter.send(Some(to), head, data) {
            self.fail(client, failed, &format!("the answer does not fit: {why}"));
        }
    }

    fn fail(&mut self, client: &Option<Arc<str>>, head: &str, why: &str) {
        let data = Datum::object([(REASON, Datum::text(why))]).unwrap_or_default();
        self.send(client.as_deref(), head, &data);
    }

    fn send(&mut self, client: Option<&str>, head: &str, data: &Datum) {
        let Some(client) = client else { return };
        if let Err(Undelivered::Unfit(why)) = self.adapter.send(Some(client), head, data) {
            self.note(format!("<{head}> is left out: {why}"));
        }
    }
}

impl Conversation {
    fn is_of(&self, client: &Arc<str>, operation: usize) -> bool {
        self.operation == operation && self.client.as_ref() == Some(client)
    }
}

/// What does not fit a channel, the same for each message.
fn without_values(why: &Undelivered) -> String {
    let words = why.to_string();
    words.split(", and ").next().unwrap_or_default().to_owned()
}

fn unsendable(why: Mismatch) -> String {
    format!("it cannot be sent: {why}")
}

/// The id of a goal.
fn goal_id(run: u64, number: u64) -> [u8; 16] {
    let mut id = [0; 16];
    id[..8].copy_from_slice(&run.to_le_bytes());
    id[8..].copy_from_slice(&number.to_le_bytes());
    id
}

/// A message that consists of a goal's id and these bytes.
fn with_id(id: [u8; 16], rest: &[u8]) -> Vec<u8> {
    let mut body = CdrWriter::reusing(Vec::new());
    id.iter().chain(rest).for_each(|byte| body.number([*byte]));
    body.bytes()
}

impl PartialEq for RemoteProcess {
    fn eq(&self, other: &Self) -> bool {
        (&self.component, &self.adapter, self.last_number, &self.calls, &self.heard, &self.open)
            == (&other.component, &other.adapter, other.last_number, &other.calls, &other.heard, &other.open)
    }
}

impl Eq for RemoteProcess {}

impl Hash for RemoteProcess {
    fn hash<H: Hasher>(&self, state: &mut H) {
        (&self.adapter, self.last_number, &self.calls, &self.heard, &self.open).hash(state);
    }
}

impl Process for RemoteProcess {
    fn offers(&self, offers: &mut Vec<Offer>) {
        self.adapter.offers(offers);
    }

    fn take(&mut self, transition: TransitionId, received: Option<Envelope>, _: Duration) {
        let Some(event) = self.adapter.take(transition, received.as_ref()) else { return };
        if let Some(client) = &event.origin {
            self.ask(client, &event.name, &event.data);
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

    /// Whether it is to answer anything.
    fn location(&self) -> String {
        if self.open.is_empty() { "idle" } else { "asked" }.to_owned()
    }
}
