//! Paths to fields: `pose.position.x`, `covariance[0]`, `status_list[-1].status`.

use interfaces::ros::{Base, Constant, Count};

use crate::cdr::{Value, Want};
use crate::layout::{Item, Layout};

/// A path that leads to a field of a message type.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Path {
    /// The fields, each with an item if it is an array; negative items count from the end.
    steps: Vec<(usize, Option<i64>)>,
    pub(crate) end: End,
}

/// The destination of a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum End {
    Bool,
    Int,
    Real,
    Text,
    /// An array of bytes, such as the identifier of a goal.
    Bytes,
    /// A message `builtin_interfaces/Time`.
    Time,
}

/// The longest array of bytes that can be one value.
const MOST_BYTES: usize = 64;

impl Path {
    /// The path in a type, if it leads to a value.
    pub(crate) fn resolve(text: &str, layout: &Layout) -> Result<Self, String> {
        let (mut steps, mut at) = (Vec::new(), Some(layout));
        let mut end = Err(format!("`{text}` is not a path"));
        for part in text.split('.') {
            let (name, item) = match part.strip_suffix(']').and_then(|part| part.split_once('[')) {
                Some((name, item)) => {
                    (name, Some(item.parse::<i64>().map_err(|_| format!("`{item}` is not the number of an item"))?))
                }
                None => (part, None),
            };
            let Some(layout) = at else { return Err(format!("there is nothing below `{}`", before(text, part))) };
            let Some(field) = layout.fields.iter().position(|slot| slot.name == name) else {
                let names: Vec<&str> = layout.fields.iter().map(|slot| slot.name.as_str()).collect();
                let meant = diagnostics::nearest_or_all(name, "fields", &names);
                return Err(format!("{} has no field `{name}`: {meant}", layout.name));
            };
            let slot = &layout.fields[field];
            let is_array = slot.count != Count::One;
            if let (false, Some(item)) = (is_array, item) {
                return Err(format!("`{name}` is not an array, so it has no item {item}"));
            }
            steps.push((field, item));
            end = end_of(&slot.item, slot.count, item.is_some());
            at = match &slot.item {
                Item::Message(layout) if !is_array || item.is_some() => Some(layout),
                _ => None,
            };
        }
        Ok(Self { steps, end: end? })
    }

    /// Adds the path to the wanted parts of a message.
    pub(crate) fn want(&self, layout: &Layout, want: &mut Want) {
        want_below(&self.steps, layout, want);
    }

    /// Whether it leads through an item that an array may not have.
    pub(crate) fn may_be_missing(&self) -> bool {
        self.steps.iter().any(|(_, item)| item.is_some())
    }

    /// The value in a message of that type; none if an array does not have the item.
    pub(crate) fn find<'v>(&self, message: &'v Value) -> Option<&'v Value> {
        self.steps.iter().try_fold(message, |at, (field, item)| {
            let Value::Message(fields) = at else { return None };
            match (fields.get(*field)?, item) {
                (Value::List(items), Some(item)) => {
                    let index = if *item < 0 { items.len() as i64 + item } else { *item };
                    items.get(usize::try_from(index).ok()?)
                }
                (value, _) => Some(value),
            }
        })
    }
}

fn before(text: &str, part: &str) -> String {
    text.split('.').take_while(|other| *other != part).collect::<Vec<_>>().join(".")
}

fn end_of(item: &Item, count: Count, has_item: bool) -> Result<End, String> {
    let is_one = count == Count::One || has_item;
    match item {
        Item::Plain(Base::Byte | Base::Char | Base::Uint8)
            if !is_one && matches!(count, Count::Exactly(count) if count <= MOST_BYTES) =>
        {
            Ok(End::Bytes)
        }
        _ if !is_one => {
            Err("this is an array; name one of its items, such as `[0]`, or `[-1]` for the last".to_owned())
        }
        Item::Plain(Base::Bool) => Ok(End::Bool),
        Item::Plain(Base::Float32 | Base::Float64) => Ok(End::Real),
        Item::Plain(Base::String(_) | Base::WString(_)) => Ok(End::Text),
        Item::Plain(_) => Ok(End::Int),
        Item::Message(layout) if is_time(layout) => Ok(End::Time),
        Item::Message(layout) => {
            let names: Vec<&str> = layout.fields.iter().map(|slot| slot.name.as_str()).collect();
            Err(format!("this is a message; name one of its fields: {}", names.join(", ")))
        }
    }
}

fn is_time(layout: &Layout) -> bool {
    layout.name.package.as_deref() == Some("builtin_interfaces") && layout.name.name == "Time"
}

fn want_below(steps: &[(usize, Option<i64>)], layout: &Layout, want: &mut Want) {
    let Some(((field, _), rest)) = steps.split_first() else {
        *want = Want::All;
        return;
    };
    if *want == Want::Nothing {
        *want = Want::Fields(vec![Want::Nothing; layout.fields.len()]);
    }
    let Want::Fields(wants) = want else { return };
    match &layout.fields[*field].item {
        Item::Message(inner) => want_below(rest, inner, &mut wants[*field]),
        Item::Plain(_) => wants[*field] = Want::All,
    }
}

/// A field that can be a value in a channel's message.
#[derive(Clone, Debug)]
pub(crate) struct Leaf<'l> {
    pub(crate) path: String,
    pub(crate) end: End,
    /// The constants of the message that contains the field.
    pub(crate) constants: &'l [Constant],
}

/// The fields of a type that can be a value, among its first 10,000; for an array of messages, those of the last
/// message. Messages nested in each other may have far more fields than definitions.
pub(crate) fn leaves(layout: &Layout) -> Vec<Leaf<'_>> {
    let mut found = Vec::new();
    add_leaves(layout, "", &mut 10_000, &mut found);
    found
}

fn add_leaves<'l>(layout: &'l Layout, below: &str, left: &mut usize, found: &mut Vec<Leaf<'l>>) {
    for slot in &layout.fields {
        let Some(fewer) = left.checked_sub(1) else { return };
        *left = fewer;
        let path = if below.is_empty() { slot.name.clone() } else { format!("{below}.{}", slot.name) };
        match (&slot.item, end_of(&slot.item, slot.count, false)) {
            (_, Ok(end)) => found.push(Leaf { path, end, constants: &layout.constants }),
            (Item::Message(inner), Err(_)) if slot.count == Count::One => add_leaves(inner, &path, left, found),
            (Item::Message(inner), Err(_)) => add_leaves(inner, &format!("{path}[-1]"), left, found),
            (Item::Plain(_), Err(_)) => {}
        }
    }
}
