//! Values that a formula remembers from one message and compares in another.

use std::cmp::Ordering;
use std::f64::consts::TAU;
use std::sync::Arc;

use channels::{ChannelId, Message, Relation, Value};

use crate::formula::{Arithmetic, EventAtom, Formula, Function, MessageCondition, MessageField, Term, ValueType};

/// The values of names. Names without a value are left out.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Default)]
pub(crate) struct Values(Option<Arc<[Binding]>>);

type Binding = (Arc<str>, Value);

/// A name, and the field of the last message on a channel that it stands for.
pub(crate) type Remembered = (Arc<str>, ChannelId, MessageField);

impl Values {
    fn bindings(&self) -> &[Binding] {
        self.0.as_deref().unwrap_or_default()
    }

    pub(crate) fn get(&self, name: &str) -> Option<&Value> {
        self.bindings().iter().find(|(known, _)| **known == *name).map(|(_, value)| value)
    }

    fn new(mut bindings: Vec<Binding>) -> Self {
        bindings.sort_by(|(a, _), (b, _)| a.cmp(b));
        Self((!bindings.is_empty()).then(|| bindings.into()))
    }

    /// These values, updated with those that are remembered now; a field may lack a value.
    pub(crate) fn with<'m>(&self, remembered: &[Remembered], last: impl Fn(ChannelId) -> Option<&'m Message>) -> Self {
        if remembered.is_empty() {
            return self.clone();
        }
        let is_new = |name: &Arc<str>| remembered.iter().any(|(new, ..)| new == name);
        let mut bindings: Vec<_> = self.bindings().iter().filter(|(name, _)| !is_new(name)).cloned().collect();
        let new = remembered.iter().filter_map(|(name, channel, field)| {
            let seen = Seen { message: last(*channel)?, item: None };
            Some((Arc::clone(name), seen.field(field)?.clone()))
        });
        bindings.extend(new);
        Self::new(bindings)
    }

    pub(crate) fn only(&self, names: &[Arc<str>]) -> Self {
        if self.bindings().iter().all(|(name, _)| names.contains(name)) {
            return self.clone();
        }
        Self::new(self.bindings().iter().filter(|(name, _)| names.contains(name)).cloned().collect())
    }
}

/// An arbitrary total order, so that obligations have one.
fn order(a: &Value, b: &Value) -> Ordering {
    let rank = |value: &Value| match value {
        Value::Symbol(_) => 0,
        Value::Bool(_) => 1,
        Value::Int(_) => 2,
        Value::Real(_) => 3,
        Value::Text(_) => 4,
        Value::List(_) => 5,
    };
    match (a, b) {
        _ if a == b => Ordering::Equal,
        (Value::Symbol(a), Value::Symbol(b)) => a.cmp(b),
        (Value::Int(a), Value::Int(b)) => a.cmp(b),
        (Value::Real(a), Value::Real(b)) => a.total_cmp(b),
        (Value::Text(a), Value::Text(b)) => a.cmp(b),
        (Value::Bool(a), Value::Bool(b)) => a.cmp(b),
        (Value::List(a), Value::List(b)) => {
            let first = a.iter().zip(b.iter()).map(|(a, b)| order(a, b)).find(|ordering| ordering.is_ne());
            first.unwrap_or_else(|| a.len().cmp(&b.len()))
        }
        _ => rank(a).cmp(&rank(b)),
    }
}

impl Ord for Values {
    fn cmp(&self, other: &Self) -> Ordering {
        let pairs = self.bindings().iter().zip(other.bindings());
        let mut differences = pairs.map(|((a, x), (b, y))| a.cmp(b).then_with(|| order(x, y)));
        let first = differences.find(|ordering| *ordering != Ordering::Equal);
        first.unwrap_or_else(|| self.bindings().len().cmp(&other.bindings().len()))
    }
}

impl PartialOrd for Values {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Term {
    /// The term's value; `None` if a field or a remembered value is missing, or if an operand is not a number.
    fn value(&self, seen: Seen<'_>, values: &Values) -> Option<Value> {
        match self {
            Self::Field(field) => seen.field(field).cloned(),
            Self::Value(value) => Some(value.clone()),
            Self::Remembered(name) => values.get(name).cloned(),
            Self::Arithmetic(left, operator, right) => {
                operator.of(&left.value(seen, values)?, &right.value(seen, values)?)
            }
            Self::Call(function, terms) => {
                let numbers = terms.iter().map(|term| term.value(seen, values)?.as_number());
                function.of(&numbers.collect::<Option<Vec<_>>>()?)
            }
            Self::Count(condition) => {
                let (mut longest, whole) = (None, Seen { item: None, ..seen });
                condition.fields(&mut |field| {
                    if let Some(Value::List(items)) = whole.field(field) {
                        longest = longest.max(Some(items.len()));
                    }
                });
                let holds = |item: &usize| condition.holds_in(Seen { item: Some(*item), ..seen }, values);
                Some(Value::Int((0..longest?).filter(holds).count() as i64))
            }
        }
    }

