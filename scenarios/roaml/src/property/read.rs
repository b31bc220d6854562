//! Reads properties from a JANI file.

use std::collections::BTreeMap;
use std::ops::Range;

use diagnostics::{Problem, Source, Spanned, nearest_or_all};
use serde_json::Value as Json;

use super::formula::{Expression, FIRST_NODE, Operator, Path, Variable};

use crate::instance::Fields;

/// The events that a model's machines send, with their fields.
type Events = BTreeMap<String, Fields>;

/// A problem found while reading: the message, the words of the file that it is about, and help.
struct Unfit {
    message: String,
    words: Option<String>,
    help: Option<String>,
}

fn unfit(message: impl Into<String>) -> Unfit {
    Unfit { message: message.into(), words: None, help: None }
}

/// The names and formulas of a file.
pub(super) fn properties(source: &Source, events: &Events) -> Result<Vec<(Spanned<String>, Path)>, Vec<Problem>> {
    let text = source.text();
    let file: Json = serde_json::from_str(text).map_err(|error| {
        let line_start: usize = text.split_inclusive('\n').take(error.line().saturating_sub(1)).map(str::len).sum();
        let at = (line_start + error.column().saturating_sub(1)).min(text.len());
        vec![Problem::new(format!("this is not JSON: {error}")).at(at..at, "here")]
    })?;
    let Some(listed) = file.get("properties").and_then(Json::as_array) else {
        return Err(vec![Problem::new("the file has no `properties`").at(0..0, "in this file")]);
    };
    let (mut properties, mut problems) = (Vec::new(), Vec::new());
    let mut from = 0;
    for property in listed {
        let name = property.get("name").and_then(Json::as_str).unwrap_or_default();
        // The parser reports no positions, but keeps the order: the name is the next of its kind in the text.
        let place = find(text, name, from).unwrap_or(from..from);
        from = place.end;
        match path(property, events) {
            Ok(path) => properties.push((Spanned { value: name.to_owned(), span: source.span(place) }, path)),
            Err(Unfit { message, words, help }) => {
                let inner = words.as_ref().and_then(|words| find(text, words, from));
                let problem = Problem::new(format!("the property `{name}` cannot be checked: {message}"));
                problems.push(problem.at(inner.unwrap_or(place), "here").with_help_if(help));
            }
        }
    }
    if problems.is_empty() { Ok(properties) } else { Err(problems) }
}

/// The place of a string in the file.
fn find(text: &str, words: &str, from: usize) -> Option<Range<usize>> {
    let quoted = format!("\"{words}\"");
    let start = from + text.get(from..)?.find(&quoted)? + 1;
    Some(start..start + words.len())
}

fn path(property: &Json, events: &Events) -> Result<Path, Unfit> {
    let filter = property.get("expression").ok_or_else(|| unfit("it has no `expression`"))?;
    if operator(filter) != Some("filter") || filter.get("fun").and_then(Json::as_str) != Some("values") {
        return Err(unfit("only a `filter` with `\"fun\": \"values\"` asks for the value of a formula"));
    }
    if filter.get("states").and_then(operator) != Some("initial") {
        return Err(unfit("only the value in the initial state can be estimated from runs"));
    }
    let values = filter.get("values").ok_or_else(|| unfit("it has no `values`"))?;
    let Some("Pmin" | "Pmax") = operator(values) else {
        let words = operator(values).map(str::to_owned);
        return Err(Unfit { words, ..unfit("only `Pmin` and `Pmax`, the probability of a formula, are supported") });
    };
    let formula = values.get("exp").ok_or_else(|| unfit("the formula is missing"))?;
    let operand = |name: &str| {
        let operand = formula.get(name).ok_or_else(|| unfit(format!("`{name}` is missing")))?;
        truth(operand, events)
    };
    let (from, to) = bounds(formula)?;
    let until = |left, right, reached, at_end| Path { left, right, reached, at_end, from, to };
    Ok(match operator(formula) {
        Some("F") => until(Expression::Bool(true), operand("exp")?, true, false),
        // No state violates the condition: in terms of U, a violation is what must not be reached.
        Some("G") => until(Expression::Bool(true), Expression::Not(Box::new(operand("exp")?)), false, true),
        Some("U") => until(operand("left")?, operand("right")?, true, false),
        Some("W") => until(operand("left")?, operand("right")?, true, true),
        other => {
            let words = other.map(str::to_owned);
            let message = "the formula must be F, G, U or W applied to conditions without further temporal operators";
            return Err(Unfit { words, ..unfit(message) });
        }
    })
}

fn operator(json: &Json) -> Option<&str> {
    json.get("op").and_then(Json::as_str)
}

