//! Formulas in the SCOPE language: text that reads back as the same formula.

use channels::{Topology, Value};

use crate::formula::{EventAtom, Formula, MessageCondition};
use crate::syntax::{
    self, ByteRange, Condition, ConditionKind, Constraint, ConstraintKind, Field, FieldName, Literal, Name, Operand,
};

const NOWHERE: ByteRange = ByteRange { start: 0, end: 0 };

impl Formula {
    /// The formula in the SCOPE language, over its topology. Bounds are in ticks.
    ///
    /// Reading the text gives the same formula, except for an `and` or `or` of fewer than two parts, which the language
    /// does not have.
    #[must_use]
    pub fn text(&self, topology: &Topology) -> String {
        constraint(self, topology).to_string()
    }
}

impl EventAtom {
    fn named(&self, topology: &Topology) -> syntax::Event {
        let (source, target) = topology.ends(self.channel);
        let name = |text: &str| Name { text: text.to_owned(), span: NOWHERE };
        let condition = condition(&self.condition);
        syntax::Event { source: name(source), target: name(target), condition, span: NOWHERE }
    }
}

fn constraint(formula: &Formula, topology: &Topology) -> Constraint {
    let of = |part: &Formula| Box::new(constraint(part, topology));
    let list = |parts: &[Formula]| parts.iter().map(|part| constraint(part, topology)).collect();
    let kind = match formula {
        Formula::True => ConstraintKind::True,
        Formula::False => ConstraintKind::False,
        Formula::And(parts) if parts.is_empty() => ConstraintKind::True,
        Formula::Or(parts) if parts.is_empty() => ConstraintKind::False,
        Formula::And(parts) | Formula::Or(parts) if parts.len() == 1 => return constraint(&parts[0], topology),
        Formula::And(parts) => ConstraintKind::And(list(parts)),
        Formula::Or(parts) => ConstraintKind::Or(list(parts)),
        Formula::Event(event) => ConstraintKind::Event(event.named(topology)),
        Formula::TimeUntil { event, relation, ticks } => ConstraintKind::TimeUntil {
            event: event.named(topology),
            relation: *relation,
            bound: operand(Literal::Int(i64::try_from(*ticks).unwrap_or(i64::MAX))),
        },
        Formula::Not(part) => ConstraintKind::Not(of(part)),
        Formula::Implies(a, b) => ConstraintKind::Implies(of(a), of(b)),
        Formula::Next(part) => ConstraintKind::Next(of(part)),
        Formula::Always(part) => ConstraintKind::Always(of(part)),
        Formula::Eventually(part) => ConstraintKind::Eventually(of(part)),
        Formula::Until(a, b) => ConstraintKind::Until(of(a), of(b)),
    };
    Constraint { kind, span: NOWHERE }
}

/// A condition in the words of the language.
pub(crate) fn condition(from: &MessageCondition) -> Condition {
    let of = |part: &MessageCondition| Box::new(condition(part));
    let list = |parts: &[MessageCondition]| parts.iter().map(condition).collect();
    let kind = match from {
        MessageCondition::True => ConditionKind::True,
        MessageCondition::False => ConditionKind::False,
        MessageCondition::And(parts) if parts.is_empty() => ConditionKind::True,
        MessageCondition::Or(parts) if parts.is_empty() => ConditionKind::False,
        MessageCondition::And(parts) | MessageCondition::Or(parts) if parts.len() == 1 => return condition(&parts[0]),
        MessageCondition::And(parts) => ConditionKind::And(list(parts)),
        MessageCondition::Or(parts) => ConditionKind::Or(list(parts)),
        MessageCondition::Compare { field, relation, value } => ConditionKind::Compare {
            field: Field { name: FieldName::Number(*field), span: NOWHERE },
            relation: *relation,
            value: operand(literal(value)),
        },
        MessageCondition::Not(part) => ConditionKind::Not(of(part)),
        MessageCondition::Implies(a, b) => ConditionKind::Implies(of(a), of(b)),
    };
    Condition { kind, span: NOWHERE }
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

fn operand(literal: Literal) -> Operand {
    Operand::Literal(literal, NOWHERE)
}
