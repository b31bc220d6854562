//! Which conditions on the messages of a channel can hold together.
//!
//! The constants that a field is compared with divide its values into regions, and each region has a sample. The fields
//! are decided one after the other. What is left of the conditions is all that matters of the fields before it: two
//! beginnings of a message that leave the same are one node. This is a decision diagram, built from its root: one
//! condition on eight fields has two nodes for each field, where it has 5⁸ combinations of regions.

use std::collections::{BTreeSet, HashSet};

use channels::{Domain, FieldKind, Message, Relation, Value};

use crate::formula::{MessageCondition, ValueType};

/// Messages for all combinations of conditions that a message of the domain can satisfy, at least one for each; `None`
/// if finding them takes more than `work`: visits to parts of conditions.
///
/// Exact for conditions that compare fields with constants. Others are left to the messages that are found.
pub(crate) fn combinations(domain: &Domain, conditions: &[MessageCondition], work: usize) -> Option<Vec<Message>> {
    let conditions: Vec<MessageCondition> = conditions.iter().map(MessageCondition::spelled_out).collect();
    let constants = Constants::of(&conditions);
    let mut work = work;
    let mut messages = Vec::new();
    for shape in domain.shapes() {
        let fields: Vec<FieldDomain<'_>> = shape.fields().iter().map(|(_, kind)| FieldDomain::Of(kind)).collect();
        messages.extend(constants.messages(&conditions, &fields, &mut work)?);
    }
    if domain.shapes().is_empty() {
        // Without shapes, a message has any number of fields, each with any value.
        let lengths: BTreeSet<usize> = constants.0.iter().map(|(field, _)| *field).chain([0]).collect();
        for length in lengths {
            messages.extend(constants.messages(&conditions, &vec![FieldDomain::Any; length], &mut work)?);
        }
    }
    Some(messages)
}

/// The possible values of a field.
#[derive(Clone, Copy)]
enum FieldDomain<'a> {
    Of(&'a FieldKind),
    Any,
}

/// The fields that conditions mention, in the order in which they do, each with the constants it is compared with.
struct Constants<'a>(Vec<(usize, Vec<&'a Value>)>);

/// The beginning of a message: a sample for each field that has been decided.
type Beginning = Vec<(usize, Value)>;

impl<'a> Constants<'a> {
    fn of(conditions: &'a [MessageCondition]) -> Self {
        let mut fields: Vec<(usize, Vec<&Value>)> = Vec::new();
        for condition in conditions {
            condition.mentions(&mut |field, value| {
                let place = fields.iter().position(|(known, _)| *known == field).unwrap_or_else(|| {
                    fields.push((field, Vec::new()));
                    fields.len() - 1
                });
                fields[place].1.extend(value);
            });
        }
        Self(fields)
    }

