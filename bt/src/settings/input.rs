//! The source of a port's value.

use std::sync::Arc;

use crate::Status;
use crate::blackboard::{Blackboard, Slot, Type, Value, ValueError, status_named};
use crate::script::ScriptError;

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Input {
    /// A constant in the file.
    Constant(Value),
    /// The blackboard entry with this key.
    Entry(Slot, Arc<str>),
}

#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum ReadError {
    #[error("the entry `{0}` has no value")]
    Empty(Arc<str>),
    #[error(transparent)]
    Value(#[from] ValueError),
    #[error(transparent)]
    Script(#[from] ScriptError),
}

impl Input {
    pub(crate) fn entry(&self) -> Option<Slot> {
        match self {
            Self::Constant(_) => None,
            Self::Entry(slot, _) => Some(*slot),
        }
    }

    pub(super) fn value<'a>(&'a self, board: &'a Blackboard) -> Option<&'a Value> {
        match self {
            Self::Constant(value) => Some(value),
            Self::Entry(slot, _) => board.value(*slot),
        }
    }

    /// The value, converted to this type.
    pub(crate) fn read(&self, board: &Blackboard, of: &Type) -> Result<Value, ReadError> {
        let value = self.value(board).ok_or_else(|| self.empty())?;
        Ok(match of {
            Type::Text => Value::Text(value.to_text()),
            of => of.convert(value)?,
        })
    }

    pub(super) fn number(&self, board: &Blackboard, of: &Type) -> Result<i64, ReadError> {
        Ok(self.read(board, of)?.to_int()?)
    }

    pub(super) fn status(&self, board: &Blackboard) -> Result<Status, ReadError> {
        let name = self.read(board, &Type::Text)?.to_text();
        Ok(status_named(&name).ok_or_else(|| ValueError::new(&name, "a status"))?)
    }

    pub(super) fn empty(&self) -> ReadError {
        let name = if let Self::Entry(_, name) = self { name.clone() } else { Arc::default() };
        ReadError::Empty(name)
    }
}