fn bounds(formula: &Json) -> Result<(u64, Option<u64>), Unfit> {
    if let Some(other) = ["time-bounds", "reward-bounds"].into_iter().find(|name| formula.get(name).is_some()) {
        let words = Some(other.to_owned());
        return Err(Unfit { words, ..unfit(format!("`{other}` are not supported, only `step-bounds`")) });
    }
    let Some(bounds) = formula.get("step-bounds") else { return Ok((0, None)) };
    let bound = |name: &str| match bounds.get(name) {
        None => Ok(None),
        Some(number) => number.as_u64().map(Some).ok_or_else(|| unfit(format!("`{name}` is not a whole number"))),
    };
    Ok((bound("lower")?.unwrap_or(0), bound("upper")?))
}

/// An expression that is true or false.
fn truth(json: &Json, events: &Events) -> Result<Expression, Unfit> {
    let expression = expression(json, events)?;
    match &expression {
        Expression::Number(number) => Err(unfit(format!("{number} is neither true nor false"))),
        Expression::Binary(operator, ..) if !operator.is_truth() => Err(unfit("a number is neither true nor false")),
        _ => Ok(expression),
    }
}

fn expression(json: &Json, events: &Events) -> Result<Expression, Unfit> {
    match json {
        Json::Bool(truth) => return Ok(Expression::Bool(*truth)),
        Json::Number(number) => return Ok(Expression::Number(number.as_f64().unwrap_or_default())),
        Json::String(name) => return variable(name, events),
        _ => {}
    }
    let part = |name: &str| {
        let part = json.get(name).ok_or_else(|| unfit(format!("`{name}` is missing")))?;
        expression(part, events).map(Box::new)
    };
    Ok(match operator(json) {
        Some("¬") => Expression::Not(part("exp")?),
        // JANI's extension for arrays calls an access `aa` and a value `av`.
        Some("aa") => Expression::Item(part("exp")?, part("index")?),
        Some("av") => {
            let items = json.get("elements").and_then(Json::as_array);
            let numbers = items.and_then(|items| items.iter().map(Json::as_f64).collect());
            Expression::Array(numbers.ok_or_else(|| unfit("`av` needs `elements` that are numbers"))?)
        }
        Some("abs") => Expression::Absolute(part("exp")?),
        Some(sign) => match Operator::of(sign) {
            Some(operator) => Expression::Binary(operator, part("left")?, part("right")?),
            None => {
                let message = format!("the operator `{sign}` is not supported in a condition");
                return Err(Unfit { words: Some(sign.to_owned()), ..unfit(message) });
            }
        },
        None => return Err(unfit(format!("`{json}` is not an expression"))),
    })
}

/// The variable with this name in AS2FM.
fn variable(name: &str, events: &Events) -> Result<Expression, Unfit> {
    let node = name.strip_prefix("bt_").and_then(|rest| rest.split_once("_response"));
    let node = node.filter(|(_, member)| ["__status", ".status"].contains(member));
    if let Some(node) = node.and_then(|(node, _)| node.parse::<usize>().ok()?.checked_sub(FIRST_NODE)) {
        return Ok(Expression::Variable(Variable::Node(node)));
    }
    // The name of one event may begin with that of another.
    let event = events.keys().filter(|event| name.starts_with(event.as_str())).max_by_key(|event| event.len());
    let unknown = || {
        let known: Vec<&str> = events.keys().map(String::as_str).collect();
        let words = Some(name.to_owned());
        let help = Some(nearest_or_all(name, "events", &known));
        Unfit { message: format!("no machine sends `{name}`"), words, help }
    };
    let event = event.ok_or_else(unknown)?;
    let rest = &name[event.len()..];
    if rest == ".valid" {
        return Ok(Expression::Variable(Variable::Valid(event.clone())));
    }
    let path = ["__ros_fields__", ".ros_fields__", "__", "."].into_iter().find_map(|prefix| rest.strip_prefix(prefix));
    let path = path.ok_or_else(unknown)?;
    let (path, is_length) = match path.strip_suffix(".d1_len").or_else(|| path.strip_suffix(".length")) {
        Some(path) => (path, true),
        None => (path, false),
    };
    let path = path.replace("__", ".");
    let fields = &events[event];
    let outer = path.split('.').next().unwrap_or_default();
    let is_field =
        |(known, _): &(String, _)| *known == path || known == outer || known.starts_with(&format!("{path}."));
    if !fields.iter().any(is_field) {
        let known: Vec<&str> = fields.iter().map(|(name, _)| name.as_str()).collect();
        let help = Some(nearest_or_all(&path, "its fields", &known));
        return Err(Unfit { message: format!("{event} has no field `{path}`"), words: Some(name.to_owned()), help });
    }
    let field = Expression::Variable(Variable::Field(event.clone(), path));
    Ok(if is_length { Expression::Length(Box::new(field)) } else { field })
}
