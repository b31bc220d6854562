//! BehaviorTree.CPP's scripting language.
//!
//! A script is a list of expressions, separated by semicolons, which may be left out; its value is that of the last
//! one. Expressions consist of numbers, strings in single quotes, `true` and `false`, names of blackboard entries and
//! of constants, and these operators, from the lowest to the highest precedence:
//!
//! | operators | meaning |
//! |---|---|
//! | `:=` `=` `+=` `-=` `*=` `/=` | assignment; only `:=` creates an entry |
//! | `c ? a : b` | choice |
//! | `\|\|`, then `&&` | logic; both sides are evaluated |
//! | `==` `!=` `<` `>` `<=` `>=` | comparison, can be chained: `0 < x < 10` |
//! | `\|` `^`, then `&` | bits |
//! | `+` `-` `..` | addition, and concatenation of strings |
//! | `*` `/` | multiplication |
//! | `-x` `!x` `~x` | |
//!
//! Arithmetic always uses real numbers. An entry keeps its kind of value: an assigned value is converted, and it is an
//! error if that is impossible.

mod evaluate;
mod expression;
mod parse;
mod reading;
mod token;

use std::ops::Range;

pub(crate) use evaluate::ScriptError;
pub(crate) use expression::{Assignment, Binary, Comparison, Expression, Script};
pub(crate) use reading::{Names, SyntaxError};

impl Script {
    /// Reads a script. Also gives the place of the first statement that no semicolon separates from the one before it.
    pub(crate) fn parse(text: &str, names: &mut dyn Names) -> Result<(Self, Option<Range<usize>>), SyntaxError> {
        parse::parse(text, names).map(|(statements, unseparated)| (Self { statements }, unseparated))
    }

    /// The script that does nothing.
    pub(crate) fn empty() -> Self {
        Self { statements: Vec::new() }
    }
}

#[cfg(test)]
mod tests;
