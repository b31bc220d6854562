//! Which robot is watched.

use std::collections::BTreeSet;

use campaigns::Error;
use clap::{Args, ValueEnum};
use network::{Bridge, Live};
use reports::html::quoted;

/// Which robot is watched, and how it is reached.
#[derive(Debug, Args)]
pub(super) struct TargetArgs {
    /// Listens to the robot's Foxglove bridge: `ws://HOST:8765` [default: to its nodes, by DDS]
    #[arg(long, value_name = "URL")]
    foxglove: Option<String>,
    /// The DDS domain of its nodes
    #[arg(long, value_name = "NUMBER", env = "ROS_DOMAIN_ID", hide_env_values = true, default_value_t = 0)]
    #[arg(value_parser = clap::value_parser!(u16).range(..=232))]
    domain: u16,
    /// How far to look for nodes
    #[arg(long, value_name = "RANGE", env = "ROS_AUTOMATIC_DISCOVERY_RANGE", hide_env_values = true)]
    #[arg(ignore_case = true, default_value = "subnet")]
    discovery_range: Range,
}

/// How far to look for nodes, as `ROS_AUTOMATIC_DISCOVERY_RANGE` says it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Range {
    /// As far as multicast reaches
    #[value(alias = "system_default")]
    Subnet,
    /// On this machine
    Localhost,
    /// Nowhere
    #[value(hide = true)]
    Off,
}

impl TargetArgs {
    /// Connects, for topics with these names, or for all.
    pub(super) fn connect(&self, topics: Option<BTreeSet<String>>) -> Result<Box<dyn Live>, Error> {
        match &self.foxglove {
            Some(address) => Ok(Box::new(Bridge::connect(address, topics).map_err(refused)?)),
            None => self.join(topics),
        }
    }

    #[cfg(feature = "dds")]
    fn join(&self, topics: Option<BTreeSet<String>>) -> Result<Box<dyn Live>, Error> {
        if self.discovery_range == Range::Off {
            let help = "without discovery, no node is found: `--discovery-range localhost`";
            return Err(Error::refused("ROS_AUTOMATIC_DISCOVERY_RANGE is OFF", help));
        }
        let is_local = self.discovery_range == Range::Localhost
            || std::env::var("ROS_LOCALHOST_ONLY").is_ok_and(|only| only == "1");
        network::obstacles(&|name| std::env::var(name).ok()).iter().for_each(|text| crate::output::note(text));
        Ok(Box::new(network::Domain::join(network::Options { domain: self.domain, is_local }, topics)))
    }

    #[cfg(not(feature = "dds"))]
    fn join(&self, _: Option<BTreeSet<String>>) -> Result<Box<dyn Live>, Error> {
        let help = "name a bridge, `--foxglove ws://HOST:8765`, or build with `cargo build --release --features dds`";
        Err(Error::refused("this program cannot join a DDS domain: it was built without the feature `dds`", help))
    }

    /// The robot, as reports name it.
    pub(super) fn name(&self) -> String {
        self.foxglove.clone().unwrap_or_else(|| format!("DDS domain {}", self.domain))
    }

    pub(super) fn about(&self) -> String {
        match &self.foxglove {
            Some(address) => format!("A robot, as the bridge at {address} told it"),
            None => format!("A robot whose nodes are in DDS domain {}", self.domain),
        }
    }

    /// The command that watches it.
    pub(super) fn command(&self) -> String {
        match &self.foxglove {
            Some(address) => format!("steward watch --foxglove {}", quoted(address)),
            None if self.discovery_range == Range::Localhost => {
                format!("steward watch --domain {} --discovery-range localhost", self.domain)
            }
            None => format!("steward watch --domain {}", self.domain),
        }
    }
}

pub(super) fn refused(error: network::Error) -> Error {
    Error::refused(error.to_string(), error.help())
}