    /// Calls `visit` with each name.
    fn names<'a>(&'a self, visit: &mut dyn FnMut(&'a Arc<str>)) {
        match self {
            Self::Field(_) | Self::Value(_) => {}
            Self::Remembered(name) => visit(name),
            Self::Arithmetic(left, _, right) => {
                left.names(visit);
                right.names(visit);
            }
            Self::Call(_, terms) => terms.iter().for_each(|term| term.names(visit)),
            Self::Count(condition) => condition.names(visit),
        }
    }

    /// The term with values in place of names.
    fn instantiated(&self, values: &Values) -> Self {
        match self {
            Self::Remembered(name) => values.get(name).map_or_else(|| self.clone(), |value| Self::Value(value.clone())),
            Self::Arithmetic(left, operator, right) => {
                let (left, right) = (left.instantiated(values), right.instantiated(values));
                let known = match (&left, &right) {
                    (Self::Value(a), Self::Value(b)) => operator.of(a, b),
                    _ => None,
                };
                known.map_or_else(|| Self::Arithmetic(Box::new(left), *operator, Box::new(right)), Self::Value)
            }
            Self::Call(function, terms) => {
                let terms: Vec<Self> = terms.iter().map(|term| term.instantiated(values)).collect();
                let known = |term: &Self| if let Self::Value(value) = term { value.as_number() } else { None };
                let numbers: Option<Vec<f64>> = terms.iter().map(known).collect();
                let whole = numbers.and_then(|numbers| function.of(&numbers));
                whole.map_or_else(|| Self::Call(*function, terms), Self::Value)
            }
            Self::Count(condition) => Self::Count(Box::new(condition.instantiated(values))),
            other => other.clone(),
        }
    }
}

impl Function {
    /// Its value for as many numbers as it takes.
    pub(crate) fn of(self, numbers: &[f64]) -> Option<Value> {
        let real = match (self, numbers) {
            (Self::Distance, [x, y, u, v]) => libm::hypot(x - u, y - v),
            (Self::Angle, [a, b]) => {
                let turn = (a - b).rem_euclid(TAU);
                turn.min(TAU - turn)
            }
            (Self::Yaw, [x, y, z, w]) => {
                // Squares of a large or small quaternion would overflow or vanish.
                let largest = [x, y, z, w].into_iter().fold(0.0_f64, |largest, part| largest.max(part.abs()));
                let [x, y, z, w] = [x, y, z, w].map(|part| part / largest);
                libm::atan2(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z)
            }
            _ => f64::NAN,
        };
        real.is_finite().then_some(Value::Real(real))
    }
}

/// A message as a condition sees it: whole, or with an item in place of each list.
#[derive(Clone, Copy)]
struct Seen<'m> {
    message: &'m Message,
    item: Option<usize>,
}

impl<'m> Seen<'m> {
    fn field(self, field: &MessageField) -> Option<&'m Value> {
        let has_another = |given: &MessageCondition| !given.holds(self.message);
        if field.given.as_deref().is_some_and(has_another) {
            return None;
        }
        match (self.message.field(field.number)?, self.item) {
            (Value::List(items), Some(item)) => items.get(item),
            (value, _) => Some(value),
        }
    }
}

impl Arithmetic {
    /// The result of the operation on two numbers. Integers stay integers, except in a division; a value that is not
    /// finite is not a number.
    pub(crate) fn of(self, a: &Value, b: &Value) -> Option<Value> {
        if let (Value::Int(a), Value::Int(b)) = (a, b) {
            let whole = match self {
                Self::Add => Some(a.checked_add(*b)?),
                Self::Subtract => Some(a.checked_sub(*b)?),
                Self::Multiply => Some(a.checked_mul(*b)?),
                Self::Divide => None,
            };
            if let Some(whole) = whole {
                return Some(Value::Int(whole));
            }
        }
        let (a, b) = (a.as_number()?, b.as_number()?);
        let real = match self {
            Self::Add => a + b,
            Self::Subtract => a - b,
            Self::Multiply => a * b,
            Self::Divide => a / b,
        };
        real.is_finite().then_some(Value::Real(real))
    }
}

