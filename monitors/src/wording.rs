//! Formulas in the SCOPE language: text that reads back as the same formula.

use channels::{FieldKind, Shape, Topology, Value};

use crate::formula::{Bound, EventAtom, Formula, MessageCondition, Term};
use crate::syntax::{
    self, ByteRange, Condition, ConditionKind, Constraint, ConstraintKind, Field, FieldName, Interval, Literal, Name,
    Operand, Unit,
};

const NOWHERE: ByteRange = ByteRange { start: 0, end: 0 };

impl Formula {
    /// The formula in the SCOPE language, over its topology. Bounds are in ticks; those of a timed formula are
    /// durations.
    ///
    /// Reading the text gives the same formula, except for an `and` or `or` of fewer than two parts, which the language
    /// does not have.
    #[must_use]
    pub fn text(&self, topology: &Topology) -> String {
        constraint(self, topology, false).to_string()
    }
}

impl MessageCondition {
    /// The condition in the SCOPE language. Fields have the names that messages of these shapes give them, or numbers.
    #[must_use]
    pub fn text(&self, shapes: &[Shape]) -> String {
        condition(self, shapes).to_string()
    }
}

impl EventAtom {
    fn named(&self, topology: &Topology) -> syntax::Event {
        let (source, target) = topology.ends(self.channel);
        let name = |text: &str| Name { text: text.to_owned(), span: NOWHERE };
        let condition = condition(&self.condition, topology.get(self.channel).domain.shapes());
        syntax::Event { source: name(source), target: name(target), condition, span: NOWHERE }
    }
}

fn constraint(formula: &Formula, topology: &Topology, is_timed: bool) -> Constraint {
    let of = |part: &Formula| Box::new(constraint(part, topology, is_timed));
    let list = |parts: &[Formula]| parts.iter().map(|part| constraint(part, topology, is_timed)).collect();
    let number = |number: u64| operand(Literal::Int(i64::try_from(number).unwrap_or(i64::MAX)));
    let length = |length: u64| if is_timed { operand(duration(length)) } else { number(length) };
    let ago = |bound: &Bound| {
        let interval = Interval { relation: bound.relation, bound: length(bound.ticks) };
        (*bound != Bound::NONE).then_some(interval)
    };
    let kind = match formula {
        Formula::True => ConstraintKind::True,
        Formula::False => ConstraintKind::False,
        Formula::And(parts) if parts.is_empty() => ConstraintKind::True,
        Formula::Or(parts) if parts.is_empty() => ConstraintKind::False,
        Formula::And(parts) | Formula::Or(parts) if parts.len() == 1 => {
            return constraint(&parts[0], topology, is_timed);
        }
        Formula::And(parts) => ConstraintKind::And(list(parts)),
        Formula::Or(parts) => ConstraintKind::Or(list(parts)),
        Formula::Event(event) => ConstraintKind::Event(event.named(topology)),
        Formula::TimeUntil { event, relation, ticks } => {
            ConstraintKind::TimeUntil { event: event.named(topology), relation: *relation, bound: length(*ticks) }
        }
        Formula::Timed(part) => return constraint(part, topology, true),
        Formula::Not(part) => ConstraintKind::Not(of(part)),
        Formula::Implies(a, b) => ConstraintKind::Implies(of(a), of(b)),
        Formula::Next(part) => ConstraintKind::Next(of(part)),
        Formula::Always(part) => ConstraintKind::Always(of(part)),
        Formula::Eventually(part) => ConstraintKind::Eventually(of(part)),
        Formula::Until(a, b) => ConstraintKind::Until(of(a), of(b)),
        Formula::Once(bound, a) => ConstraintKind::Once(ago(bound), of(a)),
        Formula::Historically(bound, a) => ConstraintKind::Historically(ago(bound), of(a)),
        Formula::Previous(bound, a) => ConstraintKind::Previous(ago(bound), of(a)),
        Formula::Since(bound, a, b) => ConstraintKind::Since(ago(bound), of(a), of(b)),
        Formula::Count { event, is_at_most, count, ticks } => ConstraintKind::Count {
            is_at_most: *is_at_most,
            count: number(*count),
            event: event.named(topology),
            bound: length(*ticks),
        },
    };
    Constraint { kind, span: NOWHERE }
}

