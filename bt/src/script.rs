//! BehaviorTree.CPP's scripting language.
//!
//! A script is a list of expressions with semicolons between them; its value is that of the last one. There are numbers,
//! texts in single quotes, `true` and `false`, names of blackboard entries and of constants, and, from the loosest to
//! the tightest, the operators
//!
//! | operators | meaning |
//! |---|---|
//! | `:=` `=` `+=` `-=` `*=` `/=` | assignment; only `:=` makes a new entry |
//! | `c ? a : b` | choice |
//! | `\|\|`, then `&&` | logic; both sides are evaluated |
//! | `==` `!=` `<` `>` `<=` `>=` | comparison, which may be chained: `0 < x < 10` |
//! | `\|` `^`, then `&` | bits |
//! | `+` `-` `..` | addition, and joining of texts |
//! | `*` `/` | multiplication |
//! | `-x` `!x` `~x` | |
//!
//! Arithmetic is that of real numbers, whatever goes in. An entry keeps the kind of value that it has: what is assigned
//! is converted, and it is an error if it can't be.

mod evaluate;
mod parse;
mod token;

use std::ops::Range;
use std::sync::Arc;

pub(crate) use evaluate::ScriptError;

use crate::Value;
use crate::blackboard::Slot;

/// A script, ready to run: its entries have been found.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Script {
    statements: Vec<Expression>,
}

#[derive(Clone, Debug, PartialEq)]
enum Expression {
    Literal(Value),
    /// An entry, and its name for what goes wrong.
    Name(Slot, Arc<str>),
    Unary(Unary, Box<Expression>),
    Binary(Binary, Box<Expression>, Box<Expression>),
    /// The first operand, and the others with what they are compared by.
    Comparison(Box<Expression>, Vec<(Comparison, Expression)>),
    Choice(Box<[Expression; 3]>),
    Assignment(Assignment, Slot, Arc<str>, Box<Expression>),
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Unary {
    Negate,
    Complement,
    Not,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Binary {
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
enum Comparison {
    Equal,
    NotEqual,
    Less,
    Greater,
    LessEqual,
    GreaterEqual,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Assignment {
    /// `:=`
    Create,
    /// `=`
    Existing,
    /// `+=` and its like.
    With(Binary),
}

/// What is wrong with the text of a script, and where.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct SyntaxError {
    pub(crate) message: String,
    /// In bytes of the script.
    pub(crate) range: Range<usize>,
}

/// What names in scripts mean.
pub(crate) trait Names {
    /// The number that a constant stands for.
    fn constant(&self, name: &str) -> Option<i64>;

    /// The entry that a name means.
    fn slot(&mut self, name: &str) -> Slot;
}

impl Script {
    /// Reads a script.
    pub(crate) fn parse(text: &str, names: &mut dyn Names) -> Result<Self, SyntaxError> {
        parse::parse(text, names).map(|statements| Self { statements })
    }
}

#[cfg(test)]
mod tests;
