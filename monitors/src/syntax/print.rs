//! Prints a tree as ASCII text; parsing the text gives the same tree.

use std::fmt::{self, Display, Formatter};

use channels::{Relation, Value};

use super::ast::{
    Condition, ConditionKind, Constraint, ConstraintKind, Event, Field, FieldName, File, Interval, Item, Literal, Name,
    Operand, Party, Term,
};
use super::token::is_plain_name;
use crate::formula::Unit;
use crate::operator::Infix;

impl Display for File {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        self.items.iter().try_for_each(|item| writeln!(f, "{item}"))
    }
}

impl Display for Item {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Constant(constant) => write!(f, "const {} := {}", constant.name, constant.value),
            Self::Property(property) => {
                let timed = if property.is_timed { "timed " } else { "" };
                write!(f, "{timed}property {} := {}", property.name, property.constraint)
            }
        }
    }
}

impl Display for Name {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        if is_plain_name(&self.text) { f.write_str(&self.text) } else { write_text(f, &self.text) }
    }
}

impl Display for Party {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Named(name) => name.fmt(f),
            Self::Any(_) => f.write_str("*"),
        }
    }
}

/// A part with lower precedence than its place demands is put in parentheses.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Precedence {
    Implies,
    Or,
    And,
    Until,
    Prefix,
}

/// What has a precedence: constraints and conditions.
trait Expression: Display {
    fn precedence(&self) -> Precedence;

    /// The same in a place that demands at least this precedence.
    fn at(&self, demanded: Precedence) -> Parenthesized<'_, Self>
    where
        Self: Sized,
    {
        Parenthesized(self, demanded)
    }
}

struct Parenthesized<'a, E>(&'a E, Precedence);

impl<E: Expression> Display for Parenthesized<'_, E> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self(operand, demanded) = self;
        if operand.precedence() < *demanded { write!(f, "({operand})") } else { operand.fmt(f) }
    }
}

impl Expression for Constraint {
    fn precedence(&self) -> Precedence {
        match self.kind {
            ConstraintKind::Infix(Infix::Implies, ..) => Precedence::Implies,
            ConstraintKind::Or(_) => Precedence::Or,
            ConstraintKind::And(_) => Precedence::And,
            ConstraintKind::Infix(Infix::Until | Infix::Since, ..) => Precedence::Until,
            _ => Precedence::Prefix,
        }
    }
}

impl Display for Constraint {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match &self.kind {
            ConstraintKind::True | ConstraintKind::Unreadable => f.write_str("true"),
            ConstraintKind::False => f.write_str("false"),
            ConstraintKind::Event(event) => event.fmt(f),
            ConstraintKind::Fresh(event) => write!(f, "fresh {event}"),
            ConstraintKind::TimeUntil { event, relation, bound } => {
                write!(f, "time_until {event} {} {bound}", ascii(*relation))
            }
            ConstraintKind::Prefix(operator, ago, part) => {
                write!(f, "{}{} {}", operator.word(), Ago(ago), part.at(Precedence::Prefix))
            }
            ConstraintKind::Infix(operator, ago, left, right) => {
                let (on_left, on_right) = match operator {
                    Infix::Until | Infix::Since => (Precedence::Prefix, Precedence::Until),
                    Infix::Implies => (Precedence::Or, Precedence::Implies),
                };
                write!(f, "{} {}{} {}", left.at(on_left), operator.word(), Ago(ago), right.at(on_right))
            }
            ConstraintKind::Count { is_at_most, count, event, bound } => {
                write!(f, "at {} {count} {event} in {bound}", if *is_at_most { "most" } else { "least" })
            }
            ConstraintKind::And(parts) => join(f, parts.iter().map(|part| part.at(Precedence::Until)), " and "),
            ConstraintKind::Or(parts) => join(f, parts.iter().map(|part| part.at(Precedence::And)), " or "),
        }
    }
}

/// `[< 10]`, or nothing.
struct Ago<'a>(&'a Option<Interval>);

impl Display for Ago<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self.0 {
            Some(Interval { relation, bound }) => write!(f, "[{} {bound}]", ascii(*relation)),
            None => Ok(()),
        }
    }
}

impl Display for Event {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "({}, {}, {})", self.source, self.target, self.condition)
    }
}

impl Expression for Condition {
    fn precedence(&self) -> Precedence {
        match self.kind {
            ConditionKind::Implies(..) => Precedence::Implies,
            ConditionKind::Or(_) => Precedence::Or,
            ConditionKind::And(_) => Precedence::And,
            _ => Precedence::Prefix,
        }
    }
}

