//! The configuration of the robots.

use bags::Remapping;

/// What the robots of a scenario are called in a domain, what they do there, and how time passes for them.
#[derive(Clone, Debug)]
pub struct RobotConfig {
    /// The namespaces of their nodes and topics, such as `/r1`: there is a robot in each, or a single one outside of
    /// namespaces.
    pub namespaces: Vec<String>,
    /// Other names of topics, services and actions, as in ROS 2.
    pub remapped: Vec<Remapping>,
    /// Other names of frames: from, to.
    pub frames: Vec<(String, String)>,
    /// Whether their own software localizes them: their estimated poses are published.
    pub localizes: bool,
    /// Whether their own software drives them to the goals of clients of `navigate_to_pose`.
    pub navigates: bool,
    /// Whether they publish the map.
    pub publishes_map: bool,
    /// How time passes.
    pub pace: PaceConfig,
}

impl RobotConfig {
    /// The namespace of each robot, empty if it is outside of namespaces.
    pub(super) fn spaces(&self) -> Vec<&str> {
        if self.namespaces.is_empty() { vec![""] } else { self.namespaces.iter().map(String::as_str).collect() }
    }
}

/// How simulated time passes.
#[derive(Clone, Copy, Debug)]
pub enum PaceConfig {
    /// So many simulated seconds in a second, above 0; infinite for as many as possible.
    Steady {
        /// Simulated seconds in a second.
        speed: f64,
    },
    /// In periods, of which each begins once its command has come.
    LockStep {
        /// The simulated time between two commands, in seconds: a multiple of the scenario's step.
        period_s: f64,
        /// How long to wait for a command, in seconds.
        deadline_s: f64,
    },
}
