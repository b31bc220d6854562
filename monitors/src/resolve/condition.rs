//! Conditions on a message, checked against the domain of its channel.

use std::collections::BTreeSet;

use channels::{ChannelId, FieldKind, Relation, Shape, Symbol, Value};
use diagnostics::{Problem, nearest, nearest_or_all};

use super::Resolver;
use crate::formula::{self, MessageCondition};
use crate::syntax::{ByteRange, Condition, ConditionKind, Field, FieldName, Literal, Name, Operand, Term};

impl<'a> Resolver<'a> {
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
            ConditionKind::Compare { left: Term::Field(field), relation, right: Term::Operand(value) }
                if !self.is_field_or_remembered(value, channel) =>
            {
                let constant = self.value(value);
                let places = channel.and_then(|channel| self.places(field, channel));
                let (places, constant) = (places?, constant?);
                self.check(&places, condition.span, *relation, &constant, value.span());
                self.comparison(field, &places, *relation, &constant)?
            }
            ConditionKind::Compare { left, relation, right } => {
                let mut guards = Vec::new();
                let [left, right] = [left, right].map(|term| self.term(term, channel, &mut guards));
                let ((left, of_left), (right, of_right)) = (left?, right?);
                self.check_kinds(condition.span, *relation, of_left, of_right);
                // A missing value differs from everything.
                let positive = if *relation == Relation::NotEqual { Relation::Equal } else { *relation };
                guards.push(MessageCondition::relating(left, positive, right));
                let holds = all(guards);
                if *relation == positive { holds } else { MessageCondition::Not(Box::new(holds)) }
            }
            ConditionKind::Remember { field, name } => {
                let (place, mut guards) = self.place(field, channel?)?;
                guards.push(MessageCondition::Remember { field: place.called(field), name: name.text.as_str().into() });
                all(guards)
            }
        })
    }

    /// Whether an operand is a name, but not that of a constant.
    fn is_field_or_remembered(&self, operand: &Operand, channel: Option<ChannelId>) -> bool {
        let Operand::Constant(name) = operand else { return false };
        let text = name.text.as_str();
        let is_field = || {
            let shapes = channel.map(|channel| self.topology.get(channel).domain.shapes()).unwrap_or_default();
            shapes.iter().flat_map(Shape::fields).any(|(field, _)| field == text)
        };
        self.remembered.contains(text) || !self.constants.contains_key(text) && is_field()
    }

    /// A term, and what is known about its value; conditions that select the messages with its fields are added.
    fn term(
        &mut self,
        term: &Term,
        channel: Option<ChannelId>,
        guards: &mut Vec<MessageCondition>,
    ) -> Option<(formula::Term, Kinds<'a>)> {
        Some(match term {
            Term::Field(field) => {
                let (place, distinguishing) = self.place(field, channel?)?;
                guards.extend(distinguishing.into_iter().filter(|guard| !guards.contains(guard)).collect::<Vec<_>>());
                (formula::Term::Field(place.called(field)), Some(place.kinds().map(|(_, kind)| kind).collect()))
            }
            Term::Operand(Operand::Constant(name)) if self.remembered.contains(&name.text) => {
                (formula::Term::Remembered(name.text.as_str().into()), None)
            }
            Term::Operand(Operand::Constant(name)) if self.is_field_or_remembered_name(name, channel) => {
                let field = Field { name: FieldName::Named(name.text.clone()), span: name.span };
                self.term(&Term::Field(field), channel, guards)?
            }
            Term::Operand(operand) => (formula::Term::Value(self.value(operand)?), None),
            Term::Arithmetic(left, operator, right) => {
                let sides = [left, right].map(|side| (side.span(), self.term(side, channel, guards)));
                for (span, side) in &sides {
                    self.check_number(*span, side.as_ref());
                }
                let [(_, left), (_, right)] = sides;
                let ((left, _), (right, _)) = (left?, right?);
                let whole = match (&left, &right) {
                    (formula::Term::Value(a), formula::Term::Value(b)) => operator.of(a, b),
                    _ => None,
                };
                let parts = || formula::Term::Arithmetic(Box::new(left.clone()), *operator, Box::new(right.clone()));
                (whole.map_or_else(parts, formula::Term::Value), Some(vec![&FieldKind::Real]))
            }
        })
    }

    fn is_field_or_remembered_name(&self, name: &Name, channel: Option<ChannelId>) -> bool {
        self.is_field_or_remembered(&Operand::Constant(name.clone()), channel)
    }

    /// The only position of a field, and conditions that select the messages that have it there.
    fn place(&mut self, field: &Field, channel: ChannelId) -> Option<(FieldPosition<'a>, Vec<MessageCondition>)> {
        let mut places = self.places(field, channel)?;
        let guards = match &places[..] {
            [place] => {
                let samples: Vec<Value> = place.kinds().map(|(_, kind)| sample(kind)).collect();
                samples.iter().map(|sample| place.guard(sample)).collect::<Option<Vec<_>>>()
            }
            _ => None,
        };
        let Some(guards) = guards else {
            let numbers: Vec<String> = places.iter().map(|place| format!("m[{}]", place.number)).collect();
            let problem = Problem::new("several fields have this name").at(field.span, "in which messages?");
            self.problems.push(problem.with_help(format!("write {}", numbers.join(" or "))));
            return None;
        };
        let mut distinguishing = Vec::new();
        guards.into_iter().flatten().for_each(|guard| {
            if !distinguishing.contains(&guard) {
                distinguishing.push(guard);
            }
        });
        Some((places.remove(0), distinguishing))
    }

    /// Reports terms that are never numbers.
    fn check_number(&mut self, span: ByteRange, side: Option<&(formula::Term, Kinds<'a>)>) {
        let is_number = match side {
            Some((formula::Term::Value(value), _)) => value.as_number().is_some(),
            Some((_, Some(kinds))) => {
                kinds.is_empty() || kinds.iter().any(|kind| kind.is_comparable_to(&Value::Real(0.0)))
            }
            _ => true,
        };
        if !is_number {
            let problem = Problem::new("arithmetic needs numbers").at(span, "never a number");
            self.problems.push(problem.with_help("compare symbols, strings and Booleans with `=` or `!=`"));
        }
    }

    /// Reports a comparison of values that can never be compared.
    fn check_kinds(&mut self, whole: ByteRange, relation: Relation, left: Kinds<'a>, right: Kinds<'a>) {
        let is_ordered = !matches!(relation, Relation::Equal | Relation::NotEqual);
        let number = Value::Real(0.0);
        let never = |kinds: &Kinds<'a>| {
            kinds
                .as_ref()
                .is_some_and(|kinds| !kinds.is_empty() && !kinds.iter().any(|kind| kind.is_comparable_to(&number)))
        };
        let problem = if is_ordered && (never(&left) || never(&right)) {
            Problem::new("these values cannot be ordered").at(whole, "only numbers can be compared by size")
        } else {
            let (Some(left), Some(right)) = (left, right) else { return };
            let compare = |a: &&FieldKind| right.iter().any(|b| a.is_comparable_to(&sample(b)));
            if left.is_empty() || right.is_empty() || left.iter().any(compare) {
                return;
            }
            Problem::new("these values are never equal").at(whole, "of different types")
        };
        self.problems.push(problem.with_help("compare values of one type"));
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

    /// The positions of a field: the one given by its number, or that of its name in each shape.
    fn places(&mut self, field: &Field, channel: ChannelId) -> Option<Vec<FieldPosition<'a>>> {
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
                return Some(vec![FieldPosition {
                    number: *number,
                    with: shapes.iter().collect(),
                    without: Vec::new(),
                }]);
            }
            FieldName::Named(name) => name,
        };
        let place = |shape: &Shape| shape.fields().iter().position(|(known, _)| known == name).map(|place| place + 1);
        let numbers: BTreeSet<usize> = shapes.iter().filter_map(place).collect();
        if numbers.is_empty() {
            let problem = Problem::new(format!("messages from {source} to {target} have no field `{name}`"));
            let mut known: Vec<&str> = Vec::new();
            for (field, _) in shapes.iter().flat_map(Shape::fields) {
                if !known.contains(&field.as_str()) {
                    known.push(field);
                }
            }
            let problem = problem.at(field.span, "no such field");
            self.problems.push(problem.with_help(nearest_or_all(name, "fields", &known)));
            return None;
        }
        let at = |number| {
            let (with, without) = shapes.iter().partition(|shape| place(shape) == Some(number));
            FieldPosition { number, with, without }
        };
        Some(numbers.into_iter().map(at).collect())
    }

    /// The comparison of a field, which holds only for messages that have the field.
    fn comparison(
        &mut self,
        field: &Field,
        places: &[FieldPosition<'_>],
        relation: Relation,
        value: &Value,
    ) -> Option<MessageCondition> {
        // A missing value differs from every value.
        let positive = if relation == Relation::NotEqual { Relation::Equal } else { relation };
        let compare = |place: &FieldPosition<'_>, relation| {
            let field = place.called(field);
            MessageCondition::Compare { field, relation, value: value.clone() }
        };
        if let [place] = places
            && place.confused_with(value).next().is_none()
        {
            return Some(compare(place, relation));
        }
        let mut alternatives = Vec::new();
        for place in places {
            let Some(mut conditions) = place.guard(value) else {
                let numbers: Vec<String> = places.iter().map(|place| format!("m[{}]", place.number)).collect();
                let message = "no symbol distinguishes the messages with this field from others";
                let problem = Problem::new(message).at(field.span, "in which messages?");
                self.problems.push(problem.with_help(format!("write {}", numbers.join(" or "))));
                return None;
            };
            conditions.push(compare(place, positive));
            alternatives.push(all(conditions));
        }
        let holds = any(alternatives);
        Some(if relation == positive { holds } else { MessageCondition::Not(Box::new(holds)) })
    }

    /// Reports a comparison that no message can make true, because of its type or its symbol.
    fn check(
        &mut self,
        places: &[FieldPosition<'_>],
        whole: ByteRange,
        relation: Relation,
        value: &Value,
        span: ByteRange,
    ) {
        let kinds: Vec<(usize, &FieldKind)> = places.iter().flat_map(FieldPosition::kinds).collect();
        let is_number = value.is_number();
        if !matches!(relation, Relation::Equal | Relation::NotEqual) && !is_number {
            let problem =
                Problem::new(format!("`{value}` cannot be ordered")).at(whole, "only numbers can be compared by size");
            self.problems.push(problem.with_help("compare it with `=` or `!=`"));
            return;
        }
        if places.iter().all(|place| place.with.is_empty())
            || kinds.iter().any(|(_, kind)| kind.is_comparable_to(value))
        {
            return;
        }
        let symbols: Vec<&str> = kinds
            .iter()
            .flat_map(|(_, kind)| if let FieldKind::Symbol(symbols) = kind { symbols.as_slice() } else { &[] })
            .map(|symbol| symbol.name())
            .collect();
        let accepted: Vec<String> = kinds.iter().map(|(field, kind)| format!("m[{field}] is {kind}")).collect();
        let (accepted, field) = (accepted.join(", or "), places.first().map_or(1, |place| place.number));
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

/// A position of a field in messages.
struct FieldPosition<'a> {
    /// Counted from 1.
    number: usize,
    /// The shapes of messages that have the field there, and the others.
    with: Vec<&'a Shape>,
    without: Vec<&'a Shape>,
}

impl<'a> FieldPosition<'a> {
    /// The field here, as it is written.
    fn called(&self, field: &Field) -> formula::MessageField {
        let name = match &field.name {
            FieldName::Named(name) => Some(name.as_str().into()),
            FieldName::Number(_) => None,
        };
        formula::MessageField { number: self.number, name }
    }

    /// The possible values of the field.
    fn kinds(&self) -> impl Iterator<Item = (usize, &'a FieldKind)> {
        self.with.iter().filter_map(|shape| Some((self.number, kind(shape, self.number)?)))
    }

    /// The shapes in which another field at this position can be compared with the value.
    fn confused_with(&self, value: &Value) -> impl Iterator<Item = &'a Shape> {
        let compares = |shape: &&&Shape| kind(shape, self.number).is_some_and(|kind| kind.is_comparable_to(value));
        self.without.iter().filter(compares).copied()
    }

    /// Conditions that distinguish, by their symbols, the messages with the field from those with which they might be
    /// confused; `None` if their symbols are the same.
    fn guard(&self, value: &Value) -> Option<Vec<MessageCondition>> {
        let others: Vec<&Shape> = self.confused_with(value).collect();
        if others.is_empty() {
            return Some(Vec::new());
        }
        let mut guards: Vec<Vec<MessageCondition>> = Vec::new();
        for shape in &self.with {
            let distinguishing =
                others.iter().map(|other| (1..=shape.fields().len()).find(|at| distinguishes(shape, other, *at)));
            let distinguishing: BTreeSet<usize> = distinguishing.collect::<Option<_>>()?;
            let guard =
                distinguishing.into_iter().map(|at| any(symbols(shape, at).iter().map(|one| is(at, one)).collect()));
            guards.push(guard.collect());
        }
        guards.dedup();
        Some(if guards.len() == 1 { guards.remove(0) } else { vec![any(guards.into_iter().map(all).collect())] })
    }
}

