//! The tree of a property file.

use channels::Relation;
use miette::SourceSpan;

use crate::formula::{Arithmetic, Function, Unit};
use crate::operator::{Infix, Prefix};

/// A range of bytes of a file.
///
/// All ranges compare equal, so two trees are equal if they have the same contents, wherever they are written.
#[derive(Clone, Copy, Debug, Default, Eq)]
pub struct ByteRange {
    /// The first byte.
    pub start: usize,
    /// The byte after the last.
    pub end: usize,
}

impl PartialEq for ByteRange {
    fn eq(&self, _other: &Self) -> bool {
        true
    }
}

impl ByteRange {
    /// The bytes from the start of this range to the end of the other.
    #[must_use]
    pub fn to(self, end: Self) -> Self {
        Self { start: self.start, end: end.end.max(self.end) }
    }
}

impl From<ByteRange> for SourceSpan {
    fn from(span: ByteRange) -> Self {
        (span.start..span.end).into()
    }
}

/// A property file.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub struct File {
    /// Its constants and properties, in order.
    pub items: Vec<Item>,
}

/// A constant or a property.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Item {
    /// `const theta := 10`
    Constant(Constant),
    /// `property phi1 := …`
    Property(Box<PropertyItem>),
}

/// A named constant.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Constant {
    /// Its name.
    pub name: Name,
    /// Its value.
    pub value: Literal,
    /// The span of the value.
    pub value_span: ByteRange,
}

/// A named property.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PropertyItem {
    /// Its name.
    pub name: Name,
    /// Whether durations are measured in time, not in ticks.
    pub is_timed: bool,
    /// What it requires.
    pub constraint: Constraint,
    /// Its span, from its first keyword.
    pub span: ByteRange,
}

/// A name with its span.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Name {
    /// The name.
    pub text: String,
    /// Its span.
    pub span: ByteRange,
}

/// A constraint of the paper's grammar, with its span.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Constraint {
    /// What it is.
    pub kind: ConstraintKind,
    /// Its span.
    pub span: ByteRange,
}

/// The forms of a constraint.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ConstraintKind {
    /// `true`
    True,
    /// `false`
    False,
    /// `(source, dest, condition)`
    Event(Event),
    /// `fresh (source, dest, condition)`
    Fresh(Event),
    /// `time_until (event) ⋈ bound`
    TimeUntil {
        /// The event that is awaited.
        event: Event,
        /// ⋈
        relation: Relation,
        /// The number of ticks, or the duration.
        bound: Operand,
    },
    /// `always α`, `once[⋈ bound] α`, or another operator in front of its operand.
    Prefix(Prefix, Option<Interval>, Box<Constraint>),
    /// `α until β`, `α since[⋈ bound] β` or `α implies β`
    Infix(Infix, Option<Interval>, Box<Constraint>, Box<Constraint>),
    /// `at most n (event) in bound`, or `at least`
    Count {
        /// Whether it is `at most`.
        is_at_most: bool,
        /// n
        count: Operand,
        /// The event that is counted.
        event: Event,
        /// The number of ticks, or the duration.
        bound: Operand,
    },
    /// `α and β and …`, two or more
    And(Vec<Constraint>),
    /// `α or β or …`, two or more
    Or(Vec<Constraint>),
    /// A part that could not be read; a problem reports it.
    Unreadable,
}

impl File {
    /// All literals that are constants, or with which a condition compares something.
    #[must_use]
    pub fn literals(&self) -> Vec<&Literal> {
        let mut literals = Vec::new();
        for item in &self.items {
            match item {
                Item::Constant(constant) => literals.push(&constant.value),
                Item::Property(property) => property.constraint.literals(&mut literals),
            }
        }
        literals
    }
}

