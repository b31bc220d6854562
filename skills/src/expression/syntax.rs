//! The parts of an expression.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::Datum;
use crate::expression::Code;
use crate::ids::{DataId, StateId};

#[derive(Debug, Default)]
pub(crate) struct Names {
    pub(crate) data: BTreeMap<String, DataId>,
    pub(crate) states: BTreeMap<String, StateId>,
}

/// A compiled expression.
#[derive(Clone, Debug)]
pub(crate) enum Expr {
    Constant(Datum),
    Data(DataId),
    /// An unknown name: evaluating it is an error.
    Unknown(Arc<str>),
    /// An expression that could not be compiled, and why: evaluating it is an error.
    Broken(Arc<str>),
    /// A whole expression outside the subset; it is never part of another one.
    Foreign(Arc<Code>),
    /// `_event` as a whole.
    Event,
    /// `_event.name` and similar fields.
    EventField(EventField),
    /// `_name`
    MachineName,
    /// `_sessionid`
    SessionId,
    /// `_ioprocessors`
    IoProcessors,
    Member(Box<Expr>, Arc<str>),
    Index(Box<[Expr; 2]>),
    Unary(UnaryOp, Box<Expr>),
    Binary(BinaryOp, Box<[Expr; 2]>),
    Logic(LogicOp, Box<[Expr; 2]>),
    /// `test ? then : otherwise`
    Choice(Box<[Expr; 3]>),
    /// `In('state')` with a state of this machine.
    In(StateId),
    /// `In(…)` with an id that is computed at run time.
    InDynamic(Box<Expr>),
    Array(Vec<Expr>),
    Object(Vec<(Arc<str>, Expr)>),
}

/// A field of `_event` (SCXML 5.10.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum EventField {
    Name,
    Type,
    SendId,
    Origin,
    OriginType,
    InvokeId,
    Data,
    Raw,
}

impl EventField {
    pub(crate) const ALL: [(&'static str, Self); 8] = [
        ("name", Self::Name),
        ("type", Self::Type),
        ("sendid", Self::SendId),
        ("origin", Self::Origin),
        ("origintype", Self::OriginType),
        ("invokeid", Self::InvokeId),
        ("data", Self::Data),
        ("raw", Self::Raw),
    ];
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum UnaryOp {
    Not,
    Minus,
    Plus,
    BitNot,
    TypeOf,
    Void,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LogicOp {
    And,
    Or,
    /// `??`
    Coalesce,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BinaryOp {
    Add,
    Subtract,
    Multiply,
    Divide,
    Remainder,
    Less,
    LessEqual,
    Greater,
    GreaterEqual,
    Equal,
    NotEqual,
    Identical,
    NotIdentical,
    BitAnd,
    BitOr,
    BitXor,
    ShiftLeft,
    ShiftRight,
    ShiftRightUnsigned,
}

impl BinaryOp {
    /// Whether it compares its operands.
    pub(crate) fn compares(self) -> bool {
        use BinaryOp::{Equal, Greater, GreaterEqual, Identical, Less, LessEqual, NotEqual, NotIdentical};
        matches!(self, Equal | NotEqual | Identical | NotIdentical | Less | LessEqual | Greater | GreaterEqual)
    }
}

impl Expr {
    /// Whether the value never changes, given the data that never change.
    pub(crate) fn is_fixed(&self, fixed: &dyn Fn(DataId) -> bool) -> bool {
        match self {
            Self::Constant(_) | Self::MachineName => true,
            Self::Data(id) => fixed(*id),
            Self::Unknown(_) | Self::Broken(_) | Self::Foreign(_) | Self::In(_) | Self::InDynamic(_) => false,
            Self::Event | Self::EventField(_) | Self::SessionId | Self::IoProcessors => false,
            _ => self.parts().into_iter().all(|part| part.is_fixed(fixed)),
        }
    }

    /// Calls `visit` with the expression and with all its parts.
    pub(crate) fn visit<'e>(&'e self, visit: &mut dyn FnMut(&'e Self)) {
        visit(self);
        self.parts().into_iter().for_each(|part| part.visit(visit));
    }

    /// The expressions directly inside it.
    pub(crate) fn parts(&self) -> Vec<&Self> {
        match self {
            Self::Constant(_) | Self::Data(_) | Self::Unknown(_) | Self::Broken(_) | Self::Foreign(_) => Vec::new(),
            Self::Event | Self::EventField(_) | Self::MachineName | Self::SessionId => Vec::new(),
            Self::IoProcessors | Self::In(_) => Vec::new(),
            Self::Member(part, _) | Self::Unary(_, part) | Self::InDynamic(part) => vec![&**part],
            Self::Index(parts) | Self::Binary(_, parts) | Self::Logic(_, parts) => parts.iter().collect(),
            Self::Choice(parts) => parts.iter().collect(),
            Self::Array(items) => items.iter().collect(),
            Self::Object(members) => members.iter().map(|(_, part)| part).collect(),
        }
    }

    /// Whether the expression is literal: a JSON value, or nearly.
    pub(super) fn is_literal(&self) -> bool {
        match self {
            Self::Constant(_) => true,
            Self::Unary(UnaryOp::Minus, operand) => matches!(**operand, Self::Constant(Datum::Number(_))),
            Self::Array(items) => items.iter().all(Self::is_literal),
            Self::Object(members) => members.iter().all(|(_, value)| value.is_literal()),
            _ => false,
        }
    }
}
