//! Whether a message satisfies a condition, with numbers as integers of 128 bits: a real is an odd integer times a
//! power of two. No number is compared as a real, and none with the functions of the crates that this checks.

use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::sync::Arc;

use channels::{Message, Relation, Shape, Value};
use monitors::{Arithmetic, MessageCondition, MessageField, Term};

/// Values that have names.
pub(crate) type Names = BTreeMap<Arc<str>, Value>;

/// A number as its sign, and its size as `whole` times two to the power of `exponent`.
#[derive(Clone, Copy)]
enum Number {
    Finite { is_negative: bool, whole: u128, exponent: i32 },
    Infinite { is_negative: bool },
}

fn number(value: &Value) -> Option<Number> {
    match value {
        Value::Int(number) => {
            Some(Number::Finite { is_negative: *number < 0, whole: i128::from(*number).unsigned_abs(), exponent: 0 })
        }
        Value::Real(real) => {
            let bits = real.to_bits();
            let (is_negative, exponent) = (bits >> 63 == 1, (bits >> 52 & 0x7FF) as i32);
            let fraction = u128::from(bits & ((1 << 52) - 1));
            match (exponent, fraction) {
                (0x7FF, 0) => Some(Number::Infinite { is_negative }),
                (0x7FF, _) => None,
                (0, _) => Some(Number::Finite { is_negative, whole: fraction, exponent: -1074 }),
                _ => Some(Number::Finite { is_negative, whole: fraction | 1 << 52, exponent: exponent - 1075 }),
            }
        }
        _ => None,
    }
}

/// The order of two sizes. Both `whole`s have at most 64 bits.
fn order_of_sizes((a, p): (u128, i32), (b, q): (u128, i32)) -> Ordering {
    match (a, b) {
        (0, 0) => Ordering::Equal,
        (0, _) => Ordering::Less,
        (_, 0) => Ordering::Greater,
        // A shift by more than 63 bits makes the one with the larger exponent larger in any case.
        _ if p > q => {
            if p - q > 63 {
                Ordering::Greater
            } else {
                (a << (p - q)).cmp(&b)
            }
        }
        _ => {
            if q - p > 63 {
                Ordering::Less
            } else {
                a.cmp(&(b << (q - p)))
            }
        }
    }
}

/// The order of two numbers; none if one of them is no number.
pub(crate) fn order(a: &Value, b: &Value) -> Option<Ordering> {
    let sign = |is_negative: bool, order: Ordering| if is_negative { order.reverse() } else { order };
    Some(match (number(a)?, number(b)?) {
        (Number::Infinite { is_negative: a }, Number::Infinite { is_negative: b }) => b.cmp(&a),
        (Number::Infinite { is_negative }, _) => sign(is_negative, Ordering::Greater),
        (_, Number::Infinite { is_negative }) => sign(is_negative, Ordering::Less),
        (
            Number::Finite { is_negative: a, whole: x, exponent: p },
            Number::Finite { is_negative: b, whole: y, exponent: q },
        ) => match (x, y) {
            (0, 0) => Ordering::Equal,
            (0, _) => sign(b, Ordering::Less),
            (_, 0) => sign(a, Ordering::Greater),
            _ if a != b => b.cmp(&a),
            _ => sign(a, order_of_sizes((x, p), (y, q))),
        },
    })
}

/// Whether a relation holds between two values.
pub(crate) fn relates(a: &Value, relation: Relation, b: &Value) -> bool {
    let order = order(a, b);
    let is_equal = match (a, b) {
        (Value::Symbol(a), Value::Symbol(b)) => a.name() == b.name(),
        (Value::Text(a), Value::Text(b)) => **a == **b,
        (Value::Bool(a), Value::Bool(b)) => a == b,
        _ => order == Some(Ordering::Equal),
    };
    match relation {
        Relation::Equal => is_equal,
        Relation::NotEqual => !is_equal,
        Relation::Less => order == Some(Ordering::Less),
        Relation::LessOrEqual => matches!(order, Some(Ordering::Less | Ordering::Equal)),
        Relation::Greater => order == Some(Ordering::Greater),
        Relation::GreaterOrEqual => matches!(order, Some(Ordering::Greater | Ordering::Equal)),
    }
}

/// A message, and the shape that its fields' names are from.
#[derive(Clone, Copy)]
pub(crate) struct Named<'a> {
    message: &'a Message,
    shape: Option<&'a Shape>,
}

