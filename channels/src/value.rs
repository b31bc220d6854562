//! Values that messages carry.

use std::cmp::Ordering;
use std::fmt;
use std::hash::{Hash, Hasher};
use std::sync::Arc;

use serde::{Deserialize, Serialize};

/// A name that stands for itself, written `<ok>`.
#[derive(Clone, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Symbol(Arc<str>);

impl Symbol {
    /// The symbol with this name (without the angle brackets).
    #[must_use]
    pub fn new(name: &str) -> Self {
        Self(name.into())
    }

    /// The name, without angle brackets.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.0
    }
}

impl fmt::Display for Symbol {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "<{}>", self.0)
    }
}

impl fmt::Debug for Symbol {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

/// One value: a field of a message or the content of a variable.
///
/// Values are compared exactly and can be hashed, so that the states of a system can be compared and hashed, too.
/// Integers and reals are different types and never equal. A real in a channel is never NaN (domains refuse it); as a
/// value, NaN equals itself, and `-0.0` equals `0.0`.
#[derive(Clone, Serialize, Deserialize)]
pub enum Value {
    /// A symbol such as `<ok>`.
    Symbol(Symbol),
    /// A truth value.
    Bool(bool),
    /// An integer.
    Int(i64),
    /// A real number.
    Real(f64),
    /// Text.
    Text(Arc<str>),
    /// A list of any length.
    List(Arc<[Value]>),
}

impl Value {
    /// The symbol with this name.
    #[must_use]
    pub fn symbol(name: &str) -> Self {
        Self::Symbol(Symbol::new(name))
    }

    /// The order of two numbers, exact also between an integer and a real; `None` if one of them is no number, or NaN.
    #[inline]
    #[must_use]
    pub fn order(&self, other: &Self) -> Option<Ordering> {
        match (self, other) {
            (Self::Int(a), Self::Int(b)) => Some(a.cmp(b)),
            (Self::Real(a), Self::Real(b)) => a.partial_cmp(b),
            (Self::Int(a), Self::Real(b)) => order_of(*a, *b),
            (Self::Real(a), Self::Int(b)) => order_of(*b, *a).map(Ordering::reverse),
            _ => None,
        }
    }

    /// The real that is equal to an integer; `None` if the integer has more than 53 bits and would be rounded.
    #[must_use]
    pub fn exact_real(integer: i64) -> Option<Self> {
        let real = Self::Real(integer as f64);
        real.order(&Self::Int(integer)).is_some_and(Ordering::is_eq).then_some(real)
    }

    /// Whether the value is an integer or a real.
    #[must_use]
    pub fn is_number(&self) -> bool {
        matches!(self, Self::Int(_) | Self::Real(_))
    }

    /// The number as a real, if the value is an integer or a real. An integer of more than 53 bits is rounded: numbers
    /// are compared with [`Value::order`].
    #[must_use]
    pub fn as_number(&self) -> Option<f64> {
        match self {
            Self::Int(number) => Some(*number as f64),
            Self::Real(number) => Some(*number),
            _ => None,
        }
    }

    /// Whether the value is the symbol with this name.
    #[must_use]
    pub fn is_symbol(&self, name: &str) -> bool {
        matches!(self, Self::Symbol(symbol) if symbol.name() == name)
    }

