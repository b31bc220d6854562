//! The states of the nodes of Nav2 whose work the robot's own software does: clients wait until these are active.

use components::Component;
use remote::{NodeMessage, ServiceRequest};
use ros_messages::RosType as _;
use ros_messages::standard::LifecycleState;
use runs::ControllerInput;

use super::config::RobotConfig;

/// The type of the service that returns a node's state.
pub(super) const KIND: &str = "lifecycle_msgs/srv/GetState";

/// The states of `lifecycle_msgs/msg/State`, by number and label.
const INACTIVE: (u8, &str) = (2, "inactive");
const ACTIVE: (u8, &str) = (3, "active");

/// A node of Nav2 with a lifecycle, whose work the robot's own software does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ManagedNode {
    /// AMCL: the robot is localized.
    Localizer,
    /// The server of `navigate_to_pose`.
    Navigator,
}

impl ManagedNode {
    pub(super) const ALL: [Self; 2] = [Self::Localizer, Self::Navigator];

    /// The service that returns its state, in a namespace.
    pub(super) fn service(self) -> &'static str {
        match self {
            Self::Localizer => "amcl/get_state",
            Self::Navigator => "bt_navigator/get_state",
        }
    }

    /// Whether the robot's own software does its work.
    pub(super) fn is_there(self, config: &RobotConfig) -> bool {
        match self {
            Self::Localizer => config.localizes,
            Self::Navigator => config.navigates,
        }
    }

    /// The node whose state a service returns, by the service's name within the program.
    pub(super) fn of_service(service: &str) -> Option<Self> {
        let name = service.strip_prefix('/')?;
        Self::ALL.into_iter().find(|node| node.service() == name)
    }

    /// Whether it does not respond, because the software that does its work is frozen.
    pub(super) fn is_frozen(self, input: &ControllerInput<'_>) -> bool {
        input.software.is_frozen(match self {
            Self::Localizer => Component::Localization,
            Self::Navigator => Component::Navigation,
        })
    }
}

/// The response to a request for the state of a node, a `lifecycle_msgs/srv/GetState_Response`: the node is active once
/// the run has begun.
pub(super) fn response(request: &ServiceRequest, has_begun: bool) -> NodeMessage {
    let (id, label) = if has_begun { ACTIVE } else { INACTIVE };
    let body = LifecycleState { id, label: label.to_owned() }.encode();
    NodeMessage::Response { number: request.number, body }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_node_is_inactive_until_the_run_begins() {
        let service = "/amcl/get_state".to_owned();
        let request = ServiceRequest { service, kind: KIND.to_owned(), number: 7, body: Vec::new() };
        let body = |has_begun| match response(&request, has_begun) {
            NodeMessage::Response { number: 7, body } => body[4..].to_vec(),
            other => panic!("{other:?}"),
        };
        assert_eq!(body(false), b"\x02\0\0\0\x09\0\0\0inactive\0");
        assert_eq!(body(true), b"\x03\0\0\0\x07\0\0\0active\0");
    }

    #[test]
    fn a_service_returns_the_state_of_one_node() {
        assert_eq!(ManagedNode::of_service("/amcl/get_state"), Some(ManagedNode::Localizer));
        assert_eq!(ManagedNode::of_service("/Door/get_state"), None);
    }
}
