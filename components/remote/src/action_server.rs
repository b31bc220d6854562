//! The server of an action of ROS 2. It pursues one goal at a time: a newer goal replaces the current one, as in Nav2's
//! servers.

use std::collections::VecDeque;
use std::time::Duration;

use ros_messages::standard::{CancelRequest, CancelResponse, GoalInfo, GoalResponse, GoalStatus, GoalStatuses, Uuid};
use ros_messages::{CdrReader, RosType};

use crate::action::{
    self, CANCEL_ACCEPTED, CANCEL_GOAL, CANCEL_TERMINATED, CANCEL_UNKNOWN, GET_RESULT, SEND_GOAL, STATUS_ABORTED,
    STATUS_CANCELED, STATUS_CANCELING, STATUS_EXECUTING, STATUS_SUCCEEDED, STATUS_UNKNOWN,
};
use crate::message::{GoalId, NodeMessage, ServiceRequest};

/// The most goals that the server remembers; beyond that, it forgets the oldest, which have ended.
const MOST_GOALS: usize = 100;

/// The most requests that wait for the result of one goal, and the most goals that wait to be accepted.
const MOST_WAITING: usize = 1000;

/// An action server, with the goals that it has received and their states.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct ActionServer {
    /// The action's name, such as `/navigate_to_pose`.
    name: String,
    /// The goals that are neither accepted nor rejected yet, each with the number of its request.
    offered: VecDeque<(GoalId, u64)>,
    /// The accepted goals, oldest first. All but the last have ended.
    goals: VecDeque<Goal>,
    /// The responses and messages that have not been taken yet.
    outbox: Vec<NodeMessage>,
}

/// An accepted goal.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Goal {
    id: GoalId,
    since: Duration,
    status: i8,
    /// The response with its result, once it has ended.
    result: Vec<u8>,
    /// The numbers of the requests that wait for the result.
    waiting: Vec<u64>,
}

/// What a request demands of a server.
#[derive(Clone, Debug, PartialEq)]
pub enum Demand<G> {
    /// To pursue a goal. The caller must [accept](ActionServer::accept) or [reject](ActionServer::reject) it.
    Pursue(GoalId, G),
    /// To cancel the current goal.
    Cancel,
}

/// How a goal ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// It was reached.
    Succeeded,
    /// It was canceled.
    Canceled,
    /// It was not reached.
    Aborted,
    /// It was given up: it counts as canceled if a client had requested that, and as aborted otherwise.
    GivenUp,
}

impl ActionServer {
    /// A server of the action with this name, such as `/navigate_to_pose`.
    #[must_use]
    pub fn new(name: String) -> Self {
        let mut server = Self { name, offered: VecDeque::new(), goals: VecDeque::new(), outbox: Vec::new() };
        server.publish_status();
        server
    }

    /// The responses and messages since the last call, in order.
    pub fn take_outbox(&mut self) -> Vec<NodeMessage> {
        std::mem::take(&mut self.outbox)
    }

    /// The current goal.
    #[must_use]
    pub fn pursued(&self) -> Option<GoalId> {
        self.goals.back().filter(|goal| goal.status < STATUS_SUCCEEDED).map(|goal| goal.id)
    }

