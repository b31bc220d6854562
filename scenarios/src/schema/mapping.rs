//! The keys of a file that maps the messages of a bag to messages of channels.

use serde_json::{Value, json};

use super::{Key, json_schema, list, number, or, scalar, seconds, some_seconds, table, text, with};

/// The JSON schema of a mapping file.
#[must_use]
pub fn schema() -> Value {
    json_schema("A mapping of a bag for steward", json!({}), &keys())
}

/// All keys of a mapping file.
#[must_use]
pub fn keys() -> Vec<Key> {
    let words = |takes: Value, words: &str| with(takes, json!({ "title": words }));
    let time = || words(text(), "`log`, `publish`, or the path of a stamp in the message, such as `header.stamp`");
    vec![
        Key::new(
            "tick_s",
            "Time between ticks, in seconds. The first tick comes with the first mapped message.",
            or(some_seconds(), 1),
        ),
        Key::new(
            "time",
            "The time of a message: when it was recorded, when it was sent, or the value of a field.",
            or(time(), "log"),
        ),
        Key::new(
            "reorder_s",
            "How long to wait for messages that arrive late, in seconds. Messages that arrive even later get the time \
             of the message before them.",
            or(seconds(), 1),
        ),
        Key::new(
            "definitions",
            "Folders with ROS packages, such as `/opt/ros/jazzy/share`, for types that the bag does not define.",
            list("an array of strings, relative to this file", &text()),
        ),
        Key::new("messages[]", "The messages that travel on a channel.", table(json!({}))).required(),
        Key::new("messages[].topic", "The topic; also one of a service or an action: `/go/_action/status`.", text())
            .required(),
        Key::new("messages[].from", "The process that sends.", text()).required(),
        Key::new("messages[].to", "The process that receives.", text()).required(),
        Key::new("messages[].fields", "The fields of the channel's message, in order, each with its source.", fields())
            .required(),
        Key::new(
            "messages[].where",
            "Only messages in which each of these paths has this value, or one of these values.",
            tests(),
        ),
        Key::new("messages[].time", "Like `time`, for these messages.", time()),
        Key::new("messages[].about", "A description of the messages. The program does not use it.", text()),
    ]
}

fn fields() -> Value {
    let symbols = json!({ "type": "object", "additionalProperties": text() });
    let of_path = json!({ "path": text(), "symbols": symbols, "scale": number(-1e300, 1e300) });
    let form = |required: &str, properties: Value| json!({ "type": "object", "additionalProperties": false, "required": [required], "properties": properties });
    let forms = [
        text(),
        form("path", of_path),
        form("symbol", json!({ "symbol": text() })),
        form("value", json!({ "value": scalar() })),
    ];
    let words = "a table: each field with the path of a field in the topic's message, or with a table that has `path` \
                 and, if need be, `symbols` or `scale`, or that has `symbol` or `value` for a constant";
    json!({ "title": words, "type": ["object"], "additionalProperties": { "anyOf": forms } })
}

fn tests() -> Value {
    let words = "a table: each path with a string, a number, true or false, or with an array of these";
    let one_or_several = json!({ "anyOf": [scalar(), { "type": "array", "items": scalar() }] });
    json!({ "title": words, "type": ["object"], "additionalProperties": one_or_several })
}
