//! Formulas about the latest message of each event.

use std::collections::BTreeMap;
use std::fmt;

use skills::Datum;

/// `left U right`, or a formula defined by it: `right` must hold in some state with a number of steps within the
/// bounds, and `left` until then.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Path {
    pub(super) left: Expression,
    pub(super) right: Expression,
    /// The verdict as soon as `right` holds, if `left` has held until then.
    pub(super) reached: bool,
    /// The verdict if the run ends before that.
    pub(super) at_end: bool,
    pub(super) from: u64,
    pub(super) to: Option<u64>,
}

impl Path {
    pub(super) fn counts_steps(&self) -> bool {
        self.from > 0 || self.to.is_some()
    }

    /// The verdict in this state, if it is final.
    pub(super) fn verdict(&self, state: &Valuation, step: u64) -> Option<bool> {
        if self.to.is_some_and(|to| step > to) {
            return Some(self.at_end);
        }
        if step >= self.from && self.right.holds(state) {
            return Some(self.reached);
        }
        (!self.left.holds(state)).then_some(!self.reached)
    }
}

/// AS2FM's number for the first node of a tree.
pub(super) const FIRST_NODE: usize = 1000;

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Variable {
    /// Whether an event has been sent.
    Valid(String),
    /// A field of an event's latest message; dots lead to nested members.
    Field(String, String),
    /// The last status of a node of the tree, by its place in the file: 1 success, 2 failure, 3 running; 0 before the
    /// end of the first tick that reaches it.
    Node(usize),
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Expression {
    Bool(bool),
    Number(f64),
    Array(Vec<f64>),
    Variable(Variable),
    Not(Box<Self>),
    Binary(Operator, Box<Self>, Box<Self>),
    Item(Box<Self>, Box<Self>),
    Length(Box<Self>),
    Absolute(Box<Self>),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Operator {
    And,
    Or,
    Implies,
    Equal,
    Unequal,
    Less,
    LessOrEqual,
    Greater,
    GreaterOrEqual,
    Plus,
    Minus,
    Times,
    Divided,
    Modulo,
    Minimum,
    Maximum,
}

impl Operator {
    const SIGNS: [(&str, Self); 16] = [
        ("∧", Self::And),
        ("∨", Self::Or),
        ("⇒", Self::Implies),
        ("=", Self::Equal),
        ("≠", Self::Unequal),
        ("<", Self::Less),
        ("≤", Self::LessOrEqual),
        (">", Self::Greater),
        ("≥", Self::GreaterOrEqual),
        ("+", Self::Plus),
        ("-", Self::Minus),
        ("*", Self::Times),
        ("/", Self::Divided),
        ("%", Self::Modulo),
        ("min", Self::Minimum),
        ("max", Self::Maximum),
    ];

    pub(super) fn of(sign: &str) -> Option<Self> {
        Self::SIGNS.iter().find(|(known, _)| *known == sign).map(|(_, operator)| *operator)
    }

    fn sign(self) -> &'static str {
        Self::SIGNS.iter().find(|(_, operator)| *operator == self).map_or("", |(sign, _)| sign)
    }

    /// Whether its result is true or false.
    pub(super) fn is_truth(self) -> bool {
        !matches!(
            self,
            Self::Plus | Self::Minus | Self::Times | Self::Divided | Self::Modulo | Self::Minimum | Self::Maximum
        )
    }
}

/// The latest messages.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(crate) struct Valuation {
    /// The data of the latest message, by event.
    pub(crate) latest: BTreeMap<String, Datum>,
    /// See [`Variable::Node`].
    pub(crate) nodes: Vec<u8>,
}

impl Expression {
    pub(super) fn holds(&self, state: &Valuation) -> bool {
        matches!(self.value(state), Datum::Bool(true))
    }

    fn number(&self, state: &Valuation) -> f64 {
        match self.value(state) {
            Datum::Number(number) => number,
            Datum::Bool(truth) => f64::from(u8::from(truth)),
            // A value that has not been sent yet counts as 0, as in AS2FM.
            _ => 0.0,
        }
    }

    fn value(&self, state: &Valuation) -> Datum {
        match self {
            Self::Bool(truth) => (*truth).into(),
            Self::Number(number) => (*number).into(),
            Self::Variable(Variable::Valid(event)) => state.latest.contains_key(event).into(),
            Self::Variable(Variable::Field(event, path)) => {
                let data = state.latest.get(event).cloned().unwrap_or_default();
                path.split('.').fold(data, |data, name| data.member(name).cloned().unwrap_or_default())
            }
            Self::Variable(Variable::Node(node)) => f64::from(state.nodes.get(*node).copied().unwrap_or(0)).into(),
            Self::Array(items) => Datum::array(items.iter().map(|number| Datum::from(*number))).unwrap_or_default(),
            Self::Not(inner) => (!inner.holds(state)).into(),
            Self::Binary(operator, left, right) => binary(*operator, left, right, state),
            Self::Item(array, index) => match array.value(state) {
                Datum::Array(array) => array.items().get(index.number(state) as usize).cloned().unwrap_or_default(),
                _ => Datum::Undefined,
            },
            Self::Length(array) => match array.value(state) {
                Datum::Array(array) => (array.items().len() as f64).into(),
                _ => 0.0.into(),
            },
            Self::Absolute(inner) => inner.number(state).abs().into(),
        }
    }

