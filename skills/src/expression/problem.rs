//! Problems of an expression.

use std::ops::Range;

/// A part of an expression that cannot be compiled. Spans are bytes of the expression.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct ExpressionProblem {
    pub(crate) message: String,
    pub(crate) span: Range<usize>,
    pub(crate) label: String,
    pub(crate) help: Option<String>,
    pub(crate) kind: ProblemKind,
}

/// How a full engine would treat the expression.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ProblemKind {
    /// It is not in the subset's grammar; an engine might accept it.
    Grammar,
    /// It is known to be outside the subset.
    Beyond,
    /// An engine would accept it, with a meaning that was probably not intended.
    Suspicious,
    /// An engine would have the same problem with it.
    Name,
}

impl ExpressionProblem {
    pub(crate) fn new(message: impl Into<String>, span: Range<usize>, label: impl Into<String>) -> Self {
        Self { message: message.into(), span, label: label.into(), help: None, kind: ProblemKind::Grammar }
    }

    pub(crate) fn with_help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    pub(crate) fn of_kind(mut self, kind: ProblemKind) -> Self {
        self.kind = kind;
        self
    }

    pub(crate) fn outside_subset(what: &str, span: Range<usize>) -> Self {
        let subset = "without the feature `ecmascript`, expressions may use literals, data, `_event`, member access, operators, `?:` and `In('state')`";
        Self::new(format!("{what} cannot be evaluated here"), span, "outside the expression subset")
            .with_help(subset)
            .of_kind(ProblemKind::Beyond)
    }
}
