//! Validates a value against a JSON Schema, draft 2020-12: only the keywords that our schemas use.
//!
//! A crate for the whole draft needs more features of shared dependencies than the program does, so they would be built
//! twice. `STEWARD_SCHEMA_CASES=FILE` writes every case with its answer; `tests/schemas/foreign.py` gives them to
//! `jsonschema-rs`.

use std::fs::OpenOptions;
use std::io::Write;

use serde_json::{Value, json};

/// The problem with a value, or `None`.
pub(super) fn problem(schema: &Value, value: &Value) -> Option<String> {
    let problem = check(schema, value).err();
    if let Some(file) = std::env::var_os("STEWARD_SCHEMA_CASES") {
        let case = json!({ "schema": schema["title"], "value": value, "valid": problem.is_none() });
        let line = format!("{case}\n");
        OpenOptions::new().create(true).append(true).open(file).unwrap().write_all(line.as_bytes()).unwrap();
    }
    problem
}

fn check(schema: &Value, value: &Value) -> Result<(), String> {
    let keywords = match schema {
        Value::Bool(true) => return Ok(()),
        Value::Bool(false) => return Err(format!("{value} is not allowed here")),
        keywords => keywords.as_object().expect("a schema is an object"),
    };
    for (keyword, wanted) in keywords {
        let holds = holds(keyword, wanted, keywords, value)?;
        if !holds {
            return Err(format!("{value}: {keyword} {wanted}"));
        }
    }
    Ok(())
}

fn holds(keyword: &str, wanted: &Value, all: &serde_json::Map<String, Value>, value: &Value) -> Result<bool, String> {
    let valid = |schema: &Value| check(schema, value).is_ok();
    let each = || wanted.as_array().into_iter().flatten();
    let number = |compare: fn(&f64, &f64) -> bool| {
        value.as_f64().is_none_or(|value| compare(&value, &wanted.as_f64().expect("a limit is a number")))
    };
    let count = || wanted.as_u64().expect("a count is a whole number") as usize;
    let object = value.as_object();
    let has_all = |keys: &Value| {
        object.is_none_or(|object| {
            keys.as_array().into_iter().flatten().all(|key| object.contains_key(key.as_str().unwrap()))
        })
    };
    Ok(match keyword {
        "$schema" | "title" | "description" | "default" | "then" | "else" => true,
        "type" => match wanted {
            Value::Array(types) => types.iter().any(|name| is_a(name, value)),
            name => is_a(name, value),
        },
        "enum" => each().any(|one| one == value),
        "const" => wanted == value,
        "minimum" => number(f64::ge),
        "maximum" => number(f64::le),
        "exclusiveMinimum" => number(f64::gt),
        "exclusiveMaximum" => number(f64::lt),
        "minLength" => value.as_str().is_none_or(|text| text.chars().count() >= count()),
        "maxLength" => value.as_str().is_none_or(|text| text.chars().count() <= count()),
        "minItems" => value.as_array().is_none_or(|items| items.len() >= count()),
        "maxItems" => value.as_array().is_none_or(|items| items.len() <= count()),
        "items" => {
            value.as_array().into_iter().flatten().try_for_each(|item| check(wanted, item))?;
            true
        }
        "required" => has_all(wanted),
        "properties" | "additionalProperties" => {
            for (name, member) in object.into_iter().flatten() {
                let known = all.get("properties").and_then(|properties| properties.get(name));
                let schema = if keyword == "properties" { known } else { Some(wanted).filter(|_| known.is_none()) };
                schema.map_or(Ok(()), |schema| check(schema, member)).map_err(|error| format!("{name}: {error}"))?;
            }
            true
        }
        "propertyNames" => object.into_iter().flatten().all(|(name, _)| check(wanted, &json!(name)).is_ok()),
        "dependentRequired" => wanted
            .as_object()
            .into_iter()
            .flatten()
            .all(|(key, needed)| !object.is_some_and(|object| object.contains_key(key)) || has_all(needed)),
        "not" => !valid(wanted),
        "anyOf" => each().any(valid),
        "oneOf" => each().filter(|schema| valid(schema)).count() == 1,
        "allOf" => {
            each().try_for_each(|schema| check(schema, value))?;
            true
        }
        "if" => {
            let branch = all.get(if valid(wanted) { "then" } else { "else" });
            branch.map_or(Ok(()), |branch| check(branch, value))?;
            true
        }
        other => panic!("the schemas have the keyword {other}, which is not known here"),
    })
}

fn is_a(name: &Value, value: &Value) -> bool {
    match name.as_str().expect("a type is a name") {
        "string" => value.is_string(),
        "boolean" => value.is_boolean(),
        "number" => value.is_number(),
        "integer" => value.as_f64().is_some_and(|number| number.fract() == 0.0),
        "array" => value.is_array(),
        "object" => value.is_object(),
        other => panic!("the schemas have the type {other}, which is not known here"),
    }
}
