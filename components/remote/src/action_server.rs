//! The server of an action of ROS 2 that pursues one goal at a time: a newer one takes the place of an older one, as in
//! Nav2's servers.

use std::collections::VecDeque;
use std::time::Duration;

use ros_messages::{CdrReader, CdrWriter, Mismatch};

use crate::action::{
    self, CANCEL_ACCEPTED, CANCEL_GOAL, CANCEL_TERMINATED, CANCEL_UNKNOWN, GET_RESULT, SEND_GOAL, STATUS_ABORTED,
    STATUS_CANCELED, STATUS_CANCELING, STATUS_EXECUTING, STATUS_SUCCEEDED, STATUS_UNKNOWN,
};
use crate::message::{Call, FromNode, GoalId};

/// The most goals that are remembered, the oldest of which have ended, and the most that wait for the result of one, or
/// to be accepted.
const MOST_GOALS: usize = 100;
const MOST_WAITING: usize = 1000;

/// An action server: the goals that it was sent, and what becomes of them.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct ActionServer {
    /// Its name, such as `/navigate_to_pose`.
    name: String,
    /// The goals that are neither accepted nor rejected, each with the call that sends it.
    offered: VecDeque<(GoalId, u64)>,
    /// Oldest first: only the last may not have ended.
    goals: VecDeque<Goal>,
    said: Vec<FromNode>,
}

/// A goal that was accepted.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Goal {
    id: GoalId,
    since: Duration,
    status: i8,
    /// The message that tells its result, once it has ended; and the calls that ask for it.
    result: Vec<u8>,
    waiting: Vec<u64>,
}

/// What a server is asked to do.
#[derive(Clone, Debug, PartialEq)]
pub enum Demand<G> {
    /// To pursue a goal: it is to be [accepted](ActionServer::accept) or [rejected](ActionServer::reject).
    Pursue(GoalId, G),
    /// To end the goal that it pursues.
    Cancel,
}

/// How a goal has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// It was reached.
    Succeeded,
    /// It was canceled.
    Canceled,
    /// It was not reached.
    Aborted,
    /// It was given up: canceled if somebody had asked for that, and aborted otherwise.
    GivenUp,
}

impl ActionServer {
    /// The action with this name, such as `/navigate_to_pose`.
    #[must_use]
    pub fn new(name: String) -> Self {
        let mut server = Self { name, offered: VecDeque::new(), goals: VecDeque::new(), said: Vec::new() };
        server.tell_status();
        server
    }

    /// What it has said since the last call, in order.
    pub fn take_said(&mut self) -> Vec<FromNode> {
        std::mem::take(&mut self.said)
    }

    /// The goal that it pursues.
    #[must_use]
    pub fn pursued(&self) -> Option<GoalId> {
        self.goals.back().filter(|goal| goal.status < STATUS_SUCCEEDED).map(|goal| goal.id)
    }

