//! The elements that RoAML adds to SCXML, and the events that they stand for.

/// A machine's declaration about an interface: the elements that use it need the same role.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) enum Role {
    /// Publishes on a topic.
    Publisher,
    /// Subscribes to a topic.
    Subscriber,
    /// Calls a service.
    Client,
    /// Provides a service.
    Server,
    /// Sends goals to an action server.
    ActionClient,
    /// Provides an action.
    ActionServer,
    /// Has a timer.
    Timer,
}

impl Role {
    const ALL: [Self; 7] = [
        Self::Publisher,
        Self::Subscriber,
        Self::Client,
        Self::Server,
        Self::ActionClient,
        Self::ActionServer,
        Self::Timer,
    ];

    /// The element that declares it.
    pub(super) fn element(self) -> &'static str {
        match self {
            Self::Publisher => "ros_topic_publisher",
            Self::Subscriber => "ros_topic_subscriber",
            Self::Client => "ros_service_client",
            Self::Server => "ros_service_server",
            Self::ActionClient => "ros_action_client",
            Self::ActionServer => "ros_action_server",
            Self::Timer => "ros_time_rate",
        }
    }

    /// The attribute with the interface's name.
    pub(super) fn attribute(self) -> &'static str {
        match self {
            Self::Publisher | Self::Subscriber => "topic",
            Self::Client | Self::Server => "service_name",
            Self::ActionClient | Self::ActionServer => "action_name",
            Self::Timer => "name",
        }
    }

    pub(super) fn declared_by(element: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|role| role.element() == element)
    }
}

/// Where an event goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) enum Way {
    /// To every other machine that has a transition for it.
    Everyone,
    /// To the server, which takes the next request once it has answered.
    Request,
    /// To the client whose request the server is answering.
    Response,
    /// To the server, which gets the sender's number as `goal_id`.
    Goal,
    /// To the client with this `goal_id`.
    Client,
    /// To the thread of the same server with this `thread_id`.
    Thread,
    /// From a thread to its server.
    Server,
}

/// The codes of results, as in `action_msgs/GoalStatus`.
const SUCCEEDED: u8 = 4;
const CANCELED: u8 = 5;
const ABORTED: u8 = 6;

/// An element that reacts to an event, like a transition: its role, its event (`{}` is the interface), and the code of
/// the result that it waits for.
pub(super) struct Reaction {
    pub(super) element: &'static str,
    pub(super) role: Option<Role>,
    pub(super) event: &'static str,
    pub(super) code: Option<u8>,
}

const fn reaction(element: &'static str, role: Role, event: &'static str) -> Reaction {
    Reaction { element, role: Some(role), event, code: None }
}

const REACTIONS: [Reaction; 15] = [
    reaction("ros_topic_callback", Role::Subscriber, "topic_{}_msg"),
    reaction("ros_service_handle_request", Role::Server, "srv_{}_request"),
    reaction("ros_service_handle_response", Role::Client, "srv_{}_response"),
    reaction("ros_action_handle_goal", Role::ActionServer, "action_{}_goal_handle"),
    reaction("ros_action_handle_cancel", Role::ActionServer, "action_{}_cancel_handle"),
    reaction("ros_action_handle_feedback", Role::ActionClient, "action_{}_feedback"),
    Reaction {
        code: Some(SUCCEEDED),
        ..reaction("ros_action_handle_success_result", Role::ActionClient, "action_{}_result")
    },
    Reaction {
        code: Some(ABORTED),
        ..reaction("ros_action_handle_aborted_result", Role::ActionClient, "action_{}_result")
    },
    Reaction {
        code: Some(CANCELED),
        ..reaction("ros_action_handle_canceled_result", Role::ActionClient, "action_{}_result")
    },
    reaction("ros_action_handle_thread_start", Role::ActionServer, "action_{}_thread_start"),
    reaction("ros_action_handle_thread_free", Role::ActionServer, "action_{}_thread_free"),
    reaction("ros_rate_callback", Role::Timer, "timer_{}"),
    // The events for both outcomes of a goal request; the second is `…_rejected`.
    reaction(GOAL_RESPONSE, Role::ActionClient, "action_{}_goal_accepted"),
    Reaction { element: "bt_tick", role: None, event: "bt_tick", code: None },
    Reaction { element: "bt_halt", role: None, event: "bt_halt", code: None },
];

