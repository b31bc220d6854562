//! Without an engine: the feature `ecmascript` is off.

use super::World;
use crate::Datum;
use crate::datum::EvaluationError;
use crate::expression::{Code, ExpressionProblem, Form};

pub(super) const AVAILABLE: bool = false;

pub(super) fn check(_: &str, _: Form) -> Result<(), ExpressionProblem> {
    Ok(())
}

pub(super) fn run(_: &Code, _: &mut World<'_>, _: Option<&Datum>) -> Result<Datum, EvaluationError> {
    Err(EvaluationError::Broken("there is no engine".into()))
}