impl<'a> Named<'a> {
    /// The message, which has one of these shapes.
    pub(crate) fn new(message: &'a Message, shapes: &'a [Shape]) -> Self {
        Self { message, shape: shapes.iter().find(|shape| shape.contains(message)) }
    }

    /// The value of the field with this name, wherever it is; only a field without a name is known by its number.
    pub(crate) fn field(self, field: &MessageField) -> Option<&'a Value> {
        let index = match (&field.name, self.shape) {
            (Some(meant), Some(shape)) => shape.fields().iter().position(|(name, _)| **name == **meant)?,
            _ => field.number.wrapping_sub(1),
        };
        self.message.fields().get(index)
    }
}

/// Whether a message satisfies a condition.
pub(crate) fn satisfies(condition: &MessageCondition, message: Named<'_>, names: &Names) -> bool {
    match condition {
        MessageCondition::True => true,
        MessageCondition::False => false,
        MessageCondition::Compare { field: compared, relation, value } => {
            message.field(compared).map_or(*relation == Relation::NotEqual, |found| relates(found, *relation, value))
        }
        MessageCondition::Relate { left, relation, right } => {
            match (term(left, message, names), term(right, message, names)) {
                (Some(left), Some(right)) => relates(&left, *relation, &right),
                _ => *relation == Relation::NotEqual,
            }
        }
        MessageCondition::Remember { field: remembered, .. } => message.field(remembered).is_some(),
        MessageCondition::Is { .. } => unreachable!("the language has no words for it"),
        MessageCondition::Not(a) => !satisfies(a, message, names),
        MessageCondition::And(all) => !all.iter().any(|part| !satisfies(part, message, names)),
        MessageCondition::Or(all) => all.iter().any(|part| satisfies(part, message, names)),
        MessageCondition::Implies(a, b) => !satisfies(a, message, names) || satisfies(b, message, names),
    }
}

fn term(term: &Term, message: Named<'_>, names: &Names) -> Option<Value> {
    match term {
        Term::Field(field) => message.field(field).cloned(),
        Term::Value(value) => Some(value.clone()),
        Term::Remembered(name) => names.get(name).cloned(),
        Term::Arithmetic(left, operator, right) => {
            calculated(&self::term(left, message, names)?, *operator, &self::term(right, message, names)?)
        }
        Term::Count(condition) => counted(condition, message, names),
        // Rounded here and there, so the numbers could differ: they have tests of their own.
        Term::Call(..) => unreachable!("no condition is drawn that calls a function"),
    }
}

/// Literally: for each place in the lists that the condition mentions, the message with the items there in place of the
/// lists.
fn counted(condition: &MessageCondition, message: Named<'_>, names: &Names) -> Option<Value> {
    let mut longest = None;
    condition.fields(&mut |field| {
        if let Some(Value::List(items)) = message.field(field) {
            longest = longest.max(Some(items.len()));
        }
    });
    let holds = |place: usize| {
        // For what is missing, no relation holds but `!=`, as for a list, even between two of them.
        let at = |value: &Value| match value {
            Value::List(items) => items.get(place).cloned().unwrap_or_else(|| Value::List([].into())),
            value => value.clone(),
        };
        let items = Message::new(message.message.fields().iter().map(at));
        satisfies(condition, Named { message: &items, ..message }, names)
    };
    Some(Value::Int((0..longest?).filter(|place| holds(*place)).count() as i64))
}

/// The result of two integers is an integer of 64 bits, or none; every other result is a finite real, or none.
fn calculated(a: &Value, operator: Arithmetic, b: &Value) -> Option<Value> {
    if let (Value::Int(a), Value::Int(b), false) = (a, b, operator == Arithmetic::Divide) {
        let (a, b) = (i128::from(*a), i128::from(*b));
        let whole = match operator {
            Arithmetic::Add => a + b,
            Arithmetic::Subtract => a - b,
            Arithmetic::Multiply | Arithmetic::Divide => a * b,
        };
        return i64::try_from(whole).ok().map(Value::Int);
    }
    let real = |value: &Value| match value {
        Value::Int(number) => Some(*number as f64),
        Value::Real(real) => Some(*real),
        _ => None,
    };
    let (a, b) = (real(a)?, real(b)?);
    let real = match operator {
        Arithmetic::Add => a + b,
        Arithmetic::Subtract => a - b,
        Arithmetic::Multiply => a * b,
        Arithmetic::Divide => a / b,
    };
    real.is_finite().then_some(Value::Real(real))
}
