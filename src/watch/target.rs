//! Which robot is watched.

use std::collections::BTreeSet;

use campaigns::Error;
use clap::Args;
use network::{Bridge, Live};
use reports::html::quoted;

use crate::domain::DomainArgs;
#[cfg(not(feature = "dds"))]
use crate::domain::WITHOUT;

/// Which robot is watched, and how it is reached.
#[derive(Debug, Args)]
pub(super) struct TargetArgs {
    /// Listens to the robot's Foxglove bridge: `ws://HOST:8765` [default: to its nodes, by DDS]
    #[arg(long, value_name = "URL")]
    foxglove: Option<String>,
    #[command(flatten)]
    domain: DomainArgs,
}

impl TargetArgs {
    /// Connects to the robot, for topics with these names, or for all.
    pub(super) fn connect(&self, topics: Option<BTreeSet<String>>) -> Result<Box<dyn Live>, Error> {
        match &self.foxglove {
            Some(address) => Ok(Box::new(Bridge::connect(address, topics).map_err(refused)?)),
            None => self.join(topics),
        }
    }

    #[cfg(feature = "dds")]
    fn join(&self, topics: Option<BTreeSet<String>>) -> Result<Box<dyn Live>, Error> {
        Ok(Box::new(network::Domain::join(self.domain.options()?, topics)))
    }

    #[cfg(not(feature = "dds"))]
    fn join(&self, _: Option<BTreeSet<String>>) -> Result<Box<dyn Live>, Error> {
        let help = "name a bridge, `--foxglove ws://HOST:8765`, or build with `cargo build --release --features dds`";
        Err(Error::refused(WITHOUT, help))
    }

    /// The robot, as reports name it.
    pub(super) fn name(&self) -> String {
        self.foxglove.clone().unwrap_or_else(|| format!("DDS domain {}", self.domain.number))
    }

    pub(super) fn about(&self) -> String {
        match &self.foxglove {
            Some(address) => format!("A robot, as forwarded by the bridge at {address}"),
            None => format!("A robot whose nodes are in DDS domain {}", self.domain.number),
        }
    }

    /// The problem if nothing is known of the robot, and the likely reasons.
    pub(super) fn absence(&self) -> [String; 2] {
        if let Some(address) = &self.foxglove {
            let why = format!(
                "the robot's nodes do not run, or the bridge does not see them: it may be in another domain, or its \
                 `topic_whitelist` leaves them out. `steward watch --foxglove {} --list` shows what it offers",
                quoted(address)
            );
            return [format!("the bridge at {address} offers none of the topics"), why];
        }
        let what = format!("nothing is known of a robot in DDS domain {}: no node, no topic", self.domain.number);
        let why = "the robot's nodes do not run, or are in another domain (their ROS_DOMAIN_ID; here `--domain`); they are \
                   on another host or in a container that multicast does not reach, or are set to stay on their own \
                   (ROS_AUTOMATIC_DISCOVERY_RANGE, ROS_LOCALHOST_ONLY); or they use only shared memory \
                   (FASTDDS_BUILTIN_TRANSPORTS=SHM), a discovery server (ROS_DISCOVERY_SERVER), SROS 2 or zenoh. A \
                   bridge sees them in any case: `--foxglove ws://HOST:8765`";
        [what, why.to_owned()]
    }

    /// The command that watches the robot.
    pub(super) fn command(&self) -> String {
        match &self.foxglove {
            Some(address) => format!("steward watch --foxglove {}", quoted(address)),
            None => format!("steward watch {}", self.domain.words()),
        }
    }
}

pub(super) fn refused(error: network::Error) -> Error {
    Error::refused(error.to_string(), error.help())
}
