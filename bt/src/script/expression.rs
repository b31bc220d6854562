//! The parts of a script.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use crate::Value;
use crate::blackboard::Slot;

/// A script, ready to run: its entries have been resolved.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Script {
    pub(crate) statements: Vec<Expression>,
}

impl Script {
    /// Adds the entries that the script assigns to, each with whether it can be assigned a string. `is_text` decides
    /// whether an entry that no script has assigned to so far is a string.
    pub(crate) fn assigned(&self, slots: &mut BTreeMap<Slot, bool>, is_text: impl Fn(Slot) -> bool + Copy) {
        for statement in &self.statements {
            statement.assigned(slots, is_text);
        }
    }

    /// Adds the entries whose values the script reads, with their names.
    pub(crate) fn read(&self, names: &mut BTreeMap<Slot, Arc<str>>) {
        for statement in &self.statements {
            statement.read(names);
        }
    }

    /// Whether its value is that of an assignment to an entry with `=`.
    pub(crate) fn only_assigns(&self) -> bool {
        matches!(self.statements.last(), Some(Expression::Assignment(Assignment::Existing, ..)))
    }

    /// Whether the script calculates with an integer that is too large for it: one in its text, or the value of one of
    /// these entries. Those to which it assigns such an integer are added.
    pub(crate) fn calculates_with_large(&self, large: &mut BTreeSet<Slot>) -> bool {
        let mut calculates = false;
        for statement in &self.statements {
            statement.find_large(large, &mut calculates);
        }
        calculates
    }
}

impl Expression {
    /// Adds the entries whose values it reads, as [`Script::read`] does.
    fn read(&self, names: &mut BTreeMap<Slot, Arc<str>>) {
        match self {
            Self::Literal(_) => {}
            Self::Name(slot, name) => {
                names.entry(*slot).or_insert_with(|| Arc::clone(name));
            }
            Self::Unary(_, operand) | Self::Assignment(_, _, _, operand) => operand.read(names),
            Self::Binary(_, left, right) => [left, right].into_iter().for_each(|side| side.read(names)),
            Self::Comparison(first, others) => {
                first.read(names);
                others.iter().for_each(|(_, other)| other.read(names));
            }
            Self::Choice(parts) => parts.iter().for_each(|part| part.read(names)),
        }
    }

    /// Whether the value can be an integer that is too large to calculate with, as far as the file shows.
    fn find_large(&self, large: &mut BTreeSet<Slot>, calculates: &mut bool) -> bool {
        match self {
            Self::Literal(value) => value.is_too_large(),
            Self::Name(slot, _) => large.contains(slot),
            Self::Unary(_, operand) => {
                *calculates |= operand.find_large(large, calculates);
                false
            }
            Self::Binary(operator, left, right) => {
                let found = [left, right].map(|side| side.find_large(large, calculates));
                *calculates |= *operator != Binary::Join && found.contains(&true);
                false
            }
            Self::Comparison(first, others) => {
                *calculates |= first.find_large(large, calculates);
                for (_, other) in others {
                    *calculates |= other.find_large(large, calculates);
                }
                false
            }
            Self::Choice(parts) => {
                let [condition, chosen, other] = parts.each_ref().map(|part| part.find_large(large, calculates));
                *calculates |= condition;
                chosen || other
            }
            Self::Assignment(Assignment::With(_), slot, _, right) => {
                let found = right.find_large(large, calculates);
                *calculates |= found || large.contains(slot);
                false
            }
            Self::Assignment(_, slot, _, right) => {
                let found = right.find_large(large, calculates);
                if found {
                    large.insert(*slot);
                }
                found
            }
        }
    }

    /// Adds the entries assigned to, as [`Script::assigned`] does. Returns whether the result can be a string.
    fn assigned(&self, slots: &mut BTreeMap<Slot, bool>, is_text: impl Fn(Slot) -> bool + Copy) -> bool {
        match self {
            Self::Literal(value) => matches!(value, Value::Text(_)),
            Self::Name(slot, _) => is_text(*slot) || slots.get(slot).is_some_and(|text| *text),
            Self::Unary(_, operand) => {
                operand.assigned(slots, is_text);
                false
            }
            Self::Binary(operator, left, right) => {
                // Both sides are visited in any case: each may assign to entries.
                let texts = [left, right].map(|side| side.assigned(slots, is_text));
                matches!(operator, Binary::Add | Binary::Join) && texts.contains(&true)
            }
            Self::Comparison(first, others) => {
                first.assigned(slots, is_text);
                for (_, other) in others {
                    other.assigned(slots, is_text);
                }
                false
            }
            Self::Choice(parts) => {
                let [_, chosen, other] = parts.each_ref().map(|part| part.assigned(slots, is_text));
                chosen || other
            }
            Self::Assignment(_, slot, _, right) => {
                let text = right.assigned(slots, is_text);
                *slots.entry(*slot).or_default() |= text;
                text
            }
        }
    }
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Expression {
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
pub(crate) enum Unary {
    Negate,
    Complement,
    Not,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Binary {
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
pub(crate) enum Comparison {
    Equal,
    NotEqual,
    Less,
    Greater,
    LessEqual,
    GreaterEqual,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Assignment {
    /// `:=`
    Create,
    /// `=`
    Existing,
    /// `+=` and similar operators.
    With(Binary),
}
