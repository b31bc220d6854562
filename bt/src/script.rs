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

pub(crate) use evaluate::ScriptError;
pub(crate) use expression::{Assignment, Binary, Comparison, Expression, Script};
pub(crate) use reading::Names;

#[cfg(test)]
mod tests;
