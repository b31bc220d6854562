//! Locations: the targets of assignments.

use std::ops::Range;
use std::sync::Arc;

use super::{Expr, ExpressionProblem, ProblemKind};
use crate::ids::DataId;

/// A datum, or a part of one: `x`, `x.y`, `x[i].z`.
#[derive(Clone, Debug)]
pub(crate) struct Location {
    pub(crate) data: DataId,
    pub(super) path: Vec<Access>,
}

#[derive(Clone, Debug)]
pub(super) enum Access {
    Member(Arc<str>),
    Index(Expr),
}

impl Location {
    /// The location that an expression names. `span` is the position of the expression.
    pub(super) fn from_expr(expr: Expr, span: Range<usize>) -> Result<Self, ExpressionProblem> {
        let mut path = Vec::new();
        let mut rest = expr;
        loop {
            rest = match rest {
                // The last member was the outermost expression.
                Expr::Data(data) => {
                    path.reverse();
                    return Ok(Self { data, path });
                }
                Expr::Unknown(name) => {
                    let message = format!("there is no data named `{name}` to assign to");
                    return Err(ExpressionProblem::new(message, span, "unknown name").of_kind(ProblemKind::Name));
                }
                Expr::Member(value, name) => {
                    path.push(Access::Member(name));
                    *value
                }
                Expr::Index(parts) => {
                    let [value, index] = *parts;
                    path.push(Access::Index(index));
                    value
                }
                Expr::Event | Expr::EventField(_) | Expr::MachineName | Expr::SessionId | Expr::IoProcessors => {
                    let problem = ExpressionProblem::new("system variables cannot be assigned to", span, "read-only");
                    return Err(problem
                        .of_kind(ProblemKind::Name)
                        .with_help("copy the part that you need to your own <data>"));
                }
                _ => {
                    let problem = ExpressionProblem::new("this cannot be assigned to", span, "a value");
                    return Err(problem.with_help(
                        "`x`, `x.member` and `x[index]` can be assigned to, where `x` is the id of a <data>",
                    ));
                }
            };
        }
    }

    /// The expression for the value stored there.
    pub(crate) fn to_expr(&self) -> Expr {
        let mut expr = Expr::Data(self.data);
        for access in &self.path {
            expr = match access {
                Access::Member(name) => Expr::Member(Box::new(expr), Arc::clone(name)),
                Access::Index(index) => Expr::Index(Box::new([expr, index.clone()])),
            };
        }
        expr
    }
}
