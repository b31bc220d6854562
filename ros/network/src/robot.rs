//! Robots that run, and what they tell of themselves beside their topics.

use std::collections::{BTreeMap, BTreeSet};

use bags::Source;

use crate::Error;

/// What the names of an action's topics and services have after its own.
const ACTION: &str = "/_action/";

/// The most names of a kind.
const MOST: usize = 10_000;

/// A robot that runs, as a source of messages.
pub trait Live: Source {
    /// Who tells of the robot, in words.
    fn name(&self) -> &str;

    /// What the robot tells beside its topics.
    fn robot(&self) -> &Robot;

    /// These of the wanted topics are only shown: no verdict depends on what is missing there.
    fn only_show(&mut self, topics: BTreeSet<String>);

    /// Messages count from here on. What is latched comes again, if it has come before.
    ///
    /// # Errors
    /// If the robot cannot be reached.
    fn begin(&mut self) -> Result<(), Error>;

    /// What publishes the standing of properties among the robot's nodes; none if nothing can be published there.
    fn publisher(&self) -> Option<Publish> {
        None
    }
}

/// Publishes the standing of all properties.
pub type Publish = Box<dyn FnMut(&[Standing])>;

/// The standing of a property, as `diagnostic_msgs/msg/DiagnosticStatus` tells it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Standing {
    /// The name of the property.
    pub property: String,
    /// How bad it is.
    pub level: Level,
    /// The verdict, in words.
    pub message: String,
    /// What else is known, each by its name.
    pub values: Vec<(&'static str, String)>,
}

/// How bad something is, as `diagnostic_msgs/msg/DiagnosticStatus` numbers it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// Nothing is wrong.
    Ok = 0,
    /// Something may be wrong, or was.
    Warn = 1,
    /// Something is wrong.
    Error = 2,
}

/// What a robot tells of itself beside its topics, as far as it is known.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Robot {
    /// The names of its nodes.
    pub nodes: BTreeSet<String>,
    /// How many of its participants have nodes, and have not said which.
    pub unnamed: usize,
    /// Its actions, with their types.
    pub actions: BTreeMap<String, Option<String>>,
    /// Its services, with their types.
    pub services: BTreeMap<String, Option<String>>,
    /// Who publishes on its topics, and with which quality of service, in words.
    pub publishers: BTreeMap<String, String>,
}

impl Robot {
    /// Takes note of a service, or of the action that a name belongs to.
    pub(crate) fn name(&mut self, name: &str, kind: Option<String>) {
        let (names, name) = match name.split_once(ACTION) {
            Some((action, _)) => (&mut self.actions, action),
            None => (&mut self.services, name),
        };
        if names.len() < MOST || names.contains_key(name) {
            let known = names.entry(name.to_owned()).or_default();
            *known = known.take().or(kind);
        }
    }

    /// Takes note of nodes.
    pub(crate) fn add_nodes(&mut self, nodes: impl IntoIterator<Item = String>) {
        let room = MOST.saturating_sub(self.nodes.len());
        self.nodes.extend(nodes.into_iter().take(room));
    }
}

/// Whether a topic or service belongs to an action.
pub(crate) fn is_of_action(name: &str) -> bool {
    name.contains(ACTION)
}
