//! The syntax of property files: tokens, tree, and back to text.

mod ast;
mod boolean;
mod layout;
mod operators;
mod parse;
mod parse_condition;
mod parse_constraint;
mod pieces;
mod pretty;
mod print;
mod quantity;
mod real;
mod summary;
mod token;

pub use ast::{
    ByteRange, Condition, ConditionKind, Constant, Constraint, ConstraintKind, Event, Field, FieldName, File, Interval,
    Item, Literal, Name, Operand, Party, PropertyItem, Term,
};
pub use layout::layout;
pub use operators::{OPERATORS, Operator};
pub use parse::{Parsed, parse_file};
pub(crate) use summary::summary_above;
