//! Points and poses on the map, in words and as JSON Schema.

use diagnostics::document::FromItem;
use serde_json::{Value, json};

/// The numbers of a point.
pub(crate) const POINT: &str = "[x, y] in meters";

/// The numbers of a pose.
pub(crate) const POSE: &str = "[x, y, heading] in meters and degrees";

pub(crate) fn points() -> Value {
    let mut point = <[f64; 2]>::takes();
    point["title"] = json!(POINT);
    json!({ "title": "[[x, y], …] in meters", "items": point })
}
