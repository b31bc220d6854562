//! Paths to fields: `pose.position.x`, `covariance[0]`, `status_list[-1].status`, `ranges[]`.

use std::sync::Arc;

use ros_messages::{Base, Constant, Count, Layout, Primitive, Type, Value, Want};

/// A path that leads to a field of a message type.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Path {
    steps: Vec<Step>,
    pub(crate) end: End,
}

/// The number of a field, and what of it if it is an array.
type Step = (usize, Option<Part>);

/// What a path takes of an array.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Part {
    /// One item; negative numbers count from the end.
    Item(i64),
    /// Every item: the path leads to a list.
    Every,
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
        // Where the path has led so far: a message, or none below which fields could be named. A value in the middle of
        // a path is no mistake until another part follows, so only the last part's end counts.
        let (mut steps, mut at) = (Vec::new(), Some(layout));
        let mut end = Err(format!("`{text}` is not a path"));
        for part in text.split('.') {
            let (name, item) = match part.strip_suffix(']').and_then(|part| part.split_once('[')) {
                Some((name, "")) => (name, Some(Part::Every)),
                Some((name, item)) => {
                    let number = item.parse().map_err(|_| format!("`{item}` is not the number of an item"))?;
                    (name, Some(Part::Item(number)))
                }
                None => (part, None),
            };
            let Some(layout) = at else { return Err(format!("there is nothing below `{}`", before(text, part))) };
            let Some(field) = layout.fields.iter().position(|field| field.name == name) else {
                let names: Vec<&str> = layout.fields.iter().map(|field| field.name.as_str()).collect();
                let meant = diagnostics::nearest_or_all(name, "fields", &names);
                return Err(format!("{} has no field `{name}`: {meant}", layout.name));
            };
            let kind = &layout.fields[field].kind;
            let is_array = kind.count != Count::One;
            match item {
                Some(Part::Item(item)) if !is_array => {
                    return Err(format!("`{name}` is not an array, so it has no item {item}"));
                }
                Some(Part::Every) if !is_array => return Err(format!("`{name}` is not an array, so it has no items")),
                Some(Part::Every) if steps.iter().any(|(_, part)| *part == Some(Part::Every)) => {
                    return Err(format!("`{text}` would be a list of lists: name an item of one array"));
                }
                _ => steps.push((field, item)),
            }
            end = end_of(kind, item.is_some());
            at = match &kind.base {
                Base::Message(layout) if !is_array || item.is_some() => Some(layout),
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
        self.steps.iter().any(|(_, part)| matches!(part, Some(Part::Item(_))))
    }

    /// Whether it leads to every item of an array.
    pub(crate) fn is_list(&self) -> bool {
        self.steps.iter().any(|(_, part)| *part == Some(Part::Every))
    }

    /// The value in a message of that type; none if an array does not have the item, or if the path leads to every
    /// item.
    pub(crate) fn find<'v>(&self, message: &'v Value) -> Option<&'v Value> {
        follow(&self.steps, message)
    }

    /// The values of every item of the array, each of them as [`Self::find`] returns it.
    pub(crate) fn find_all<'v>(&self, message: &'v Value) -> impl Iterator<Item = Option<&'v Value>> {
        let every = self.steps.iter().position(|(_, part)| *part == Some(Part::Every)).unwrap_or_default();
        let (before, after) = self.steps.split_at(every);
        let array = after.split_first().and_then(|((field, _), rest)| {
            let Value::Message(fields) = follow(before, message)? else { return None };
            let Value::List(items) = fields.get(*field)? else { return None };
            Some(items.iter().map(move |item| follow(rest, item)))
        });
        array.into_iter().flatten()
    }
}