impl Constraint {
    fn literals<'f>(&'f self, literals: &mut Vec<&'f Literal>) {
        self.events(&mut |event| event.condition.literals(literals));
    }

    /// Calls `visit` with each event in it.
    pub fn events<'f>(&'f self, visit: &mut dyn FnMut(&'f Event)) {
        if let ConstraintKind::Event(event)
        | ConstraintKind::Fresh(event)
        | ConstraintKind::TimeUntil { event, .. }
        | ConstraintKind::Count { event, .. } = &self.kind
        {
            visit(event);
        }
        self.operands().into_iter().for_each(|part| part.events(visit));
    }

    /// Its immediate parts, in the order in which they are written.
    #[must_use]
    pub fn operands(&self) -> Vec<&Self> {
        match &self.kind {
            ConstraintKind::True
            | ConstraintKind::False
            | ConstraintKind::Event(_)
            | ConstraintKind::Fresh(_)
            | ConstraintKind::TimeUntil { .. }
            | ConstraintKind::Count { .. }
            | ConstraintKind::Unreadable => Vec::new(),
            ConstraintKind::Prefix(_, _, a) => vec![a],
            ConstraintKind::Infix(_, _, a, b) => vec![a, b],
            ConstraintKind::And(parts) | ConstraintKind::Or(parts) => parts.iter().collect(),
        }
    }
}

/// How long ago: `[⋈ bound]`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Interval {
    /// ⋈
    pub relation: Relation,
    /// The number of ticks, or the duration.
    pub bound: Operand,
}

/// A process of an event.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Party {
    /// The process with this name.
    Named(Name),
    /// `*`: any process that fits.
    Any(ByteRange),
}

impl Party {
    /// Its span.
    #[must_use]
    pub fn span(&self) -> ByteRange {
        match self {
            Self::Named(name) => name.span,
            Self::Any(span) => *span,
        }
    }

    /// Its name, if it has one.
    #[must_use]
    pub fn name(&self) -> Option<&Name> {
        if let Self::Named(name) = self { Some(name) } else { None }
    }
}

/// An event: a message from `source` to `target` that satisfies a condition.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Event {
    /// The process that sends.
    pub source: Party,
    /// The process that receives.
    pub target: Party,
    /// The condition on the message.
    pub condition: Condition,
    /// The span of the event, including its parentheses.
    pub span: ByteRange,
}

/// A condition on a message, with its span.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Condition {
    /// What it is.
    pub kind: ConditionKind,
    /// Its span.
    pub span: ByteRange,
}

impl Condition {
    /// Its immediate parts, in the order in which they are written. Terms are none.
    #[must_use]
    pub fn operands(&self) -> Vec<&Self> {
        match &self.kind {
            ConditionKind::True
            | ConditionKind::False
            | ConditionKind::Compare { .. }
            | ConditionKind::Remember { .. }
            | ConditionKind::Unreadable => Vec::new(),
            ConditionKind::Not(a) | ConditionKind::Items { condition: a, .. } => vec![a],
            ConditionKind::And(parts) | ConditionKind::Or(parts) => parts.iter().collect(),
            ConditionKind::Implies(a, b) => vec![a, b],
        }
    }

    fn literals<'f>(&'f self, literals: &mut Vec<&'f Literal>) {
        if let ConditionKind::Compare { left, right, .. } = &self.kind {
            [left, right].into_iter().for_each(|term| term.literals(literals));
        }
        self.operands().into_iter().for_each(|part| part.literals(literals));
    }

    /// The names that it gives to values. One item among several cannot be remembered, which the resolver reports.
    #[must_use]
    pub fn remembered(&self) -> Vec<&Name> {
        match &self.kind {
            ConditionKind::Remember { name, .. } => vec![name],
            _ => self.operands().into_iter().flat_map(Self::remembered).collect(),
        }
    }
}

