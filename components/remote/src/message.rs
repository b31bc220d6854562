//! The requests, responses and topic messages between a channel system and nodes of ROS 2, in both directions.

use std::time::Duration;

use channels::Flaw;
use ros_messages::RosType as _;

use crate::action::{self, CANCEL_GOAL, GET_RESULT, SEND_GOAL};

/// The id of an action's goal.
pub type GoalId = [u8; 16];

/// The most feedback messages in a queue. Beyond that, the oldest are dropped.
const MOST_FEEDBACK: usize = 100;

/// A request to a service.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct ServiceRequest {
    /// The service, such as `/say`.
    pub service: String,
    /// Its type, such as `std_srvs/srv/Trigger`.
    pub kind: String,
    /// The number that its response refers to. No other open request has it.
    pub number: u64,
    /// The request in CDR, with the encapsulation header of four bytes.
    pub body: Vec<u8>,
}

/// A response, or a message on a topic: of a node of ROS 2 to a channel system, or of a component to nodes.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum NodeMessage {
    /// The response to a request.
    Response {
        /// The number of the request.
        number: u64,
        /// The response in CDR; empty if no server can respond.
        body: Vec<u8>,
    },
    /// A message on a topic.
    Message {
        /// The topic, such as `/amcl_pose`.
        topic: String,
        /// The message in CDR.
        body: Vec<u8>,
    },
}

/// Something that may be lost on its way from a node.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Lost {
    /// Messages on the topic with this name, until the next one.
    Topic(String),
    /// The response to the request with this number.
    Response(u64),
}

/// A loss on the way from a node.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Loss {
    /// What is lost.
    pub what: Lost,
    /// The kind of flaw: messages are missing, or a presumed response is [mixed](Flaw::Mixed) with those of the nodes.
    pub flaw: Flaw,
    /// Since when it may be missing, as time since the start of the run.
    pub since: Duration,
    /// Why, in words.
    pub why: String,
}

impl NodeMessage {
    /// Adds itself to a queue. A message replaces an older one on the same topic; of feedback, the queue keeps the
    /// newest 100.
    pub fn enqueue_in(self, queue: &mut Vec<Self>) {
        if let Self::Message { topic, .. } = &self {
            let is_older = |other: &Self| matches!(other, Self::Message { topic: of, .. } if of == topic);
            let most = if action::is_feedback(topic) { MOST_FEEDBACK } else { 1 };
            if queue.iter().filter(|other| is_older(other)).count() >= most
                && let Some(oldest) = queue.iter().position(is_older)
            {
                queue.remove(oldest);
            }
        }
        queue.push(self);
    }
}

impl ServiceRequest {
    /// Whether sending it again has no further effect: it requests the result of a goal, or cancels one.
    #[must_use]
    pub fn is_repeatable(&self) -> bool {
        [GET_RESULT, CANCEL_GOAL].iter().any(|part| self.is_to(part))
    }

    /// The response that is presumed if the real one is lost. A goal counts as accepted: its result shows if it is not
    /// pursued. Any other request counts as failed.
    #[must_use]
    pub fn presumed(&self) -> NodeMessage {
        let body = if self.is_to(SEND_GOAL) { true.encode() } else { Vec::new() };
        NodeMessage::Response { number: self.number, body }
    }

    fn is_to(&self, part: &str) -> bool {
        self.service.ends_with(&action::service("", part))
    }
}
