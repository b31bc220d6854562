//! The keys of an interface file.

use interfaces::{KEYS, KINDS};
use serde_json::{Map, Value, json};

use super::{Key, json_schema, list, table, text, with};

/// The tables of an interface file, and the meaning of each.
const TABLES: [(&str, &str, &str); 3] = [
    ("services", "The services, topics and actions of the component.", "A service: a request, and one reply."),
    ("topics", "The topics that the component publishes.", "A topic: messages to all that read it."),
    ("actions", "The actions of the component.", "An action: a goal, feedback on the way, and a result."),
];

/// The key of a ROS definition.
const ROS: &str = "ros";

/// The JSON schema of an interface file.
#[must_use]
pub fn schema() -> Value {
    json_schema("An interface of steward", json!({}), &keys())
}

/// All keys of an interface file.
#[must_use]
pub fn keys() -> Vec<Key> {
    let tables = TABLES.into_iter().flat_map(|(name, all, one)| {
        let parts = KEYS.iter().filter_map(move |key| key.path.strip_prefix(name)?.strip_prefix(".NAME."));
        let of_parts = |takes: Value| {
            let parts = parts.clone().filter(|part| *part != ROS);
            let parts: Map<String, Value> = parts.map(|part| (part.to_owned(), takes.clone())).collect();
            json!({ "properties": parts })
        };
        let rules = json!({ "if": { "required": [ROS] }, "then": of_parts(selection()), "else": of_parts(kinds()) });
        [Key::new(name, all, table(json!({}))), Key::new(&format!("{name}.NAME"), one, table(rules))]
    });
    tables.chain(KEYS.iter().map(|key| Key::new(key.path, key.about, takes(key)))).collect()
}

fn takes(key: &interfaces::Key) -> Value {
    match key.path.rsplit('.').next() {
        Some("packages") => list(key.takes, &text()),
        Some(ROS) => with(text(), json!({ "title": key.takes })),
        _ => json!({ "title": key.takes, "type": ["object", "array"] }),
    }
}

/// Fields with their kinds.
fn kinds() -> Value {
    let names: Vec<String> = KINDS.iter().flat_map(|(kind, _)| [(*kind).to_owned(), format!("{kind}?")]).collect();
    let symbols = json!({ "type": "array", "items": text(), "minItems": 1 });
    json!({ "type": "object", "additionalProperties": { "anyOf": [{ "enum": names }, symbols] } })
}

/// Fields from a ROS definition.
fn selection() -> Value {
    json!({ "anyOf": [{ "type": "array", "items": text() }, { "type": "object", "additionalProperties": text() }] })
}
