//! The meanings and types of a file's keys.
//!
//! From this description, the file's JSON schema (which editors use), its chapter in the reference, and the text of
//! `steward help` are generated. It comes from the file's reader where that [declares](Key::all) its keys; of the other
//! keys, tests check it against the reader: keys, types, ranges and defaults.

pub mod interface;
pub mod mapping;

use diagnostics::document::{DeclaredKey, Table, Takes};
use serde_json::{Value, json};

/// A key of a file that people write.
#[derive(Clone, Debug)]
pub struct Key {
    /// Its path: `battery.initial_pct`. `[]` follows an array of tables; a part in capitals is a name that the file
    /// chooses.
    pub path: String,
    /// Its meaning, in a sentence or two.
    pub about: String,
    /// Its type, as JSON Schema, including the rules that relate several keys of a table.
    pub takes: Value,
    /// Whether its table needs it.
    pub required: bool,
}

impl Key {
    /// An optional key.
    #[must_use]
    pub fn new(path: &str, about: &str, takes: Value) -> Self {
        Self { path: path.to_owned(), about: about.to_owned(), takes, required: false }
    }

    /// The same key, but required.
    #[must_use]
    pub fn required(self) -> Self {
        Self { required: true, ..self }
    }

    /// All keys that a reader declares.
    #[must_use]
    pub fn all(read: impl for<'d> FnOnce(Table<'d>)) -> Vec<Self> {
        DeclaredKey::all(read).into_iter().map(Self::declared).collect()
    }

    fn declared(key: DeclaredKey) -> Self {
        let mut takes = of_type(&key.takes);
        for (name, value) in [
            ("title", key.words.map(Value::from)),
            ("minLength", key.filled.then(|| json!(1))),
            ("minimum", key.range.as_ref().map(|[least, _]| of_toml(least))),
            ("maximum", key.range.as_ref().map(|[_, most]| of_toml(most))),
            ("default", key.default.as_ref().map(of_toml)),
        ] {
            takes = with(takes, value.map_or_else(|| json!({}), |value| json!({ (name): value })));
        }
        Self { path: key.path, about: key.about, takes, required: key.required }
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

    /// Its type, in words: `a number from 0 to 100`.
    #[must_use]
    pub fn accepts(&self) -> String {
        accepts(&self.takes)
    }

    /// Its default value, as TOML.
    #[must_use]
    pub fn default(&self) -> Option<String> {
        self.takes.get("default").map(Value::to_string)
    }
}

fn of_type(takes: &Takes) -> Value {
    match takes {
        Takes::Text => text(),
        Takes::OneOf(names) => json!({ "enum": names }),
        Takes::Number => json!({ "type": "number" }),
        Takes::Integer => json!({ "type": "integer" }),
        Takes::Count => whole(0),
        Takes::Flag => flag(),
        Takes::Seconds => seconds(),
        Takes::Table => table(json!({})),
        Takes::Array(of, _) if **of == Takes::Table => of_type(of),
        Takes::Array(of, None) => json!({ "type": "array", "items": of_type(of) }),
        Takes::Array(of, Some(count)) => {
            json!({ "type": "array", "items": of_type(of), "minItems": count, "maxItems": count })
        }
        Takes::Other => json!({}),
    }
}

fn of_toml(value: &toml::Value) -> Value {
    match value {
        toml::Value::Float(number) => plain(*number),
        toml::Value::Integer(number) => json!(number),
        toml::Value::Boolean(value) => json!(value),
        toml::Value::Array(items) => items.iter().map(of_toml).collect(),
        other => json!(other.as_str()),
    }
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
        Some("integer") => "an integer",
        _ => "a number",
    };
    // Nobody reaches a limit of a billion.
    let most = takes.get("maximum").filter(|most| most.as_f64() < Some(1e9));
    match (takes.get("minimum"), takes.get("exclusiveMinimum"), most) {
        (Some(least), _, Some(most)) => format!("{what} from {least} to {most}"),
        (Some(least), ..) => format!("{what}, {least} or more"),
        (None, Some(limit), _) => match takes.get("exclusiveMaximum") {
            Some(most) => format!("{what} between {limit} and {most}"),
            None => format!("{what} above {limit}"),
        },
        _ => what.to_owned(),
    }
}

/// A text.
#[must_use]
pub fn text() -> Value {
    json!({ "type": "string" })
}

/// True or false.
#[must_use]
pub fn flag() -> Value {
    json!({ "type": "boolean" })
}

