//! Formulas with resolved names, as the semantics uses them.

use std::cmp::Ordering;
use std::hash::{Hash, Hasher};
use std::sync::Arc;

use channels::{ChannelId, Relation, Value};
use serde::{Deserialize, Serialize};

/// A SCOPE constraint over the channels of a topology.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Formula {
    /// Always holds.
    True,
    /// Never holds.
    False,
    /// The last message on the channel satisfies the condition.
    Event(EventAtom),
    /// This state is a message on the channel, and it satisfies the condition.
    Fresh(EventAtom),
    /// `time_until (event) ⋈ θ`: a message that satisfies the event passes at some j ≥ i with τj − τi within the bound.
    TimeUntil {
        /// The event.
        event: EventAtom,
        /// ⋈ θ
        bound: Bound,
    },
    /// The operand does not hold.
    Not(Box<Formula>),
    /// All operands hold.
    And(Vec<Formula>),
    /// One operand holds.
    Or(Vec<Formula>),
    /// If the first holds, so does the second.
    Implies(Box<Formula>, Box<Formula>),
    /// The operand holds at the next state at which it is checked.
    Next(Box<Formula>),
    /// The operand holds whenever it is checked.
    Always(Box<Formula>),
    /// The operand holds at some state at which it is checked.
    Eventually(Box<Formula>),
    /// The second operand holds at some state, and the first whenever it is checked before that.
    Until(Box<Formula>, Box<Formula>),
    /// The operand holds or held at some j ≤ i with τi − τj within the bound.
    Once(Bound, Box<Formula>),
    /// The operand holds and held at every j ≤ i with τi − τj within the bound, whenever it was checked.
    Historically(Bound, Box<Formula>),
    /// The operand held when it was checked the last time before i, at a j with τi − τj within the bound.
    Previous(Bound, Box<Formula>),
    /// The second operand holds or held at some j ≤ i with τi − τj within the bound, and the first whenever it was
    /// checked after that.
    Since(Bound, Box<Formula>, Box<Formula>),
    /// At least, or at most, `count` messages that satisfy the event have passed at states j ≤ i with τi − τj within
    /// the bound.
    Count {
        /// The event.
        event: EventAtom,
        /// Whether `count` is the maximum, not the minimum.
        is_at_most: bool,
        /// The number.
        count: u64,
        /// `< θ`, where θ is the length of the window.
        bound: Bound,
    },
    /// A whole formula in which τ is the time of a state and bounds are durations, both in nanoseconds.
    Timed(Box<Formula>),
}

/// A formula cannot be evaluated or monitored.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum FormulaError {
    /// Its clause form has too many parts.
    #[error("the formula is too large: its clause form has more than two thousand parts")]
    TooLarge,
    /// An operator that looks ahead is inside one that looks back.
    #[error("an operator that looks back contains one that looks ahead")]
    LooksAhead,
    /// A formula compares with a value in a case in which the value was not remembered.
    #[error("`{0}` is not remembered in every case in which something is compared with it")]
    NotRemembered(Arc<str>),
    /// Two values with one name are remembered at once.
    #[error("two values named `{0}` are remembered at the same time")]
    RememberedTwice(Arc<str>),
    /// A formula that looks back at values would have to remember all messages.
    #[error("looking back at remembered values needs an upper bound, as in `once[<= 10 min]`")]
    Endless,
    /// A condition is about field 0.
    #[error("a condition is about m[0], but fields are counted from 1")]
    NoSuchField,
}

/// A bound of an operator, as the formula has it: `⋈ ticks`.
///
/// A bound that no number of ticks can meet, `< 0`, is not special: the part that contains it is checked like any
/// other.
///
/// The duration from which the ticks were computed is for people: bounds with equal ticks are equal.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Bound {
    /// ⋈
    pub relation: Relation,
    /// θ
    pub ticks: u64,
    /// The duration that the property writes for θ, in nanoseconds, and its unit.
    pub(crate) written: Option<(u64, Unit)>,
}

impl Bound {
    /// No bound: `>= 0`.
    pub const NONE: Self = Self::new(Relation::GreaterOrEqual, 0);

    /// A bound in ticks.
    #[must_use]
    pub const fn new(relation: Relation, ticks: u64) -> Self {
        Self { relation, ticks, written: None }
    }

    /// Whether the property writes a duration, from which the ticks were computed.
    #[must_use]
    pub fn is_duration(&self) -> bool {
        self.written.is_some()
    }

    fn meaning(self) -> (Relation, u64) {
        (self.relation, self.ticks)
    }
}

impl PartialEq for Bound {
    fn eq(&self, other: &Self) -> bool {
        self.meaning() == other.meaning()
    }
}

