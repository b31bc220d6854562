//! Names and types of ROS 2, as they are in DDS.
//!
//! <https://design.ros2.org/articles/topic_and_service_names.html>

/// What a DDS topic is in ROS 2, with the name of the topic or service.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum RosName {
    Topic(String),
    Request(String),
    Reply(String),
}

impl RosName {
    /// None if the topic does not belong to ROS 2.
    pub(super) fn of(topic: &str) -> Option<Self> {
        let (prefix, name) = topic.split_once('/')?;
        let name = format!("/{name}");
        let service = |suffix| name.strip_suffix(suffix).filter(|name| name.len() > 1).map(str::to_owned);
        match prefix {
            "rt" => Some(Self::Topic(name)),
            "rq" => service("Request").map(Self::Request),
            "rr" => service("Reply").map(Self::Reply),
            _ => None,
        }
    }
}

/// The DDS topic of a topic.
pub(super) fn topic(name: &str) -> String {
    format!("rt{name}")
}

/// The DDS topic of the requests to a service.
pub(super) fn request(service: &str) -> String {
    format!("rq{service}Request")
}

/// The DDS topic of the responses of a service.
pub(super) fn reply(service: &str) -> String {
    format!("rr{service}Reply")
}

/// The type of messages: `std_msgs/msg/String` for `std_msgs::msg::dds_::String_`. Other names stay as they are.
pub(super) fn kind(name: &str) -> String {
    let short = name.strip_suffix('_').map(|name| name.replace("::dds_::", "/").replace("::", "/"));
    short.unwrap_or_else(|| name.to_owned())
}

/// The DDS type of messages: `std_msgs::msg::dds_::String_` for `std_msgs/msg/String`.
pub(super) fn dds_kind(kind: &str) -> String {
    let (package, name) = kind.rsplit_once('/').unwrap_or(("", kind));
    format!("{}::dds_::{name}_", package.replace('/', "::"))
}

/// The DDS type of the requests to a service.
pub(super) fn request_kind(service_kind: &str) -> String {
    dds_kind(&format!("{service_kind}_Request"))
}

/// The DDS type of the responses of a service.
pub(super) fn response_kind(service_kind: &str) -> String {
    dds_kind(&format!("{service_kind}_Response"))
}

/// The type of a service or an action: the type of one of its parts, without the suffix of the part.
pub(super) fn whole(part: &str, suffixes: &[&str]) -> Option<String> {
    let kind = kind(part);
    suffixes.iter().find_map(|suffix| kind.strip_suffix(suffix)).map(str::to_owned)
}

/// The hash of a publisher's type, from its user data.
pub(super) fn hash(user_data: &[u8]) -> Option<String> {
    let text = str::from_utf8(user_data).ok()?;
    let hash = text.split([';', '\0']).find_map(|part| part.strip_prefix("typehash="))?;
    hash.starts_with("RIHS01_").then(|| hash.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_ros() {
        let topic = |name: &str| RosName::Topic(name.to_owned());
        assert_eq!(RosName::of("rt/a/b"), Some(topic("/a/b")));
        assert_eq!(RosName::of("rq/a/bRequest"), Some(RosName::Request("/a/b".to_owned())));
        assert_eq!(RosName::of("rr/a/bReply"), Some(RosName::Reply("/a/b".to_owned())));
        for other in ["ros_discovery_info", "rq/Request", "rq/a", "rr/aRequest", "", "/", "rs/a"] {
            assert_eq!(RosName::of(other), None, "{other}");
        }
        assert_eq!(super::topic("/a/b"), "rt/a/b");
    }

    #[test]
    fn types_of_ros() {
        assert_eq!(kind("std_msgs::msg::dds_::String_"), "std_msgs/msg/String");
        assert_eq!(kind("Other"), "Other");
        let request = "std_srvs::srv::dds_::Trigger_Request_";
        assert_eq!(whole(request, &["_Request", "_Response"]).as_deref(), Some("std_srvs/srv/Trigger"));
        assert_eq!(whole("Other", &["_Request"]), None);
    }

    #[test]
    fn hashes_are_read_from_user_data() {
        assert_eq!(hash(b"typehash=RIHS01_ab;").as_deref(), Some("RIHS01_ab"));
        assert_eq!(hash(b"enclave=/;typehash=RIHS01_ab;\0").as_deref(), Some("RIHS01_ab"));
        for other in [&b""[..], b"typehash=", b"typehash=RIHS02_ab;", b"\xff"] {
            assert_eq!(hash(other), None);
        }
    }
}
