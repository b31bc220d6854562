//! Running robots, and what is known of them beside the messages on their topics.

use std::collections::{BTreeMap, BTreeSet};

use bags::Source;

use crate::Error;

/// What follows an action's name in the names of its topics and services.
const ACTION: &str = "/_action/";

/// The most names of each kind.
const MOST: usize = 10_000;

/// A running robot as a source of messages.
pub trait Live: Source {
    /// The name of what the messages are received from, such as a bridge.
    fn name(&self) -> &str;

    /// What is known of the robot beside its messages.
    fn robot(&self) -> &Robot;

    /// No verdict depends on these of the wanted topics: losses there do not matter.
    fn only_show(&mut self, topics: BTreeSet<String>);

    /// Messages count from now on. Latched messages that have been received before are received again.
    ///
    /// # Errors
    /// If the robot cannot be reached.
    fn begin(&mut self) -> Result<(), Error>;

    /// Publishes the statuses of properties among the robot's nodes. None if nothing can be published there.
    fn status_publisher(&self) -> Option<Publish> {
        None
    }
}

/// Publishes the statuses of all properties.
pub type Publish = Box<dyn FnMut(&[PropertyStatus])>;

/// The status of a property, as in `diagnostic_msgs/msg/DiagnosticStatus`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PropertyStatus {
    /// The name of the property.
    pub property: String,
    /// Its severity.
    pub level: Level,
    /// The verdict, in words.
    pub message: String,
    /// Further values, by their names.
    pub values: Vec<(&'static str, String)>,
}

/// A severity, with its number in `diagnostic_msgs/msg/DiagnosticStatus`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// Nothing is wrong.
    Ok = 0,
    /// Something may be wrong, or was.
    Warn = 1,
    /// Something is wrong.
    Error = 2,
}

/// What is known of a robot beside its messages.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Robot {
    /// The names of its nodes.
    pub nodes: BTreeSet<String>,
    /// The number of its participants that have nodes and have not listed them.
    pub unnamed: usize,
    /// Its actions, with their types as far as these are known.
    pub actions: BTreeMap<String, Option<String>>,
    /// Its services, with their types as far as these are known.
    pub services: BTreeMap<String, Option<String>>,
    /// The number of publishers on each topic and their quality of service, in words.
    pub publishers: BTreeMap<String, String>,
}

impl Robot {
    /// Adds a service, or the action to which the name belongs.
    pub(crate) fn add_name(&mut self, name: &str, kind: Option<String>) {
        let (names, name) = match name.split_once(ACTION) {
            Some((action, _)) => (&mut self.actions, action),
            None => (&mut self.services, name),
        };
        if names.len() < MOST || names.contains_key(name) {
            let known = names.entry(name.to_owned()).or_default();
            *known = known.take().or(kind);
        }
    }

    pub(crate) fn add_nodes(&mut self, nodes: impl IntoIterator<Item = String>) {
        let room = MOST.saturating_sub(self.nodes.len());
        self.nodes.extend(nodes.into_iter().take(room));
    }
}

/// Whether a topic or service belongs to an action.
pub(crate) fn is_of_action(name: &str) -> bool {
    name.contains(ACTION)
}