/// The element that waits for the answer to a goal request.
pub(super) const GOAL_RESPONSE: &str = "ros_action_handle_goal_response";

impl Reaction {
    pub(super) fn of(element: &str) -> Option<&'static Self> {
        REACTIONS.iter().find(|reaction| reaction.element == element)
    }
}

/// An element that sends an event: its role, its event, its way, and the attributes that become fields.
pub(super) struct Sending {
    pub(super) element: &'static str,
    pub(super) role: Role,
    pub(super) event: &'static str,
    pub(super) way: Way,
    pub(super) attributes: &'static [&'static str],
    pub(super) code: Option<u8>,
}

const fn sending(element: &'static str, role: Role, event: &'static str, way: Way) -> Sending {
    Sending { element, role, event, way, attributes: &[], code: None }
}

const fn answer(element: &'static str, event: &'static str) -> Sending {
    Sending { attributes: &["goal_id"], ..sending(element, Role::ActionServer, event, Way::Client) }
}

const SENDINGS: [Sending; 13] = [
    sending("ros_topic_publish", Role::Publisher, "topic_{}_msg", Way::Everyone),
    sending("ros_service_send_request", Role::Client, "srv_{}_request", Way::Request),
    sending("ros_service_send_response", Role::Server, "srv_{}_response", Way::Response),
    sending("ros_action_send_goal", Role::ActionClient, "action_{}_goal_handle", Way::Goal),
    sending("ros_action_send_cancel", Role::ActionClient, "action_{}_cancel_handle", Way::Goal),
    answer("ros_action_accept_goal", "action_{}_goal_accepted"),
    answer("ros_action_reject_goal", "action_{}_goal_rejected"),
    answer("ros_action_feedback", "action_{}_feedback"),
    Sending { code: Some(SUCCEEDED), ..answer("ros_action_succeed", "action_{}_result") },
    Sending { code: Some(ABORTED), ..answer("ros_action_aborted", "action_{}_result") },
    Sending { code: Some(CANCELED), ..answer("ros_action_canceled", "action_{}_result") },
    Sending {
        attributes: &["goal_id", "thread_id"],
        ..sending("ros_action_start_thread", Role::ActionServer, "action_{}_thread_start", Way::Thread)
    },
    sending("ros_action_thread_free", Role::ActionServer, "action_{}_thread_free", Way::Server),
];

impl Sending {
    pub(super) fn of(element: &str) -> Option<&'static Self> {
        SENDINGS.iter().find(|sending| sending.element == element)
    }
}

/// The event of an interface: `/go_to/goal` is `go_to__goal`, as AS2FM writes it.
pub(super) fn event(pattern: &str, interface: &str) -> String {
    pattern.replace("{}", &sanitized(interface))
}

pub(super) fn sanitized(interface: &str) -> String {
    interface.strip_prefix('/').unwrap_or(interface).replace('/', "__")
}

/// All elements that RoAML adds, for suggestions.
pub(super) fn elements() -> impl Iterator<Item = &'static str> {
    let others = ["bt_declare_port_in", "bt_declare_port_out", "bt_get_input", "bt_return_halted", "bt_return_status"];
    let more = ["bt_set_output", "field", "ros_action_thread", "target"];
    let reactions = REACTIONS.iter().map(|reaction| reaction.element);
    let sendings = SENDINGS.iter().map(|sending| sending.element);
    reactions.chain(sendings).chain(others).chain(more).chain(Role::ALL.map(Role::element))
}
