//! Paths to fields: `pose.position.x`, `covariance[0]`, `status_list[-1].status`, `ranges[]`.

use std::sync::Arc;

use channels::Value as Scalar;
use ros_messages::{Base, Constant, Count, Layout, Primitive, Type, Value, Want};

/// A path that leads to a field of a message, or of an item of an array in it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Path {
    /// Whether it begins at the item.
    is_within_item: bool,
    steps: Vec<Step>,
    pub(crate) end: End,
    /// The type of the value, or of the items of an array of bytes, and how many these are; none for a time.
    kind: Option<(Primitive, Count)>,
}

/// A path to an array whose items are messages.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ItemsPath {
    steps: Vec<Step>,
    /// The type of the items.
    pub(crate) layout: Arc<Layout>,
}

/// What becomes an event: a message, or an item of it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Part<'v> {
    pub(crate) message: &'v Value,
    /// The item, or else the message.
    pub(crate) item: &'v Value,
}

/// The number of a field, and what of it if it is an array.
type Step = (usize, Option<Items>);

/// What a path takes of an array.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Items {
    /// One item; negative numbers count from the end.
    One(i64),
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
    /// The path in a message, if it leads to a value. Where items of an array in it become events, a path is that in an
    /// item, unless it begins with `/`.
    pub(crate) fn resolve(text: &str, layout: &Layout, items: Option<&ItemsPath>) -> Result<Self, String> {
        let (from, rest) = match (text.strip_prefix('/'), items) {
            (None, Some(items)) => (&*items.layout, text),
            (rest, _) => (layout, rest.unwrap_or(text)),
        };
        let (steps, kind) = walk(rest, from)?;
        let has_item = steps.last().is_some_and(|(_, part)| part.is_some());
        let end = end_of(kind, has_item)?;
        let kind = match &kind.base {
            Base::Primitive(primitive) => Some((*primitive, kind.count)),
            Base::Message(_) => None,
        };
        Ok(Self { is_within_item: rest == text && items.is_some(), end, kind, steps })
    }

    /// What values there can be, in words, if this one cannot be among them.
    pub(crate) fn excludes(&self, value: &Scalar) -> Option<String> {
        let number = match value {
            Scalar::Int(integer) => Some(*integer as f64),
            Scalar::Real(real) => Some(*real),
            _ => None,
        };
        let primitive = self.kind.map(|(primitive, _)| primitive);
        let (is_possible, what) = match (self.end, primitive.and_then(Primitive::range)) {
            (End::Bool, _) => (matches!(value, Scalar::Bool(_)), "true or false".to_owned()),
            (End::Int, Some((least, greatest))) => {
                let is_whole =
                    |number: f64| number.fract() == 0.0 && (least as f64..=greatest as f64).contains(&number);
                let is_possible = match value {
                    Scalar::Int(integer) => (least..=greatest).contains(&i128::from(*integer)),
                    _ => number.is_some_and(is_whole),
                };
                let is_large = greatest >= i64::MAX.into();
                let what =
                    if is_large { "an integer".to_owned() } else { format!("an integer from {least} to {greatest}") };
                (is_possible, what)
            }
            (End::Real, _) if primitive == Some(Primitive::Float32) => {
                let nearest = number.map_or(0.0, |number| f64::from(number as f32));
                let nearest = if number.is_some() { format!(", such as {nearest:?}") } else { String::new() };
                (
                    number.is_some_and(|number| f64::from(number as f32) == number),
                    format!("a number of 32 bits{nearest}"),
                )
            }
            (End::Int | End::Real | End::Time, _) => (number.is_some(), "a number".to_owned()),
            (End::Text, _) => {
                let most = match primitive {
                    Some(Primitive::String(most)) => most,
                    _ => None,
                };
                let fits = |text: &str| most.is_none_or(|most| text.len() <= most);
                let what = most.map_or_else(String::new, |most| format!(" of at most {most} bytes"));
                (matches!(value, Scalar::Text(text) if fits(text)), format!("a string{what}"))
            }
            (End::Bytes, _) => {
                let digits = match self.kind {
                    Some((_, Count::Exactly(bytes))) => 2 * bytes,
                    _ => 0,
                };
                let is_digit = |digit: char| matches!(digit, '0'..='9' | 'a'..='f');
                let fits = |text: &str| text.len() == digits && text.chars().all(is_digit);
                (matches!(value, Scalar::Text(text) if fits(text)), format!("a string of {digits} hexadecimal digits"))
            }
        };
        (!is_possible).then_some(what)
    }

    /// Adds the path to the wanted parts of a message.
    pub(crate) fn want(&self, layout: &Layout, items: Option<&ItemsPath>, want: &mut Want) {
        let above = items.filter(|_| self.is_within_item).map_or(&[][..], |items| &items.steps);
        want_below(&[above, &self.steps].concat(), layout, want, Want::All);
    }

    /// Whether it leads through an item that an array may not have.
    pub(crate) fn may_be_missing(&self) -> bool {
        self.steps.iter().any(|(_, part)| matches!(part, Some(Items::One(_))))
    }

    /// Whether it leads to every item of an array.
    pub(crate) fn is_list(&self) -> bool {
        self.steps.iter().any(|(_, part)| *part == Some(Items::Every))
    }

    /// The value in a message of that type, or in an item; none if an array does not have the item, or if the path
    /// leads to every item.
    pub(crate) fn find<'v>(&self, part: Part<'v>) -> Option<&'v Value> {
        follow(&self.steps, self.start(part))
    }

    /// The values of every item of the array, each of them as [`Self::find`] returns it.
    pub(crate) fn find_all<'v>(&self, part: Part<'v>) -> impl Iterator<Item = Option<&'v Value>> {
        let every = self.steps.iter().position(|(_, part)| *part == Some(Items::Every)).unwrap_or_default();
        let (before, after) = self.steps.split_at(every);
        let array = after.split_first().and_then(|((field, _), rest)| {
            let Value::Message(fields) = follow(before, self.start(part))? else { return None };
            let Value::List(items) = fields.get(*field)? else { return None };
            Some(items.iter().map(move |item| follow(rest, item)))
        });
        array.into_iter().flatten()
    }

    fn start<'v>(&self, part: Part<'v>) -> &'v Value {
        if self.is_within_item { part.item } else { part.message }
    }
}

