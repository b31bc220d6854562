//! The server of an action of ROS 2 that pursues one goal at a time: a newer one takes the place of an older one, as in
//! Nav2's servers.

use std::collections::VecDeque;
use std::time::Duration;

use network::{Client, Publication, Reply, Served, Voice};
use recording::ros::Time;
use remote::action::{
    self, CANCEL_ACCEPTED, CANCEL_GOAL, CANCEL_KIND, CANCEL_TERMINATED, CANCEL_UNKNOWN, GET_RESULT, SEND_GOAL,
    STATUS_ABORTED, STATUS_CANCELED, STATUS_CANCELING, STATUS_EXECUTING, STATUS_KIND, STATUS_SUCCEEDED, STATUS_UNKNOWN,
};
use ros_messages::{CdrReader, CdrWriter, Mismatch, RosType as _};

/// The most goals that are remembered, the oldest of which have ended, and the most that wait for the result of one.
const MOST_GOALS: usize = 100;
const MOST_WAITING: usize = 1000;

/// An action server: the goals that it was sent, and what becomes of them.
#[derive(Debug)]
pub(super) struct ActionServer {
    /// Its name, such as `/navigate_to_pose`, and its type.
    name: String,
    kind: String,
    /// Oldest first: only the last may not have ended.
    goals: VecDeque<Goal>,
    said: Vec<Said>,
}

/// A goal that was accepted.
#[derive(Debug)]
struct Goal {
    id: [u8; 16],
    since: Duration,
    status: i8,
    /// The message that tells its result, once it has ended; and who waits for it.
    result: Vec<u8>,
    waiting: Vec<Client>,
}

/// What a server is to do.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Demand<G> {
    Pursue(G),
    Cancel,
}

/// How a goal has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ending {
    Succeeded,
    Canceled,
    Aborted,
}

/// What a server has said.
#[derive(Clone, Debug, PartialEq)]
enum Said {
    Reply(Reply),
    Publication(Publication),
}

impl ActionServer {
    pub(super) fn new(name: String, kind: &str) -> Self {
        let (goals, said) = (VecDeque::new(), Vec::new());
        let mut server = Self { name, kind: kind.to_owned(), goals, said };
        server.publish(action::feedback(&server.name), format!("{kind}_FeedbackMessage"), false, Vec::new());
        server.tell_status();
        server
    }

    pub(super) fn services(&self) -> impl Iterator<Item = (String, String)> {
        action::services(&self.name, &self.kind).into_iter()
    }

    /// Says what is to be said.
    pub(super) fn speak(&mut self, voice: &Voice) {
        for said in self.said.drain(..) {
            match said {
                Said::Reply(reply) => voice.respond(reply),
                Said::Publication(publication) => voice.publish(publication),
            }
        }
    }

