//! Nodes of ROS 2 that are clients of components, as a process of a channel system: the counterpart of a remote
//! component.

use std::sync::Arc;
use std::time::Duration;

use channels::{
    ChannelId, Envelope, NoNormalForm, NormalForm, Offer, Process, ProcessId, RequestNumber, Shared, Topology,
    TransitionId, Unobserved, Use,
};
use interfaces::{
    ABORTED, ACCEPTED, CANCEL, CANCELED, FEEDBACK, Field, GOAL, OK, REASON, REJECTED, SUCCEEDED, WirePart,
};
use skills::{Adapter as _, ChannelAdapter, Datum, Undelivered};

use crate::action_server::{ActionServer, Demand, Ending};
use crate::component::{RemoteComponent, RemoteOperation};
use crate::convert;
use crate::message::{GoalId, NodeMessage, ServiceRequest};

/// The most requests that wait for a reply. Beyond that, the oldest get none.
const MOST_OPEN: usize = 4096;

/// The most different notes.
const MOST_NOTES: usize = 100;

/// A component that is offered to nodes of ROS 2: its process, and its names and types there.
pub type Offered = (String, RemoteComponent);

/// The nodes of ROS 2 as one process of a channel system. It sends their requests to components, and receives the
/// components' replies and all of their topics.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct RemoteClients {
    offered: Shared<[Offered]>,
    adapter: ChannelAdapter,
    /// The servers of all components' actions, in order, each with the indices of its component and its action.
    servers: Vec<(usize, usize, ActionServer)>,
    /// The requests without a reply, oldest first.
    open: Vec<OpenRequest>,
    /// The responses and messages that have not been taken yet, except those of the servers.
    outbox: Vec<NodeMessage>,
    /// What was left out, without repetitions.
    notes: Unobserved<Vec<String>>,
    /// The number of notes that have been taken.
    notes_taken: Unobserved<usize>,
}

/// A request to which a component has not replied.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct OpenRequest {
    request: RequestNumber,
    component: usize,
    operation: usize,
    of: RequestKind,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum RequestKind {
    /// To a service, with the number of the node's request.
    Service(u64),
    /// To an action.
    Goal(GoalId),
}

impl OpenRequest {
    /// Whether this is a goal of the same action, sent earlier.
    fn is_goal_before(&self, other: &Self) -> bool {
        let of_one = (self.component, self.operation) == (other.component, other.operation);
        of_one && matches!(self.of, RequestKind::Goal(_)) && self.request < other.request
    }
}

impl RemoteClients {
    /// The process of a topology that sends requests to these components. It has channels to and from all of them.
    #[must_use]
    pub fn new(topology: &Topology, process: ProcessId, offered: Arc<[Offered]>) -> Self {
        let servers = offered.iter().enumerate().flat_map(|(place, (_, component))| {
            let server = move |(of, action)| (place, of, ActionServer::new(component.full_name(action)));
            component.actions.iter().enumerate().map(server)
        });
        Self {
            servers: servers.collect(),
            adapter: ChannelAdapter::new(topology, process).patient(),
            offered: offered.into(),
            open: Vec::new(),
            outbox: Vec::new(),
            notes: Unobserved::default(),
            notes_taken: Unobserved::default(),
        }
    }

    /// The components' responses and messages since the last call, in order.
    pub fn take_outbox(&mut self) -> Vec<NodeMessage> {
        let mut outbox = std::mem::take(&mut self.outbox);
        outbox.extend(self.servers.iter_mut().flat_map(|(.., server)| server.take_outbox()));
        outbox
    }

    /// What has been left out since the last call, and why, without repetitions.
    pub fn take_notes(&mut self) -> Vec<String> {
        let new = self.notes[*self.notes_taken..].to_vec();
        *self.notes_taken = self.notes.len();
        new
    }

    /// Passes a node's request on to its component.
    pub fn receive(&mut self, request: &ServiceRequest) {
        let offered = Shared::clone(&self.offered);
        for (place, (name, component)) in offered.iter().enumerate() {
            let is_it = |service: &RemoteOperation| component.full_name(service) == request.service;
            if let Some(operation) = component.services.iter().position(is_it) {
                return self.request_service(place, name, operation, &component.services[operation], request);
            }
        }
        for server in 0..self.servers.len() {
            let (place, operation, _) = self.servers[server];
            let (name, component) = &offered[place];
            self.request_action(server, name, &component.actions[operation], request);
        }
    }

    /// Gives up all goals, at the end of a run.
    pub fn conclude(&mut self) {
        for (component, operation, server) in &mut self.servers {
            let action = &self.offered[*component].1.actions[*operation];
            server.end(Ending::GivenUp, |status| result(action, status, None).0);
        }
    }

