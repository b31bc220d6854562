//! What a script is made of.

use super::{BinaryOp, Expr, Location};

/// A statement of a script.
#[derive(Clone, Debug)]
pub(crate) enum Statement {
    /// `location = value`
    Assign(Location, Expr),
    /// `location op= value`
    Update(Location, BinaryOp, Expr),
    /// An expression for its own sake.
    Evaluate(Expr),
}
