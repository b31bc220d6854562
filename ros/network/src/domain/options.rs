//! Which part of the network is joined.
//!
//! Source: OMG's DDSI-RTPS 2.5, 9.6.2.2 (ports).

use std::net::Ipv4Addr;

use serde::{Deserialize, Serialize};

/// The multicast address of discovery.
pub(super) const EVERYBODY: Ipv4Addr = Ipv4Addr::new(239, 255, 0, 1);

/// Which domain is joined, and how far discovery reaches.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Options {
    /// The number of the domain, from 0 to 232.
    pub domain: u16,
    /// Whether only participants on this machine are looked for.
    pub is_local: bool,
}

impl Options {
    /// The largest number of a domain: with larger ones, no port would be left.
    pub const LARGEST_DOMAIN: u16 = 232;

    /// The port of the domain's discovery by multicast, with which its other ports begin.
    pub(super) fn port(self) -> u32 {
        7400 + 250 * u32::from(self.domain)
    }
}

/// What in the environment of ROS 2 keeps a robot from being seen, each with what to do; `variable` returns a variable
/// of the environment.
#[must_use]
pub fn obstacles(variable: &dyn Fn(&str) -> Option<String>) -> Vec<String> {
    let is_set = |name: &str| variable(name).filter(|value| !value.is_empty());
    let mut found = Vec::new();
    let mut add = |name: &str, value: String, why: &str| found.push(format!("{name} is {value}: {why}"));
    if let Some(rmw) = is_set("RMW_IMPLEMENTATION").filter(|rmw| rmw.contains("zenoh")) {
        add("RMW_IMPLEMENTATION", rmw, "its nodes do not use DDS; watch them through a bridge, with `--foxglove`");
    }
    if let Some(peers) = is_set("ROS_STATIC_PEERS") {
        add(
            "ROS_STATIC_PEERS",
            peers,
            "hosts that multicast does not reach are not seen; watch them with `--foxglove`",
        );
    }
    if let Some(server) = is_set("ROS_DISCOVERY_SERVER") {
        add("ROS_DISCOVERY_SERVER", server, "nodes that only it knows are not seen; watch them with `--foxglove`");
    }
    if let Some(transports) = is_set("FASTDDS_BUILTIN_TRANSPORTS").filter(|names| !names.starts_with("DEFAULT")) {
        let why = "nodes that do not use UDP are not seen; start them with UDPv4 or DEFAULT";
        add("FASTDDS_BUILTIN_TRANSPORTS", transports, why);
    }
    if let Some(enabled) = is_set("ROS_SECURITY_ENABLE").filter(|enabled| enabled == "true") {
        add("ROS_SECURITY_ENABLE", enabled, "nodes with SROS 2 are not seen; watch them with `--foxglove`");
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_hides_a_robot_is_named() {
        let none = obstacles(&|_| None);
        assert!(none.is_empty());
        let all = obstacles(&|name| {
            Some(match name {
                "RMW_IMPLEMENTATION" => "rmw_zenoh_cpp".to_owned(),
                "ROS_SECURITY_ENABLE" => "true".to_owned(),
                "FASTDDS_BUILTIN_TRANSPORTS" => "SHM".to_owned(),
                _ => "robot.local".to_owned(),
            })
        });
        assert_eq!(all.len(), 5, "{all:?}");
        assert!(obstacles(&|_| Some(String::new())).is_empty());
    }
}