impl Display for Condition {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match &self.kind {
            ConditionKind::True | ConditionKind::Unreadable => f.write_str("true"),
            ConditionKind::False => f.write_str("false"),
            ConditionKind::Compare { left, relation, right } => write!(f, "{left} {} {right}", ascii(*relation)),
            ConditionKind::Items { every, condition } => {
                write!(f, "{}({condition})", if *every { "all" } else { "any" })
            }
            ConditionKind::Remember { field, name } => write!(f, "{field} as {name}"),
            ConditionKind::Not(part) => write!(f, "not {}", part.at(Precedence::Prefix)),
            ConditionKind::And(parts) => join(f, parts.iter().map(|part| part.at(Precedence::Until)), " and "),
            ConditionKind::Or(parts) => join(f, parts.iter().map(|part| part.at(Precedence::And)), " or "),
            ConditionKind::Implies(left, right) => {
                write!(f, "{} implies {}", left.at(Precedence::Or), right.at(Precedence::Implies))
            }
        }
    }
}

/// A term; with `true`, where only a factor can stand.
struct Factor<'a>(&'a Term, bool);

impl Display for Factor<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self(term @ Term::Arithmetic(..), true) => write!(f, "({term})"),
            // A sum on the right of a sign needs its parentheses, one on the left of `+` or `-` does not.
            Self(term, _) => term.fmt(f),
        }
    }
}

impl Display for Term {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Field(field) => field.fmt(f),
            Self::Operand(operand) => operand.fmt(f),
            Self::Arithmetic(left, operator, right) => {
                let is_sum = |term: &Self| matches!(term, Self::Arithmetic(_, inner, _) if !inner.is_factor());
                let left = Factor(left, operator.is_factor() && is_sum(left));
                write!(f, "{left} {} {}", operator.sign(), Factor(right, true))
            }
            Self::Call(function, terms, _) => {
                write!(f, "{}(", function.signature().0)?;
                join(f, terms.iter(), ", ")?;
                f.write_str(")")
            }
            Self::Count(condition, _) => write!(f, "count({condition})"),
        }
    }
}

impl Display for Field {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match &self.name {
            FieldName::Number(number) => write!(f, "m[{number}]"),
            FieldName::Named(name) if is_plain_name(name) => write!(f, "m.{name}"),
            FieldName::Named(name) => {
                f.write_str("m.")?;
                write_text(f, name)
            }
        }
    }
}

impl Display for Operand {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Literal(literal, _) => literal.fmt(f),
            Self::Constant(name) => name.fmt(f),
        }
    }
}

impl Display for Literal {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Symbol(symbol) => write!(f, "<{symbol}>"),
            Self::Bool(truth) => write!(f, "{truth}"),
            Self::Int(number) => write!(f, "{number}"),
            Self::Real(number) => Value::Real(*number).fmt(f),
            Self::Text(text) => write_text(f, text),
            Self::Duration { nanos, unit } => write_duration(f, *nanos, *unit),
        }
    }
}

/// `1.5 min`, with at most 20 digits after the point: durations read from a file have fewer.
fn write_duration(f: &mut Formatter<'_>, nanos: u64, unit: Unit) -> fmt::Result {
    let whole = u128::from(unit.nanos());
    let mut rest = u128::from(nanos) % whole;
    write!(f, "{}", u128::from(nanos) / whole)?;
    for digit in 0..20 {
        if rest == 0 {
            break;
        }
        rest *= 10;
        write!(f, "{}{}", if digit == 0 { "." } else { "" }, rest / whole)?;
        rest %= whole;
    }
    write!(f, " {}", unit.name())
}

fn ascii(relation: Relation) -> &'static str {
    match relation {
        Relation::Equal => "=",
        Relation::NotEqual => "!=",
        Relation::Less => "<",
        Relation::LessOrEqual => "<=",
        Relation::Greater => ">",
        Relation::GreaterOrEqual => ">=",
    }
}

fn join<T: Display>(f: &mut Formatter<'_>, parts: impl Iterator<Item = T>, word: &str) -> fmt::Result {
    for (index, part) in parts.enumerate() {
        if index > 0 {
            f.write_str(word)?;
        }
        part.fmt(f)?;
    }
    Ok(())
}

fn write_text(f: &mut Formatter<'_>, text: &str) -> fmt::Result {
    f.write_str("\"")?;
    for char in text.chars() {
        match char {
            '"' => f.write_str("\\\"")?,
            '\\' => f.write_str("\\\\")?,
            '\n' => f.write_str("\\n")?,
            '\t' => f.write_str("\\t")?,
            other => write!(f, "{other}")?,
        }
    }
    f.write_str("\"")
}