impl Eq for Bound {}

impl Hash for Bound {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.meaning().hash(state);
    }
}

impl PartialOrd for Bound {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Bound {
    fn cmp(&self, other: &Self) -> Ordering {
        self.meaning().cmp(&other.meaning())
    }
}

/// A unit of time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Unit {
    /// `ms`
    Milliseconds,
    /// `s`
    Seconds,
    /// `min`
    Minutes,
    /// `h`
    Hours,
}

impl Unit {
    /// All units.
    pub const ALL: [Self; 4] = [Self::Milliseconds, Self::Seconds, Self::Minutes, Self::Hours];

    /// The name in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Milliseconds => "ms",
            Self::Seconds => "s",
            Self::Minutes => "min",
            Self::Hours => "h",
        }
    }

    /// Its length in nanoseconds.
    #[must_use]
    pub fn nanos(self) -> u64 {
        match self {
            Self::Milliseconds => 1_000_000,
            Self::Seconds => 1_000_000_000,
            Self::Minutes => 60_000_000_000,
            Self::Hours => 3_600_000_000_000,
        }
    }
}

/// An event atom: a channel and a condition on its messages.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct EventAtom {
    /// The channel.
    pub channel: ChannelId,
    /// The condition that a message must satisfy.
    pub condition: MessageCondition,
}

/// A condition on one message.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum MessageCondition {
    /// Any message.
    True,
    /// No message.
    False,
    /// `m[field] ⋈ value`. If the field is missing or of another type, every relation is false except `!=`, which means
    /// `not (m[field] = value)`.
    Compare {
        /// The field.
        field: MessageField,
        /// ⋈
        relation: Relation,
        /// The value that it is compared with.
        value: Value,
    },
    /// The operand does not hold.
    Not(Box<MessageCondition>),
    /// All operands hold.
    And(Vec<MessageCondition>),
    /// One operand holds.
    Or(Vec<MessageCondition>),
    /// If the first holds, so does the second.
    Implies(Box<MessageCondition>, Box<MessageCondition>),
    /// The values of two terms compare. If one has none, every relation is false except `!=`.
    Relate {
        /// The left term.
        left: Term,
        /// ⋈
        relation: Relation,
        /// The right term.
        right: Term,
    },
    /// The message has the field, and its value is remembered: `m[field] as name`.
    Remember {
        /// The field.
        field: MessageField,
        /// The name of the value.
        name: Arc<str>,
    },
    /// The message has a value of this type at this position, counted from 1. The language has no words for it: it
    /// distinguishes messages that have different fields.
    Is {
        /// The position.
        number: usize,
        /// The type.
        is: ValueType,
    },
}

/// The type of a value. Integers and reals are of one type, since they compare.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub enum ValueType {
    /// A symbol.
    Symbol,
    /// `true` or `false`.
    Bool,
    /// An integer or a real number.
    Number,
    /// Text.
    Text,
    /// A list.
    List,
}

impl ValueType {
    /// The type of a value.
    #[must_use]
    pub fn of(value: &Value) -> Self {
        match value {
            Value::Symbol(_) => Self::Symbol,
            Value::Bool(_) => Self::Bool,
            Value::Int(_) | Value::Real(_) => Self::Number,
            Value::Text(_) => Self::Text,
            Value::List(_) => Self::List,
        }
    }
}

/// A field of a message.
///
/// Its number and what is given determine which field is meant. The name is for readers: fields that agree in both are
/// equal, whatever they are called.
#[derive(Clone, Debug, Eq, Serialize, Deserialize)]
pub struct MessageField {
    /// Its position, counted from 1.
    pub number: usize,
    /// Its name, if the property calls it by name.
    pub name: Option<Arc<str>>,
    /// If other messages of the channel have another field at this position: what selects those that have this one. All
    /// others do not have the field, in every condition.
    pub given: Option<Box<MessageCondition>>,
}

impl PartialEq for MessageField {
    fn eq(&self, other: &Self) -> bool {
        self.number == other.number && self.given == other.given
    }
}

impl Hash for MessageField {
    fn hash<H: Hasher>(&self, state: &mut H) {
        (self.number, &self.given).hash(state);
    }
}

impl From<usize> for MessageField {
    fn from(number: usize) -> Self {
        Self { number, name: None, given: None }
    }
}

/// A value that a condition compares.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Term {
    /// The field of the message.
    Field(MessageField),
    /// A constant.
    Value(Value),
    /// A value that was remembered from this message or another.
    Remembered(Arc<str>),
    /// Arithmetic on numbers.
    Arithmetic(Box<Term>, Arithmetic, Box<Term>),
    /// A function of numbers, with as many as it takes.
    Call(Function, Vec<Term>),
    /// The number of items with which the condition holds: each time, every list that it mentions stands for its item
    /// at the same place. It counts up to the end of the longest list; shorter ones then have no value. A message
    /// without any of these lists has no such number.
    Count(Box<MessageCondition>),
}

