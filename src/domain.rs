//! The DDS domain to join.

use clap::{Args, Parser, ValueEnum};
#[cfg(feature = "dds")]
use network::Options;
#[cfg(feature = "dds")]
use scenarios::Error;

/// The message of a program that cannot join one, and its help.
#[cfg(not(feature = "dds"))]
pub(crate) const WITHOUT: &str = "this program cannot join a DDS domain: it was built without the feature `dds`";
#[cfg(not(feature = "dds"))]
pub(crate) const HOW: &str = "build it with `cargo build --release --features dds`";

/// The last domain. Higher numbers would need ports that do not exist.
#[cfg(feature = "dds")]
const LAST_DOMAIN: u16 = 232;

/// Which DDS domain is joined, and how far it reaches.
#[derive(Clone, Debug, Args)]
pub(crate) struct DomainArgs {
    /// The DDS domain of the robot's nodes
    #[arg(id = "domain", long = "domain", value_name = "NUMBER", env = "ROS_DOMAIN_ID", hide_env_values = true)]
    #[arg(default_value = "0")]
    pub(crate) number: String,
    /// How far to look for nodes
    #[arg(long, value_name = "RANGE", env = "ROS_AUTOMATIC_DISCOVERY_RANGE", hide_env_values = true)]
    #[arg(ignore_case = true, default_value = "subnet")]
    discovery_range: Range,
}

/// How far to look for nodes, as in `ROS_AUTOMATIC_DISCOVERY_RANGE`.
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

/// The values of the environment, as without arguments.
impl Default for DomainArgs {
    fn default() -> Self {
        #[derive(Parser)]
        struct Alone {
            #[command(flatten)]
            domain: DomainArgs,
        }
        Alone::try_parse_from([""])
            .map_or(Self { number: "0".to_owned(), discovery_range: Range::Subnet }, |alone| alone.domain)
    }
}

impl DomainArgs {
    /// The options for joining it. Notes what may prevent discovery.
    #[cfg(feature = "dds")]
    pub(crate) fn options(&self) -> Result<Options, Error> {
        // An empty environment variable counts as unset.
        let number = if self.number.is_empty() { Ok(0) } else { self.number.parse() };
        let Some(domain) = number.ok().filter(|number| *number <= LAST_DOMAIN) else {
            let message = format!("there is no DDS domain `{}`", self.number);
            return Err(Error::refused(message, format!("the domains are 0 to {LAST_DOMAIN}")));
        };
        if self.discovery_range == Range::Off {
            let help = "without discovery, no node is found: `--discovery-range localhost`";
            return Err(Error::refused("ROS_AUTOMATIC_DISCOVERY_RANGE is OFF", help));
        }
        let is_local = self.discovery_range == Range::Localhost
            || std::env::var("ROS_LOCALHOST_ONLY").is_ok_and(|only| only == "1");
        let (variable, read) = (|name: &str| std::env::var(name).ok(), |path: &str| std::fs::read_to_string(path).ok());
        network::obstacles(&variable, &read).iter().for_each(|text| crate::output::note(text));
        Ok(Options { domain, is_local })
    }

    /// The domain as options of a command.
    pub(crate) fn words(&self) -> String {
        let range = if self.discovery_range == Range::Localhost { " --discovery-range localhost" } else { "" };
        format!("--domain {}{range}", self.number)
    }
}
