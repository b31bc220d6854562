//! The parts of an action in ROS 2: services, topics, and the codes in their messages.
//!
//! <https://design.ros2.org/articles/actions.html>

/// The service of an action that takes goals.
pub const SEND_GOAL: &str = "send_goal";
/// The service that returns the result of a goal.
pub const GET_RESULT: &str = "get_result";
/// The service that cancels goals.
pub const CANCEL_GOAL: &str = "cancel_goal";

/// The type of every action's service for canceling goals.
pub const CANCEL_KIND: &str = "action_msgs/srv/CancelGoal";

/// The type of every action's status topic.
pub const STATUS_KIND: &str = "action_msgs/msg/GoalStatusArray";

/// A goal's status, from `action_msgs/msg/GoalStatus`: unknown.
pub const STATUS_UNKNOWN: i8 = 0;
/// The server pursues the goal.
pub const STATUS_EXECUTING: i8 = 2;
/// The server is canceling the goal.
pub const STATUS_CANCELING: i8 = 3;
/// The goal was reached.
pub const STATUS_SUCCEEDED: i8 = 4;
/// The goal was canceled.
pub const STATUS_CANCELED: i8 = 5;
/// The server gave the goal up.
pub const STATUS_ABORTED: i8 = 6;

/// The return code of a cancel request, from `action_msgs/srv/CancelGoal`: the server cancels the goals.
pub const CANCEL_ACCEPTED: i8 = 0;
/// The server rejects the request.
pub const CANCEL_REJECTED: i8 = 1;
/// The server does not know the goal.
pub const CANCEL_UNKNOWN: i8 = 2;
/// The goal has already ended.
pub const CANCEL_TERMINATED: i8 = 3;

/// The name of a service of an action.
#[must_use]
pub fn service(action: &str, part: &str) -> String {
    format!("{action}/_action/{part}")
}

/// The services of an action of a type, each with its type.
pub fn services(action: &str, kind: &str) -> [(String, String); 3] {
    [
        (service(action, SEND_GOAL), format!("{kind}_SendGoal")),
        (service(action, GET_RESULT), format!("{kind}_GetResult")),
        (service(action, CANCEL_GOAL), CANCEL_KIND.to_owned()),
    ]
}

/// The topic of an action's feedback.
#[must_use]
pub fn feedback(action: &str) -> String {
    format!("{action}/_action/feedback")
}

/// The type of the feedback of an action of a type.
#[must_use]
pub fn feedback_kind(kind: &str) -> String {
    format!("{kind}_FeedbackMessage")
}

/// The topic on which an action publishes the status of its goals.
#[must_use]
pub fn status(action: &str) -> String {
    format!("{action}/_action/status")
}

pub(crate) fn is_feedback(topic: &str) -> bool {
    topic.ends_with("/_action/feedback")
}
