//! The statements of a script.

use super::{BinaryOp, Expr, Location};

#[derive(Clone, Debug)]
pub(crate) enum Statement {
    /// `location = value`
    Assign(Location, Expr),
    /// `location op= value`
    Update(Location, BinaryOp, Expr),
    /// An expression whose value is not used.
    Evaluate(Expr),
}
