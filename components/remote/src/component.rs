//! The names and types of a component in ROS 2.

use interfaces::{FEEDBACK, Interface, Wire};
use ros_messages::is_name;

use crate::action;

/// The names and types of a component in ROS 2: one that consists of nodes, or one that is offered to nodes. They are
/// the same in both cases, so one such component can be the counterpart of the other.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RemoteComponent {
    /// The namespace of its services, topics and actions: empty, or `/robot`.
    namespace: String,
    pub(crate) services: Vec<RemoteOperation>,
    pub(crate) topics: Vec<RemoteOperation>,
    pub(crate) actions: Vec<RemoteOperation>,
}

/// A service, topic or action.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct RemoteOperation {
    /// Its name in the interface.
    pub(crate) name: String,
    /// Its type in ROS 2.
    pub(crate) wire: Wire,
    /// The names of the fields of each of its messages.
    pub(crate) fields: Vec<Vec<interfaces::Field>>,
}

impl RemoteComponent {
    /// The component with this interface in a namespace, such as `/robot` or `/`.
    ///
    /// # Errors
    /// All operations whose types in ROS 2 are not known, or whose names are not valid there, in words.
    pub fn new(namespace: &str, interface: &Interface) -> Result<Self, Vec<String>> {
        let mut unknown = Vec::new();
        let mut operation = |name: &str, wire: &Result<Wire, String>, fields: &[&Vec<interfaces::Field>]| {
            let fields = fields.iter().map(|fields| (*fields).clone()).collect();
            match wire {
                Ok(wire) if is_name(name) => {
                    return Some(RemoteOperation { name: name.to_owned(), wire: wire.clone(), fields });
                }
                Ok(_) => unknown.push(format!("`{name}` cannot be a name in ROS 2")),
                Err(why) => unknown.push(format!("the type of `{name}` in ROS 2 is not known: {why}")),
            }
            None
        };
        let services = interface.services.iter();
        let services =
            services.filter_map(|one| operation(&one.name, &one.wire, &[&one.request, &one.reply])).collect();
        let topics = interface.topics.iter();
        let topics = topics.filter_map(|one| operation(&one.name, &one.wire, &[&one.fields])).collect();
        let actions = interface.actions.iter();
        let actions = actions
            .filter_map(|one| operation(&one.name, &one.wire, &[&one.goal, &one.feedback, &one.result]))
            .collect();
        let namespace = namespace.trim_end_matches('/').to_owned();
        if unknown.is_empty() { Ok(Self { namespace, services, topics, actions }) } else { Err(unknown) }
    }

    pub(crate) fn full_name(&self, operation: &RemoteOperation) -> String {
        format!("{}/{}", self.namespace, operation.name)
    }

    /// Its services, including those of its actions: names, such as `/navigate_to_pose/_action/send_goal`, and types.
    pub fn services(&self) -> impl Iterator<Item = (String, String)> {
        let services = self.services.iter().map(|one| (self.full_name(one), one.wire.kind.clone()));
        services.chain(self.actions.iter().flat_map(|one| action::services(&self.full_name(one), &one.wire.kind)))
    }

    /// The topics that it publishes, including those of its actions' feedback: names and types.
    pub fn topics(&self) -> impl Iterator<Item = (String, String)> {
        let topics = self.topics.iter().map(|one| (self.full_name(one), one.wire.kind.clone()));
        let feedback =
            |one: &RemoteOperation| (action::feedback(&self.full_name(one)), action::feedback_kind(&one.wire.kind));
        topics.chain(self.actions.iter().map(feedback))
    }

    /// The first symbol of the channel messages for a topic, if it is one of its [topics](Self::topics).
    pub(crate) fn head(&self, topic: &str) -> Option<String> {
        let of_topic = self.topics.iter().find(|one| self.full_name(one) == topic).map(|one| one.name.clone());
        let action = self.actions.iter().find(|one| action::feedback(&self.full_name(one)) == topic);
        of_topic.or_else(|| Some(format!("{}.{FEEDBACK}", action?.name)))
    }

    /// The latched topics on which its actions publish the status of their goals: names and types.
    pub fn statuses(&self) -> impl Iterator<Item = (String, String)> {
        self.actions.iter().map(|one| (action::status(&self.full_name(one)), action::STATUS_KIND.to_owned()))
    }
}
