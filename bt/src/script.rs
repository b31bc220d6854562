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
mod expression;
mod parse;
mod reading;
mod token;

pub(crate) use evaluate::ScriptError;
pub(crate) use expression::Script;
pub(crate) use reading::{Names, SyntaxError};

impl Script {
    /// Reads a script.
    pub(crate) fn parse(text: &str, names: &mut dyn Names) -> Result<Self, SyntaxError> {
        parse::parse(text, names).map(|statements| Self { statements })
    }
}

#[cfg(test)]
mod tests;
