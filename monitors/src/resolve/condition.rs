//! Conditions on a message, checked against the domain of its channel.

use std::collections::BTreeSet;

use channels::{ChannelId, FieldKind, Relation, Shape, Symbol, Value};
use diagnostics::{Problem, nearest, nearest_or_all};

use super::Resolver;
use crate::formula::{self, MessageCondition, ValueType};
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
            ConditionKind::Compare { left: Term::Field(field), relation, right: right @ Term::Operand(value) }
                if !self.is_field_or_remembered(value, channel) =>
            {
                if let Some(name) = self.hidden_field(right, channel) {
                    self.doubt_name(name);
                }
                let constant = self.value(value);
                let positions = channel.and_then(|channel| self.positions(field, channel));
                let (positions, constant) = (positions?, constant?);
                self.check((field, &positions), condition.span, *relation, &constant, value.span());
                self.doubt_unit(channel?, &positions, value, &constant);
                self.comparison(field, &positions, *relation, &constant)?
            }
            ConditionKind::Compare { left, relation, right } => {
                self.relate(condition.span, [left, right], *relation, channel)?
            }
            ConditionKind::Items { every, condition: inside } => {
                let inside = self.items(inside, condition.span, channel)?;
                let (counted, relation, number) = match every {
                    true => (MessageCondition::Not(Box::new(inside)), Relation::Equal, 0),
                    false => (inside, Relation::GreaterOrEqual, 1),
                };
                let counted = formula::Term::Count(Box::new(counted));
                MessageCondition::relating(counted, relation, formula::Term::Value(Value::Int(number)))
            }
            ConditionKind::Remember { field, name } => {
                let (position, called) = self.position(field, channel?)?;
                if position.is_list() || self.of_items {
                    let problem = Problem::new("only a single value can be remembered").at(condition.span, "here");
                    self.problems
                        .push(problem.with_help("compare items where they are, with any(…), all(…) or count(…)"));
                    return None;
                }
                MessageCondition::Remember { field: called, name: name.text.as_str().into() }
            }
        })
    }

    fn items(
        &mut self,
        condition: &Condition,
        span: ByteRange,
        channel: Option<ChannelId>,
    ) -> Option<MessageCondition> {
        if self.of_items {
            let problem = Problem::new("an item has no items").at(span, "inside another any(…), all(…) or count(…)");
            self.problems.push(problem.with_help("combine the conditions on one item with `and` and `or`"));
            return None;
        }
        self.of_items = true;
        let inside = self.condition(condition, channel);
        self.of_items = false;
        let (inside, channel) = (inside?, channel?);
        let shapes = self.topology.get(channel).domain.shapes();
        let mut has_list = false;
        inside.fields(&mut |field| {
            let is_meant = |(name, _): &&(String, FieldKind)| field.name.as_ref().is_none_or(|meant| **meant == **name);
            let mut kinds = shapes.iter().filter_map(|shape| shape.fields().get(field.number - 1)).filter(is_meant);
            has_list |= kinds.any(|(_, kind)| matches!(kind, FieldKind::List(_)));
        });
        if !has_list {
            let problem = Problem::new("no field here is a list").at(span, "of which list?");
            self.problems.push(problem.with_help("any(…), all(…) and count(…) are about the items of lists"));
            return None;
        }
        Some(inside)
    }

    /// The comparison of two terms of any kind.
    fn relate(
        &mut self,
        whole: ByteRange,
        sides: [&Term; 2],
        relation: Relation,
        channel: Option<ChannelId>,
    ) -> Option<MessageCondition> {
        let [left, right] = sides.map(|term| self.term(term, channel));
        let ((left, of_left), (right, of_right)) = (left?, right?);
        self.check_kinds(whole, relation, of_left, of_right);
        self.doubt_comparison(whole, sides, [&left, &right], channel);
        // `20 m < level`: the other order is a comparison with a constant.
        if let (Term::Operand(operand), formula::Term::Value(value)) = (sides[0], &left)
            && let (Some(field), Some(channel)) = (self.field_of(sides[1], channel), channel)
        {
            let positions = self.positions(&field, channel)?;
            self.doubt_unit(channel, &positions, operand, value);
        }
        Some(MessageCondition::relating(left, relation, right))
    }

    fn field_of(&self, term: &Term, channel: Option<ChannelId>) -> Option<Field> {
        match term {
            Term::Field(field) => Some(field.clone()),
            Term::Operand(Operand::Constant(name))
                if !self.remembered.contains(&name.text) && self.is_field_or_remembered_name(name, channel) =>
            {
                Some(Field { name: FieldName::Named(name.text.clone()), span: name.span })
            }
            _ => None,
        }
    }

    /// Whether an operand is a name, but not that of a constant.
    fn is_field_or_remembered(&self, operand: &Operand, channel: Option<ChannelId>) -> bool {
        let Operand::Constant(name) = operand else { return false };
        let text = name.text.as_str();
        self.remembered.contains(text) || !self.constants.contains_key(text) && self.is_field(text, channel)
    }

    /// A term, and what is known about its value.
    fn term(&mut self, term: &Term, channel: Option<ChannelId>) -> Option<(formula::Term, Kinds<'a>)> {
        Some(match term {
            Term::Field(field) => {
                let (position, called) = self.position(field, channel?)?;
                (formula::Term::Field(called), Some(position.kinds().map(|(_, kind)| kind).collect()))
            }
            Term::Operand(Operand::Constant(name)) if self.remembered.contains(&name.text) => {
                (formula::Term::Remembered(name.text.as_str().into()), None)
            }
            Term::Operand(Operand::Constant(name)) if self.is_field_or_remembered_name(name, channel) => {
                let field = Field { name: FieldName::Named(name.text.clone()), span: name.span };
                self.term(&Term::Field(field), channel)?
            }
            Term::Operand(operand) => {
                let value = self.value(operand)?;
                let kind = match &value {
                    Value::Bool(_) => Some(&FieldKind::Bool),
                    Value::Int(_) | Value::Real(_) => Some(&FieldKind::Real),
                    Value::Text(_) => Some(&FieldKind::Text),
                    Value::Symbol(_) | Value::List(_) => None,
                };
                (formula::Term::Value(value), kind.map(|kind| vec![kind]))
            }
            Term::Arithmetic(left, operator, right) => {
                let sides = [left, right].map(|side| (side.span(), self.term(side, channel)));
                for (span, side) in &sides {
                    self.check_number(*span, side.as_ref());
                }
                let [(_, left), (_, right)] = sides;
                let ((left, _), (right, _)) = (left?, right?);
                // Arithmetic on constants is done now: a field can then be compared with the result as with a constant.
                let whole = match (&left, &right) {
                    (formula::Term::Value(a), formula::Term::Value(b)) => operator.of(a, b),
                    _ => None,
                };
                let parts = || formula::Term::Arithmetic(Box::new(left.clone()), *operator, Box::new(right.clone()));
                (whole.map_or_else(parts, formula::Term::Value), Some(vec![&FieldKind::Real]))
            }
            Term::Call(function, terms, _) => {
                let terms: Vec<_> = terms.iter().map(|term| (term.span(), self.term(term, channel))).collect();
                terms.iter().for_each(|(span, term)| self.check_number(*span, term.as_ref()));
                let terms = terms.into_iter().map(|(_, term)| Some(term?.0)).collect::<Option<_>>()?;
                (formula::Term::Call(*function, terms), Some(vec![&FieldKind::Real]))
            }
            Term::Count(condition, span) => {
                let counted = self.items(condition, *span, channel)?;
                (formula::Term::Count(Box::new(counted)), Some(vec![&FieldKind::Int]))
            }
        })
    }

    fn is_field_or_remembered_name(&self, name: &Name, channel: Option<ChannelId>) -> bool {
        self.is_field_or_remembered(&Operand::Constant(name.clone()), channel)
    }

    /// The only position of a field, and the field there as any operand may meet it.
    fn position(&mut self, field: &Field, channel: ChannelId) -> Option<(FieldPosition<'a>, formula::MessageField)> {
        let mut positions = self.positions(field, channel)?;
        if positions.len() > 1 {
            self.is_ambiguous("several fields have this name", field, &positions);
            return None;
        }
        let position = positions.remove(0);
        let called = self.called(field, &position, None)?;
        Some((position, called))
    }

    /// The field at this position, as the property calls it, for a comparison with this constant; with `None`, for any
    /// operand. `None` after reporting that nothing distinguishes the messages with this field from others.
    fn called(
        &mut self,
        field: &Field,
        position: &FieldPosition<'a>,
        constant: Option<&Value>,
    ) -> Option<formula::MessageField> {
        let called = position.called(field, constant.filter(|_| !position.is_item()));
        if called.is_none() {
            let message = match constant {
                Some(_) => "no symbol distinguishes the messages with this field from others",
                None => "nothing distinguishes the messages with this field from others",
            };
            self.is_ambiguous(message, field, std::slice::from_ref(position));
        }
        called
    }

    fn is_ambiguous(&mut self, message: &str, field: &Field, positions: &[FieldPosition<'_>]) {
        let numbers: Vec<String> = positions.iter().map(|position| format!("m[{}]", position.number)).collect();
        let problem = Problem::new(message).at(field.span, "in which messages?");
        self.problems.push(problem.with_help(format!("write {}", numbers.join(" or "))));
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
                self.problems.push(problem.with_help("compare with a number, in the unit of the field"));
                return None;
            }
        })
    }

    /// The positions of a field: the one given by its number, or that of its name in each shape.
    fn positions(&mut self, field: &Field, channel: ChannelId) -> Option<Vec<FieldPosition<'a>>> {
        match &field.name {
            FieldName::Number(number) => self.numbered(*number, field.span, channel).map(|position| vec![position]),
            FieldName::Named(name) => self.named(name, field.span, channel),
        }
    }

    fn numbered(&mut self, number: usize, span: ByteRange, channel: ChannelId) -> Option<FieldPosition<'a>> {
        let topology = self.topology;
        let shapes = topology.get(channel).domain.shapes();
        let longest = shapes.iter().map(|shape| shape.fields().len()).max();
        if let Some(longest) = longest.filter(|longest| number > *longest) {
            let (source, target) = topology.ends(channel);
            let problem = Problem::new(format!("messages from {source} to {target} have no field m[{number}]"));
            let problem = problem.at(span, "no such field");
            self.problems.push(problem.with_help(format!("they have m[1] to m[{longest}]")));
            return None;
        }
        let of_items = self.of_items;
        Some(FieldPosition { number, with: shapes.iter().collect(), without: Vec::new(), of_items })
    }

    fn named(&mut self, name: &str, span: ByteRange, channel: ChannelId) -> Option<Vec<FieldPosition<'a>>> {
        let topology = self.topology;
        let shapes = topology.get(channel).domain.shapes();
        let position =
            |shape: &Shape| shape.fields().iter().position(|(known, _)| known == name).map(|index| index + 1);
        let numbers: BTreeSet<usize> = shapes.iter().filter_map(position).collect();
        if numbers.is_empty() {
            let (source, target) = topology.ends(channel);
            let problem = Problem::new(format!("messages from {source} to {target} have no field `{name}`"));
            let mut known: Vec<&str> = Vec::new();
            for (field, _) in shapes.iter().flat_map(Shape::fields) {
                if !known.contains(&field.as_str()) {
                    known.push(field);
                }
            }
            let problem = problem.at(span, "no such field");
            self.problems.push(problem.with_help(nearest_or_all(name, "fields", &known)));
            return None;
        }
        let of_items = self.of_items;
        let at = |number| {
            let (with, without) = shapes.iter().partition(|shape| position(shape) == Some(number));
            FieldPosition { number, with, without, of_items }
        };
        Some(numbers.into_iter().map(at).collect())
    }

    /// The comparison of a field, wherever it is.
    fn comparison(
        &mut self,
        field: &Field,
        positions: &[FieldPosition<'a>],
        relation: Relation,
        value: &Value,
    ) -> Option<MessageCondition> {
        let mut compare = |position: &FieldPosition<'a>, relation| {
            let field = self.called(field, position, Some(value))?;
            Some(MessageCondition::Compare { field, relation, value: value.clone() })
        };
        if let [position] = positions {
            return compare(position, relation);
        }
        // A missing value differs from every value.
        let positive = if relation == Relation::NotEqual { Relation::Equal } else { relation };
        let alternatives = positions.iter().map(|position| compare(position, positive)).collect::<Option<_>>()?;
        let holds = MessageCondition::Or(alternatives);
        Some(if relation == positive { holds } else { MessageCondition::Not(Box::new(holds)) })
    }

    /// Reports a comparison that no message can make true, because of its type or its symbol.
    fn check(
        &mut self,
        (field, positions): (&Field, &[FieldPosition<'_>]),
        whole: ByteRange,
        relation: Relation,
        value: &Value,
        span: ByteRange,
    ) {
        let kinds: Vec<(usize, &FieldKind)> = positions.iter().flat_map(FieldPosition::kinds).collect();
        let is_number = value.is_number();
        if !matches!(relation, Relation::Equal | Relation::NotEqual) && !is_number {
            let problem =
                Problem::new(format!("`{value}` cannot be ordered")).at(whole, "only numbers can be compared by size");
            self.problems.push(problem.with_help("compare it with `=` or `!=`"));
            return;
        }
        if positions.iter().all(|position| position.with.is_empty())
            || kinds.iter().any(|(_, kind)| kind.is_comparable_to(value))
        {
            return;
        }
        let number = positions.first().map_or(1, |position| position.number);
        let written = |number: usize| match &field.name {
            FieldName::Named(name) => format!("m.{name}"),
            FieldName::Number(_) => format!("m[{number}]"),
        };
        self.problems.push(never_equal((number, &written), &kinds, value, span));
    }
}

/// The problem of a comparison with a value that the field never has.
fn never_equal(
    (number, written): (usize, &dyn Fn(usize) -> String),
    kinds: &[(usize, &FieldKind)],
    value: &Value,
    span: ByteRange,
) -> Problem {
    // Several kinds of messages may have the same field.
    let mut accepted: Vec<String> = Vec::new();
    for (number, kind) in kinds {
        let kind = format!("{} is {kind}", written(*number));
        if !accepted.contains(&kind) {
            accepted.push(kind);
        }
    }
    let (accepted, field) = (accepted.join(", or "), written(number));
    if kinds.iter().any(|(_, kind)| matches!(kind, FieldKind::List(_))) {
        let problem = Problem::new(format!("{field} is a list, and `{value}` is not")).at(span, "not a list");
        return problem.with_help(format!("its items are compared with any({field} …), all(…) or count(…)"));
    }
    let mut symbols = kinds.iter().flat_map(|(_, kind)| symbols_of(kind)).map(Symbol::name).peekable();
    match value {
        Value::Symbol(symbol) if symbols.peek().is_some() => {
            let near = nearest(symbol.name(), symbols);
            let problem = Problem::new(format!("{field} is never {symbol}")).at(span, "no such symbol in this field");
            problem.with_help(near.map_or(accepted, |near| format!("did you mean `<{near}>`?")))
        }
        _ => {
            let problem = Problem::new(format!("{field} cannot be compared with `{value}`"));
            problem.at(span, format!("this is {}", type_name(value))).with_help(accepted)
        }
    }
}

pub(super) struct FieldPosition<'a> {
    /// Counted from 1.
    pub(super) number: usize,
    /// The shapes of messages that have the field there, and the others.
    pub(super) with: Vec<&'a Shape>,
    without: Vec<&'a Shape>,
    /// Whether a list stands for its items.
    of_items: bool,
}