/// Whether messages of the first shape have a symbol in this field that those of the other shape do not have there.
fn distinguishes(shape: &Shape, other: &Shape, at: usize) -> bool {
    let symbols = symbols(shape, at);
    let is_possible =
        |symbol: &Symbol| kind(other, at).is_some_and(|kind| kind.contains(&Value::Symbol(symbol.clone())));
    !symbols.is_empty() && !symbols.iter().any(is_possible)
}

/// The symbols of a field, if it holds one.
fn symbols(shape: &Shape, at: usize) -> &[Symbol] {
    match kind(shape, at) {
        Some(FieldKind::Symbol(symbols)) => symbols,
        _ => &[],
    }
}

fn is(field: usize, symbol: &Symbol) -> MessageCondition {
    MessageCondition::Compare { field: field.into(), relation: Relation::Equal, value: Value::Symbol(symbol.clone()) }
}

/// All of these conditions hold.
fn all(mut conditions: Vec<MessageCondition>) -> MessageCondition {
    if conditions.len() == 1 { conditions.remove(0) } else { MessageCondition::And(conditions) }
}

/// One of these conditions holds.
fn any(mut conditions: Vec<MessageCondition>) -> MessageCondition {
    if conditions.len() == 1 { conditions.remove(0) } else { MessageCondition::Or(conditions) }
}

fn kind(shape: &Shape, number: usize) -> Option<&FieldKind> {
    shape.fields().get(number - 1).map(|(_, kind)| kind)
}

fn type_name(value: &Value) -> &'static str {
    match value {
        Value::Symbol(_) => "a symbol",
        Value::Bool(_) => "a Boolean",
        Value::Int(_) => "an integer",
        Value::Real(_) => "a real number",
        Value::Text(_) => "text",
    }
}

/// The kinds of values that a term can have; `None` if nothing is known about it.
type Kinds<'a> = Option<Vec<&'a FieldKind>>;

/// A value of a kind.
fn sample(kind: &FieldKind) -> Value {
    match kind {
        FieldKind::Symbol(symbols) => symbols.first().map_or_else(|| Value::symbol("none"), |one| one.clone().into()),
        FieldKind::Bool => true.into(),
        FieldKind::Int | FieldKind::Real => Value::Real(0.0),
        FieldKind::Text => Value::from(""),
        FieldKind::Optional(kind) => sample(kind),
    }
}
