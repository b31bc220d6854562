//! Which DDS domain is joined, and what keeps its nodes from being discovered.
//!
//! Source: OMG's DDSI-RTPS 2.5, 9.6.2.2 (ports).

use std::net::Ipv4Addr;

use serde::{Deserialize, Serialize};

/// The multicast address of discovery.
pub(super) const MULTICAST: Ipv4Addr = Ipv4Addr::new(239, 255, 0, 1);

/// A DDS domain, and how far discovery reaches.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Options {
    /// The number of the domain, from 0 to 232: greater ones would have no ports.
    pub domain: u16,
    /// Whether only participants on this machine are discovered.
    pub is_local: bool,
}

impl Options {
    /// The port of the domain's discovery by multicast. It is the first of the domain's ports.
    pub(super) fn port(self) -> u32 {
        7400 + 250 * u32::from(self.domain)
    }
}

/// The variables that name a file with profiles of Fast DDS: the first up to ROS 2 Jazzy, the second since then.
const PROFILES: [&str; 2] = ["FASTRTPS_DEFAULT_PROFILES_FILE", "FASTDDS_DEFAULT_PROFILES_FILE"];

/// The settings in profiles of Fast DDS and Cyclone DDS, without spaces, that keep nodes from being discovered.
const IN_PROFILES: [(&str, &str); 7] = [
    ("<initialPeersList>", "names peers: hosts that multicast does not reach are not seen"),
    ("<discoveryServersList>", "names discovery servers: nodes that only these know are not seen"),
    ("<useBuiltinTransports>false<", "chooses transports: nodes that do not use UDP are not seen"),
    ("<Peers>", "names peers: hosts that multicast does not reach are not seen"),
    ("<AllowMulticast>false<", "turns multicast off: nodes on other hosts are not seen"),
    ("<AllowMulticast>none<", "turns multicast off: nodes on other hosts are not seen"),
    ("<Security>", "turns security on: nodes with SROS 2 are not seen"),
];

/// What in the environment of ROS 2 keeps a robot from being discovered, each with a remedy. `variable` returns an
/// environment variable, and `read` the text of a file.
#[must_use]
pub fn obstacles(variable: &dyn Fn(&str) -> Option<String>, read: &dyn Fn(&str) -> Option<String>) -> Vec<String> {
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
        add(
            "ROS_DISCOVERY_SERVER",
            server,
            "nodes that are known only to it are not seen; watch them with `--foxglove`",
        );
    }
    // Options may follow the name of a transport.
    let is_seen = |names: &String| matches!(names.split('?').next(), Some("DEFAULT" | "UDPv4"));
    if let Some(transports) = is_set("FASTDDS_BUILTIN_TRANSPORTS").filter(|names| !is_seen(names)) {
        let why = "nodes that do not use UDP with IPv4 are not seen; start them with UDPv4 or DEFAULT";
        add("FASTDDS_BUILTIN_TRANSPORTS", transports, why);
    }
    if let Some(enabled) = is_set("ROS_SECURITY_ENABLE").filter(|enabled| enabled == "true") {
        add("ROS_SECURITY_ENABLE", enabled, "nodes with SROS 2 are not seen; watch them with `--foxglove`");
    }
    // Fast DDS reads one file. Cyclone DDS reads a list of files, or a text.
    let files = PROFILES.iter().filter_map(|name| Some((*name, read(&is_set(name)?)?)));
    let uri = is_set("CYCLONEDDS_URI").unwrap_or_default();
    let parts: Vec<&str> = if uri.contains('<') { vec![&uri] } else { uri.split(',').map(str::trim).collect() };
    let text =
        |part: &str| if part.contains('<') { Some(part.to_owned()) } else { read(part.trim_start_matches("file://")) };
    let texts = parts.into_iter().filter_map(|part| Some(("CYCLONEDDS_URI", text(part)?)));
    for (name, text) in files.chain(texts) {
        found.extend(hidden(&text).map(|why| format!("{name} {why}; watch them with `--foxglove`")));
    }
    found
}

/// What in the text of a profile keeps nodes from being discovered.
fn hidden(profiles: &str) -> impl Iterator<Item = &'static str> {
    let (mut text, mut rest) = (String::new(), profiles);
    while let Some((before, comment)) = rest.split_once("<!--") {
        text += before;
        rest = comment.split_once("-->").map_or("", |(_, after)| after);
    }
    text += rest;
    let text: String = text.split_whitespace().collect();
    IN_PROFILES.iter().filter(move |(what, _)| text.contains(what)).map(|(_, why)| *why)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variables_that_hide_a_robot_are_named() {
        let unread = |_: &str| None;
        let none = obstacles(&|_| None, &unread);
        assert!(none.is_empty());
        let all = obstacles(
            &|name| {
                Some(match name {
                    "RMW_IMPLEMENTATION" => "rmw_zenoh_cpp".to_owned(),
                    "ROS_SECURITY_ENABLE" => "true".to_owned(),
                    "FASTDDS_BUILTIN_TRANSPORTS" => "SHM".to_owned(),
                    _ => "robot.local".to_owned(),
                })
            },
            &unread,
        );
        assert_eq!(all.len(), 5, "{all:?}");
        assert!(obstacles(&|_| Some(String::new()), &unread).is_empty());
    }

    #[test]
    fn only_unsupported_transports_hide_a_robot() {
        let set = |value: &'static str| {
            obstacles(&|name| (name == "FASTDDS_BUILTIN_TRANSPORTS").then(|| value.to_owned()), &|_| None).len()
        };
        for seen in ["DEFAULT", "UDPv4", "UDPv4?max_msg_size=1MB", ""] {
            assert_eq!(set(seen), 0, "{seen}");
        }
        for hidden in ["SHM", "LARGE_DATA", "LARGE_DATA?non_blocking=true", "UDPv6", "DEFAULTv6", "TCPv4", "NONE"] {
            assert_eq!(set(hidden), 1, "{hidden}");
        }
    }

    #[test]
    fn profiles_that_hide_a_robot_are_named() {
        let named = |variable: &'static str, value: &'static str, text: &'static str| {
            let read = move |path: &str| (path == "/profiles.xml").then(|| text.to_owned());
            obstacles(&|name| (name == variable).then(|| value.to_owned()), &read)
        };
        let servers = "<profiles><x><!-- <initialPeersList> --><discoveryServersList>\n <RemoteServer/></x></profiles>";
        for variable in PROFILES {
            let [one] = &named(variable, "/profiles.xml", servers)[..] else { panic!("one obstacle") };
            assert!(one.starts_with(variable) && one.contains("names discovery servers"), "{one}");
            assert!(named(variable, "/none.xml", servers).is_empty());
            assert!(named(variable, "/profiles.xml", "<profiles/>").is_empty());
        }
        let cyclone = "<CycloneDDS><Domain><General><AllowMulticast> false </AllowMulticast></General>\
                       <Discovery><Peers><Peer address=\"robot\"/></Peers></Discovery></Domain></CycloneDDS>";
        for value in [cyclone, "file:///profiles.xml", "/none.xml,file:///profiles.xml"] {
            assert_eq!(named("CYCLONEDDS_URI", value, cyclone).len(), 2, "{value}");
        }
        assert!(named("CYCLONEDDS_URI", "<CycloneDDS/>", cyclone).is_empty());
    }
}
