//! Conditions on a message, checked against the domain of its channel.

use channels::{ChannelId, FieldKind, Relation, Shape, Value};
use diagnostics::{Problem, nearest, nearest_or_all};

use super::Resolver;
use crate::formula::MessageCondition;
use crate::syntax::{ByteRange, Condition, ConditionKind, Field, FieldName, Literal, Operand};

impl Resolver<'_> {
    /// The condition; `None` after its problems have been reported. Without a channel, only constants are resolved.
    pub(super) fn condition(&mut self, condition: &Condition, channel: Option<ChannelId>) -> Option<MessageCondition> {
        Some(match &condition.kind {
            ConditionKind::True => MessageCondition::True,
            ConditionKind::False => MessageCondition::False,
            ConditionKind::Unreadable => {
                self.unreadable = true;
                return None;
            }
            ConditionKind::Not(part) => MessageCondition::Not(Box::new(self.condition(part, channel)?)),
            ConditionKind::And(parts) => MessageCondition::And(self.conditions(parts, channel)?),
            ConditionKind::Or(parts) => MessageCondition::Or(self.conditions(parts, channel)?),
            ConditionKind::Implies(left, right) => {
                let (left, right) = (self.condition(left, channel), self.condition(right, channel));
                MessageCondition::Implies(Box::new(left?), Box::new(right?))
            }
            ConditionKind::Compare { field, relation, value } => {
                let constant = self.value(value);
                let number = channel.and_then(|channel| self.field(field, channel));
                let (field, constant) = (number?, constant?);
                self.check(channel?, field, condition.span, *relation, &constant, value.span());
                MessageCondition::Compare { field, relation: *relation, value: constant }
            }
        })
    }

    fn conditions(&mut self, parts: &[Condition], channel: Option<ChannelId>) -> Option<Vec<MessageCondition>> {
        let parts: Vec<Option<MessageCondition>> = parts.iter().map(|part| self.condition(part, channel)).collect();
        parts.into_iter().collect()
    }

    fn value(&mut self, operand: &Operand) -> Option<Value> {
        let literal = match operand {
            Operand::Literal(literal, _) => literal.clone(),
            Operand::Constant(name) => self.constant(name)?.clone(),
        };
        Some(match literal {
            Literal::Symbol(symbol) => Value::symbol(&symbol),
            Literal::Bool(truth) => truth.into(),
            Literal::Int(number) => number.into(),
            Literal::Real(number) => number.into(),
            Literal::Text(text) => text.as_str().into(),
            Literal::Duration { .. } => {
                let problem = Problem::new("messages do not contain durations").at(operand.span(), "a duration");
                self.problems.push(problem.with_help("compare with a number"));
                return None;
            }
        })
    }

    /// The number of a field, counted from 1.
    fn field(&mut self, field: &Field, channel: ChannelId) -> Option<usize> {
        let topology = self.topology;
        let shapes = topology.get(channel).domain.shapes();
        let (source, target) = topology.ends(channel);
        let name = match &field.name {
            FieldName::Number(number) => {
                let longest = shapes.iter().map(|shape| shape.fields().len()).max();
                if let Some(longest) = longest.filter(|longest| number > longest) {
                    let problem = Problem::new(format!("messages from {source} to {target} have no field m[{number}]"));
                    let problem = problem.at(field.span, "no such field");
                    self.problems.push(problem.with_help(format!("they have m[1] to m[{longest}]")));
                    return None;
                }
                return Some(*number);
            }
            FieldName::Named(name) => name,
        };
        let place = |shape: &Shape| shape.fields().iter().position(|(known, _)| known == name);
        let mut places: Vec<usize> = shapes.iter().filter_map(place).collect();
        places.dedup();
        if let [place] = places[..] {
            return Some(place + 1);
        }
        let problem = Problem::new(format!("messages from {source} to {target} have no field `{name}`"));
        let problem = problem.at(field.span, "no such field");
        let mut known: Vec<&str> = Vec::new();
        for (field, _) in shapes.iter().flat_map(Shape::fields) {
            if !known.contains(&field.as_str()) {
                known.push(field);
            }
        }
        self.problems.push(match places[..] {
            [] => problem.with_help(nearest_or_all(name, "fields", &known)),
            _ => Problem::new(format!("`{name}` is a different field in different messages"))
                .at(field.span, "which one?")
                .with_help("write m[1], m[2], …"),
        });
        None
    }

    /// Reports a comparison that no message can make true, because of its type or its symbol.
    fn check(
        &mut self,
        channel: ChannelId,
        field: usize,
        whole: ByteRange,
        relation: Relation,
        value: &Value,
        span: ByteRange,
    ) {
        let shapes = self.topology.get(channel).domain.shapes();
        let kinds: Vec<&FieldKind> =
            shapes.iter().filter_map(|shape| shape.fields().get(field - 1)).map(|(_, kind)| kind).collect();
        let is_number = value.as_number().is_some();
        if !matches!(relation, Relation::Equal | Relation::NotEqual) && !is_number {
            let problem =
                Problem::new(format!("`{value}` cannot be ordered")).at(whole, "only numbers can be less or greater");
            self.problems.push(problem.with_help("compare it with `=` or `!=`"));
            return;
        }
        if shapes.is_empty() || kinds.iter().any(|kind| kind.is_comparable_to(value)) {
            return;
        }
        let symbols: Vec<&str> = kinds
            .iter()
            .flat_map(|kind| if let FieldKind::Symbol(symbols) = kind { symbols.as_slice() } else { &[] })
            .map(|symbol| symbol.name())
            .collect();
        let accepted: Vec<String> = kinds.iter().map(|kind| format!("m[{field}] is {kind}")).collect();
        let accepted = accepted.join(", or ");
        let problem = match value {
            Value::Symbol(symbol) if !symbols.is_empty() => {
                let near = nearest(symbol.name(), symbols.iter().copied());
                let problem =
                    Problem::new(format!("m[{field}] is never {symbol}")).at(span, "no such symbol in this field");
                problem.with_help(near.map_or(accepted, |near| format!("did you mean `<{near}>`?")))
            }
            _ => {
                let problem = Problem::new(format!("m[{field}] cannot be compared with `{value}`"));
                problem.at(span, format!("this is {}", type_name(value))).with_help(accepted)
            }
        };
        self.problems.push(problem);
    }
}

fn type_name(value: &Value) -> &'static str {
    match value {
        Value::Symbol(_) => "a symbol",
        Value::Bool(_) => "a truth value",
        Value::Int(_) => "an integer",
        Value::Real(_) => "a real number",
        Value::Text(_) => "text",
    }
}