    /// Messages with these fields for all combinations of conditions that such a message can satisfy.
    fn messages(
        &self,
        conditions: &[MessageCondition],
        fields: &[FieldDomain<'_>],
        work: &mut usize,
    ) -> Option<Vec<Message>> {
        let mut nodes: Vec<(Vec<MessageCondition>, Beginning)> = vec![(conditions.to_vec(), Vec::new())];
        for (field, constants) in &self.0 {
            let kind = field.checked_sub(1).and_then(|index| fields.get(index));
            let values = kind.map_or(vec![None], |kind| kind.samples(constants).into_iter().map(Some).collect());
            let mut known: HashSet<Vec<MessageCondition>> = HashSet::new();
            let mut next: Vec<(Vec<MessageCondition>, Beginning)> = Vec::new();
            for (left, beginning) in &nodes {
                for value in &values {
                    *work = work.checked_sub(left.iter().map(MessageCondition::size).sum())?;
                    let left: Vec<_> = left.iter().map(|condition| condition.given(*field, value.as_ref())).collect();
                    // Beginnings that leave the same are one node, and the first of them stands for all.
                    if known.insert(left.clone()) {
                        let decided = value.iter().map(|value| (*field, value.clone()));
                        next.push((left, beginning.iter().cloned().chain(decided).collect()));
                    }
                }
            }
            nodes = next;
        }
        Some(nodes.into_iter().map(|(_, beginning)| message(fields, &beginning)).collect())
    }
}

/// The message with these samples, and any value in the other fields.
fn message(fields: &[FieldDomain<'_>], samples: &Beginning) -> Message {
    let values = fields.iter().enumerate().map(|(index, kind)| {
        let decided = samples.iter().find(|(field, _)| *field == index + 1).map(|(_, value)| value.clone());
        decided.or_else(|| kind.samples(&[]).into_iter().next())
    });
    Message::new(values.map_while(|value| value))
}

impl FieldDomain<'_> {
    /// Values of the field, one for each region that comparisons with the constants distinguish.
    fn samples(self, constants: &[&Value]) -> Vec<Value> {
        match self {
            Self::Of(kind) => samples(kind, constants),
            Self::Any => {
                // One symbol stands for all values of other types.
                let unmentioned = unmentioned("Unmentioned", |name| constants.contains(&&Value::symbol(name)));
                let others = constants.iter().filter(|value| !value.is_number()).map(|value| (*value).clone());
                let numbers = reals(constants).into_iter().chain(integers(constants));
                std::iter::once(Value::symbol(&unmentioned)).chain(numbers).chain(others).collect()
            }
        }
    }
}

/// Values of a kind, one for each region that comparisons with the constants distinguish: each symbol, number and text
/// that is one of them, and one of the others. Of a list, only the empty one.
#[must_use]
pub fn samples(kind: &FieldKind, constants: &[&Value]) -> Vec<Value> {
    match kind {
        FieldKind::Symbol(symbols) => {
            let (mentioned, others): (Vec<Value>, Vec<Value>) =
                symbols.iter().cloned().map(Value::Symbol).partition(|symbol| constants.contains(&symbol));
            mentioned.into_iter().chain(others.into_iter().take(1)).collect()
        }
        FieldKind::Bool if constants.is_empty() => vec![false.into()],
        FieldKind::Bool => vec![false.into(), true.into()],
        FieldKind::Real => reals(constants),
        FieldKind::Int => integers(constants),
        FieldKind::Text => {
            let texts = constants.iter().filter(|value| matches!(value, Value::Text(_))).map(|value| (*value).clone());
            let other = unmentioned("unmentioned", |text| constants.contains(&&Value::from(text)));
            texts.chain([Value::from(other.as_str())]).collect()
        }
        FieldKind::Optional(kind) => {
            let none = Value::symbol(FieldKind::NONE);
            std::iter::once(none).chain(samples(kind, constants)).collect()
        }
        FieldKind::List(_) => vec![Value::List([].into())],
    }
}

fn unmentioned(text: &str, is_mentioned: impl Fn(&str) -> bool) -> String {
    let mut text = text.to_owned();
    while is_mentioned(&text) {
        text.push('\'');
    }
    text
}

/// The numbers among the constants, each once, in their exact order.
fn numbers(constants: &[&Value]) -> Vec<Value> {
    let mut numbers: Vec<Value> = constants.iter().filter(|value| value.is_number()).map(|v| (*v).clone()).collect();
    numbers.retain(|number| number.order(number).is_some());
    numbers.sort_by(|a, b| a.order(b).unwrap_or(std::cmp::Ordering::Equal));
    numbers.dedup_by(|a, b| Relation::Equal.holds(a, b));
    numbers
}

/// Integers in each region: every integer constant and its neighbors, the integers around every other number.
fn integers(constants: &[&Value]) -> Vec<Value> {
    let near = |number: &Value| match number {
        Value::Int(number) => *number,
        // The conversion saturates; a real of this size is an integer.
        Value::Real(number) => number.floor() as i64,
        _ => 0,
    };
    let numbers = numbers(constants);
    let around = |number: i64| [number.saturating_sub(1), number, number.saturating_add(1)];
    let all: BTreeSet<i64> = numbers.iter().map(near).flat_map(around).collect();
    if all.is_empty() { vec![Value::Int(0)] } else { all.into_iter().map(Value::Int).collect() }
}

/// Reals in each region: below all numbers, above them, between neighbors, and the numbers themselves, where there is a
/// real.
fn reals(constants: &[&Value]) -> Vec<Value> {
    let numbers = numbers(constants);
    let (Some(least), Some(greatest)) = (numbers.first(), numbers.last()) else { return vec![Value::Real(0.0)] };
    let nearest = |number: &Value| number.as_number().unwrap_or(0.0);
    let exact = |number: &Value| Some(nearest(number)).filter(|real| Relation::Equal.holds(&(*real).into(), number));
    let between = |low: Option<&Value>, high: Option<&Value>| {
        let is_between = |real: &f64| {
            let real = Value::Real(*real);
            low.is_none_or(|low| Relation::Greater.holds(&real, low))
                && high.is_none_or(|high| Relation::Less.holds(&real, high))
        };
        // Round numbers read better than neighbors, where they lie between.
        let round = match (low.map(nearest), high.map(nearest)) {
            (Some(low), Some(high)) => [low + (high - low) / 2.0, low / 2.0 + high / 2.0],
            (Some(low), None) => [low + low.abs() + 1.0; 2],
            (None, high) => [high.map_or(0.0, |high| high - high.abs() - 1.0); 2],
        };
        let neighbors = [
            low.map(nearest),
            low.map(|low| nearest(low).next_up()),
            high.map(nearest),
            high.map(|high| nearest(high).next_down()),
        ];
        round.into_iter().chain(neighbors.into_iter().flatten()).find(is_between)
    };
    let inner = numbers.windows(2).filter_map(|pair| between(Some(&pair[0]), Some(&pair[1])));
    let outer = [between(None, Some(least)), between(Some(greatest), None)].into_iter().flatten();
    numbers.iter().filter_map(exact).chain(inner).chain(outer).map(Value::Real).collect()
}

impl MessageCondition {
    /// The number of its parts, itself included.
    fn size(&self) -> usize {
        1 + self.operands().into_iter().map(Self::size).sum::<usize>()
    }

