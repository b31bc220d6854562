//! Messages of Foxglove's WebSocket protocol, from the server and to it.
//!
//! <https://github.com/foxglove/ws-protocol/blob/main/docs/spec.md>

use bags::{Definition, Topic};
use serde::Deserialize;
use serde_json::json;

/// The subprotocols to offer: that of the SDK, and that of older servers. Their messages are the same.
pub(crate) const NAMES: &str = "foxglove.sdk.v1, foxglove.websocket.v1";

/// A text message of a server.
#[derive(Debug, Deserialize)]
#[serde(tag = "op", rename_all = "camelCase")]
pub(crate) enum ServerMessage {
    /// The first message.
    ServerInfo {
        #[serde(default)]
        name: String,
        #[serde(default)]
        capabilities: Vec<String>,
    },
    /// Further channels.
    Advertise { channels: Vec<Channel> },
    /// Channels that no longer exist.
    #[serde(rename_all = "camelCase")]
    Unadvertise { channel_ids: Vec<u64> },
    /// Services.
    AdvertiseServices { services: Vec<Service> },
    /// The changes of the nodes and of what they offer.
    #[serde(rename_all = "camelCase")]
    ConnectionGraphUpdate {
        #[serde(default)]
        published_topics: Vec<Publishers>,
        #[serde(default)]
        subscribed_topics: Vec<Subscribers>,
        #[serde(default)]
        advertised_services: Vec<Providers>,
    },
    /// A report of the server itself.
    Status { level: u8, message: String },
    /// Any other message. It is ignored.
    #[serde(other)]
    Other,
}

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

/// The capability of a server that reports nodes.
pub(crate) const GRAPH: &str = "connectionGraph";

/// The request for the nodes.
pub(crate) fn subscribe_graph() -> String {
    json!({ "op": "subscribeConnectionGraph" }).to_string()
}

/// The level from which on a status is an error.
pub(crate) const ERROR: u8 = 2;

/// A channel: a topic, in the terms of ROS.
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
    /// The topic. Older servers do not name the language of its definition: it is that of ROS 2.
    pub(crate) fn into_topic(self) -> Topic {
        let language = self.schema_encoding.unwrap_or_else(|| "ros2msg".to_owned());
        let definition = (!language.is_empty()).then_some(Definition { language, text: self.schema });
        Topic { name: self.topic, kind: self.schema_name, encoding: self.encoding, definition, hash: None }
    }
}

/// The request for the messages of channels. Each has the number that its subscription will have, and its own.
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
