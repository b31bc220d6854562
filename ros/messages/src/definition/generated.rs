//! The messages that ROS sends for services and actions.

use diagnostics::FileProblems;

use super::{Action, Message, Service};

impl Message {
    /// The messages that a file defines, by name: of a `.msg` file one, of others all that ROS makes for them. `name`
    /// is that of the file, without its ending `kind`.
    pub(crate) fn of_file(
        kind: &str,
        name: &str,
        title: &str,
        text: &str,
    ) -> Result<Vec<(String, Self)>, FileProblems> {
        Ok(match kind {
            "msg" => vec![(name.to_owned(), Self::parse(title, text)?)],
            "srv" => Service::parse(title, text)?.messages(name).to_vec(),
            _ => Action::parse(title, text)?.messages(name),
        })
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