    /// Calls `visit` with each field that the condition mentions, and with the constant if it compares with one.
    fn mentions<'a>(&'a self, visit: &mut impl FnMut(usize, Option<&'a Value>)) {
        match self {
            Self::Compare { field, value, .. } => visit(field.number, Some(value)),
            Self::Remember { field, .. } => visit(field.number, None),
            Self::Is { number, .. } => visit(*number, None),
            _ => self.operands().into_iter().for_each(|operand| operand.mentions(visit)),
        }
    }

    /// What is left of the condition if a field has this value, or is missing.
    fn given(&self, field: usize, value: Option<&Value>) -> Self {
        match self {
            Self::Compare { field: compared, relation, value: constant } if compared.number == field => {
                let holds = value.map_or(*relation == Relation::NotEqual, |value| relation.holds(value, constant));
                Self::constant(holds)
            }
            Self::Remember { field: remembered, .. } if remembered.number == field => Self::constant(value.is_some()),
            Self::Is { number, is } if *number == field => {
                Self::constant(value.is_some_and(|value| ValueType::of(value) == *is))
            }
            Self::Not(a) => a.given(field, value).denied(),
            Self::And(parts) => Self::joined(parts.iter().map(|part| part.given(field, value)), true),
            Self::Or(parts) => Self::joined(parts.iter().map(|part| part.given(field, value)), false),
            Self::Implies(a, b) => {
                Self::joined([a.given(field, value).denied(), b.given(field, value)].into_iter(), false)
            }
            other => other.clone(),
        }
    }

    fn constant(holds: bool) -> Self {
        if holds { Self::True } else { Self::False }
    }

    fn denied(self) -> Self {
        match self {
            Self::True => Self::False,
            Self::False => Self::True,
            Self::Not(a) => *a,
            other => Self::Not(Box::new(other)),
        }
    }

    /// The `and` of conditions, or their `or`, without those that make no difference.
    fn joined(conditions: impl Iterator<Item = Self>, and: bool) -> Self {
        let (neutral, decisive) = (Self::constant(and), Self::constant(!and));
        let mut parts: Vec<Self> = Vec::new();
        for condition in conditions {
            if condition == decisive {
                return decisive;
            }
            if condition != neutral && !parts.contains(&condition) {
                parts.push(condition);
            }
        }
        match parts.len() {
            0 => neutral,
            1 => parts.swap_remove(0),
            _ if and => Self::And(parts),
            _ => Self::Or(parts),
        }
    }
}
