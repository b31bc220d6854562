//! Expressions: the part of ECMAScript that machines use most, compiled once and evaluated without an engine.
//!
//! The subset contains: literals of every kind (also arrays and objects), names of data, `_event` and the other system
//! variables, member access and indexing, arithmetic, bit operations, comparison, `&&`, `||`, `??`, `!`, `typeof`,
//! `void`, `?:`, parentheses, and `In('state')`. Assignments are allowed in `<assign>` and, with `=`, `+=`, `++` and
//! similar operators, in `<script>`. Conversions follow ECMAScript. Everything else is for [`crate::engine`].

mod code;
mod dates;
mod evaluate;
mod location;
mod parse;
mod problem;
pub(crate) mod scan;
mod script;
mod statement;
mod syntax;
mod token;
mod vocabulary;

pub(crate) use code::{Code, Form};
pub(crate) use dates::kept_dates;
pub(crate) use evaluate::{Scope, binary};
pub(crate) use location::Location;
pub(crate) use parse::{Parsed, expression, literal, location};
pub(crate) use problem::{ExpressionProblem, ProblemKind};
pub(crate) use script::script;
pub(crate) use statement::Statement;
pub(crate) use syntax::{BinaryOp, EventField, Expr, LogicOp, Names, UnaryOp};

/// Whether a word can be the name of a datum: an identifier that is not reserved.
pub(crate) fn is_identifier(word: &str) -> bool {
    let starts = word.starts_with(|c: char| c.is_alphabetic() || c == '_' || c == '$');
    starts && word.chars().all(|c| c.is_alphanumeric() || c == '_' || c == '$') && !vocabulary::is_taken(word)
}
