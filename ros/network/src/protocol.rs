//! What a server of Foxglove's WebSocket protocol says, and what its client asks for.
//!
//! <https://github.com/foxglove/ws-protocol/blob/main/docs/spec.md>

use bags::{Definition, Topic};
use serde::Deserialize;
use serde_json::json;

/// The subprotocols to offer: the SDK's name, and that of older servers. The messages are the same.
pub(crate) const NAMES: &str = "foxglove.sdk.v1, foxglove.websocket.v1";

/// What a server says in a text.
#[derive(Debug, Deserialize)]
#[serde(tag = "op", rename_all = "camelCase")]
pub(crate) enum Said {
    /// The first message of all.
    ServerInfo {
        #[serde(default)]
        name: String,
        #[serde(default)]
        capabilities: Vec<String>,
    },
    /// Further channels.
    Advertise { channels: Vec<Channel> },
    /// Channels that are no more.
    #[serde(rename_all = "camelCase")]
    Unadvertise { channel_ids: Vec<u64> },
    /// Services.
    AdvertiseServices { services: Vec<Service> },
    /// Which nodes there are, and what they offer; what it does not mention is as before.
    #[serde(rename_all = "camelCase")]
    ConnectionGraphUpdate {
        #[serde(default)]
        published_topics: Vec<Publishers>,
        #[serde(default)]
        subscribed_topics: Vec<Subscribers>,
        #[serde(default)]
        advertised_services: Vec<Providers>,
    },
    /// What it wants to be known.
    Status { level: u8, message: String },
    /// Whatever a listener need not know.
    #[serde(other)]
    Other,
}

/// A service.
#[derive(Debug, Deserialize)]
pub(crate) struct Service {
    pub(crate) name: String,
    #[serde(rename = "type")]
    pub(crate) kind: String,
}

/// The nodes that publish on a topic.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Publishers {
    pub(crate) name: String,
    pub(crate) publisher_ids: Vec<String>,
}

/// The nodes that subscribe to a topic.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Subscribers {
    pub(crate) subscriber_ids: Vec<String>,
}

/// The nodes that offer a service.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Providers {
    pub(crate) name: String,
    pub(crate) provider_ids: Vec<String>,
}

/// The capability of a server that knows nodes.
pub(crate) const GRAPH: &str = "connectionGraph";

/// The request for the nodes.
pub(crate) fn subscribe_graph() -> String {
    json!({ "op": "subscribeConnectionGraph" }).to_string()
}

/// A status of this level, or of a higher one, is an error.
pub(crate) const ERROR: u8 = 2;

/// A channel, which is a topic in our words.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Channel {
    pub(crate) id: u64,
    topic: String,
    encoding: String,
    schema_name: String,
    #[serde(default)]
    schema: String,
    schema_encoding: Option<String>,
}

impl Channel {
    /// The topic. Older servers do not say in which language they define it: ROS 2's is meant.
    pub(crate) fn into_topic(self) -> Topic {
        let language = self.schema_encoding.unwrap_or_else(|| "ros2msg".to_owned());
        let definition = (!language.is_empty()).then_some(Definition { language, text: self.schema });
        Topic { name: self.topic, kind: self.schema_name, encoding: self.encoding, definition, hash: None }
    }
}

/// The request for the messages of channels: each with the number by which they will be known, and its own.
pub(crate) fn subscribe(subscriptions: &[(u32, u64)]) -> String {
    let all = subscriptions.iter().map(|(id, channel)| json!({ "id": id, "channelId": channel }));
    json!({ "op": "subscribe", "subscriptions": all.collect::<Vec<_>>() }).to_string()
}

/// A message on a channel.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Data<'b> {
    pub(crate) subscription: u32,
    /// The server's stamp, in nanoseconds.
    pub(crate) sent_ns: u64,
    pub(crate) body: &'b [u8],
}

impl<'b> Data<'b> {
    /// The message in a binary frame, if there is one.
    pub(crate) fn of(frame: &'b [u8]) -> Option<Self> {
        const MESSAGE_DATA: u8 = 1;
        let (opcode, frame) = frame.split_first()?;
        let (subscription, frame) = frame.split_first_chunk()?;
        let (sent_ns, body) = frame.split_first_chunk()?;
        let (subscription, sent_ns) = (u32::from_le_bytes(*subscription), u64::from_le_bytes(*sent_ns));
        (*opcode == MESSAGE_DATA).then_some(Self { subscription, sent_ns, body })
    }
}