impl ItemsPath {
    /// The path in a message, if it leads to an array of messages.
    pub(crate) fn resolve(text: &str, layout: &Layout) -> Result<Self, String> {
        let (steps, kind) = walk(text, layout)?;
        if steps.iter().any(|(_, part)| *part == Some(Items::Every)) {
            return Err(format!("`{text}` is not one array: leave out `[]`, or name an item instead"));
        }
        let is_item = steps.last().is_some_and(|(_, part)| part.is_some());
        match &kind.base {
            _ if is_item || kind.count == Count::One => Err(format!("`{text}` is not an array")),
            Base::Message(layout) => Ok(Self { steps, layout: Arc::clone(layout) }),
            Base::Primitive(_) => Err(format!("the items of `{text}` are not messages")),
        }
    }

    /// Adds the array to the wanted parts of a message, and nothing of its items.
    pub(crate) fn want(&self, layout: &Layout, want: &mut Want) {
        want_below(&self.steps, layout, want, nothing_of(&self.layout));
    }

    /// The items in a message; none if the path leads through an item that another array does not have.
    pub(crate) fn find<'v>(&self, message: &'v Value) -> &'v [Value] {
        match follow(&self.steps, message) {
            Some(Value::List(items)) => items,
            _ => &[],
        }
    }
}

/// The steps of a path in a type, and the type of the field to which it leads.
fn walk<'l>(text: &str, layout: &'l Layout) -> Result<(Vec<Step>, &'l Type<Arc<Layout>>), String> {
    // Where the path has led so far: a message, or none below which fields could be named. A value in the middle of
    // a path is no mistake until another part follows, so only the last part's end counts.
    let (mut steps, mut at, mut end) = (Vec::new(), Some(layout), None);
    for part in text.split('.') {
        let (name, item) = match part.strip_suffix(']').and_then(|part| part.split_once('[')) {
            Some((name, "")) => (name, Some(Items::Every)),
            Some((name, item)) => {
                let number = item.parse().map_err(|_| format!("`{item}` is not the number of an item"))?;
                (name, Some(Items::One(number)))
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
            Some(Items::One(item)) if !is_array => {
                return Err(format!("`{name}` is not an array, so it has no item {item}"));
            }
            Some(Items::Every) if !is_array => return Err(format!("`{name}` is not an array, so it has no items")),
            Some(Items::Every) if steps.iter().any(|(_, part)| *part == Some(Items::Every)) => {
                return Err(format!("`{text}` would be a list of lists: name an item of one array"));
            }
            _ => steps.push((field, item)),
        }
        end = Some(kind);
        at = match &kind.base {
            Base::Message(layout) if !is_array || item.is_some() => Some(layout),
            _ => None,
        };
    }
    Ok((steps, end.ok_or_else(|| format!("`{text}` is not a path"))?))
}

fn follow<'v>(steps: &[Step], from: &'v Value) -> Option<&'v Value> {
    steps.iter().try_fold(from, |at, (field, part)| {
        let Value::Message(fields) = at else { return None };
        match (fields.get(*field)?, part) {
            (Value::List(items), Some(Items::One(item))) => {
                let index = if *item < 0 { items.len() as i64 + item } else { *item };
                items.get(usize::try_from(index).ok()?)
            }
            (_, Some(Items::Every)) => None,
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

/// Adds that much of what the steps lead to.
fn want_below(steps: &[Step], layout: &Layout, want: &mut Want, end: Want) {
    let Some(((field, _), rest)) = steps.split_first() else {
        if *want == Want::Nothing || end == Want::All {
            *want = end;
        }
        return;
    };
    if *want == Want::Nothing {
        *want = nothing_of(layout);
    }
    let Want::Fields(wants) = want else { return };
    match &layout.fields[*field].kind.base {
        Base::Message(inner) => want_below(rest, inner, &mut wants[*field], end),
        Base::Primitive(_) => wants[*field] = Want::All,
    }
}

/// That there is a message, and none of its fields.
fn nothing_of(layout: &Layout) -> Want {
    Want::Fields(vec![Want::Nothing; layout.fields.len()])
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

/// The arrays of messages in a message, with the type of their items, but for those within the items of others.
pub(crate) fn arrays(layout: &Layout) -> Vec<(String, &Layout)> {
    let (mut found, mut left) = (Vec::new(), 10_000);
    add_arrays(layout, "", &mut left, &mut found);
    found
}

fn add_arrays<'l>(layout: &'l Layout, below: &str, left: &mut usize, found: &mut Vec<(String, &'l Layout)>) {
    for field in &layout.fields {
        let Some(fewer) = left.checked_sub(1) else { return };
        *left = fewer;
        let Base::Message(inner) = &field.kind.base else { continue };
        let path = if below.is_empty() { field.name.clone() } else { format!("{below}.{}", field.name) };
        match field.kind.count {
            Count::One => add_arrays(inner, &path, left, found),
            _ => found.push((path, inner)),
        }
    }
}
