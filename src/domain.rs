//! Which DDS domain is joined.

#[cfg(feature = "dds")]
use campaigns::Error;
use clap::{Args, Parser, ValueEnum};

/// What is wrong with a program that cannot join one.
#[cfg(not(feature = "dds"))]
pub(crate) const WITHOUT: &str = "this program cannot join a DDS domain: it was built without the feature `dds`";
#[cfg(not(feature = "dds"))]
pub(crate) const HOW: &str = "build it with `cargo build --release --features dds`";

/// Which DDS domain is joined, and how far it reaches.
#[derive(Clone, Debug, Args)]
pub(crate) struct DomainArgs {
    /// The DDS domain of the robot's nodes
    #[arg(id = "domain", long = "domain", value_name = "NUMBER", env = "ROS_DOMAIN_ID", hide_env_values = true)]
    #[arg(default_value_t = 0, value_parser = clap::value_parser!(u16).range(..=232))]
    pub(crate) number: u16,
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

/// As without arguments: what the environment says.
impl Default for DomainArgs {
    fn default() -> Self {
        #[derive(Parser)]
        struct Alone {
            #[command(flatten)]
            domain: DomainArgs,
        }
        Alone::try_parse_from([""]).map_or(Self { number: 0, discovery_range: Range::Subnet }, |alone| alone.domain)
    }
}

impl DomainArgs {
    /// How to join it. Says what may be in the way.
    #[cfg(feature = "dds")]
    pub(crate) fn options(&self) -> Result<network::Options, Error> {
        if self.discovery_range == Range::Off {
            let help = "without discovery, no node is found: `--discovery-range localhost`";
            return Err(Error::refused("ROS_AUTOMATIC_DISCOVERY_RANGE is OFF", help));
        }
        let is_local = self.discovery_range == Range::Localhost
            || std::env::var("ROS_LOCALHOST_ONLY").is_ok_and(|only| only == "1");
        network::obstacles(&|name| std::env::var(name).ok()).iter().for_each(|text| crate::output::note(text));
        Ok(network::Options { domain: self.number, is_local })
    }

    /// As words of a command.
    pub(crate) fn words(&self) -> String {
        let range = if self.discovery_range == Range::Localhost { " --discovery-range localhost" } else { "" };
        format!("--domain {}{range}", self.number)
    }
}
