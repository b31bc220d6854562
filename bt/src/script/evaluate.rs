//! Running a script.

use std::cmp::Ordering;
use std::fmt::Display;
use std::sync::Arc;

use super::expression::{Assignment, Binary, Comparison, Expression, Script, Unary};
use crate::blackboard::{Blackboard, Slot, Type, Value, ValueError};

/// An error while a script runs.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum ScriptError {
    #[error("the blackboard has no entry `{0}`")]
    Missing(Arc<str>),
    #[error("the blackboard has no entry `{0}`; use `:=` to create one")]
    MissingToAssign(Arc<str>),
    #[error("the entry `{0}` has no value yet")]
    Empty(Arc<str>),
    #[error(transparent)]
    Value(#[from] ValueError),
    #[error("`{operator}` cannot be applied to `{left}` and `{right}`")]
    Operands { operator: &'static str, left: String, right: String },
    #[error("`{operator}` cannot be applied to `{operand}`")]
    Operand { operator: &'static str, operand: String },
    #[error("the entry `{name}` {is} and cannot take `{new}`")]
    Assignment { name: Arc<str>, is: String, new: String },
    #[error("a script can only copy the entry `{name}`, which holds a {of}")]
    Custom { name: Arc<str>, of: Type },
    #[error("a string may have at most {MAX_TEXT_BYTES} bytes")]
    TooLong,
}

/// The maximum length of a string that a script builds: a script that doubles a string in a loop would soon use up all
/// memory.
const MAX_TEXT_BYTES: usize = 1 << 20;

type Evaluated = Result<Value, ScriptError>;

impl Script {
    /// Runs the script: its value is that of its last expression.
    pub(crate) fn run(&self, board: &mut Blackboard) -> Evaluated {
        // A <Script> may be empty; nothing reads its value.
        let Some((last, others)) = self.statements.split_last() else { return Ok(Value::from(true)) };
        for statement in others {
            statement.evaluate(board)?;
        }
        last.evaluate(board)
    }

    /// Runs the script and converts its value to a Boolean.
    pub(crate) fn holds(&self, board: &mut Blackboard) -> Result<bool, ScriptError> {
        match self.run(board)? {
            // A string is not a Boolean in a script, not even `'true'`.
            text @ (Value::Text(_) | Value::List(_)) => Err(ValueError::new(text, "true or false").into()),
            value => Ok(value.to_bool()?),
        }
    }
}

impl Expression {
    /// The value, and its type in BehaviorTree.CPP: an entry's is that of its value, and the others are those of the
    /// literals and operators of the language.
    fn typed(&self, board: &mut Blackboard) -> Result<(Value, Type), ScriptError> {
        match self {
            Self::Choice(parts) => {
                let [condition, then, otherwise] = &**parts;
                let is_true = condition.operand(board)?.to_real()? != 0.0;
                if is_true { then.typed(board) } else { otherwise.typed(board) }
            }
            Self::Name(slot, _) | Self::Assignment(_, slot, ..) => {
                let value = self.evaluate(board)?;
                Ok((value, board.holds(*slot).clone()))
            }
            _ => {
                let value = self.evaluate(board)?;
                let holds = if matches!(value, Value::Int(_)) { Type::INT64 } else { Type::of_value(&value) };
                Ok((value, holds))
            }
        }
    }

    /// The value, for an operator: in BehaviorTree.CPP, one of a custom type is neither a number nor a string.
    fn operand(&self, board: &mut Blackboard) -> Evaluated {
        let value = self.evaluate(board)?;
        match (self, &value) {
            (Self::Name(slot, name) | Self::Assignment(_, slot, name, _), Value::Text(_)) => match board.holds(*slot) {
                of @ Type::Other(_) => Err(ScriptError::Custom { name: name.clone(), of: of.clone() }),
                _ => Ok(value),
            },
            _ => Ok(value),
        }
    }

    fn evaluate(&self, board: &mut Blackboard) -> Evaluated {
        match self {
            Self::Literal(value) => Ok(value.clone()),
            Self::Name(slot, name) => read(board, *slot, name),
            Self::Unary(operator, operand) => operator.apply(&operand.operand(board)?),
            Self::Binary(operator, left, right) => {
                let left = left.operand(board)?;
                let right = right.operand(board)?;
                operator.apply(&left, &right)
            }
            // `0 < x < 10` compares neighbors. What follows the first comparison that does not hold is not evaluated.
            Self::Comparison(first, others) => {
                let mut left = first.operand(board)?;
                for (comparison, right) in others {
                    let right = right.operand(board)?;
                    if !comparison.holds(&left, &right)? {
                        return Ok(Value::Real(0.0));
                    }
                    left = right;
                }
                Ok(Value::Real(1.0))
            }
            Self::Choice(parts) => {
                let [condition, then, otherwise] = &**parts;
                let is_true = condition.operand(board)?.to_real()? != 0.0;
                if is_true { then.evaluate(board) } else { otherwise.evaluate(board) }
            }
            Self::Assignment(operator, slot, name, right) => assign(*operator, *slot, name, right, board),
        }
    }
}

/// BehaviorTree.CPP's enumeration of statuses.
const STATUSES: [&str; 5] = ["IDLE", "RUNNING", "SUCCESS", "FAILURE", "SKIPPED"];

fn read(board: &Blackboard, slot: Slot, name: &Arc<str>) -> Evaluated {
    match board.value(slot) {
        // BehaviorTree.CPP's scripts see the number of a status in its enumeration.
        Some(Value::Text(name)) if *board.holds(slot) == Type::Status => {
            let number = STATUSES.iter().position(|status| *status == &**name).unwrap_or(0);
            Ok(Value::Int(i64::try_from(number).expect("there are five")))
        }
        Some(value) => Ok(value.clone()),
        None if board.exists(slot) => Err(ScriptError::Empty(name.clone())),
        None => Err(ScriptError::Missing(name.clone())),
    }
}

fn assign(operator: Assignment, slot: Slot, name: &Arc<str>, right: &Expression, board: &mut Blackboard) -> Evaluated {
    if !board.exists(slot) {
        if operator != Assignment::Create {
            return Err(ScriptError::MissingToAssign(name.clone()));
        }
        // As in BehaviorTree.CPP, the entry exists before the right side is evaluated: `x := x + 1` finds it empty.
        board.create(slot);
    }
    let (right, holds) = right.typed(board)?;
    let new = match operator {
        Assignment::Create | Assignment::Existing => right,
        Assignment::With(operator) => {
            let left = board.value(slot).ok_or_else(|| ScriptError::Empty(name.clone()))?;
            if let (Value::Text(_), of @ Type::Other(_)) = (left, board.holds(slot)) {
                return Err(ScriptError::Custom { name: name.clone(), of: of.clone() });
            }
            operator.apply_in_place(left, &right)?
        }
    };
    let (of, was_empty) = (board.type_of(slot).clone(), board.value(slot).is_none());
    let was_text = matches!(board.value(slot), Some(Value::Text(_)));
    let holds = match new {
        Value::Text(_) if of.is_strong() && !was_text => Some(of),
        Value::Text(_) if !was_empty && !was_text => Some(Type::Real),
        _ => was_empty.then_some(holds),
    };
    let fitting = fit(board, slot, name, new)?;
    board.put(slot, Some(fitting.clone()), holds);
    Ok(fitting)
}

/// The value as it is stored: an entry keeps its kind of value, and a string is parsed as that kind.
fn fit(board: &Blackboard, slot: Slot, name: &Arc<str>, new: Value) -> Evaluated {
    let (of, old) = (board.type_of(slot), board.value(slot));
    let refused = || ScriptError::Assignment {
        name: name.clone(),
        is: match old {
            _ if board.is_any(slot) => "has the type BT::Any".to_owned(),
            Some(old) => format!("holds `{old}`"),
            None => format!("has the type {of}"),
        },
        new: new.to_string(),
    };
    match (old, &new) {
        (None | Some(Value::Int(_) | Value::Real(_)), Value::Text(_)) if board.is_any(slot) => Err(refused()),
        (_, Value::Text(_)) if *of == Type::Status => Err(refused()),
        (None, _) if *of == Type::Any => Ok(new),
        (None, Value::Text(_)) => of.convert(&new).map_err(|_| refused()),
        (None, _) => Ok(new),
        (Some(Value::Text(_)), Value::Text(_)) => Ok(new),
        (Some(Value::Int(_)), Value::Int(_) | Value::Real(_)) => {
            let is_unsigned = *board.holds(slot) == Type::UNSIGNED64;
            let number = new.to_int().ok().filter(|number| *number >= 0 || !is_unsigned);
            number.map(Value::Int).ok_or_else(refused)
        }
        (Some(Value::Real(_)), Value::Int(_) | Value::Real(_)) => Ok(Value::Real(new.to_real()?)),
        (Some(_), Value::Text(_)) if of.is_strong() => of.convert(&new).map_err(|_| refused()),
        (Some(Value::Int(_) | Value::Real(_)), Value::Text(text)) => Ok(Value::Real(number_in(text)?)),
        (Some(Value::List(_)), Value::List(_)) => Ok(new),
        _ => Err(refused()),
    }
}

/// The number in a string, for an operator that needs a number.
fn number_in(text: &Arc<str>) -> Result<f64, ScriptError> {
    match &**text {
        "true" => Ok(1.0),
        "false" => Ok(0.0),
        _ => Ok(Value::Text(text.clone()).to_real()?),
    }
}

impl Unary {
    fn apply(self, operand: &Value) -> Evaluated {
        let sign = match self {
            Self::Negate => "-",
            Self::Complement => "~",
            Self::Not => "!",
        };
        let wrong = || ScriptError::Operand { operator: sign, operand: operand.to_string() };
        if !operand.is_number() {
            return Err(wrong());
        }
        let number = operand.to_real()?;
        Ok(Value::Real(match self {
            Self::Negate => -number,
            Self::Not => f64::from(u8::from(number == 0.0)),
            Self::Complement => bits(!Value::Real(number.trunc()).to_int().map_err(|_| wrong())?),
        }))
    }
}

/// An integer as the real number that all operators return.
#[expect(clippy::cast_precision_loss, reason = "BehaviorTree.CPP's arithmetic is that of doubles")]
fn bits(number: i64) -> f64 {
    number as f64
}

impl Binary {
    fn sign(self) -> &'static str {
        match self {
            Self::Add => "+",
            Self::Subtract => "-",
            Self::Multiply => "*",
            Self::Divide => "/",
            Self::Join => "..",
            Self::BitAnd => "&",
            Self::BitOr => "|",
            Self::BitXor => "^",
            Self::And => "&&",
            Self::Or => "||",
        }
    }

    fn wrong(self, left: &Value, right: &Value) -> ScriptError {
        ScriptError::Operands { operator: self.sign(), left: left.to_string(), right: right.to_string() }
    }

    fn apply(self, left: &Value, right: &Value) -> Evaluated {
        let joins = matches!((left, right), (Value::Text(_), Value::Text(_)))
            || (self == Self::Join && (left.is_number() != right.is_number()));
        match self {
            Self::Add | Self::Join if joins && !is_list(left) && !is_list(right) => joined(left, right),
            _ if left.is_number() && right.is_number() && self != Self::Join => self.calculate(left, right),
            _ => Err(self.wrong(left, right)),
        }
    }

    /// For `+=` and similar operators: a string can be appended to a string.
    fn apply_in_place(self, left: &Value, right: &Value) -> Evaluated {
        match (left, right) {
            (Value::Text(left), Value::Text(right)) if self == Self::Add => joined(left, right),
            _ if left.is_number() && right.is_number() => self.calculate(left, right),
            _ => Err(self.wrong(left, right)),
        }
    }

    fn calculate(self, left: &Value, right: &Value) -> Evaluated {
        let wrong = |_| self.wrong(left, right);
        let whole =
            || -> Result<_, ScriptError> { Ok((left.to_int().map_err(wrong)?, right.to_int().map_err(wrong)?)) };
        let truths =
            || -> Result<_, ScriptError> { Ok((left.to_bool().map_err(wrong)?, right.to_bool().map_err(wrong)?)) };
        let (a, b) = (left.to_real()?, right.to_real()?);
        Ok(Value::Real(match self {
            Self::Add => a + b,
            Self::Subtract => a - b,
            Self::Multiply => a * b,
            Self::Divide => a / b,
            Self::BitAnd => whole().map(|(a, b)| bits(a & b))?,
            Self::BitOr => whole().map(|(a, b)| bits(a | b))?,
            Self::BitXor => whole().map(|(a, b)| bits(a ^ b))?,
            Self::And => truths().map(|(a, b)| f64::from(u8::from(a && b)))?,
            Self::Or => truths().map(|(a, b)| f64::from(u8::from(a || b)))?,
            Self::Join => return Err(self.wrong(left, right)),
        }))
    }
}

/// Concatenates both as strings.
fn joined(left: &impl Display, right: &impl Display) -> Evaluated {
    let text = format!("{left}{right}");
    if text.len() > MAX_TEXT_BYTES { Err(ScriptError::TooLong) } else { Ok(Value::Text(text.into())) }
}

fn is_list(value: &Value) -> bool {
    matches!(value, Value::List(_))
}

/// Real numbers that differ by at most this are equal, as in BehaviorTree.CPP's scripts.
const EQUAL_WITHIN: f64 = f32::EPSILON as f64;

impl Comparison {
    fn holds(self, left: &Value, right: &Value) -> Result<bool, ScriptError> {
        match (left, right) {
            (Value::Text(left), Value::Text(right)) => Ok(self.decide(left == right, Some(left.cmp(right)))),
            (Value::List(_), _) | (_, Value::List(_)) => {
                Err(ScriptError::Operands { operator: "==", left: left.to_string(), right: right.to_string() })
            }
            _ => {
                let number = |value: &Value| match value {
                    Value::Text(text) => number_in(text),
                    value => Ok(value.to_real()?),
                };
                let (left, right) = (number(left)?, number(right)?);
                Ok(self.decide((left - right).abs() <= EQUAL_WITHIN, left.partial_cmp(&right)))
            }
        }
    }

    /// If the operands are not comparable, as with 0 / 0, the four ordering relations are all true.
    fn decide(self, equal: bool, order: Option<Ordering>) -> bool {
        match self {
            Self::Equal => equal,
            Self::NotEqual => !equal,
            Self::Less => !matches!(order, Some(Ordering::Greater | Ordering::Equal)),
            Self::Greater => !matches!(order, Some(Ordering::Less | Ordering::Equal)),
            Self::LessEqual => order != Some(Ordering::Greater),
            Self::GreaterEqual => order != Some(Ordering::Less),
        }
    }
}
