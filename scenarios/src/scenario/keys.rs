//! The JSON schema of a scenario file, from the [keys](ScenarioFile::keys) that its reader declares.

use diagnostics::document::Key;
use serde_json::{Map, Value, json};

use super::ScenarioFile;
use super::component_entry::FORMS;

impl ScenarioFile {
    /// The JSON schema of a scenario file.
    #[must_use]
    pub fn schema() -> Value {
        let keys = Self::keys();
        // Parts of a table that a file without a map refuses are left to the reader.
        let needed = keys.iter().filter_map(|key| Some((key.path.trim_end_matches("[]"), key.needs.as_ref()?)));
        let needed = needed.filter(|(path, _)| !path.contains('.'));
        let mut dependent: Map<String, Value> = needed.map(|(key, needs)| (key.to_owned(), json!([needs]))).collect();
        dependent.insert("map".to_owned(), json!(["sites"]));
        // A file with a base inherits what is required.
        let whole = json!({
            "required": ["tree"],
            "dependentRequired": dependent,
            "properties": {
                "sites": { "required": ["start"] },
                "components": { "additionalProperties": { "anyOf": FORMS.map(|key| json!({ "required": [key] })) } },
            },
        });
        let rules = json!({ "anyOf": [{ "required": ["base"] }, { "required": ["model"] }, whole] });
        Key::json_schema("A scenario of steward", rules, keys)
    }
}