/// A condition in the words of the language.
pub(crate) fn condition(from: &MessageCondition, shapes: &[Shape]) -> Condition {
    let of = |part: &MessageCondition| Box::new(condition(part, shapes));
    let list = |parts: &[MessageCondition]| parts.iter().map(|part| condition(part, shapes)).collect();
    let kind = match from {
        MessageCondition::True => ConditionKind::True,
        MessageCondition::False => ConditionKind::False,
        MessageCondition::And(parts) if parts.is_empty() => ConditionKind::True,
        MessageCondition::Or(parts) if parts.is_empty() => ConditionKind::False,
        MessageCondition::And(parts) | MessageCondition::Or(parts) if parts.len() == 1 => {
            return condition(&parts[0], shapes);
        }
        MessageCondition::And(parts) => ConditionKind::And(list(parts)),
        MessageCondition::Or(parts) => ConditionKind::Or(list(parts)),
        MessageCondition::Compare { field, relation, value } => ConditionKind::Compare {
            left: syntax::Term::Field(named(*field, shapes)),
            relation: *relation,
            right: syntax::Term::Operand(operand(literal(value))),
        },
        MessageCondition::Relate { left, relation, right } => {
            ConditionKind::Compare { left: term(left, shapes), relation: *relation, right: term(right, shapes) }
        }
        MessageCondition::Remember { field, name } => {
            let name = Name { text: name.to_string(), span: NOWHERE };
            ConditionKind::Remember { field: named(*field, shapes), name }
        }
        MessageCondition::Not(part) => ConditionKind::Not(of(part)),
        MessageCondition::Implies(a, b) => ConditionKind::Implies(of(a), of(b)),
    };
    Condition { kind, span: NOWHERE }
}

fn named(field: usize, shapes: &[Shape]) -> Field {
    let name = field_name(field, shapes).map_or(FieldName::Number(field), |name| FieldName::Named(name.to_owned()));
    Field { name, span: NOWHERE }
}

/// The name of a field, if it means this field in all messages. A first field that is always a symbol tells what the
/// message is: it keeps its number, as in the paper.
pub(crate) fn field_name(field: usize, shapes: &[Shape]) -> Option<&str> {
    let index = field.checked_sub(1)?;
    let mut here = shapes.iter().filter_map(|shape| shape.fields().get(index));
    let (name, _) = here.clone().next()?;
    let is_tag = index == 0 && here.clone().all(|(_, kind)| matches!(kind, FieldKind::Symbol(_)));
    let elsewhere = shapes.iter().flat_map(|shape| shape.fields().iter().enumerate());
    let is_unique = elsewhere.filter(|(_, (known, _))| known == name).all(|(place, _)| place == index);
    (!is_tag && is_unique && here.all(|(known, _)| known == name)).then_some(name)
}

/// A term in the words of the language.
fn term(from: &Term, shapes: &[Shape]) -> syntax::Term {
    match from {
        Term::Field(field) => syntax::Term::Field(named(*field, shapes)),
        Term::Value(value) => syntax::Term::Operand(operand(literal(value))),
        Term::Remembered(name) => {
            syntax::Term::Operand(Operand::Constant(Name { text: name.to_string(), span: NOWHERE }))
        }
        Term::Arithmetic(left, operator, right) => {
            syntax::Term::Arithmetic(Box::new(term(left, shapes)), *operator, Box::new(term(right, shapes)))
        }
    }
}

fn literal(value: &Value) -> Literal {
    match value {
        Value::Symbol(symbol) => Literal::Symbol(symbol.name().to_owned()),
        Value::Bool(truth) => Literal::Bool(*truth),
        Value::Int(number) => Literal::Int(*number),
        Value::Real(number) => Literal::Real(*number),
        Value::Text(text) => Literal::Text(text.to_string()),
    }
}

/// A duration in the largest unit in which it has at most three decimals.
pub(crate) fn duration(nanos: u64) -> Literal {
    let is_short = |unit: &Unit| nanos >= unit.nanos() && nanos.is_multiple_of(unit.nanos() / 1000);
    let unit = Unit::ALL.into_iter().rev().find(is_short).unwrap_or(Unit::Milliseconds);
    Literal::Duration { nanos, unit }
}

fn operand(literal: Literal) -> Operand {
    Operand::Literal(literal, NOWHERE)
}
