//! Why a program has no value.

use rquickjs::{Ctx, Error, Value};

use super::runtime::Turns;
use crate::datum::EvaluationError;

pub(super) const TOO_LARGE: &str = "the code needs more memory than 4 MiB";

pub(super) enum Failure {
    Failed(EvaluationError),
    /// Something was thrown; the engine holds it.
    Thrown(Error),
}

impl From<EvaluationError> for Failure {
    fn from(error: EvaluationError) -> Self {
        Self::Failed(error)
    }
}

impl From<crate::TooLarge> for Failure {
    fn from(error: crate::TooLarge) -> Self {
        Self::Failed(error.into())
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        Self::Thrown(error)
    }
}

impl Failure {
    pub(super) fn reported(self, ctx: &Ctx<'_>, turns: &Turns) -> EvaluationError {
        let error = match self {
            Self::Failed(error) => return error,
            Self::Thrown(error) => error,
        };
        let thrown = matches!(error, Error::Exception).then(|| ctx.catch());
        if turns.are_over() {
            return EvaluationError::TooLong;
        }
        let text = thrown.and_then(|thrown| thrown_text(ctx, &thrown));
        // If there is no memory for an error, there is none for its text.
        EvaluationError::Thrown(text.unwrap_or_else(|| TOO_LARGE.to_owned()))
    }
}

/// The first line of the thrown error; `None` if memory ran out.
fn thrown_text(ctx: &Ctx<'_>, thrown: &Value<'_>) -> Option<String> {
    /// The longest text that is useful.
    const MAX_CHARS: usize = 300;
    if thrown.is_null() || thrown.type_of() == rquickjs::Type::Uninitialized {
        return None;
    }
    let text = match thrown.get::<rquickjs::Coerced<String>>() {
        Ok(text) => text.0,
        Err(_) => {
            ctx.catch();
            "a value that is not text was thrown".to_owned()
        }
    };
    if text.ends_with("out of memory") {
        return None;
    }
    Some(text.lines().next().unwrap_or_default().chars().take(MAX_CHARS).collect())
}