    /// Hears a request, if it is one of this action. `read` reads what a goal says, and returns none if it cannot be
    /// pursued; `unknown` is the result, with its status, of a goal that nobody has sent.
    pub fn hear<G>(
        &mut self,
        call: &Call,
        read: impl FnOnce(&mut CdrReader<'_>) -> Option<G>,
        unknown: impl FnOnce(i8) -> Vec<u8>,
    ) -> Option<Demand<G>> {
        let part = call.service.strip_prefix(&action::service(&self.name, ""))?;
        match part {
            SEND_GOAL => self.take_goal(call, read),
            CANCEL_GOAL => self.cancel(call).then_some(Demand::Cancel),
            GET_RESULT => {
                self.ask_for_result(call, unknown);
                None
            }
            _ => None,
        }
    }

    fn take_goal<G>(&mut self, call: &Call, read: impl FnOnce(&mut CdrReader<'_>) -> Option<G>) -> Option<Demand<G>> {
        let mut reader = CdrReader::new(&call.body).ok();
        let id = reader.as_mut().and_then(|reader| reader.take(16).ok()?.try_into().ok());
        let is_new = |id: &GoalId| {
            let mut known = self.offered.iter().map(|(id, _)| id).chain(self.goals.iter().map(|goal| &goal.id));
            known.all(|known| known != id)
        };
        let is_full = self.offered.len() == MOST_WAITING;
        let goal = id.filter(is_new).filter(|_| !is_full).zip(reader.and_then(|mut reader| read(&mut reader)));
        let Some((id, goal)) = goal else {
            self.decide(call.number, Duration::ZERO, false);
            return None;
        };
        self.offered.push_back((id, call.number));
        Some(Demand::Pursue(id, goal))
    }

    /// Accepts a goal that was sent, and pursues it from `now` on. The one before is given up: its result is
    /// `replaced`, with its status.
    pub fn accept(&mut self, id: GoalId, now: Duration, replaced: impl FnOnce(i8) -> Vec<u8>) {
        let Some(number) = self.take_offered(id) else { return };
        self.decide(number, now, true);
        self.end(Ending::GivenUp, replaced);
        if self.goals.len() == MOST_GOALS {
            self.goals.pop_front();
        }
        let (result, waiting) = (Vec::new(), Vec::new());
        self.goals.push_back(Goal { id, since: now, status: STATUS_EXECUTING, result, waiting });
        self.tell_status();
    }

    /// Rejects a goal that was sent.
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
        self.respond(number, |cdr| {
            cdr.number([u8::from(is_accepted)]);
            write_time(now, cdr);
        });
    }

    /// Returns whether the goal that is pursued is to be canceled.
    fn cancel(&mut self, call: &Call) -> bool {
        let read = || -> Result<_, Mismatch> {
            let mut reader = CdrReader::new(&call.body)?;
            let id: GoalId = reader.take(16)?.try_into().map_err(|_| Mismatch::Short)?;
            let (s, ns) = (i32::from_le_bytes(reader.number()?), u32::from_le_bytes(reader.number()?));
            Ok((id, Duration::new(u64::try_from(s).unwrap_or_default(), ns)))
        };
        let Ok((id, until)) = read() else {
            self.reply_to_cancel(call.number, CANCEL_UNKNOWN, &[]);
            return false;
        };
        // One goal; or, with a time, all until then as well; or, with neither, all.
        let is_alone = id != [0; 16] && until.is_zero();
        let is_meant = |goal: &Goal| goal.id == id || !is_alone && (until.is_zero() || goal.since <= until);
        let known = self.goals.iter().any(|goal| goal.id == id);
        let canceled = self.goals.back_mut().filter(|goal| goal.status == STATUS_EXECUTING && is_meant(goal));
        let canceled = canceled.map(|goal| {
            goal.status = STATUS_CANCELING;
            (goal.id, goal.since)
        });
        let code = match canceled {
            None if is_alone && known => CANCEL_TERMINATED,
            None if is_alone => CANCEL_UNKNOWN,
            _ => CANCEL_ACCEPTED,
        };
        self.reply_to_cancel(call.number, code, canceled.as_slice());
        if canceled.is_some() {
            self.tell_status();
        }
        canceled.is_some()
    }

    fn reply_to_cancel(&mut self, number: u64, code: i8, goals: &[(GoalId, Duration)]) {
        self.respond(number, |cdr| {
            cdr.number(code.to_le_bytes());
            cdr.length(goals.len());
            goals.iter().for_each(|(id, since)| write_goal_info(id, *since, cdr));
        });
    }

    fn ask_for_result(&mut self, call: &Call, unknown: impl FnOnce(i8) -> Vec<u8>) {
        let id = CdrReader::new(&call.body).and_then(|mut reader| reader.take(16));
        let goal = self.goals.iter_mut().find(|goal| id.as_ref().is_ok_and(|id| *id == goal.id));
        let body = match goal {
            Some(goal) if goal.status < STATUS_SUCCEEDED => {
                if goal.waiting.len() < MOST_WAITING {
                    goal.waiting.push(call.number);
                }
                return;
            }
            Some(goal) => goal.result.clone(),
            None => unknown(STATUS_UNKNOWN),
        };
        self.said.push(FromNode::Response { number: call.number, body });
    }

    /// Tells whoever has sent the goal that is pursued how it goes, with the message about this goal.
    pub fn feed_back(&mut self, message: impl FnOnce(GoalId) -> Vec<u8>) {
        if let Some(id) = self.pursued() {
            self.said.push(FromNode::Message { topic: action::feedback(&self.name), body: message(id) });
        }
    }

    /// Ends the goal that is pursued, if there is one, with this message of its result and its status.
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
        let responses = responses.map(|number| FromNode::Response { number, body: goal.result.clone() });
        self.said.extend(responses);
        self.tell_status();
    }

    /// Forgets all goals, as a server that was started again.
    pub fn restart(&mut self) {
        self.goals.clear();
        self.offered.clear();
        self.tell_status();
    }