    /// Hears a request. `read` reads what a goal says, and returns none if it is not accepted; `replaced` is the result
    /// of a goal in whose place another comes, and `unknown` that of one that nobody has sent.
    pub(super) fn hear<G>(
        &mut self,
        request: &Served,
        now: Duration,
        read: impl FnOnce(&mut CdrReader<'_>) -> Option<G>,
        replaced: impl FnOnce(&mut CdrWriter),
        unknown: impl FnOnce(&mut CdrWriter),
    ) -> Option<Demand<G>> {
        let part = request.service.strip_prefix(&action::service(&self.name, ""))?;
        let (body, client) = (&request.body, request.client);
        match part {
            SEND_GOAL => self.take_goal(body, client, now, read, replaced).map(Demand::Pursue),
            CANCEL_GOAL => self.cancel(body, client).then_some(Demand::Cancel),
            GET_RESULT => {
                self.ask_for_result(body, client, unknown);
                None
            }
            _ => None,
        }
    }

    fn take_goal<G>(
        &mut self,
        body: &[u8],
        client: Client,
        now: Duration,
        read: impl FnOnce(&mut CdrReader<'_>) -> Option<G>,
        replaced: impl FnOnce(&mut CdrWriter),
    ) -> Option<G> {
        let mut reader = CdrReader::new(body).ok();
        let id = reader.as_mut().and_then(|reader| reader.take(16).ok()?.try_into().ok());
        let is_new = |id: &[u8; 16]| self.goals.iter().all(|goal| goal.id != *id);
        let goal = id.filter(is_new).zip(reader.and_then(|mut reader| read(&mut reader)));
        self.reply(SEND_GOAL, &format!("{}_SendGoal", self.kind), client, |cdr| {
            goal.is_some().write(cdr);
            Time::from(now).write(cdr);
        });
        let (id, goal) = goal?;
        self.end(Ending::Aborted, replaced);
        if self.goals.len() == MOST_GOALS {
            self.goals.pop_front();
        }
        let (result, waiting) = (Vec::new(), Vec::new());
        self.goals.push_back(Goal { id, since: now, status: STATUS_EXECUTING, result, waiting });
        self.tell_status();
        Some(goal)
    }

    /// Returns whether the goal that is pursued is to be canceled.
    fn cancel(&mut self, body: &[u8], client: Client) -> bool {
        let read = || -> Result<_, Mismatch> {
            let mut reader = CdrReader::new(body)?;
            let id: [u8; 16] = reader.take(16)?.try_into().map_err(|_| Mismatch::Short)?;
            let (s, ns) = (i32::from_le_bytes(reader.number()?), u32::from_le_bytes(reader.number()?));
            Ok((id, Duration::new(u64::try_from(s).unwrap_or_default(), ns)))
        };
        let Ok((id, until)) = read() else {
            self.reply_to_cancel(client, CANCEL_UNKNOWN, &[]);
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
        self.reply_to_cancel(client, code, canceled.as_slice());
        if canceled.is_some() {
            self.tell_status();
        }
        canceled.is_some()
    }

    fn reply_to_cancel(&mut self, client: Client, code: i8, goals: &[([u8; 16], Duration)]) {
        self.reply(CANCEL_GOAL, CANCEL_KIND, client, |cdr| {
            code.write(cdr);
            cdr.length(goals.len());
            goals.iter().for_each(|(id, since)| write_goal_info(id, *since, cdr));
        });
    }

    fn ask_for_result(&mut self, body: &[u8], client: Client, unknown: impl FnOnce(&mut CdrWriter)) {
        let id = CdrReader::new(body).and_then(|mut reader| reader.take(16));
        let goal = self.goals.iter_mut().find(|goal| id.as_ref().is_ok_and(|id| *id == goal.id));
        let body = match goal {
            Some(goal) if goal.status < STATUS_SUCCEEDED => {
                if goal.waiting.len() < MOST_WAITING {
                    goal.waiting.push(client);
                }
                return;
            }
            Some(goal) => goal.result.clone(),
            None => written(|cdr| {
                STATUS_UNKNOWN.write(cdr);
                unknown(cdr);
            }),
        };
        self.tell_result(client, body);
    }

    fn tell_result(&mut self, client: Client, body: Vec<u8>) {
        let (service, kind) = (action::service(&self.name, GET_RESULT), format!("{}_GetResult", self.kind));
        self.said.push(Said::Reply(Reply { service, kind, client, body }));
    }

    /// Tells whoever has sent the goal that is pursued how it goes.
    pub(super) fn feed_back(&mut self, feedback: impl FnOnce(&mut CdrWriter)) {
        let Some(goal) = self.goals.back().filter(|goal| goal.status < STATUS_SUCCEEDED) else { return };
        let body = written(|cdr| {
            cdr.numbers(goal.id.iter().map(|byte| [*byte]));
            feedback(cdr);
        });
        self.publish(action::feedback(&self.name), format!("{}_FeedbackMessage", self.kind), false, body);
    }

    /// Ends the goal that is pursued, if there is one.
    pub(super) fn end(&mut self, how: Ending, result: impl FnOnce(&mut CdrWriter)) {
        let Some(goal) = self.goals.back_mut().filter(|goal| goal.status < STATUS_SUCCEEDED) else { return };
        goal.status = match how {
            Ending::Succeeded => STATUS_SUCCEEDED,
            Ending::Aborted if goal.status == STATUS_CANCELING => STATUS_CANCELED,
            Ending::Canceled => STATUS_CANCELED,
            Ending::Aborted => STATUS_ABORTED,
        };
        let status = goal.status;
        goal.result = written(|cdr| {
            status.write(cdr);
            result(cdr);
        });
        let (waiting, body) = (std::mem::take(&mut goal.waiting), goal.result.clone());
        waiting.into_iter().for_each(|client| self.tell_result(client, body.clone()));
        self.tell_status();
    }

    /// Forgets all goals, as a server that was started again.
    pub(super) fn restart(&mut self) {
        self.goals.clear();
        self.tell_status();
    }

    fn tell_status(&mut self) {
        let body = written(|cdr| {
            cdr.length(self.goals.len());
            for goal in &self.goals {
                write_goal_info(&goal.id, goal.since, cdr);
                goal.status.write(cdr);
            }
        });
        self.publish(action::status(&self.name), STATUS_KIND.to_owned(), true, body);
    }

    fn publish(&mut self, topic: String, kind: String, is_latched: bool, body: Vec<u8>) {
        self.said.push(Said::Publication(Publication { topic, kind, is_latched, body }));
    }

    fn reply(&mut self, part: &str, kind: &str, client: Client, write: impl FnOnce(&mut CdrWriter)) {
        let (service, kind) = (action::service(&self.name, part), kind.to_owned());
        self.said.push(Said::Reply(Reply { service, kind, client, body: written(write) }));
    }
}

/// `action_msgs/msg/GoalInfo`
fn write_goal_info(id: &[u8; 16], since: Duration, cdr: &mut CdrWriter) {
    cdr.numbers(id.iter().map(|byte| [*byte]));
    Time::from(since).write(cdr);
}

/// A whole message.
fn written(write: impl FnOnce(&mut CdrWriter)) -> Vec<u8> {
    let mut cdr = CdrWriter::reusing(Vec::new());
    write(&mut cdr);
    cdr.bytes()
}

#[cfg(test)]
impl ActionServer {
    /// What has been said since the last call: the parts of services that replied and the statuses of all goals, each
    /// with its message after the encoding.
    pub(super) fn take_said(&mut self) -> Vec<(String, Vec<u8>)> {
        let said = self.said.drain(..).map(|said| match said {
            Said::Reply(Reply { service: name, body, .. })
            | Said::Publication(Publication { topic: name, body, .. }) => {
                (name.rsplit('/').next().unwrap_or_default().to_owned(), body.get(4..).unwrap_or_default().to_vec())
            }
        });
        said.collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECOND: Duration = Duration::from_secs(1);

    /// A request about a goal, with more after its id.
    fn request(part: &str, id: u8, more: &[u8]) -> Served {
        let body = [&[0, 1, 0, 0][..], &[id; 16], more].concat();
        Served { service: format!("/go/_action/{part}"), client: Client::default(), body }
    }

    fn server() -> ActionServer {
        let mut server = ActionServer::new("/go".to_owned(), "nav2_msgs/action/Go");
        assert_eq!(server.take_said(), [("feedback".to_owned(), vec![]), ("status".to_owned(), vec![0; 4])]);
        server
    }

    /// Goals say a number, which must not be 0.
    fn hear(server: &mut ActionServer, request: &Served, now: Duration) -> Option<Demand<u8>> {
        let read = |reader: &mut CdrReader<'_>| reader.number().ok().map(u8::from_le_bytes).filter(|goal| *goal > 0);
        server.hear(request, now, read, |cdr| 8_u8.write(cdr), |cdr| 9_u8.write(cdr))
    }

    /// The status of each goal that the server knows.
    fn statuses(server: &mut ActionServer) -> Vec<i8> {
        let said = server.take_said();
        let (_, last) = said.iter().rev().find(|(name, _)| name == "status").expect("a status");
        last[4..].chunks(28).map(|goal| goal[24] as i8).collect()
    }

    #[test]
    fn a_goal_is_pursued_until_it_ends_and_then_its_result_is_told() {
        let mut server = server();
        assert_eq!(hear(&mut server, &request(SEND_GOAL, 1, &[7]), SECOND), Some(Demand::Pursue(7)));
        let said = server.take_said();
        assert_eq!(said[0], (SEND_GOAL.to_owned(), vec![1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0]));
        assert_eq!((said[1].0.as_str(), said[1].1[28]), ("status", STATUS_EXECUTING as u8));
        for _ in 0..2 {
            assert_eq!(hear(&mut server, &request(GET_RESULT, 1, &[]), SECOND), None);
        }
        server.feed_back(|cdr| 5_u8.write(cdr));
        assert_eq!(server.take_said(), [("feedback".to_owned(), [&[1; 16][..], &[5]].concat())]);
        server.end(Ending::Succeeded, |cdr| 3_u8.write(cdr));
        let result = (GET_RESULT.to_owned(), vec![STATUS_SUCCEEDED as u8, 3]);
        assert_eq!(server.take_said()[..2], [result.clone(), result.clone()]);
        // Who asks later hears it, too; who asks for another does not.
        hear(&mut server, &request(GET_RESULT, 1, &[]), SECOND);
        hear(&mut server, &request(GET_RESULT, 2, &[]), SECOND);
        assert_eq!(server.take_said(), [result, (GET_RESULT.to_owned(), vec![STATUS_UNKNOWN as u8, 9])]);
        server.feed_back(|cdr| 5_u8.write(cdr));
        server.end(Ending::Aborted, |_| {});
        assert!(server.take_said().is_empty());
    }

    #[test]
    fn a_newer_goal_ends_an_older_one_and_a_bad_one_does_not() {
        let mut server = server();
        hear(&mut server, &request(SEND_GOAL, 1, &[7]), SECOND);
        for bad in [request(SEND_GOAL, 2, &[0]), request(SEND_GOAL, 1, &[7]), request(SEND_GOAL, 2, &[])] {
            server.take_said();
            assert_eq!(hear(&mut server, &bad, SECOND), None);
            assert_eq!(server.take_said(), [(SEND_GOAL.to_owned(), vec![0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0])]);
        }
        assert_eq!(hear(&mut server, &request(SEND_GOAL, 2, &[8]), SECOND), Some(Demand::Pursue(8)));
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
            let said = server.take_said();
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
                let cut = Served { body: whole.body[..length].to_vec(), ..whole.clone() };
                assert_eq!(hear(&mut server, &cut, SECOND), None);
                assert_eq!(server.take_said().len(), 1, "{part} {length}");
            }
        }
        assert_eq!(
            hear(&mut server(), &Served { service: "/go/other".to_owned(), ..request("", 1, &[]) }, SECOND),
            None
        );
    }
}