/// The forms of a condition.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ConditionKind {
    /// `true`: any message.
    True,
    /// `false`: no message.
    False,
    /// `term ⋈ term`
    Compare {
        /// The left term: a field, usually.
        left: Term,
        /// ⋈
        relation: Relation,
        /// The right term: a constant, usually.
        right: Term,
    },
    /// `any(c)` or `all(c)`: the condition holds with some item, or with every item, of the lists that it mentions.
    Items {
        /// Whether it is `all`.
        every: bool,
        /// c
        condition: Box<Condition>,
    },
    /// `m[k] as name`: the message has the field, and its value is remembered.
    Remember {
        /// The field of the message.
        field: Field,
        /// The name of the value.
        name: Name,
    },
    /// `not c`
    Not(Box<Condition>),
    /// `c and d and …`, two or more
    And(Vec<Condition>),
    /// `c or d or …`, two or more
    Or(Vec<Condition>),
    /// `c implies d`
    Implies(Box<Condition>, Box<Condition>),
    /// A part that could not be read; a problem reports it.
    Unreadable,
}

/// A value that a condition compares.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Term {
    /// A field of the message.
    Field(Field),
    /// A literal, or the name of a constant, of a remembered value or of a field.
    Operand(Operand),
    /// `term + term`, or another operator.
    Arithmetic(Box<Term>, Arithmetic, Box<Term>),
    /// `distance(x, y, u, v)`, or another function.
    Call(Function, Vec<Term>, ByteRange),
    /// `count(c)`: the number of items with which the condition holds.
    Count(Box<Condition>, ByteRange),
}

impl Term {
    fn literals<'f>(&'f self, literals: &mut Vec<&'f Literal>) {
        match self {
            Self::Field(_) | Self::Operand(Operand::Constant(_)) => {}
            Self::Operand(Operand::Literal(literal, _)) => literals.push(literal),
            Self::Arithmetic(left, _, right) => [left, right].into_iter().for_each(|term| term.literals(literals)),
            Self::Call(_, terms, _) => terms.iter().for_each(|term| term.literals(literals)),
            Self::Count(condition, _) => condition.literals(literals),
        }
    }

    /// Its span.
    #[must_use]
    pub fn span(&self) -> ByteRange {
        match self {
            Self::Field(field) => field.span,
            Self::Operand(operand) => operand.span(),
            Self::Arithmetic(left, _, right) => left.span().to(right.span()),
            Self::Call(_, _, span) | Self::Count(_, span) => *span,
        }
    }
}

/// A field of the message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Field {
    /// Its name or number.
    pub name: FieldName,
    /// Its span.
    pub span: ByteRange,
}

/// The ways to name a field.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FieldName {
    /// `m[2]`, counted from 1.
    Number(usize),
    /// `m.level`, or just `level`.
    Named(String),
}

/// The right side of a relation, with its span.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Operand {
    /// A literal.
    Literal(Literal, ByteRange),
    /// The name of a constant.
    Constant(Name),
}

impl Operand {
    /// Its span.
    #[must_use]
    pub fn span(&self) -> ByteRange {
        match self {
            Self::Literal(_, span) => *span,
            Self::Constant(name) => name.span,
        }
    }
}

/// A literal. Two reals are equal if they have the same bits.
#[derive(Clone, Debug)]
pub enum Literal {
    /// `<ok>`
    Symbol(String),
    /// `true` or `false`
    Bool(bool),
    /// `20`
    Int(i64),
    /// `20.5`
    Real(f64),
    /// `"text"`
    Text(String),
    /// `30 s`
    Duration {
        /// The length in nanoseconds.
        nanos: u64,
        /// The unit it is written in.
        unit: Unit,
    },
}

impl PartialEq for Literal {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Symbol(a), Self::Symbol(b)) | (Self::Text(a), Self::Text(b)) => a == b,
            (Self::Bool(a), Self::Bool(b)) => a == b,
            (Self::Int(a), Self::Int(b)) => a == b,
            (Self::Real(a), Self::Real(b)) => a.to_bits() == b.to_bits(),
            (Self::Duration { nanos: a, unit: u }, Self::Duration { nanos: b, unit: v }) => (a, u) == (b, v),
            _ => false,
        }
    }
}

impl Eq for Literal {}