fn follow<'v>(steps: &[Step], from: &'v Value) -> Option<&'v Value> {
    steps.iter().try_fold(from, |at, (field, part)| {
        let Value::Message(fields) = at else { return None };
        match (fields.get(*field)?, part) {
            (Value::List(items), Some(Part::Item(item))) => {
                let index = if *item < 0 { items.len() as i64 + item } else { *item };
                items.get(usize::try_from(index).ok()?)
            }
            (_, Some(Part::Every)) => None,
            (value, _) => Some(value),
        }
    })
}

fn before(text: &str, part: &str) -> String {
    text.split('.').take_while(|other| *other != part).collect::<Vec<_>>().join(".")
}

fn end_of(kind: &Type<Arc<Layout>>, has_item: bool) -> Result<End, String> {
    let is_one = kind.count == Count::One || has_item;
    match &kind.base {
        Base::Primitive(Primitive::Byte | Primitive::Char | Primitive::Uint8)
            if !is_one && matches!(kind.count, Count::Exactly(count) if count <= MOST_BYTES) =>
        {
            Ok(End::Bytes)
        }
        _ if !is_one => {
            let items = "name one of its items, such as `[0]`, `[-1]` for the last, or all of them with `[]`";
            Err(format!("this is an array; {items}"))
        }
        Base::Primitive(Primitive::Bool) => Ok(End::Bool),
        Base::Primitive(Primitive::Float32 | Primitive::Float64) => Ok(End::Real),
        Base::Primitive(Primitive::String(_) | Primitive::WString(_)) => Ok(End::Text),
        Base::Primitive(_) => Ok(End::Int),
        Base::Message(layout) if is_time(layout) => Ok(End::Time),
        Base::Message(layout) => {
            let names: Vec<&str> = layout.fields.iter().map(|field| field.name.as_str()).collect();
            Err(format!("this is a message; name one of its fields: {}", names.join(", ")))
        }
    }
}

fn is_time(layout: &Layout) -> bool {
    layout.name.package.as_deref() == Some("builtin_interfaces") && layout.name.name == "Time"
}

fn want_below(steps: &[Step], layout: &Layout, want: &mut Want) {
    let Some(((field, _), rest)) = steps.split_first() else {
        *want = Want::All;
        return;
    };
    if *want == Want::Nothing {
        *want = Want::Fields(vec![Want::Nothing; layout.fields.len()]);
    }
    let Want::Fields(wants) = want else { return };
    match &layout.fields[*field].kind.base {
        Base::Message(inner) => want_below(rest, inner, &mut wants[*field]),
        Base::Primitive(_) => wants[*field] = Want::All,
    }
}

/// A field that can be a value in a channel's message.
#[derive(Clone, Debug)]
pub(crate) struct ValueField<'l> {
    pub(crate) path: String,
    pub(crate) end: End,
    /// The constants of the message that contains the field.
    pub(crate) constants: &'l [Constant],
}

/// The fields of a type that can be a value, among its first 10,000; for an array of messages, those of the last
/// message. Messages nested in each other may have far more fields than definitions.
pub(crate) fn leaves(layout: &Layout) -> Vec<ValueField<'_>> {
    let mut found = Vec::new();
    add_leaves(layout, "", &mut 10_000, &mut found);
    found
}

fn add_leaves<'l>(layout: &'l Layout, below: &str, left: &mut usize, found: &mut Vec<ValueField<'l>>) {
    for field in &layout.fields {
        let Some(fewer) = left.checked_sub(1) else { return };
        *left = fewer;
        let path = if below.is_empty() { field.name.clone() } else { format!("{below}.{}", field.name) };
        match (&field.kind.base, end_of(&field.kind, false)) {
            (_, Ok(end)) => found.push(ValueField { path, end, constants: &layout.constants }),
            (Base::Message(inner), Err(_)) if field.kind.count == Count::One => add_leaves(inner, &path, left, found),
            (Base::Message(inner), Err(_)) => add_leaves(inner, &format!("{path}[-1]"), left, found),
            (Base::Primitive(_), Err(_)) => {}
        }
    }
}