/// A function of numbers. What is not finite has no value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Function {
    /// `distance(x, y, u, v)`: from one point to another.
    Distance,
    /// `angle(a, b)`: between two directions, in radians from 0 to π.
    Angle,
    /// `yaw(x, y, z, w)`: the rotation about the z axis, in radians from −π to π, of a quaternion of any length but 0.
    Yaw,
}

impl Function {
    /// All functions.
    pub const ALL: [Self; 3] = [Self::Distance, Self::Angle, Self::Yaw];

    /// Its name, and those of its numbers.
    #[must_use]
    pub fn signature(self) -> (&'static str, &'static [&'static str]) {
        match self {
            Self::Distance => ("distance", &["x", "y", "u", "v"]),
            Self::Angle => ("angle", &["a", "b"]),
            Self::Yaw => ("yaw", &["x", "y", "z", "w"]),
        }
    }
}

/// An operator on numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Arithmetic {
    /// `+`
    Add,
    /// `-`
    Subtract,
    /// `*`
    Multiply,
    /// `/`, whose result is a real number.
    Divide,
}

impl Arithmetic {
    /// Whether it binds tighter than a sum.
    pub(crate) fn is_factor(self) -> bool {
        matches!(self, Self::Multiply | Self::Divide)
    }

    /// The sign in formulas.
    #[must_use]
    pub fn sign(self) -> &'static str {
        match self {
            Self::Add => "+",
            Self::Subtract => "-",
            Self::Multiply => "*",
            Self::Divide => "/",
        }
    }
}

impl MessageCondition {
    /// Calls `visit` with the field, relation and constant of each comparison with a constant.
    pub fn comparisons<'a>(&'a self, visit: &mut dyn FnMut(usize, Relation, &'a Value)) {
        if let Self::Compare { field, relation, value } = self {
            field.given.iter().for_each(|given| given.comparisons(visit));
            visit(field.number, *relation, value);
        }
        self.operands().into_iter().for_each(|operand| operand.comparisons(visit));
    }

    /// Calls `visit` with each field that it mentions.
    pub fn fields(&self, visit: &mut dyn FnMut(&MessageField)) {
        match self {
            Self::Compare { field, .. } | Self::Remember { field, .. } => visit(field),
            Self::Relate { left, right, .. } => [left, right].into_iter().for_each(|term| term.fields(visit)),
            _ => self.operands().into_iter().for_each(|operand| operand.fields(visit)),
        }
    }

    /// Whether it is one comparison (or remembers one value), and calls a field by its name.
    pub(crate) fn calls_by_name(&self) -> bool {
        let mut is_named = false;
        if self.operands().is_empty() {
            self.fields(&mut |field| is_named |= field.name.is_some());
        }
        is_named
    }

    /// Calls `visit` with each field that is remembered, or compared with anything but a constant.
    pub fn related_fields(&self, visit: &mut impl FnMut(usize)) {
        match self {
            Self::Remember { field, .. } => visit(field.number),
            Self::Relate { left, right, .. } => {
                [left, right].into_iter().for_each(|term| term.fields(&mut |field| visit(field.number)));
            }
            _ => self.operands().into_iter().for_each(|operand| operand.related_fields(visit)),
        }
    }
}

impl Term {
    /// Calls `visit` with each field.
    pub fn fields(&self, visit: &mut dyn FnMut(&MessageField)) {
        match self {
            Self::Field(field) => visit(field),
            Self::Value(_) | Self::Remembered(_) => {}
            Self::Arithmetic(left, _, right) => {
                left.fields(visit);
                right.fields(visit);
            }
            Self::Call(_, terms) => terms.iter().for_each(|term| term.fields(visit)),
            Self::Count(condition) => condition.fields(visit),
        }
    }
}

impl Formula {
    /// Whether it is that of a `timed property`.
    #[must_use]
    pub fn is_timed(&self) -> bool {
        matches!(self, Self::Timed(_))
    }

    /// The negation of this formula.
    #[must_use]
    pub fn negated(self) -> Self {
        Self::Not(Box::new(self))
    }

    /// The implication from this formula to the other.
    #[must_use]
    pub fn implies(self, other: Self) -> Self {
        Self::Implies(Box::new(self), Box::new(other))
    }

    /// `always` this formula.
    #[must_use]
    pub fn always(self) -> Self {
        Self::Always(Box::new(self))
    }
}
