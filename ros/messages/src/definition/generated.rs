//! The messages that ROS sends for services and actions, and the types that it always knows.

use super::{Action, Message, Service, TypeName};

/// Types that all of these messages use. The definitions are those of `rcl_interfaces` and `unique_identifier_msgs`.
const KNOWN: [(&str, &str, &str); 7] = [
    ("builtin_interfaces", "Time", "int32 sec\nuint32 nanosec\n"),
    ("builtin_interfaces", "Duration", "int32 sec\nuint32 nanosec\n"),
    ("unique_identifier_msgs", "UUID", "uint8[16] uuid\n"),
    (
        "service_msgs",
        "ServiceEventInfo",
        "uint8 REQUEST_SENT=0\nuint8 REQUEST_RECEIVED=1\nuint8 RESPONSE_SENT=2\nuint8 RESPONSE_RECEIVED=3\n\
         uint8 event_type\nbuiltin_interfaces/Time stamp\nchar[16] client_gid\nint64 sequence_number\n",
    ),
    ("action_msgs", "GoalInfo", "unique_identifier_msgs/UUID goal_id\nbuiltin_interfaces/Time stamp\n"),
    (
        "action_msgs",
        "GoalStatus",
        "int8 STATUS_UNKNOWN=0\nint8 STATUS_ACCEPTED=1\nint8 STATUS_EXECUTING=2\nint8 STATUS_CANCELING=3\n\
         int8 STATUS_SUCCEEDED=4\nint8 STATUS_CANCELED=5\nint8 STATUS_ABORTED=6\nGoalInfo goal_info\nint8 status\n",
    ),
    ("action_msgs", "GoalStatusArray", "GoalStatus[] status_list\n"),
];

impl Message {
    /// The definition of a type that ROS uses for services, actions and stamps; `None` for other types.
    #[must_use]
    pub fn known(name: &TypeName) -> Option<Self> {
        let is = |package: &str, own: &str| name.package.as_deref() == Some(package) && name.name == own;
        let (.., text) = KNOWN.iter().find(|(package, own, _)| is(package, own))?;
        Some(made(text.to_string()))
    }
}

impl Service {
    /// The messages of the service `name`: its parts as `NAME_Request` and `NAME_Response`, and `NAME_Event`, which
    /// ROS publishes on the topic `_service_event`.
    #[must_use]
    pub fn messages(self, name: &str) -> [(String, Message); 3] {
        [
            (format!("{name}_Request"), self.request),
            (format!("{name}_Response"), self.response),
            (format!("{name}_Event"), event(name)),
        ]
    }
}

impl Action {
    /// The messages of the action `name`: its parts as `NAME_Goal`, `NAME_Result` and `NAME_Feedback`;
    /// `NAME_FeedbackMessage`, which ROS publishes on the topic `_action/feedback`; and those of its two services.
    #[must_use]
    pub fn messages(self, name: &str) -> Vec<(String, Message)> {
        const ID: &str = "unique_identifier_msgs/UUID goal_id\n";
        let own = [("Goal", self.goal), ("Result", self.result), ("Feedback", self.feedback)];
        let send = Service {
            request: made(format!("{ID}{name}_Goal goal\n")),
            response: made("bool accepted\nbuiltin_interfaces/Time stamp\n".to_owned()),
        };
        let get =
            Service { request: made(ID.to_owned()), response: made(format!("int8 status\n{name}_Result result\n")) };
        let services = [("SendGoal", send), ("GetResult", get)];
        let feedback = made(format!("{ID}{name}_Feedback feedback\n"));
        let own = own.into_iter().chain([("FeedbackMessage", feedback)]);
        let own = own.map(|(part, message)| (format!("{name}_{part}"), message));
        own.chain(services.into_iter().flat_map(|(part, service)| service.messages(&format!("{name}_{part}"))))
            .collect()
    }
}

/// The event published for a call of the service.
fn event(name: &str) -> Message {
    made(format!("service_msgs/ServiceEventInfo info\n{name}_Request[<=1] request\n{name}_Response[<=1] response\n"))
}

fn made(text: String) -> Message {
    Message::parse("what ROS makes", &text).expect("ROS makes valid definitions of valid names")
}
