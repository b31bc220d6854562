//! The parts of a script.

use std::collections::BTreeSet;
use std::sync::Arc;

use crate::Value;
use crate::blackboard::Slot;

/// A script, ready to run: its entries have been resolved.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Script {
    pub(super) statements: Vec<Expression>,
}

impl Script {
    /// Adds the entries that the script assigns to.
    pub(crate) fn assigned(&self, slots: &mut BTreeSet<Slot>) {
        self.statements.iter().for_each(|statement| statement.assigned(slots));
    }
}

impl Expression {
    fn assigned(&self, slots: &mut BTreeSet<Slot>) {
        match self {
            Self::Literal(_) | Self::Name(..) => {}
            Self::Unary(_, operand) => operand.assigned(slots),
            Self::Binary(_, left, right) => [left, right].into_iter().for_each(|side| side.assigned(slots)),
            Self::Comparison(first, others) => {
                first.assigned(slots);
                others.iter().for_each(|(_, other)| other.assigned(slots));
            }
            Self::Choice(parts) => parts.iter().for_each(|part| part.assigned(slots)),
            Self::Assignment(_, slot, _, right) => {
                slots.insert(*slot);
                right.assigned(slots);
            }
        }
    }
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Expression {
    Literal(Value),
    /// An entry, and its name for error messages.
    Name(Slot, Arc<str>),
    Unary(Unary, Box<Expression>),
    Binary(Binary, Box<Expression>, Box<Expression>),
    /// The first operand, and the others with their comparisons.
    Comparison(Box<Expression>, Vec<(Comparison, Expression)>),
    Choice(Box<[Expression; 3]>),
    Assignment(Assignment, Slot, Arc<str>, Box<Expression>),
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Unary {
    Negate,
    Complement,
    Not,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Binary {
    Add,
    Subtract,
    Multiply,
    Divide,
    Join,
    BitAnd,
    BitOr,
    BitXor,
    And,
    Or,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Comparison {
    Equal,
    NotEqual,
    Less,
    Greater,
    LessEqual,
    GreaterEqual,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Assignment {
    /// `:=`
    Create,
    /// `=`
    Existing,
    /// `+=` and similar operators.
    With(Binary),
}
