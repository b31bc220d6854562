//! Why an expression has no value.

use std::sync::Arc;

use crate::TooLarge;
use crate::datum::MAX_TEXT_BYTES;

/// Why an expression has no value; it becomes `error.execution`.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum EvaluationError {
    #[error("{0} is not defined")]
    Unknown(Arc<str>),
    #[error("{0}")]
    Broken(Arc<str>),
    #[error("there is no member {member} of {value}")]
    NoMembers { value: &'static str, member: Arc<str> },
    #[error("a string may be {MAX_TEXT_BYTES} bytes long at most")]
    LongText,
    #[error("what is inherited as {0} is no plain value")]
    Inherited(Arc<str>),
    #[error(transparent)]
    TooLarge(#[from] TooLarge),
    #[error("{0} cannot be assigned to")]
    NotAssignable(String),
    #[error("this does not come to an end: it takes too many steps")]
    TooLong,
    /// What the engine has thrown.
    #[cfg_attr(not(feature = "ecmascript"), expect(dead_code, reason = "there is no engine to throw it"))]
    #[error("{0}")]
    Thrown(String),
}