    fn request_service(
        &mut self,
        component: usize,
        name: &str,
        operation: usize,
        service: &RemoteOperation,
        request: &ServiceRequest,
    ) {
        let sent = convert::data(&service.wire.parts[0], &service.fields[0], &request.body)
            .map_err(|why| format!("such requests cannot be read: {why}"))
            .and_then(|data| self.send(name, &service.name, &data));
        match sent {
            Ok(()) => self.expect(component, operation, RequestKind::Service(request.number)),
            Err(why) => self.refuse(service, &request.service, request.number, &why),
        }
    }

    fn send(&mut self, component: &str, head: &str, data: &Datum) -> Result<(), String> {
        self.adapter.send(Some(component), head, data).map_err(|why: Undelivered| why.to_string())
    }

    /// Waits for the reply to the request that was sent last.
    fn expect(&mut self, component: usize, operation: usize, of: RequestKind) {
        if self.open.len() == MOST_OPEN {
            self.open.remove(0);
        }
        self.open.push(OpenRequest { request: self.adapter.last_request(), component, operation, of });
    }

    /// Responds that a request has failed, if a response of its type can express that.
    fn refuse(&mut self, service: &RemoteOperation, full_name: &str, number: u64, why: &str) {
        match convert::refusal(&service.wire.parts[1], why) {
            Some(body) => self.outbox.push(NodeMessage::Response { number, body }),
            None => {
                let kind = &service.wire.kind;
                self.note(format!(
                    "a request to {full_name} failed, and is not answered: a {kind} cannot express that"
                ));
            }
        }
    }

    fn request_action(&mut self, server: usize, name: &str, action: &RemoteOperation, request: &ServiceRequest) {
        let (component, operation, of) = &mut self.servers[server];
        let (component, operation) = (*component, *operation);
        let read = || convert::data(&action.wire.parts[0], &action.fields[0], &request.body).ok();
        let demand = of.receive(request, |_| read(), |status| result(action, status, None).0);
        let pursued = of.pursued();
        let (goal, cancel) = (format!("{}.{GOAL}", action.name), format!("{}.{CANCEL}", action.name));
        // The goal that was sent last is canceled: earlier ones have been already.
        let newest = self.open.iter().rev().find_map(|open| match open.of {
            RequestKind::Goal(id) if (open.component, open.operation) == (component, operation) => Some(id),
            _ => None,
        });
        let cancels = match demand {
            Some(Demand::Pursue(..)) => newest.is_some(),
            Some(Demand::Cancel) => newest.is_some() && newest == pursued,
            None => false,
        };
        if cancels && let Err(why) = self.send(name, &cancel, &convert::nothing()) {
            self.note(format!("a goal of {} is not canceled: {why}", self.offered[component].1.full_name(action)));
        }
        if let Some(Demand::Pursue(id, data)) = demand {
            match self.send(name, &goal, &data) {
                Ok(()) => self.expect(component, operation, RequestKind::Goal(id)),
                Err(why) => {
                    self.servers[server].2.reject(id);
                    self.note(format!("a goal of {} is rejected: {why}", self.offered[component].1.full_name(action)));
                }
            }
        }
    }

    /// Passes on a component's reply to a request, or its message on a topic.
    fn pass_on(&mut self, component: usize, head: &str, data: &Datum, request: RequestNumber, now: Duration) {
        let offered = Shared::clone(&self.offered);
        let of = &offered[component].1;
        if let Some(topic) = of.topics.iter().find(|topic| topic.name == head) {
            return self.publish(of, topic, data);
        }
        let is_open = |open: &OpenRequest| open.request == request && open.component == component;
        let Some(place) = self.open.iter().position(is_open) else { return };
        let open = self.open[place].clone();
        match open.of {
            RequestKind::Service(number) => {
                self.open.remove(place);
                self.respond(of, &of.services[open.operation], number, head, data);
            }
            RequestKind::Goal(id) => {
                let part = head.rsplit_once('.').map_or(head, |(_, part)| part);
                if matches!(part, REJECTED | SUCCEEDED | ABORTED | CANCELED) {
                    self.open.remove(place);
                }
                self.update_goal(&open, of, id, part, data, now);
            }
        }
    }

    fn publish(&mut self, of: &RemoteComponent, topic: &RemoteOperation, data: &Datum) {
        let (name, part) = (of.full_name(topic), &topic.wire.parts[0]);
        let message = convert::message(part, &topic.fields[0], data);
        match message.and_then(|message| part.layout.encode(&message)) {
            Ok(body) => self.outbox.push(NodeMessage::Message { topic: name, body }),
            Err(why) => self.note(format!("a message on {name} is left out: {why}")),
        }
    }