    /// Handles a request, if it is one to this action. `read` reads a goal, and returns `None` if the server cannot
    /// pursue it. `unknown` makes the response, with this status, to a request for the result of an unknown goal.
    pub fn receive<G>(
        &mut self,
        request: &ServiceRequest,
        read: impl FnOnce(&mut CdrReader<'_>) -> Option<G>,
        unknown: impl FnOnce(i8) -> Vec<u8>,
    ) -> Option<Demand<G>> {
        let part = request.service.strip_prefix(&action::service(&self.name, ""))?;
        match part {
            SEND_GOAL => self.take_goal(request, read),
            CANCEL_GOAL => self.cancel(request).then_some(Demand::Cancel),
            GET_RESULT => {
                self.request_result(request, unknown);
                None
            }
            _ => None,
        }
    }

    fn take_goal<G>(
        &mut self,
        request: &ServiceRequest,
        read: impl FnOnce(&mut CdrReader<'_>) -> Option<G>,
    ) -> Option<Demand<G>> {
        let mut reader = CdrReader::new(&request.body).ok();
        let id = reader.as_mut().and_then(|reader| GoalId::read(reader).ok());
        let is_new = |id: &GoalId| {
            let mut known = self.offered.iter().map(|(id, _)| id).chain(self.goals.iter().map(|goal| &goal.id));
            known.all(|known| known != id)
        };
        let is_full = self.offered.len() == MOST_WAITING;
        let goal = id.filter(is_new).filter(|_| !is_full).zip(reader.and_then(|mut reader| read(&mut reader)));
        let Some((id, goal)) = goal else {
            self.decide(request.number, Duration::ZERO, false);
            return None;
        };
        self.offered.push_back((id, request.number));
        Some(Demand::Pursue(id, goal))
    }

    /// Accepts a goal, which is the current one from `now` on. The goal before it is given up: `replaced` makes its
    /// result, with this status.
    pub fn accept(&mut self, id: GoalId, now: Duration, replaced: impl FnOnce(i8) -> Vec<u8>) {
        let Some(number) = self.take_offered(id) else { return };
        self.decide(number, now, true);
        self.end(Ending::GivenUp, replaced);
        if self.goals.len() == MOST_GOALS {
            self.goals.pop_front();
        }
        let (result, waiting) = (Vec::new(), Vec::new());
        self.goals.push_back(Goal { id, since: now, status: STATUS_EXECUTING, result, waiting });
        self.publish_status();
    }

    /// Rejects a goal.
    pub fn reject(&mut self, id: GoalId) {
        if let Some(number) = self.take_offered(id) {
            self.decide(number, Duration::ZERO, false);
        }
    }

    fn take_offered(&mut self, id: GoalId) -> Option<u64> {
        let place = self.offered.iter().position(|(of, _)| *of == id)?;
        self.offered.remove(place).map(|(_, number)| number)
    }

    fn decide(&mut self, number: u64, now: Duration, is_accepted: bool) {
        self.respond(number, &GoalResponse { accepted: is_accepted, stamp: now.into() });
    }

    /// Handles a cancel request. Returns whether it cancels the current goal.
    fn cancel(&mut self, request: &ServiceRequest) -> bool {
        let Ok(CancelRequest { goal_info }) = CancelRequest::decode(&request.body) else {
            self.respond(request.number, &CancelResponse { return_code: CANCEL_UNKNOWN, ..Default::default() });
            return false;
        };
        let (id, until) = (goal_info.goal_id.uuid, Duration::from(goal_info.stamp));
        // An id means this goal; a time, all goals accepted until then as well; neither, all goals.
        let is_alone = id != [0; 16] && until.is_zero();
        let is_meant = |goal: &Goal| goal.id == id || !is_alone && (until.is_zero() || goal.since <= until);
        let known = self.goals.iter().any(|goal| goal.id == id);
        let canceled = self.goals.back_mut().filter(|goal| goal.status == STATUS_EXECUTING && is_meant(goal));
        let canceled = canceled.map(|goal| {
            goal.status = STATUS_CANCELING;
            goal.info()
        });
        let return_code = match canceled {
            None if is_alone && known => CANCEL_TERMINATED,
            None if is_alone => CANCEL_UNKNOWN,
            _ => CANCEL_ACCEPTED,
        };
        let is_canceled = canceled.is_some();
        let goals_canceling = canceled.into_iter().collect();
        self.respond(request.number, &CancelResponse { return_code, goals_canceling });
        if is_canceled {
            self.publish_status();
        }
        is_canceled
    }

    fn request_result(&mut self, request: &ServiceRequest, unknown: impl FnOnce(i8) -> Vec<u8>) {
        let id = GoalId::decode(&request.body);
        let goal = self.goals.iter_mut().find(|goal| id == Ok(goal.id));
        let body = match goal {
            Some(goal) if goal.status < STATUS_SUCCEEDED => {
                if goal.waiting.len() < MOST_WAITING {
                    goal.waiting.push(request.number);
                }
                return;
            }
            Some(goal) => goal.result.clone(),
            None => unknown(STATUS_UNKNOWN),
        };
        self.outbox.push(NodeMessage::Response { number: request.number, body });
    }

    /// Publishes feedback on the current goal, if there is one. `message` makes it for the goal's id.
    pub fn publish_feedback(&mut self, message: impl FnOnce(GoalId) -> Vec<u8>) {
        if let Some(id) = self.pursued() {
            self.outbox.push(NodeMessage::Message { topic: action::feedback(&self.name), body: message(id) });
        }
    }

    /// Ends the current goal, if there is one. `result` makes the response with its result, with this status.
    pub fn end(&mut self, how: Ending, result: impl FnOnce(i8) -> Vec<u8>) {
        let Some(goal) = self.goals.back_mut().filter(|goal| goal.status < STATUS_SUCCEEDED) else { return };
        goal.status = match how {
            Ending::Succeeded => STATUS_SUCCEEDED,
            Ending::GivenUp if goal.status == STATUS_CANCELING => STATUS_CANCELED,
            Ending::Canceled => STATUS_CANCELED,
            Ending::Aborted | Ending::GivenUp => STATUS_ABORTED,
        };
        goal.result = result(goal.status);
        let responses = std::mem::take(&mut goal.waiting).into_iter();
        let responses = responses.map(|number| NodeMessage::Response { number, body: goal.result.clone() });
        self.outbox.extend(responses);
        self.publish_status();
    }

    /// Forgets all goals, as a restarted server does.
    pub fn restart(&mut self) {
        self.goals.clear();
        self.offered.clear();
        self.publish_status();
    }

    fn publish_status(&mut self) {
        let status = |goal: &Goal| GoalStatus { goal_info: goal.info(), status: goal.status };
        let body = GoalStatuses { status_list: self.goals.iter().map(status).collect() }.encode();
        self.outbox.push(NodeMessage::Message { topic: action::status(&self.name), body });
    }

    fn respond(&mut self, number: u64, response: &impl RosType) {
        self.outbox.push(NodeMessage::Response { number, body: response.encode() });
    }
}

impl Goal {
    fn info(&self) -> GoalInfo {
        GoalInfo { goal_id: Uuid { uuid: self.id }, stamp: self.since.into() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECOND: Duration = Duration::from_secs(1);

    /// A request about a goal, with more bytes after its id.
    fn request(part: &str, id: u8, more: &[u8]) -> ServiceRequest {
        let body = [&[0, 1, 0, 0][..], &[id; 16], more].concat();
        ServiceRequest { service: format!("/go/_action/{part}"), kind: String::new(), number: id.into(), body }
    }

    /// What the server has sent since the last call: responses by number, and messages by the last part of their
    /// topics, each without the encapsulation header.
    fn sent(server: &mut ActionServer) -> Vec<(String, Vec<u8>)> {
        let sent = server.take_outbox().into_iter().map(|message| match message {
            NodeMessage::Response { number, body } => (format!("to {number}"), body[4..].to_vec()),
            NodeMessage::Message { topic, body } => {
                (topic.rsplit('/').next().unwrap_or_default().to_owned(), body[4..].to_vec())
            }
        });
        sent.collect()
    }

    fn server() -> ActionServer {
        let mut server = ActionServer::new("/go".to_owned());
        assert_eq!(sent(&mut server), [("status".to_owned(), vec![0; 4])]);
        server
    }

    fn result(status: i8, number: u8) -> Vec<u8> {
        vec![0, 1, 0, 0, status as u8, number]
    }

    /// Sends a request. A goal is a number, and accepted unless it is 0.
    fn receive(server: &mut ActionServer, request: &ServiceRequest, now: Duration) -> Option<Demand<u8>> {
        let read = |reader: &mut CdrReader<'_>| reader.number().ok().map(u8::from_le_bytes).filter(|goal| *goal > 0);
        let demand = server.receive(request, read, |status| result(status, 9));
        if let Some(Demand::Pursue(id, _)) = &demand {
            server.accept(*id, now, |status| result(status, 8));
        }
        demand
    }

    /// The status of each goal that the server keeps.
    fn statuses(server: &mut ActionServer) -> Vec<i8> {
        let sent = sent(server);
        let (_, last) = sent.iter().rev().find(|(name, _)| name == "status").expect("a status");
        last[4..].chunks(28).map(|goal| goal[24] as i8).collect()
    }

    #[test]
    fn a_goal_is_pursued_until_it_ends_and_then_its_result_is_returned() {
        let mut server = server();
        assert_eq!(receive(&mut server, &request(SEND_GOAL, 1, &[7]), SECOND), Some(Demand::Pursue([1; 16], 7)));
        let answers = sent(&mut server);
        assert_eq!(answers[0], ("to 1".to_owned(), vec![1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0]));
        assert_eq!((answers[1].0.as_str(), answers[1].1[28]), ("status", STATUS_EXECUTING as u8));
        for _ in 0..2 {
            assert_eq!(receive(&mut server, &request(GET_RESULT, 1, &[]), SECOND), None);
        }
        server.publish_feedback(|id| [&[0, 1, 0, 0], &id[..], &[5]].concat());
        assert_eq!(sent(&mut server), [("feedback".to_owned(), [&[1; 16][..], &[5]].concat())]);
        server.end(Ending::Succeeded, |status| result(status, 3));
        let response = ("to 1".to_owned(), vec![STATUS_SUCCEEDED as u8, 3]);
        assert_eq!(sent(&mut server)[..2], [response.clone(), response.clone()]);
        // A later request for the result returns it as well. One for another goal does not.
        receive(&mut server, &request(GET_RESULT, 1, &[]), SECOND);
        receive(&mut server, &request(GET_RESULT, 2, &[]), SECOND);
        assert_eq!(sent(&mut server), [response, ("to 2".to_owned(), vec![STATUS_UNKNOWN as u8, 9])]);
        server.publish_feedback(|_| Vec::new());
        server.end(Ending::Aborted, |_| Vec::new());
        assert!(server.take_outbox().is_empty());
    }

    #[test]
    fn a_newer_goal_ends_an_older_one_and_a_bad_one_does_not() {
        let mut server = server();
        receive(&mut server, &request(SEND_GOAL, 1, &[7]), SECOND);
        for bad in [request(SEND_GOAL, 2, &[0]), request(SEND_GOAL, 1, &[7]), request(SEND_GOAL, 2, &[])] {
            server.take_outbox();
            assert_eq!(receive(&mut server, &bad, SECOND), None);
            assert_eq!(sent(&mut server), [(format!("to {}", bad.number), vec![0; 12])]);
        }
        assert_eq!(receive(&mut server, &request(SEND_GOAL, 2, &[8]), SECOND), Some(Demand::Pursue([2; 16], 8)));
        assert_eq!(statuses(&mut server), [STATUS_ABORTED, STATUS_EXECUTING]);
        receive(&mut server, &request(CANCEL_GOAL, 2, &[0; 8]), SECOND);
        receive(&mut server, &request(SEND_GOAL, 3, &[8]), SECOND);
        assert_eq!(statuses(&mut server), [STATUS_ABORTED, STATUS_CANCELED, STATUS_EXECUTING]);
        for id in 4..=200 {
            receive(&mut server, &request(SEND_GOAL, id, &[8]), SECOND);
        }
        assert_eq!(statuses(&mut server).len(), MOST_GOALS);
        server.restart();
        assert!(statuses(&mut server).is_empty());
    }

    #[test]
    fn a_goal_may_be_rejected_later_and_is_not_pursued_before_it_is_accepted() {
        let mut server = server();
        let read = |_: &mut CdrReader<'_>| Some(());
        let offer = |server: &mut ActionServer, id| {
            server.receive(&request(SEND_GOAL, id, &[]), read, |status| result(status, 9));
            (sent(server), server.pursued())
        };
        assert_eq!((offer(&mut server, 1), offer(&mut server, 2)), ((vec![], None), (vec![], None)));
        server.reject([1; 16]);
        server.reject([1; 16]);
        assert_eq!(sent(&mut server), [("to 1".to_owned(), vec![0; 12])]);
        server.accept([2; 16], SECOND, |status| result(status, 8));
        assert_eq!((server.pursued(), statuses(&mut server)), (Some([2; 16]), vec![STATUS_EXECUTING]));
        // A goal that waits to be accepted does not end the current one, and cannot be sent again.
        offer(&mut server, 3);
        assert_eq!(server.pursued(), Some([2; 16]));
        assert_eq!(offer(&mut server, 3).0, [("to 3".to_owned(), vec![0; 12])]);
        receive(&mut server, &request(CANCEL_GOAL, 2, &[0; 8]), SECOND);
        server.end(Ending::Aborted, |status| result(status, 0));
        assert_eq!(statuses(&mut server), [STATUS_ABORTED]);
    }

    #[test]
    fn a_goal_is_canceled_by_its_id_by_its_time_or_with_all() {
        let (exactly, at_1_s, at_3_s) = ([0; 8], [1, 0, 0, 0, 0, 0, 0, 0], [3, 0, 0, 0, 0, 0, 0, 0]);
        for (id, until, code, is_canceled) in [
            (2, exactly, CANCEL_ACCEPTED, true),
            (1, exactly, CANCEL_TERMINATED, false),
            (9, exactly, CANCEL_UNKNOWN, false),
            (0, exactly, CANCEL_ACCEPTED, true),
            (0, at_1_s, CANCEL_ACCEPTED, false),
            (0, at_3_s, CANCEL_ACCEPTED, true),
            (2, at_1_s, CANCEL_ACCEPTED, true),
            (1, at_1_s, CANCEL_ACCEPTED, false),
        ] {
            let mut server = server();
            receive(&mut server, &request(SEND_GOAL, 1, &[7]), SECOND);
            receive(&mut server, &request(SEND_GOAL, 2, &[7]), 2 * SECOND);
            server.take_outbox();
            let demand = receive(&mut server, &request(CANCEL_GOAL, id, &until), 4 * SECOND);
            let sent = sent(&mut server);
            let replied = (sent[0].1[0] as i8, sent[0].1[4], demand == Some(Demand::Cancel));
            assert_eq!(replied, (code, u8::from(is_canceled), is_canceled), "{id} {until:?}");
            assert_eq!(sent.len(), 1 + usize::from(is_canceled));
        }
    }

    #[test]
    fn messages_that_are_cut_off_are_answered_and_have_no_effect() {
        for part in [SEND_GOAL, CANCEL_GOAL, GET_RESULT] {
            let mut server = server();
            receive(&mut server, &request(SEND_GOAL, 1, &[7]), SECOND);
            server.take_outbox();
            let whole = request(part, 5, &[0; 8]);
            for length in 0..20 {
                let cut = ServiceRequest { body: whole.body[..length].to_vec(), ..whole.clone() };
                assert_eq!(receive(&mut server, &cut, SECOND), None);
                assert_eq!(server.take_outbox().len(), 1, "{part} {length}");
            }
        }
        assert_eq!(
            receive(&mut server(), &ServiceRequest { service: "/go/other".to_owned(), ..request("", 1, &[]) }, SECOND),
            None
        );
    }
}