impl MessageCondition {
    /// The comparison of two terms: [`Self::Compare`] for a field on the left and a value on the right.
    pub(crate) fn relating(left: Term, relation: Relation, right: Term) -> Self {
        match (left, right) {
            (Term::Field(field), Term::Value(value)) => Self::Compare { field, relation, value },
            (left, right) => Self::Relate { left, relation, right },
        }
    }

    /// Whether a message satisfies the condition, if no value is remembered.
    #[must_use]
    pub fn holds(&self, message: &Message) -> bool {
        self.holds_with(message, &Values::default())
    }

    pub(crate) fn holds_with(&self, message: &Message, values: &Values) -> bool {
        self.holds_in(Seen { message, item: None }, values)
    }

    fn holds_in(&self, seen: Seen<'_>, values: &Values) -> bool {
        match self {
            Self::True => true,
            Self::False => false,
            Self::Compare { field, relation, value } => {
                seen.field(field).map_or(*relation == Relation::NotEqual, |found| relation.holds(found, value))
            }
            Self::Relate { left, relation, right } => match (left.value(seen, values), right.value(seen, values)) {
                (Some(left), Some(right)) => relation.holds(&left, &right),
                _ => *relation == Relation::NotEqual,
            },
            Self::Remember { field, .. } => seen.field(field).is_some(),
            Self::Is { number, is } => seen.message.field(*number).is_some_and(|value| ValueType::of(value) == *is),
            Self::Not(condition) => !condition.holds_in(seen, values),
            Self::And(conditions) => conditions.iter().all(|condition| condition.holds_in(seen, values)),
            Self::Or(conditions) => conditions.iter().any(|condition| condition.holds_in(seen, values)),
            Self::Implies(a, b) => !a.holds_in(seen, values) || b.holds_in(seen, values),
        }
    }

    /// Its immediate parts, in the order in which they are written.
    #[must_use]
    pub fn operands(&self) -> Vec<&Self> {
        match self {
            Self::True
            | Self::False
            | Self::Compare { .. }
            | Self::Relate { .. }
            | Self::Remember { .. }
            | Self::Is { .. } => Vec::new(),
            Self::Not(a) => vec![a],
            Self::And(parts) | Self::Or(parts) => parts.iter().collect(),
            Self::Implies(a, b) => vec![a, b],
        }
    }

    /// Whether it compares fields with constants only, so that samples can stand for all messages.
    pub(crate) fn is_simple(&self) -> bool {
        !matches!(self, Self::Relate { .. }) && self.operands().into_iter().all(Self::is_simple)
    }

    /// Calls `visit` with each name that it compares with.
    pub(crate) fn names<'a>(&'a self, visit: &mut dyn FnMut(&'a Arc<str>)) {
        if let Self::Relate { left, right, .. } = self {
            left.names(visit);
            right.names(visit);
        }
        self.operands().into_iter().for_each(|operand| operand.names(visit));
    }

    /// Calls `visit` with each name that it gives to a field.
    pub(crate) fn remembers<'a>(&'a self, visit: &mut impl FnMut(&'a Arc<str>, &'a MessageField)) {
        if let Self::Remember { field, name } = self {
            visit(name, field);
        }
        self.operands().into_iter().for_each(|operand| operand.remembers(visit));
    }

    /// Calls `visit` with each part that has no parts itself.
    pub(crate) fn leaves_mut(&mut self, visit: &mut dyn FnMut(&mut Self)) {
        match self {
            Self::Not(a) => a.leaves_mut(visit),
            Self::And(parts) | Self::Or(parts) => parts.iter_mut().for_each(|part| part.leaves_mut(visit)),
            Self::Implies(a, b) => [a, b].into_iter().for_each(|part| part.leaves_mut(visit)),
            leaf => visit(leaf),
        }
    }

    /// The condition with values in place of names.
    fn instantiated(&self, values: &Values) -> Self {
        let mut all = self.clone();
        all.leaves_mut(&mut |leaf| {
            if let Self::Relate { left, relation, right } = leaf {
                *leaf = Self::relating(left.instantiated(values), *relation, right.instantiated(values));
            }
        });
        all
    }
}

impl EventAtom {
    /// The event with values in place of names.
    pub(crate) fn instantiated(&self, values: &Values) -> Self {
        Self { channel: self.channel, condition: self.condition.instantiated(values) }
    }
}

impl Formula {
    /// The formula with values in place of names.
    pub(crate) fn instantiated(&self, values: &Values) -> Self {
        let mut all = self.clone();
        all.events_mut(&mut |event| *event = event.instantiated(values));
        all
    }
}