    fn respond(&mut self, of: &RemoteComponent, service: &RemoteOperation, number: u64, head: &str, data: &Datum) {
        let why = match head {
            OK => match convert::response(&service.wire.parts[1], &service.fields[1], data) {
                Ok(body) => return self.outbox.push(NodeMessage::Response { number, body }),
                Err(why) => format!("its reply cannot be sent: {why}"),
            },
            _ => reason(data),
        };
        self.refuse(service, &of.full_name(service), number, &why);
    }

    /// Updates a goal, as its component reports.
    fn update_goal(
        &mut self,
        open: &OpenRequest,
        of: &RemoteComponent,
        id: GoalId,
        part: &str,
        data: &Datum,
        now: Duration,
    ) {
        let action = &of.actions[open.operation];
        let is_it = |(component, operation, _): &&mut (usize, usize, ActionServer)| {
            (*component, *operation) == (open.component, open.operation)
        };
        let (.., server) = self.servers.iter_mut().find(is_it).expect("each action has a server");
        let mut unfit = None;
        match part {
            ACCEPTED => {
                server.accept(id, now, |status| result(action, status, None).0);
                // Earlier goals have been given up. One that has not ended was lost.
                self.open.retain(|other| !other.is_goal_before(open));
            }
            REJECTED => server.reject(id),
            _ if server.pursued() != Some(id) => {}
            FEEDBACK => server.publish_feedback(|id| {
                let (body, why) = encoded(&action.wire.parts[1], &action.fields[1], Some(data), |message| {
                    convert::identified(message, id)
                });
                unfit = why;
                body
            }),
            _ => {
                let how = match part {
                    SUCCEEDED => Ending::Succeeded,
                    CANCELED => Ending::Canceled,
                    _ => Ending::Aborted,
                };
                server.end(how, |status| {
                    let (body, why) = result(action, status, Some(data).filter(|_| how == Ending::Succeeded));
                    unfit = why;
                    body
                });
            }
        }
        if let Some(why) = unfit {
            self.note(format!("fields of <{}.{part}> are left out: {why}", action.name));
        }
    }

    fn note(&mut self, what: String) {
        if self.notes.len() < MOST_NOTES && !self.notes.contains(&what) {
            self.notes.push(what);
        }
    }
}

/// A message with the fields of `data`. If these do not fit, the message is without them, and the second value is the
/// reason.
fn encoded(
    part: &WirePart,
    fields: &[Field],
    data: Option<&Datum>,
    complete: impl Fn(ros_messages::Value) -> ros_messages::Value,
) -> (Vec<u8>, Option<ros_messages::Mismatch>) {
    let encode = |message| part.layout.encode(&complete(message));
    let full = data.map(|data| convert::message(part, fields, data).and_then(encode));
    let (body, why) = match full {
        Some(Ok(body)) => return (body, None),
        Some(Err(why)) => (part.message(Vec::new()).and_then(encode), Some(why)),
        None => (part.message(Vec::new()).and_then(encode), None),
    };
    (body.expect("a message in which nothing has been set is one of its type"), why)
}

/// The response with a goal's result.
fn result(action: &RemoteOperation, status: i8, data: Option<&Datum>) -> (Vec<u8>, Option<ros_messages::Mismatch>) {
    encoded(&action.wire.parts[2], &action.fields[2], data, |message| convert::with_status(message, status))
}

/// Why something failed.
fn reason(data: &Datum) -> String {
    match data.member(REASON) {
        Some(Datum::Text(why)) => why.to_string(),
        _ => String::new(),
    }
}

impl Process for RemoteClients {
    fn offers(&self, offers: &mut Vec<Offer>) {
        self.adapter.offers(offers);
    }

    fn take(&mut self, transition: TransitionId, received: Option<Envelope>, now: Duration) {
        let Some(event) = self.adapter.take(transition, received.as_ref()) else { return };
        let (Some(from), Some(envelope)) = (&event.origin, &received) else { return };
        let component = self.offered.iter().position(|(name, _)| **name == **from);
        let head = envelope.message.head().unwrap_or_default();
        if let Some(component) = component {
            self.pass_on(component, head, &event.data, envelope.request, now);
        }
    }

    fn uses(&self) -> Vec<Use> {
        self.adapter.receives().chain(self.adapter.sends()).collect()
    }

    fn awaits(&self, requests: &mut Vec<(ChannelId, RequestNumber)>) {
        self.adapter.awaits(requests);
    }

    fn normalize(&mut self, _: &NormalForm<'_>) -> Result<(), NoNormalForm> {
        let reason = "it consists of nodes of ROS 2, whose states are unknown".to_owned();
        Err(NoNormalForm::Unsupported { reason, help: None })
    }

    /// Whether any request is without a reply.
    fn location(&self) -> String {
        if self.open.is_empty() { "idle" } else { "asks" }.to_owned()
    }
}
