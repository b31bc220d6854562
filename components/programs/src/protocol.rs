//! The lines exchanged with a program.

use std::time::Duration;

use serde::Deserialize;
use serde_json::{Map, Number, Value};
use skills::{Datum, TooLarge};

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Message<'m> {
    pub(crate) time: Duration,
    pub(crate) event: &'m str,
    /// The sender; `None` for the program's own timers.
    pub(crate) from: Option<&'m str>,
    pub(crate) data: &'m Datum,
}

impl Message<'_> {
    /// As a JSON object on one line.
    pub(crate) fn to_json(&self) -> String {
        let quoted = |text: &str| Datum::text(text).to_json();
        let mut line = format!("{{\"time\":{:?},\"event\":{}", self.time.as_secs_f64(), quoted(self.event));
        if let Some(from) = self.from {
            line += &format!(",\"from\":{}", quoted(from));
        }
        line += &format!(",\"data\":{}}}", self.data.to_json());
        line
    }
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct Answer {
    pub(crate) send: Vec<Sent>,
    pub(crate) timers: Vec<Timer>,
    pub(crate) state: Option<String>,
}

/// A message to another process, or to all subscribers of a topic.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Sent {
    pub(crate) to: Option<String>,
    pub(crate) event: String,
    #[serde(default)]
    pub(crate) data: Map<String, Value>,
}

/// An event that the program will receive later.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Timer {
    /// In seconds of simulated time.
    pub(crate) after: f64,
    pub(crate) event: String,
    #[serde(default)]
    pub(crate) data: Map<String, Value>,
}

impl Answer {
    /// Parses a line. An error names the position in it.
    pub(crate) fn parse(line: &str) -> Result<Self, String> {
        let json: Value = serde_json::from_str(line).map_err(|error| {
            // The input is a single line, so its number is omitted.
            let message = error.to_string();
            let message = message.split(" at line ").next().unwrap_or_default();
            format!("it is not JSON: {message} at column {}", error.column())
        })?;
        // Serde would also accept an array where a struct is expected.
        let objects = ["send", "timers"].into_iter().flat_map(|key| {
            let items = json[key].as_array().into_iter().flatten().enumerate();
            items.map(move |(index, item)| (format!("at `{key}[{index}]`: "), item))
        });
        let mut objects = std::iter::once((String::new(), &json)).chain(objects);
        if let Some((place, _)) = objects.find(|(_, item)| !item.is_object()) {
            return Err(format!("{place}it must be a JSON object"));
        }
        serde_path_to_error::deserialize(&json).map_err(|error| format!("at `{}`: {}", error.path(), error.inner()))
    }
}

/// Why a JSON value cannot be a value of the data model.
#[derive(Debug, thiserror::Error)]
pub(crate) enum DatumError {
    /// The value needs too much memory.
    #[error(transparent)]
    TooLarge(#[from] TooLarge),
    /// Numbers of the data model are doubles, and this integer is not one.
    #[error("the integer {0} would be rounded")]
    Rounded(Number),
}

/// A JSON object as a value of the data model.
pub(crate) fn datum(object: Map<String, Value>) -> Result<Datum, DatumError> {
    value(Value::Object(object))
}

fn value(json: Value) -> Result<Datum, DatumError> {
    Ok(match json {
        Value::Null => Datum::Null,
        Value::Bool(truth) => truth.into(),
        Value::Number(number) => exact(&number).ok_or(DatumError::Rounded(number))?.into(),
        Value::String(text) => Datum::text(&text),
        Value::Array(items) => Datum::array(items.into_iter().map(value).collect::<Result<Vec<_>, DatumError>>()?)?,
        Value::Object(members) => {
            let members = members.into_iter().map(|(name, json)| Ok((name, value(json)?)));
            Datum::object(members.collect::<Result<Vec<_>, DatumError>>()?)?
        }
    })
}

/// The number as a double; none for an integer that is not equal to one.
fn exact(number: &Number) -> Option<f64> {
    let real = number.as_f64()?;
    number.as_i128().is_none_or(|integer| real as i128 == integer).then_some(real)
}
