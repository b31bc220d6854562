//! Keys as their readers declare them, for JSON schemas, references and help.

use std::time::Duration;

use serde_json::{Value, json};

use crate::Spanned;

/// What a text in a file stands for, so that an editor can propose it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Referent {
    /// A file with one of these endings, or a folder if there are none, relative to the file that names it.
    File(&'static [&'static str]),
    /// A file with places on a map.
    Places,
    /// A file with an interface.
    Interface,
    /// A machine's file in the folder of the skills.
    Machine,
    /// A scenario: a file, or one that comes with the program.
    Scenario,
    /// A key of scenarios, in the syntax of `--set`.
    Setting,
    /// A process of the system: a leaf, a component or the tree.
    Process,
    /// A component.
    Component,
    /// A leaf, by the name of its process.
    Leaf,
    /// A state of a leaf's machine: `LEAF.STATE`.
    LeafState,
    /// A mistake in a leaf's machine: `LEAF: MISTAKE`.
    Mutant,
    /// A `service`, a `topic` or an `action` of a component: `COMPONENT.NAME`.
    Offer(&'static str),
    /// A property.
    Property,
    /// A place on the map.
    Place,
    /// A place that is a point.
    Point,
    /// A zone on the map.
    Zone,
    /// A door of the world.
    Door,
    /// A person in the world.
    Person,
    /// A laser of the robot.
    Laser,
    /// An event of the SCOPE language.
    Event,
    /// A type of messages of ROS 2: `PACKAGE/msg/NAME`.
    MessageType,
    /// Something of the leaf or component in whose table it is.
    Own(Own),
}

/// Something of a leaf or component.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Own {
    /// A datum of its machine.
    Datum,
    /// An input port: `{PORT}`.
    InputPort,
    /// An output port.
    OutputPort,
    /// A field of its requests.
    Argument,
    /// A field of the answer.
    AnswerField,
    /// A field of an action's feedback.
    FeedbackField,
    /// An expression of the answer's fields.
    AnswerCondition,
}

/// A key of a file that people write, as its reader declares it.
#[derive(Clone, Debug)]
pub struct Key {
    /// Its path: `battery.initial_pct`. `[]` follows an array of tables; a part in capitals is a name that the file
    /// chooses.
    pub path: String,
    /// Its meaning, in a sentence or two, with its unit. Empty if the reader does not give it.
    pub about: String,
    /// The accepted values, as JSON Schema, with the default and with the rules that relate several keys of a table.
    pub takes: Value,
    /// Whether its table needs it, in whatever form the table is.
    pub required: bool,
    /// The key of the top level without which it has no meaning.
    pub needs: Option<String>,
    /// What its texts stand for.
    pub refers_to: Option<Referent>,
    /// What it stands for itself, if the file chooses it.
    pub named_after: Option<Referent>,
    /// Its value in TOML, if it is declared as [a file](super::Document::in_effect) has it.
    pub value: Option<String>,
}

impl Key {
    /// An optional key of which nothing else is known.
    #[must_use]
    pub fn new(path: String, takes: Value) -> Self {
        let (about, refers_to, named_after) = (String::new(), None, None);
        Self { path, about, takes, required: false, needs: None, refers_to, named_after, value: None }
    }

    /// Adds keywords of JSON Schema.
    pub(super) fn extend(&mut self, keywords: Value) {
        extend(&mut self.takes, keywords);
    }

    /// Its table, empty at the top level, and its name there.
    #[must_use]
    pub fn split(&self) -> (&str, &str) {
        self.path.rsplit_once('.').unwrap_or(("", &self.path))
    }

    /// Whether it is a table, or an array of tables.
    #[must_use]
    pub fn is_table(&self) -> bool {
        self.takes["type"] == "object"
    }

    /// The accepted values, in words: `a number from 0 to 100`.
    #[must_use]
    pub fn accepts(&self) -> String {
        accepts(&self.takes)
    }

    /// Its default value, as TOML.
    #[must_use]
    pub fn default(&self) -> Option<String> {
        self.takes.get("default").map(Value::to_string)
    }

    /// Its meaning, its accepted values, and its default.
    #[must_use]
    pub fn meaning(&self) -> String {
        let default = match self.default() {
            _ if self.required => "; required".to_owned(),
            Some(default) => format!("; default {default}"),
            None => String::new(),
        };
        format!("{} [{}{default}]", self.about, self.accepts())
    }