    pub(super) fn visit<'e>(&'e self, visit: &mut dyn FnMut(&'e Variable)) {
        match self {
            Self::Bool(_) | Self::Number(_) | Self::Array(_) => {}
            Self::Variable(variable) => visit(variable),
            Self::Not(inner) | Self::Length(inner) | Self::Absolute(inner) => inner.visit(visit),
            Self::Binary(_, left, right) | Self::Item(left, right) => {
                left.visit(visit);
                right.visit(visit);
            }
        }
    }
}

fn binary(operator: Operator, left: &Expression, right: &Expression, state: &Valuation) -> Datum {
    use Operator as O;
    let numbers = || (left.number(state), right.number(state));
    let compare = |test: fn(f64, f64) -> bool| {
        let (left, right) = numbers();
        Datum::from(test(left, right))
    };
    let compute = |rule: fn(f64, f64) -> f64| {
        let (left, right) = numbers();
        Datum::from(rule(left, right))
    };
    match operator {
        O::And => (left.holds(state) && right.holds(state)).into(),
        O::Or => (left.holds(state) || right.holds(state)).into(),
        O::Implies => (!left.holds(state) || right.holds(state)).into(),
        O::Equal => are_equal(left, right, state).into(),
        O::Unequal => (!are_equal(left, right, state)).into(),
        O::Less => compare(|left, right| left < right),
        O::LessOrEqual => compare(|left, right| left <= right),
        O::Greater => compare(|left, right| left > right),
        O::GreaterOrEqual => compare(|left, right| left >= right),
        O::Plus => compute(|left, right| left + right),
        O::Minus => compute(|left, right| left - right),
        O::Times => compute(|left, right| left * right),
        O::Divided => compute(|left, right| left / right),
        O::Modulo => compute(f64::rem_euclid),
        O::Minimum => compute(f64::min),
        O::Maximum => compute(f64::max),
    }
}

fn are_equal(left: &Expression, right: &Expression, state: &Valuation) -> bool {
    match (left.value(state), right.value(state)) {
        (Datum::Text(left), Datum::Text(right)) => left == right,
        // AS2FM writes a string as the array of its bytes.
        (Datum::Text(text), Datum::Array(bytes)) | (Datum::Array(bytes), Datum::Text(text)) => {
            let bytes = bytes.items().iter().map(|byte| byte.to_text().parse::<u8>().ok());
            bytes.eq(text.bytes().map(Some))
        }
        (left @ Datum::Array(_), right @ Datum::Array(_)) => left == right,
        _ => left.number(state) == right.number(state),
    }
}

impl fmt::Display for Expression {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bool(truth) => write!(f, "{truth}"),
            Self::Number(number) => write!(f, "{number}"),
            Self::Variable(Variable::Valid(event)) => write!(f, "{event}.valid"),
            Self::Variable(Variable::Field(event, path)) => write!(f, "{event}.{path}"),
            Self::Variable(Variable::Node(node)) => write!(f, "bt_{}.status", FIRST_NODE + node),
            Self::Array(items) => write!(f, "{items:?}"),
            Self::Not(inner) => write!(f, "¬{inner}"),
            Self::Binary(operator @ (Operator::Minimum | Operator::Maximum), left, right) => {
                write!(f, "{}({left}, {right})", operator.sign())
            }
            Self::Binary(operator, left, right) => write!(f, "({left} {} {right})", operator.sign()),
            Self::Item(array, index) => write!(f, "{array}[{index}]"),
            Self::Length(array) => write!(f, "{array}.length"),
            Self::Absolute(inner) => write!(f, "|{inner}|"),
        }
    }
}

impl fmt::Display for Path {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let bounds = match (self.from, self.to) {
            (0, None) => String::new(),
            (from, None) => format!("[≥{from}]"),
            (from, Some(to)) => format!("[{from}, {to}]"),
        };
        match (self.reached, self.at_end, &self.left) {
            (true, false, Expression::Bool(true)) => write!(f, "F{bounds} {}", self.right),
            (true, false, left) => write!(f, "{left} U{bounds} {}", self.right),
            (true, true, left) => write!(f, "{left} W{bounds} {}", self.right),
            // G is written as "no state violates it".
            (false, _, _) => match &self.right {
                Expression::Not(inner) => write!(f, "G{bounds} {inner}"),
                right => write!(f, "G{bounds} ¬{right}"),
            },
        }
    }
}
