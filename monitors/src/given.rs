//! Fields that only some messages of a channel have, because others have another field at the same position: what
//! selects these messages is given with the field, or beside the comparison.

use std::sync::Arc;

use channels::Relation;

use crate::formula::{MessageCondition, MessageField, Term};

impl MessageField {
    /// The field as that of any message.
    fn of_any(&self) -> Self {
        Self { given: None, ..self.clone() }
    }
}

impl MessageCondition {
    /// The same condition, where what selects the messages with a field is a part beside the comparison. Inside
    /// `any(…)`, `all(…)` and `count(…)`, it stays with the field.
    pub(crate) fn spelled_out(&self) -> Self {
        let all = |parts: &[Self]| parts.iter().map(Self::spelled_out).collect();
        match self {
            Self::Compare { field, relation, value } => beside(&[field], *relation, |relation| Self::Compare {
                field: field.of_any(),
                relation,
                value: value.clone(),
            }),
            Self::Remember { field, name } => {
                let remembered = |_| Self::Remember { field: field.of_any(), name: Arc::clone(name) };
                beside(&[field], Relation::Equal, remembered)
            }
            Self::Relate { left, relation, right } => {
                let mut fields = Vec::new();
                [left, right].into_iter().for_each(|term| term.own_fields(&mut |field| fields.push(field)));
                beside(&fields, *relation, |relation| {
                    let [left, right] = [left, right].map(|term| term.of_any(false));
                    Self::Relate { left, relation, right }
                })
            }
            Self::Not(a) => Self::Not(Box::new(a.spelled_out())),
            Self::And(parts) => Self::And(all(parts)),
            Self::Or(parts) => Self::Or(all(parts)),
            Self::Implies(a, b) => Self::Implies(Box::new(a.spelled_out()), Box::new(b.spelled_out())),
            Self::True | Self::False | Self::Is { .. } => self.clone(),
        }
    }

    /// The condition with each field as that of any message.
    pub(crate) fn of_any(&self) -> Self {
        let all = |parts: &[Self]| parts.iter().map(Self::of_any).collect();
        match self {
            Self::Compare { field, relation, value } => {
                Self::Compare { field: field.of_any(), relation: *relation, value: value.clone() }
            }
            Self::Remember { field, name } => Self::Remember { field: field.of_any(), name: Arc::clone(name) },
            Self::Relate { left, relation, right } => {
                Self::Relate { left: left.of_any(true), relation: *relation, right: right.of_any(true) }
            }
            Self::Not(a) => Self::Not(Box::new(a.of_any())),
            Self::And(parts) => Self::And(all(parts)),
            Self::Or(parts) => Self::Or(all(parts)),
            Self::Implies(a, b) => Self::Implies(Box::new(a.of_any()), Box::new(b.of_any())),
            Self::True | Self::False | Self::Is { .. } => self.clone(),
        }
    }
}

/// A comparison of these fields, beside what is given with them.
fn beside(
    fields: &[&MessageField],
    relation: Relation,
    comparison: impl FnOnce(Relation) -> MessageCondition,
) -> MessageCondition {
    let mut parts: Vec<MessageCondition> = Vec::new();
    for given in fields.iter().filter_map(|field| field.given.as_deref()) {
        if !parts.contains(given) {
            parts.push(given.clone());
        }
    }
    if parts.is_empty() {
        return comparison(relation);
    }
    // A missing value differs from every value.
    let is_denied = relation == Relation::NotEqual;
    parts.push(comparison(if is_denied { Relation::Equal } else { relation }));
    let all = MessageCondition::And(parts);
    if is_denied { MessageCondition::Not(Box::new(all)) } else { all }
}

impl Term {
    /// Calls `visit` with each field without which the term has no value.
    fn own_fields<'a>(&'a self, visit: &mut dyn FnMut(&'a MessageField)) {
        match self {
            Self::Field(field) => visit(field),
            Self::Arithmetic(left, _, right) => [left, right].into_iter().for_each(|term| term.own_fields(visit)),
            Self::Call(_, terms) => terms.iter().for_each(|term| term.own_fields(visit)),
            Self::Value(_) | Self::Remembered(_) | Self::Count(_) => {}
        }
    }

    /// The term with each field as that of any message, those that it counts with included if `items`.
    fn of_any(&self, items: bool) -> Self {
        match self {
            Self::Field(field) => Self::Field(field.of_any()),
            Self::Arithmetic(left, operator, right) => {
                Self::Arithmetic(Box::new(left.of_any(items)), *operator, Box::new(right.of_any(items)))
            }
            Self::Call(function, terms) => Self::Call(*function, terms.iter().map(|term| term.of_any(items)).collect()),
            Self::Count(condition) if items => Self::Count(Box::new(condition.of_any())),
            Self::Value(_) | Self::Remembered(_) | Self::Count(_) => self.clone(),
        }
    }
}
