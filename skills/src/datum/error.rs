//! Why an expression has no value.

use std::sync::Arc;

use super::{MAX_TEXT_BYTES, TooLarge};

/// Why an expression has no value; it becomes `error.execution`.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum EvaluationError {
    #[error("{0} is not defined")]
    Unknown(Arc<str>),
    #[error("{0}")]
    Broken(Arc<str>),
    #[error("{value} has no member {member}")]
    NoMembers { value: &'static str, member: Arc<str> },
    #[error("a string may have at most {MAX_TEXT_BYTES} bytes")]
    LongText,
    #[error("the inherited member {0} is not a plain value")]
    Inherited(Arc<str>),
    #[error(transparent)]
    TooLarge(#[from] TooLarge),
    #[error("{0} cannot be assigned to")]
    NotAssignable(String),
    #[error("this takes too many steps and may never end")]
    TooLong,
    #[cfg_attr(not(feature = "ecmascript"), expect(dead_code, reason = "there is no engine to throw it"))]
    #[error("{0}")]
    Thrown(String),
}