    /// The JSON schema, draft 2020-12, of a file with these keys; `rules` relate several keys of its top level.
    #[must_use]
    pub fn json_schema(title: &str, rules: Value, keys: &[Self]) -> Value {
        let mut schema = table();
        extend(&mut schema, json!({ "$schema": "https://json-schema.org/draft/2020-12/schema", "title": title }));
        extend(&mut schema, rules);
        keys.iter().for_each(|key| key.insert(&mut schema, &key.path));
        schema
    }

    /// Inserts it at this path below a table.
    fn insert(&self, table: &mut Value, path: &str) {
        let (part, rest) = path.split_once('.').map_or((path, None), |(part, rest)| (part, Some(rest)));
        let (name, is_array) = part.strip_suffix("[]").map_or((part, false), |name| (name, true));
        if rest.is_none() && self.required {
            let required = table["required"].as_array().cloned().unwrap_or_default();
            table["required"] = required.into_iter().chain([json!(name)]).collect();
        }
        let entry = if is_chosen(name) { &mut table["additionalProperties"] } else { &mut table["properties"][name] };
        let Some(rest) = rest else {
            let takes = self.takes.clone();
            *entry = if is_array { json!({ "type": "array", "items": takes }) } else { takes };
            return extend(entry, json!({ "description": self.about }));
        };
        self.insert(if is_array { &mut entry["items"] } else { entry }, rest);
    }
}

/// Whether this stands for names that the file chooses.
pub(super) fn is_chosen(name: &str) -> bool {
    name.chars().all(char::is_uppercase)
}

/// Adds keywords; those that are `null` are removed.
fn extend(takes: &mut Value, keywords: Value) {
    if let (Value::Object(takes), Value::Object(keywords)) = (takes, keywords) {
        takes.extend(keywords);
        takes.retain(|_, value| !value.is_null());
    }
}

/// A table that has only the keys that are inserted.
pub(super) fn table() -> Value {
    json!({ "type": "object", "additionalProperties": false })
}

fn accepts(takes: &Value) -> String {
    if let Some(title) = takes["title"].as_str() {
        return title.to_owned();
    }
    if let Some(names) = takes["enum"].as_array() {
        let names: Vec<&str> = names.iter().filter_map(Value::as_str).collect();
        return format!("one of {}", names.join(", "));
    }
    let what = match takes["type"].as_str() {
        Some("string") => return "a string".to_owned(),
        Some("boolean") => return "true or false".to_owned(),
        Some("object") => return "a table".to_owned(),
        Some("integer") => "an integer",
        _ => "a number",
    };
    // A limit of a billion is never reached.
    let most = takes.get("maximum").filter(|most| most.as_f64() < Some(1e9));
    match (takes.get("minimum"), takes.get("exclusiveMinimum"), most) {
        (_, Some(limit), _) => match takes.get("exclusiveMaximum") {
            Some(most) => format!("{what} between {limit} and {most}"),
            None => {
                format!("{what} above {limit}") + &most.map_or_else(String::new, |most| format!(", at most {most}"))
            }
        },
        (Some(least), _, Some(most)) => format!("{what} from {least} to {most}"),
        (Some(least), ..) => format!("{what}, {least} or more"),
        _ => what.to_owned(),
    }
}

/// A value as people write it.
pub trait Written {
    /// The value in JSON, which is also how TOML has it.
    fn written(&self) -> Value;
}

/// Implements [`Written`] for types that JSON has.
macro_rules! written {
    ($($type:ty)*) => {
        $(impl Written for $type {
            fn written(&self) -> Value {
                json!(self)
            }
        })*
    };
}

written!(u64 i64 bool String);

/// 80 instead of 80.0.
impl Written for f64 {
    fn written(&self) -> Value {
        if self.fract() == 0.0 && self.abs() < 1e15 { json!(*self as i64) } else { json!(self) }
    }
}

/// In seconds.
impl Written for Duration {
    fn written(&self) -> Value {
        self.as_secs_f64().written()
    }
}

impl<T: Written> Written for Spanned<T> {
    fn written(&self) -> Value {
        self.value.written()
    }
}

impl<T: Written, const N: usize> Written for [T; N] {
    fn written(&self) -> Value {
        self.iter().map(T::written).collect()
    }
}
