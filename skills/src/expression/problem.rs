//! What can be wrong with an expression.

use std::ops::Range;

/// Something in an expression that cannot be compiled. Spans are bytes of the expression.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct ExpressionProblem {
    pub(crate) message: String,
    pub(crate) span: Range<usize>,
    pub(crate) label: String,
    pub(crate) help: Option<String>,
}

impl ExpressionProblem {
    pub(crate) fn new(message: impl Into<String>, span: Range<usize>, label: impl Into<String>) -> Self {
        Self { message: message.into(), span, label: label.into(), help: None }
    }

    pub(crate) fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// ECMAScript that is outside the subset.
    pub(crate) fn outside_subset(what: &str, span: Range<usize>) -> Self {
        let subset =
            "expressions here may use literals, data, `_event`, member access, operators, `?:` and `In('state')`";
        Self::new(format!("{what} cannot be evaluated here"), span, "outside the expression subset").help(subset)
    }
}
