//! What passes between a channel system and nodes of ROS 2, in both directions.

use std::time::Duration;

use channels::Flaw;
use ros_messages::CdrWriter;

use crate::action::{self, CANCEL_GOAL, GET_RESULT, SEND_GOAL};

/// The id of an action's goal.
pub type GoalId = [u8; 16];

/// The most messages of feedback that wait: beyond that, the oldest are lost.
const MOST_FEEDBACK: usize = 100;

/// A request to a service.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Call {
    /// The service, such as `/say`.
    pub service: String,
    /// Its type, such as `std_srvs/srv/Trigger`.
    pub kind: String,
    /// What its response refers to: no other call that is open has this number.
    pub number: u64,
    /// The request, encoded, with the four bytes that say how.
    pub body: Vec<u8>,
}

/// What is said by the nodes of ROS 2 that serve or publish.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum FromNode {
    /// The response to the call with this number.
    Response {
        /// That of the call.
        number: u64,
        /// The response, encoded; empty if nobody can respond.
        body: Vec<u8>,
    },
    /// A message on a topic.
    Message {
        /// Its name, such as `/amcl_pose`.
        topic: String,
        /// The message, encoded.
        body: Vec<u8>,
    },
}

/// What may be lost on its way from a node.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Lost {
    /// Messages on the topic with this name, until the next one.
    Topic(String),
    /// The response to the call with this number.
    Response(u64),
}

/// A loss on the way from a node.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Loss {
    /// What is lost.
    pub what: Lost,
    /// What is wrong: it is missing, or what takes its place is [mixed](Flaw::Mixed) with what the nodes say.
    pub flaw: Flaw,
    /// Since when it may be missing, in time since the start of the run.
    pub since: Duration,
    /// Why, in words.
    pub why: String,
}

impl FromNode {
    /// Waits among others: a newer message on a topic replaces an older one there, and of feedback, not all is kept.
    pub fn wait_in(self, waiting: &mut Vec<Self>) {
        if let Self::Message { topic, .. } = &self {
            let is_older = |other: &Self| matches!(other, Self::Message { topic: of, .. } if of == topic);
            let most = if action::is_feedback(topic) { MOST_FEEDBACK } else { 1 };
            if waiting.iter().filter(|other| is_older(other)).count() >= most
                && let Some(oldest) = waiting.iter().position(is_older)
            {
                waiting.remove(oldest);
            }
        }
        waiting.push(self);
    }
}

impl Call {
    /// Whether it has no other effect if it is sent again: it asks for the result of a goal, or cancels it.
    #[must_use]
    pub fn is_repeatable(&self) -> bool {
        [GET_RESULT, CANCEL_GOAL].iter().any(|part| self.is_to(part))
    }

    /// What is taken for its response if that is lost. A goal may be pursued: its result tells if it is not.
    #[must_use]
    pub fn presumed(&self) -> FromNode {
        let accepts = || {
            let mut body = CdrWriter::reusing(Vec::new());
            body.number([1]);
            body.bytes()
        };
        let body = if self.is_to(SEND_GOAL) { accepts() } else { Vec::new() };
        FromNode::Response { number: self.number, body }
    }

    fn is_to(&self, part: &str) -> bool {
        self.service.ends_with(&action::service("", part))
    }
}
