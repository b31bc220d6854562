//! How the messages of an operation travel in ROS 2.

use std::sync::Arc;

use ros_messages::{Base, Count, Field, Layout, Mismatch, Primitive, Value};

use crate::field_path::{FieldStep, Part, steps};

/// What an operation is in ROS 2.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Wire {
    /// Its type, such as `nav2_msgs/action/NavigateToPose`.
    pub kind: String,
    /// Its messages, as ROS sends them: a service's request and response; a topic's message; an action's goal, feedback
    /// and result, each with what ROS adds to it.
    pub parts: Vec<WirePart>,
}

/// A message of ROS 2, and where in it the fields of an interface are.
#[derive(Clone, Debug)]
pub struct WirePart {
    /// Its type.
    pub layout: Arc<Layout>,
    /// The paths of the fields, in the order of the interface.
    paths: Vec<Vec<FieldStep>>,
}

/// Types are equal if their names are: a file has one definition of each.
impl PartialEq for WirePart {
    fn eq(&self, other: &Self) -> bool {
        self.layout.name == other.layout.name && self.paths == other.paths
    }
}

impl Eq for WirePart {}

impl WirePart {
    /// The message with this type, and the paths of fields in the part of it with this name, if there is one.
    pub(crate) fn new(layout: Arc<Layout>, part: Option<&str>, paths: &[String]) -> Self {
        let part = part.map(|name| FieldStep { name: name.to_owned(), part: None });
        let path = |path: &String| part.iter().cloned().chain(steps(path).expect("the path of a field")).collect();
        Self { layout, paths: paths.iter().map(path).collect() }
    }

    /// Whether none of its fields is one of the interface.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.paths.is_empty()
    }

    /// Whether a field of the interface is this field of the message, or in it.
    #[must_use]
    pub fn selects(&self, name: &str) -> bool {
        self.paths.iter().any(|path| path.first().is_some_and(|step| step.name == name))
    }

    /// The fields of the interface in a message of this type, in order. One that the message lacks is
    /// [`Passed`](Value::Passed).
    #[must_use]
    pub fn fields(&self, message: &Value) -> Vec<Value> {
        self.paths.iter().map(|path| of_message(message, &self.layout, path)).collect()
    }

    /// The message with these fields, in order; one is left out if it is [`Passed`](Value::Passed). All others have
    /// the defaults of the definition, or are zero.
    ///
    /// # Errors
    /// [`Mismatch`] if a field is not where the message may have one.
    pub fn message(&self, fields: Vec<Value>) -> Result<Value, Mismatch> {
        let mut message = empty(&self.layout);
        let mut filled = Vec::new();
        for (path, value) in self.paths.iter().zip(fields).filter(|(_, value)| *value != Value::Passed) {
            // What an array of the definition has by default makes room once.
            let list = path.iter().position(|step| step.part == Some(Part::Every)).map(|place| &path[..=place]);
            let is_new = list.is_some_and(|list| !filled.contains(&list));
            put(&mut message, &self.layout, path, value, is_new)?;
            filled.extend(list.filter(|_| is_new));
        }
        Ok(message)
    }
}

/// What a path leads to.
fn of_message(message: &Value, layout: &Layout, path: &[FieldStep]) -> Value {
    let (Value::Message(values), Some((step, rest))) = (message, path.split_first()) else { return message.clone() };
    let Some(index) = layout.fields.iter().position(|field| field.name == step.name) else { return Value::Passed };
    let below = |value: &Value| match &layout.fields[index].kind.base {
        Base::Message(layout) => of_message(value, layout, rest),
        Base::Primitive(_) => value.clone(),
    };
    match (&values[index], step.part) {
        (single, None) => below(single),
        (Value::List(items), Some(Part::Item(index))) => items.get(index).map_or(Value::Passed, below),
        (Value::List(items), Some(Part::Every)) => Value::List(items.iter().map(below).collect()),
        _ => Value::Passed,
    }
}

/// Puts a value where a path leads; into items of a list that is `new`, or has as many already.
fn put(message: &mut Value, layout: &Layout, path: &[FieldStep], value: Value, is_new: bool) -> Result<(), Mismatch> {
    let (Value::Message(values), Some((step, rest))) = (message, path.split_first()) else {
        return Err(Mismatch::Value);
    };
    let index = layout.fields.iter().position(|field| field.name == step.name).ok_or(Mismatch::Value)?;
    let base = &layout.fields[index].kind.base;
    let below = |place: &mut Value, value: Value| match base {
        Base::Message(layout) => put(place, layout, rest, value, is_new),
        Base::Primitive(_) => {
            *place = value;
            Ok(())
        }
    };
    match (&mut values[index], step.part, value) {
        (single, None, value) => below(single, value),
        (Value::List(items), Some(Part::Item(index)), value) => {
            if index >= items.len() {
                items.resize(index + 1, one(base));
            }
            below(&mut items[index], value)
        }
        (Value::List(items), Some(Part::Every), Value::List(values)) => {
            if is_new {
                *items = vec![one(base); values.len()];
            }
            // Lists of several fields of the same items are equally long.
            if items.len() != values.len() {
                return Err(Mismatch::Bound);
            }
            items.iter_mut().zip(values).try_for_each(|(item, value)| below(item, value))
        }
        _ => Err(Mismatch::Value),
    }
}

/// The message of a type in which nothing has been set.
fn empty(layout: &Layout) -> Value {
    let value = |field: &Field<Arc<Layout>>| match (&field.default, field.kind.count) {
        (Some(default), _) => default.clone(),
        (None, Count::One) => one(&field.kind.base),
        (None, Count::Exactly(count)) => Value::List(vec![one(&field.kind.base); count]),
        (None, Count::UpTo(_) | Count::Any) => Value::List(Vec::new()),
    };
    Value::Message(layout.fields.iter().map(value).collect())
}

fn one(base: &Base<Arc<Layout>>) -> Value {
    match base {
        Base::Message(layout) => empty(layout),
        Base::Primitive(Primitive::Bool) => Value::Bool(false),
        Base::Primitive(Primitive::Float32 | Primitive::Float64) => Value::Real(0.0),
        Base::Primitive(Primitive::String(_) | Primitive::WString(_)) => Value::Text(String::new()),
        Base::Primitive(_) => Value::Int(0),
    }
}