    /// `action_msgs/msg/GoalStatusArray`
    fn tell_status(&mut self) {
        let body = written(|cdr| {
            cdr.length(self.goals.len());
            for goal in &self.goals {
                write_goal_info(&goal.id, goal.since, cdr);
                cdr.number(goal.status.to_le_bytes());
            }
        });
        self.said.push(FromNode::Message { topic: action::status(&self.name), body });
    }

    fn respond(&mut self, number: u64, write: impl FnOnce(&mut CdrWriter)) {
        self.said.push(FromNode::Response { number, body: written(write) });
    }
}

/// `action_msgs/msg/GoalInfo`
fn write_goal_info(id: &GoalId, since: Duration, cdr: &mut CdrWriter) {
    cdr.numbers(id.iter().map(|byte| [*byte]));
    write_time(since, cdr);
}

/// `builtin_interfaces/msg/Time`
fn write_time(time: Duration, cdr: &mut CdrWriter) {
    cdr.number(i32::try_from(time.as_secs()).unwrap_or(i32::MAX).to_le_bytes());
    cdr.number(time.subsec_nanos().to_le_bytes());
}

/// A whole message.
fn written(write: impl FnOnce(&mut CdrWriter)) -> Vec<u8> {
    let mut cdr = CdrWriter::reusing(Vec::new());
    write(&mut cdr);
    cdr.bytes()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECOND: Duration = Duration::from_secs(1);

    /// A request about a goal, with more after its id.
    fn request(part: &str, id: u8, more: &[u8]) -> Call {
        let body = [&[0, 1, 0, 0][..], &[id; 16], more].concat();
        Call { service: format!("/go/_action/{part}"), kind: String::new(), number: id.into(), body }
    }

    /// What has been said since the last call: responses, and messages on topics by the last part of their names, each
    /// after the encoding.
    fn said(server: &mut ActionServer) -> Vec<(String, Vec<u8>)> {
        let said = server.take_said().into_iter().map(|said| match said {
            FromNode::Response { number, body } => (format!("to {number}"), body[4..].to_vec()),
            FromNode::Message { topic, body } => {
                (topic.rsplit('/').next().unwrap_or_default().to_owned(), body[4..].to_vec())
            }
        });
        said.collect()
    }

    fn server() -> ActionServer {
        let mut server = ActionServer::new("/go".to_owned());
        assert_eq!(said(&mut server), [("status".to_owned(), vec![0; 4])]);
        server
    }

    fn result(status: i8, number: u8) -> Vec<u8> {
        vec![0, 1, 0, 0, status as u8, number]
    }

    /// Goals say a number, which must not be 0. They are accepted.
    fn hear(server: &mut ActionServer, request: &Call, now: Duration) -> Option<Demand<u8>> {
        let read = |reader: &mut CdrReader<'_>| reader.number().ok().map(u8::from_le_bytes).filter(|goal| *goal > 0);
        let demand = server.hear(request, read, |status| result(status, 9));
        if let Some(Demand::Pursue(id, _)) = &demand {
            server.accept(*id, now, |status| result(status, 8));
        }
        demand
    }

    /// The status of each goal that the server knows.
    fn statuses(server: &mut ActionServer) -> Vec<i8> {
        let said = said(server);
        let (_, last) = said.iter().rev().find(|(name, _)| name == "status").expect("a status");
        last[4..].chunks(28).map(|goal| goal[24] as i8).collect()
    }

    #[test]
    fn a_goal_is_pursued_until_it_ends_and_then_its_result_is_told() {
        let mut server = server();
        assert_eq!(hear(&mut server, &request(SEND_GOAL, 1, &[7]), SECOND), Some(Demand::Pursue([1; 16], 7)));
        let heard = said(&mut server);
        assert_eq!(heard[0], ("to 1".to_owned(), vec![1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0]));
        assert_eq!((heard[1].0.as_str(), heard[1].1[28]), ("status", STATUS_EXECUTING as u8));
        for _ in 0..2 {
            assert_eq!(hear(&mut server, &request(GET_RESULT, 1, &[]), SECOND), None);
        }
        server.feed_back(|id| [&[0, 1, 0, 0], &id[..], &[5]].concat());
        assert_eq!(said(&mut server), [("feedback".to_owned(), [&[1; 16][..], &[5]].concat())]);
        server.end(Ending::Succeeded, |status| result(status, 3));
        let told = ("to 1".to_owned(), vec![STATUS_SUCCEEDED as u8, 3]);
        assert_eq!(said(&mut server)[..2], [told.clone(), told.clone()]);
        // Who asks later hears it, too; who asks for another does not.
        hear(&mut server, &request(GET_RESULT, 1, &[]), SECOND);
        hear(&mut server, &request(GET_RESULT, 2, &[]), SECOND);
        assert_eq!(said(&mut server), [told, ("to 2".to_owned(), vec![STATUS_UNKNOWN as u8, 9])]);
        server.feed_back(|_| Vec::new());
        server.end(Ending::Aborted, |_| Vec::new());
        assert!(server.take_said().is_empty());
    }

    #[test]
    fn a_newer_goal_ends_an_older_one_and_a_bad_one_does_not() {
        let mut server = server();
        hear(&mut server, &request(SEND_GOAL, 1, &[7]), SECOND);
        for bad in [request(SEND_GOAL, 2, &[0]), request(SEND_GOAL, 1, &[7]), request(SEND_GOAL, 2, &[])] {
            server.take_said();
            assert_eq!(hear(&mut server, &bad, SECOND), None);
            assert_eq!(said(&mut server), [(format!("to {}", bad.number), vec![0; 12])]);
        }
        assert_eq!(hear(&mut server, &request(SEND_GOAL, 2, &[8]), SECOND), Some(Demand::Pursue([2; 16], 8)));
        assert_eq!(statuses(&mut server), [STATUS_ABORTED, STATUS_EXECUTING]);
        hear(&mut server, &request(CANCEL_GOAL, 2, &[0; 8]), SECOND);
        hear(&mut server, &request(SEND_GOAL, 3, &[8]), SECOND);
        assert_eq!(statuses(&mut server), [STATUS_ABORTED, STATUS_CANCELED, STATUS_EXECUTING]);
        for id in 4..=200 {
            hear(&mut server, &request(SEND_GOAL, id, &[8]), SECOND);
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
            server.hear(&request(SEND_GOAL, id, &[]), read, |status| result(status, 9));
            (said(server), server.pursued())
        };
        assert_eq!((offer(&mut server, 1), offer(&mut server, 2)), ((vec![], None), (vec![], None)));
        server.reject([1; 16]);
        server.reject([1; 16]);
        assert_eq!(said(&mut server), [("to 1".to_owned(), vec![0; 12])]);
        server.accept([2; 16], SECOND, |status| result(status, 8));
        assert_eq!((server.pursued(), statuses(&mut server)), (Some([2; 16]), vec![STATUS_EXECUTING]));
        // One that waits does not end the other one, and cannot be sent again.
        offer(&mut server, 3);
        assert_eq!(server.pursued(), Some([2; 16]));
        assert_eq!(offer(&mut server, 3).0, [("to 3".to_owned(), vec![0; 12])]);
        hear(&mut server, &request(CANCEL_GOAL, 2, &[0; 8]), SECOND);
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
            hear(&mut server, &request(SEND_GOAL, 1, &[7]), SECOND);
            hear(&mut server, &request(SEND_GOAL, 2, &[7]), 2 * SECOND);
            server.take_said();
            let demand = hear(&mut server, &request(CANCEL_GOAL, id, &until), 4 * SECOND);
            let said = said(&mut server);
            let replied = (said[0].1[0] as i8, said[0].1[4], demand == Some(Demand::Cancel));
            assert_eq!(replied, (code, u8::from(is_canceled), is_canceled), "{id} {until:?}");
            assert_eq!(said.len(), 1 + usize::from(is_canceled));
        }
    }

    #[test]
    fn messages_that_are_cut_off_are_answered_and_have_no_effect() {
        for part in [SEND_GOAL, CANCEL_GOAL, GET_RESULT] {
            let mut server = server();
            hear(&mut server, &request(SEND_GOAL, 1, &[7]), SECOND);
            server.take_said();
            let whole = request(part, 5, &[0; 8]);
            for length in 0..20 {
                let cut = Call { body: whole.body[..length].to_vec(), ..whole.clone() };
                assert_eq!(hear(&mut server, &cut, SECOND), None);
                assert_eq!(server.take_said().len(), 1, "{part} {length}");
            }
        }
        assert_eq!(hear(&mut server(), &Call { service: "/go/other".to_owned(), ..request("", 1, &[]) }, SECOND), None);
    }
}
