//! The rules of an entry of `[[faults]]`, as JSON Schema.

use diagnostics::document::Key;
use serde_json::{Value, json};

use super::trigger::TRIGGERS;
use super::{FaultKind, KINDS};

/// What an entry must obey besides the types of `keys`, which faults of all kinds have: it has one trigger, and the
/// parameters of its kind.
pub(super) fn rules(keys: &[Key]) -> Value {
    json!({
        // Each kind has its own.
        "additionalProperties": null,
        "oneOf": TRIGGERS.map(|trigger| json!({ "required": [trigger] })),
        "dependentRequired": { "every_s": ["at_s"], "within_m": ["near"] },
        "allOf": KINDS.iter().map(|kind| of_kind(kind, keys)).collect::<Vec<_>>(),
    })
}

fn of_kind(kind: &FaultKind, keys: &[Key]) -> Value {
    let shared = keys.iter().filter(|key| !(kind.is_momentary() && key.path == "lasts_s"));
    let shared = shared.map(|key| (key.path.clone(), json!(true)));
    let parameters: Vec<Key> = kind.parameters.iter().map(super::Parameter::key).collect();
    let own = parameters.iter().map(|key| {
        let mut takes = key.takes.clone();
        takes["description"] = json!(key.about);
        (key.path.clone(), takes)
    });
    let needed: Vec<&str> = parameters.iter().filter(|key| key.required).map(|key| &*key.path).collect();
    json!({
        "if": { "properties": { "kind": { "const": kind.name } } },
        "then": {
            "description": kind.about,
            "properties": shared.chain(own).collect::<Value>(),
            "required": needed,
            "additionalProperties": false,
        },
    })
}