impl<'a> FieldPosition<'a> {
    /// The field here, as it is written, for a comparison with this constant or, with `None`, for any operand; `None`
    /// if the messages that have it cannot be distinguished from those with another field here.
    fn called(&self, field: &Field, constant: Option<&Value>) -> Option<formula::MessageField> {
        let name = match &field.name {
            FieldName::Named(name) => Some(name.as_str().into()),
            FieldName::Number(_) => None,
        };
        // A field of another type compares with a constant as a missing one does. Of any other operand, the type is
        // unknown, or also that of another field.
        let is_another = |shape: &&&'a Shape| match (constant, self.kind(shape)) {
            (Some(constant), Some(kind)) => kind.is_comparable_to(constant),
            (None, Some(_)) => true,
            (_, None) => false,
        };
        let others: Vec<&Shape> = self.without.iter().filter(is_another).copied().collect();
        let given = if others.is_empty() { None } else { Some(Box::new(self.given(&others, constant.is_none())?)) };
        Some(formula::MessageField { number: self.number, name, given })
    }

    /// Whether it is an item of a list.
    fn is_item(&self) -> bool {
        self.of_items && self.is_list()
    }

    fn is_list(&self) -> bool {
        self.with.iter().any(|shape| matches!(kind(shape, self.number), Some(FieldKind::List(_))))
    }

    pub(super) fn kind(&self, shape: &'a Shape) -> Option<&'a FieldKind> {
        match kind(shape, self.number)? {
            FieldKind::List(items) if self.of_items => Some(items),
            kind => Some(kind),
        }
    }

    /// The possible values of the field.
    fn kinds(&self) -> impl Iterator<Item = (usize, &'a FieldKind)> {
        self.with.iter().filter_map(|shape| Some((self.number, self.kind(shape)?)))
    }

    /// What distinguishes the messages with the field from others: their symbols, or else, if that is allowed, the
    /// types of their values. `None` if neither does.
    fn given(&self, others: &[&Shape], by_type: bool) -> Option<MessageCondition> {
        let mut alternatives: Vec<MessageCondition> = Vec::new();
        for shape in &self.with {
            let mut parts: Vec<MessageCondition> = Vec::new();
            for other in others {
                let by_symbol = (1..=shape.fields().len()).find(|at| distinguishes(shape, other, *at));
                let part = match by_symbol {
                    Some(at) => any(symbols(shape, at).iter().map(|one| is(at, one)).collect()),
                    None if by_type => self.by_type(shape, other)?,
                    None => return None,
                };
                if !parts.contains(&part) {
                    parts.push(part);
                }
            }
            let part = all(parts);
            if !alternatives.contains(&part) {
                alternatives.push(part);
            }
        }
        Some(any(alternatives))
    }

    /// What follows from the types of values, here or else anywhere: that a message is of the first shape and not of
    /// the other.
    fn by_type(&self, shape: &Shape, other: &Shape) -> Option<MessageCondition> {
        let longest = shape.fields().len().max(other.fields().len());
        std::iter::once(self.number).chain(1..=longest).find_map(|number| {
            let [own, others] = [shape, other].map(|shape| kind(shape, number).map_or(Vec::new(), types));
            let is = |is: ValueType| MessageCondition::Is { number, is };
            let of = |types: Vec<ValueType>| any(types.into_iter().map(is).collect());
            let differ = own.len() + others.len() > 0 && !own.iter().any(|one| others.contains(one));
            differ.then(|| if own.is_empty() { MessageCondition::Not(Box::new(of(others))) } else { of(own) })
        })
    }
}

fn types(kind: &FieldKind) -> Vec<ValueType> {
    match kind {
        FieldKind::Optional(kind) => {
            let mut types = types(kind);
            if !types.contains(&ValueType::Symbol) {
                types.push(ValueType::Symbol);
            }
            types
        }
        kind => vec![ValueType::of(&sample(kind))],
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
    kind(shape, at).map_or(&[], symbols_of)
}

fn symbols_of(kind: &FieldKind) -> &[Symbol] {
    if let FieldKind::Symbol(symbols) = kind { symbols } else { &[] }
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
        Value::List(_) => "a list",
    }
}

/// The kinds of values that a term can have; `None` if nothing is known about it.
type Kinds<'a> = Option<Vec<&'a FieldKind>>;

fn sample(kind: &FieldKind) -> Value {
    match kind {
        FieldKind::Symbol(symbols) => symbols.first().map_or_else(|| Value::symbol("none"), |one| one.clone().into()),
        FieldKind::Bool => true.into(),
        FieldKind::Int | FieldKind::Real => Value::Real(0.0),
        FieldKind::Text => Value::from(""),
        FieldKind::Optional(kind) => sample(kind),
        FieldKind::List(_) => Value::List([].into()),
    }
}