    /// A real's bits, with one pattern for zero and one for NaN.
    fn real_bits(number: f64) -> u64 {
        if number == 0.0 {
            0
        } else if number.is_nan() {
            f64::NAN.to_bits()
        } else {
            number.to_bits()
        }
    }
}

/// The order of an integer and a real. As a real, an integer of more than 53 bits would be rounded.
fn order_of(integer: i64, real: f64) -> Option<Ordering> {
    const LIMIT: f64 = -(i64::MIN as f64);
    if real.is_nan() {
        None
    } else if real >= LIMIT {
        Some(Ordering::Less)
    } else if real < -LIMIT {
        Some(Ordering::Greater)
    } else {
        let whole = real.trunc();
        Some(integer.cmp(&(whole as i64)).then_with(|| whole.total_cmp(&real)))
    }
}

impl PartialEq for Value {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Symbol(a), Self::Symbol(b)) => a == b,
            (Self::Bool(a), Self::Bool(b)) => a == b,
            (Self::Int(a), Self::Int(b)) => a == b,
            (Self::Real(a), Self::Real(b)) => Self::real_bits(*a) == Self::real_bits(*b),
            (Self::Text(a), Self::Text(b)) => a == b,
            (Self::List(a), Self::List(b)) => a == b,
            _ => false,
        }
    }
}

impl Eq for Value {}

impl Hash for Value {
    fn hash<H: Hasher>(&self, state: &mut H) {
        std::mem::discriminant(self).hash(state);
        match self {
            Self::Symbol(symbol) => symbol.hash(state),
            Self::Bool(truth) => truth.hash(state),
            Self::Int(number) => number.hash(state),
            Self::Real(number) => Self::real_bits(*number).hash(state),
            Self::Text(text) => text.hash(state),
            Self::List(items) => items.hash(state),
        }
    }
}

/// As the SCOPE language writes it. The alternate form is for readers, in whose eyes a whole real is a number without a
/// fraction: `{:#}` writes 10.0 as `10`, and 9.975000000000014 as `9.975…`, cut off after six decimals. Neither rounds:
/// a value that violates `>= 20` must not look like 20.
impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Symbol(symbol) => write!(f, "{symbol}"),
            Self::Bool(truth) => write!(f, "{truth}"),
            Self::Int(number) => write!(f, "{number}"),
            // Without its sign, since the two zeros are equal.
            Self::Real(0.0) if f.alternate() => f.write_str("0"),
            // With all digits where integers are, so that it cannot be taken for a different integer.
            Self::Real(number) if (1e16..-(i64::MIN as f64)).contains(&number.abs()) => {
                if f.alternate() {
                    write!(f, "{number:.0}")
                } else {
                    write!(f, "{number:.1}")
                }
            }
            Self::Real(number) if f.alternate() => f.write_str(&for_readers(*number)),
            Self::Real(number) => write!(f, "{number:?}"),
            Self::Text(text) => write!(f, "{text:?}"),
            Self::List(items) => write_items(items, f),
        }
    }
}

/// `[1, 2, 3]`
pub(crate) fn write_items(items: &[Value], f: &mut fmt::Formatter<'_>) -> fmt::Result {
    f.write_str("[")?;
    for (index, value) in items.iter().enumerate() {
        f.write_str(if index == 0 { "" } else { ", " })?;
        fmt::Display::fmt(value, f)?;
    }
    f.write_str("]")
}

/// The shortest text that reads back as the number, cut off after six decimals.
fn for_readers(number: f64) -> String {
    const DECIMALS: usize = 6;
    let text = format!("{number:?}");
    match text.split_once('.') {
        Some((whole, "0")) => whole.to_owned(),
        Some((whole, fraction)) if fraction.len() > DECIMALS && !fraction.contains('e') => {
            let shown = format!("{whole}.{}", &fraction[..DECIMALS]);
            format!("{}…", shown.trim_end_matches('0').trim_end_matches('.'))
        }
        _ => text,
    }
}

impl fmt::Debug for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl From<Symbol> for Value {
    fn from(symbol: Symbol) -> Self {
        Self::Symbol(symbol)
    }
}

impl From<bool> for Value {
    fn from(truth: bool) -> Self {
        Self::Bool(truth)
    }
}

impl From<i64> for Value {
    fn from(number: i64) -> Self {
        Self::Int(number)
    }
}

impl From<f64> for Value {
    fn from(number: f64) -> Self {
        Self::Real(number)
    }
}

impl From<&str> for Value {
    fn from(text: &str) -> Self {
        Self::Text(text.into())
    }
}