/// A number in a range, both ends included.
#[must_use]
pub fn number(least: f64, most: f64) -> Value {
    json!({ "type": "number", "minimum": plain(least), "maximum": plain(most) })
}

/// A number of seconds.
#[must_use]
pub fn seconds() -> Value {
    number(0.0, 1e9)
}

/// A number of seconds other than 0.
#[must_use]
pub fn some_seconds() -> Value {
    json!({ "type": "number", "exclusiveMinimum": 0, "maximum": 1_000_000_000 })
}

/// A whole number of at least this.
#[must_use]
pub fn whole(least: u64) -> Value {
    json!({ "type": "integer", "minimum": least })
}

/// One of these names.
#[must_use]
pub fn one_of(names: &[&str]) -> Value {
    json!({ "enum": names })
}

/// An array, with a description in words.
#[must_use]
pub fn list(words: &str, of: &Value) -> Value {
    json!({ "title": words, "type": "array", "items": of })
}

/// This many numbers, with a description in words.
fn numbers(words: &str, count: usize) -> Value {
    json!({ "title": words, "type": "array", "items": { "type": "number" }, "minItems": count, "maxItems": count })
}

/// A point in the `map` frame.
#[must_use]
pub fn point() -> Value {
    numbers("[x, y] in meters", 2)
}

/// Several points in the `map` frame.
#[must_use]
pub fn points() -> Value {
    list("[[x, y], …] in meters", &point())
}

/// The numbers of a pose.
pub(crate) const POSE: &str = "[x, y, heading] in meters and degrees";

/// A pose in the `map` frame.
#[must_use]
pub fn pose() -> Value {
    numbers(POSE, 3)
}

/// A text, a number, true or false.
#[must_use]
pub fn scalar() -> Value {
    json!({ "title": "a string, a number, true or false", "type": ["string", "number", "boolean"] })
}

/// A table whose keys must obey these rules.
#[must_use]
pub fn table(rules: Value) -> Value {
    with(json!({ "type": "object", "additionalProperties": false }), rules)
}

/// A key that accepts all of this, with that default.
#[must_use]
pub fn or(takes: Value, default: impl Into<Value>) -> Value {
    with(takes, json!({ "default": default.into() }))
}

/// Both together.
#[must_use]
pub fn with(takes: Value, more: Value) -> Value {
    match (takes, more) {
        (Value::Object(mut takes), Value::Object(more)) => {
            takes.extend(more);
            Value::Object(takes)
        }
        (takes, _) => takes,
    }
}

/// A phrase as a sentence.
#[must_use]
pub fn sentence(phrase: &str) -> String {
    let mut rest = phrase.chars();
    rest.next().map_or_else(String::new, |first| format!("{}{}.", first.to_uppercase(), rest.as_str()))
}

/// A number as people write it: 80 instead of 80.0.
#[must_use]
pub fn plain(number: f64) -> Value {
    if number.fract() == 0.0 && number.abs() < 1e15 { json!(number as i64) } else { json!(number) }
}

/// The JSON schema, draft 2020-12, of a file with these keys. Tables come before their contents.
#[must_use]
pub fn json_schema(title: &str, rules: Value, keys: &[Key]) -> Value {
    let head = json!({ "$schema": "https://json-schema.org/draft/2020-12/schema", "title": title });
    let mut schema = with(head, table(rules));
    keys.iter().for_each(|key| insert(&mut schema, &key.path, key));
    schema
}

fn insert(table: &mut Value, path: &str, key: &Key) {
    let (part, rest) = path.split_once('.').map_or((path, None), |(part, rest)| (part, Some(rest)));
    let (name, is_array) = part.strip_suffix("[]").map_or((part, false), |name| (name, true));
    if rest.is_none() && key.required {
        let required = table["required"].as_array().cloned().unwrap_or_default();
        table["required"] = required.into_iter().chain([json!(name)]).collect();
    }
    let is_any = name.chars().all(char::is_uppercase);
    let entry = if is_any { &mut table["additionalProperties"] } else { &mut table["properties"][name] };
    let Some(rest) = rest else {
        let takes = key.takes.clone();
        let takes = if is_array { json!({ "type": "array", "items": takes }) } else { takes };
        *entry = with(takes, json!({ "description": key.about }));
        return;
    };
    insert(if is_array { &mut entry["items"] } else { entry }, rest, key);
}
