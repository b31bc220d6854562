//! The simulated robot in a DDS domain, or several, each in a world of its own.

mod commands;
mod config;
mod exchange;
mod frames;
mod hub;
mod lifecycle;
mod navigation;
mod pace;
mod ros_robot;
mod topics;

use network::{Domain, Live as _};
use runs::Controller;
use scenarios::Error;
use scenarios::scenario::{OfferedComponents, Scenario};

pub use config::{PaceConfig, RobotConfig};
use hub::{Station, Wanted, stations};
use ros_robot::{RobotSetup, RosRobot};
use topics::Topics;

/// The controller of a robot, for the thread of its run.
pub type BoxedController = Box<dyn Controller + Send>;

/// The robots of a scenario as nodes of ROS 2, before they join a domain.
pub struct Robots {
    setup: RobotSetup,
    /// The names of their nodes, and of their topics.
    names: Vec<String>,
    topics: Vec<Topics>,
    /// Why components are not offered, in words.
    left_out: Vec<String>,
}

impl Robots {
    /// The scenario's robot, or one in each namespace, in their order.
    ///
    /// # Errors
    /// If names are missing or would be those of several things, a period is no multiple of the scenario's step, or the
    /// scenario has no robot to drive.
    pub fn of(config: RobotConfig, scenario: &Scenario) -> Result<Self, Error> {
        let spaces = config.spaces();
        if let Some((_, twice)) = spaces.iter().enumerate().find(|(place, space)| spaces[..*place].contains(space)) {
            return Err(Error::refused(format!("two robots would be in the namespace {twice}"), "give each its own"));
        }
        let OfferedComponents { offered, left_out } = scenario.offered();
        let topics = spaces.iter().map(|space| Topics::of(&config, space, &offered)).collect::<Result<Vec<_>, _>>()?;
        Topics::check(&topics)?;
        let names = spaces.iter().map(|space| format!("{space}/steward")).collect();
        Ok(Self { setup: RobotSetup::of(config, scenario)?, names, topics, left_out })
    }

    /// Joins a domain. `note` is called with what a user should know, then and later.
    ///
    /// # Errors
    /// If DDS fails.
    pub fn join(self, domain: network::Options, note: fn(&str)) -> Result<Vec<BoxedController>, Error> {
        let stations = self.enter(domain, note)?;
        self.left_out.iter().for_each(|why| note(why));
        let mut robots: Vec<BoxedController> = Vec::new();
        for ((station, topics), name) in stations.into_iter().zip(self.topics).zip(self.names) {
            note(&format!("the robot is the node {name}; commands are read from {}", topics.command));
            robots.push(Box::new(RosRobot::begin(&self.setup, station, topics)));
        }
        Ok(robots)
    }

    /// Enters the domain with their nodes, which subscribe to topics and offer services.
    fn enter(&self, domain: network::Options, note: fn(&str)) -> Result<Vec<Station>, Error> {
        let wanted = self.topics.iter().map(|topics| {
            let read = [Some(&topics.command), self.setup.config.localizes.then_some(&topics.initial_pose)];
            let services = topics.offered.services.keys().cloned().collect();
            Wanted { topics: read.into_iter().flatten().cloned().collect(), services }
        });
        let wanted: Vec<Wanted> = wanted.collect();
        let all = wanted.iter().flat_map(|wanted| wanted.topics.iter().cloned()).collect();
        let mut node = Domain::nodes(domain, self.names.clone(), false, all);
        let services = self.topics.iter().flat_map(|topics| &topics.offered.services);
        node.serve(services.map(|(name, (_, kind))| (name.clone(), kind.clone())).collect());
        node.begin().map_err(|error| Error::refused(error.to_string(), error.help()))?;
        stations(node, wanted, note).ok_or_else(|| Error::refused("the domain has been left", "start it again"))
    }
}
