//! What an action of ROS 2 consists of: services, topics, and the numbers in their messages.
//!
//! <https://design.ros2.org/articles/actions.html>

/// The services of an action.
pub const SEND_GOAL: &str = "send_goal";
/// The one that asks for results.
pub const GET_RESULT: &str = "get_result";
/// The one that cancels goals.
pub const CANCEL_GOAL: &str = "cancel_goal";

/// The type of the service that cancels goals of any action.
pub const CANCEL_KIND: &str = "action_msgs/srv/CancelGoal";

/// The type of the topic that tells the status of goals of any action.
pub const STATUS_KIND: &str = "action_msgs/msg/GoalStatusArray";

/// The status of goals, from `action_msgs/msg/GoalStatus`: nothing is known of it.
pub const STATUS_UNKNOWN: i8 = 0;
/// It is pursued.
pub const STATUS_EXECUTING: i8 = 2;
/// It is about to be canceled.
pub const STATUS_CANCELING: i8 = 3;
/// It was reached.
pub const STATUS_SUCCEEDED: i8 = 4;
/// It was canceled.
pub const STATUS_CANCELED: i8 = 5;
/// It was given up.
pub const STATUS_ABORTED: i8 = 6;

/// What a server answers to a request to cancel, from `action_msgs/srv/CancelGoal`: the goals will be canceled.
pub const CANCEL_ACCEPTED: i8 = 0;
/// They will not.
pub const CANCEL_REJECTED: i8 = 1;
/// There is no such goal.
pub const CANCEL_UNKNOWN: i8 = 2;
/// It has ended already.
pub const CANCEL_TERMINATED: i8 = 3;

/// A service of an action.
#[must_use]
pub fn service(action: &str, part: &str) -> String {
    format!("{action}/_action/{part}")
}

/// The services of an action of a type, with their types.
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

/// The topic on which an action tells the status of its goals.
#[must_use]
pub fn status(action: &str) -> String {
    format!("{action}/_action/status")
}

pub(crate) fn is_feedback(topic: &str) -> bool {
    topic.ends_with("/_action/feedback")
}
