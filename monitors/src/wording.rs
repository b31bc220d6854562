//! Formulas in the SCOPE language: text that reads back as the same formula.

use channels::{Relation, Shape, Topology, Value};

use crate::formula::{self, Bound, EventAtom, Formula, MessageCondition, Term, Unit, ValueType};
use crate::operator::{Parts, Prefix};
use crate::resolve::meaning;
use crate::syntax::{
    self, ByteRange, Condition, ConditionKind, Constraint, ConstraintKind, Field, FieldName, Interval, Literal, Name,
    Operand, Party,
};

const NOWHERE: ByteRange = ByteRange { start: 0, end: 0 };

impl Formula {
    /// The formula in the SCOPE language, over its topology, with bounds as the property writes them: in ticks, or as
    /// durations.
    ///
    /// Reading the text with the same period of ticks gives the same formula, except for an `and` or `or` of fewer than
    /// two parts, which the language does not have.
    #[must_use]
    pub fn text(&self, topology: &Topology) -> String {
        constraint(self, topology, false).to_string()
    }
}

impl MessageCondition {
    /// The condition in the SCOPE language, for messages of these shapes. Fields have the names by which the property
    /// calls them, where reading the text gives the same condition, or numbers.
    #[must_use]
    pub fn text(&self, shapes: &[Shape]) -> String {
        condition(self, shapes).to_string()
    }
}

impl EventAtom {
    fn named(&self, topology: &Topology) -> syntax::Event {
        let (source, target) = topology.ends(self.channel);
        let name = |text: &str| Party::Named(Name { text: text.to_owned(), span: NOWHERE });
        let condition = condition(&self.condition, topology.get(self.channel).domain.shapes());
        syntax::Event { source: name(source), target: name(target), condition, span: NOWHERE }
    }
}

fn constraint(formula: &Formula, topology: &Topology, is_timed: bool) -> Constraint {
    let of = |part: &Formula| Box::new(constraint(part, topology, is_timed));
    let list = |parts: &[Formula]| parts.iter().map(|part| constraint(part, topology, is_timed)).collect();
    let kind = match (formula, formula.parts()) {
        (_, Parts::Prefix(operator, bound, part)) => {
            ConstraintKind::Prefix(operator, interval(bound, is_timed), of(part))
        }
        (_, Parts::Infix(operator, bound, [left, right])) => {
            ConstraintKind::Infix(operator, interval(bound, is_timed), of(left), of(right))
        }
        (_, Parts::Timed(part)) => return constraint(part, topology, true),
        // The language joins no fewer than two operands.
        (_, Parts::Joined([part])) => return constraint(part, topology, is_timed),
        (Formula::False, _) | (Formula::Or(_), Parts::Joined([])) => ConstraintKind::False,
        (Formula::Or(parts), _) => ConstraintKind::Or(list(parts)),
        (Formula::And(parts), Parts::Joined([_, ..])) => match edge(parts) {
            Some(part) => ConstraintKind::Prefix(Prefix::Becomes, None, of(part)),
            None => ConstraintKind::And(list(parts)),
        },
        (Formula::Event(event), _) => ConstraintKind::Event(event.named(topology)),
        (Formula::Fresh(event), _) => ConstraintKind::Fresh(event.named(topology)),
        (Formula::TimeUntil { event, bound }, _) => {
            let (event, relation) = (event.named(topology), bound.relation);
            ConstraintKind::TimeUntil { event, relation, bound: length(*bound, is_timed) }
        }
        (Formula::Count { event, is_at_most, count, bound }, _) => {
            let (count, event, bound) = (number(*count), event.named(topology), length(*bound, is_timed));
            ConstraintKind::Count { is_at_most: *is_at_most, count, event, bound }
        }
        // `true`, and the `and` of nothing.
        (_, Parts::Atom | Parts::Joined(_)) => ConstraintKind::True,
    };
    Constraint { kind, span: NOWHERE }
}

/// What becomes true if these hold.
pub(crate) fn edge(parts: &[Formula]) -> Option<&Formula> {
    let [now, Formula::Not(before)] = parts else { return None };
    matches!(&**before, Formula::Previous(bound, before) if *bound == Bound::NONE && **before == *now).then_some(now)
}

fn interval(bound: Bound, is_timed: bool) -> Option<Interval> {
    (bound != Bound::NONE).then(|| Interval { relation: bound.relation, bound: length(bound, is_timed) })
}

/// θ: a number of ticks, or a duration.
fn length(bound: Bound, is_timed: bool) -> Operand {
    bound.duration(is_timed).map_or_else(|| number(bound.ticks), operand)
}

fn number(number: u64) -> Operand {
    operand(Literal::Int(i64::try_from(number).unwrap_or(i64::MAX)))
}

/// A condition in the words of the language.
pub(crate) fn condition(from: &MessageCondition, shapes: &[Shape]) -> Condition {
    match by_name(from, shapes) {
        Some(comparison) => spelled(&comparison, &called, &|part| condition(part, shapes)),
        None => {
            // The parts of others are spelled out one by one, if they have to be.
            let is_joined = !from.operands().is_empty();
            let plain = if is_joined { from.clone() } else { from.spelled_out() };
            spelled(&plain, &|field| FieldName::Number(field.number), &|part| condition(part, shapes))
        }
    }
}

/// The comparison that stands for this condition, if the names of its fields are enough: of a field at several
/// positions, the last one. Without shapes, names are taken as they are.
pub(crate) fn by_name(from: &MessageCondition, shapes: &[Shape]) -> Option<MessageCondition> {
    let (inside, is_denied) = match from {
        MessageCondition::Not(inside) => (&**inside, true),
        from => (from, false),
    };
    // Whether the comparison alone means the same is not decided here but asked of the resolver.
    let last = if let MessageCondition::Or(parts) = inside { parts.last()? } else { inside };
    let mut comparison = last.clone();
    match &mut comparison {
        MessageCondition::Compare { relation, .. } | MessageCondition::Relate { relation, .. }
            if is_denied && *relation == Relation::Equal =>
        {
            *relation = Relation::NotEqual;
        }
        _ if is_denied => return None,
        _ => {}
    }
    if !comparison.calls_by_name() {
        return None;
    }
    let by_name = spelled(&comparison, &called, &|part| condition(part, shapes));
    let mut remembered = Vec::new();
    comparison.names(&mut |name| remembered.push(&**name));
    let is_enough = match shapes {
        [] => *from == comparison,
        shapes => meaning(&by_name, &remembered, shapes).is_some_and(|meant| is_called(from, &meant)),
    };
    is_enough.then_some(comparison)
}

/// Whether this is how `from` is called: what reading its names gives, except that it may be given more. (A constant
/// that stands for a remembered value may be of a type that no other field has.)
fn is_called(from: &MessageCondition, meant: &MessageCondition) -> bool {
    let fields = |condition: &MessageCondition| {
        let mut fields = Vec::new();
        condition.fields(&mut |field| fields.push((field.number, field.given.clone())));
        fields
    };
    let (from_fields, meant_fields) = (fields(from), fields(meant));
    let is_given = |((a, from), (b, meant)): (&(usize, Option<_>), &(usize, Option<_>))| {
        a == b && (from == meant || meant.is_none() && from.is_some())
    };
    let pairs = from_fields.iter().zip(&meant_fields);
    from_fields.len() == meant_fields.len() && pairs.into_iter().all(is_given) && from.of_any() == meant.of_any()
}

fn called(field: &formula::MessageField) -> FieldName {
    field.name.as_ref().map_or(FieldName::Number(field.number), |name| FieldName::Named(name.to_string()))
}

type Naming<'n> = &'n dyn Fn(&formula::MessageField) -> FieldName;

/// The condition with fields named in this way, and its parts spelled in that one.
fn spelled(from: &MessageCondition, name: Naming<'_>, part: &dyn Fn(&MessageCondition) -> Condition) -> Condition {
    let of = |inside: &MessageCondition| Box::new(part(inside));
    let list = |parts: &[MessageCondition]| parts.iter().map(part).collect();
    let kind = match from {
        MessageCondition::True => ConditionKind::True,
        MessageCondition::False => ConditionKind::False,
        MessageCondition::And(parts) if parts.is_empty() => ConditionKind::True,
        MessageCondition::Or(parts) if parts.is_empty() => ConditionKind::False,
        MessageCondition::And(parts) | MessageCondition::Or(parts) if parts.len() == 1 => {
            return part(&parts[0]);
        }
        MessageCondition::And(parts) => ConditionKind::And(list(parts)),
        MessageCondition::Or(parts) => ConditionKind::Or(list(parts)),
        MessageCondition::Compare { field, relation, value } => ConditionKind::Compare {
            left: syntax::Term::Field(named(name(field))),
            relation: *relation,
            right: syntax::Term::Operand(operand(literal(value))),
        },
        MessageCondition::Relate { left, relation, right } => match of_items(left, *relation, right) {
            Some(Items { every, is_denied, inside }) => {
                let kind = ConditionKind::Items { every, condition: Box::new(of_item(inside, name)) };
                if is_denied { ConditionKind::Not(Box::new(Condition { kind, span: NOWHERE })) } else { kind }
            }
            None => ConditionKind::Compare { left: term(left, name), relation: *relation, right: term(right, name) },
        },
        MessageCondition::Remember { field, name: value } => {
            let value = Name { text: value.to_string(), span: NOWHERE };
            ConditionKind::Remember { field: named(name(field)), name: value }
        }
        MessageCondition::Is { number, is } => of_type(*number, *is),
        MessageCondition::Not(inside) => ConditionKind::Not(of(inside)),
        MessageCondition::Implies(a, b) => ConditionKind::Implies(of(a), of(b)),
    };
    Condition { kind, span: NOWHERE }
}

/// That a field is of a type, for which the language has no words: only people read this.
fn of_type(number: usize, is: ValueType) -> ConditionKind {
    let word = match is {
        ValueType::Symbol => "a symbol",
        ValueType::Bool => "a Boolean",
        ValueType::Number => "a number",
        ValueType::Text => "a text",
        ValueType::List => "a list",
    };
    ConditionKind::Compare {
        left: syntax::Term::Field(named(FieldName::Number(number))),
        relation: Relation::Equal,
        right: syntax::Term::Operand(Operand::Constant(Name { text: word.to_owned(), span: NOWHERE })),
    }
}

/// A condition on items, which has a meaning only inside the one around it: its parts are not looked at alone.
fn of_item(from: &MessageCondition, name: Naming<'_>) -> Condition {
    spelled(from, name, &|part| of_item(part, name))
}

/// What `any(…)` or `all(…)` requires of items.
pub(crate) struct Items<'t> {
    /// Whether it is `all`.
    pub(crate) every: bool,
    pub(crate) is_denied: bool,
    pub(crate) inside: &'t MessageCondition,
}

/// The `any(…)` or `all(…)`, or the denial of one, that this comparison is.
pub(crate) fn of_items<'t>(left: &'t Term, relation: Relation, right: &Term) -> Option<Items<'t>> {
    let (Term::Count(counted), Term::Value(Value::Int(number))) = (left, right) else { return None };
    match (&**counted, relation, number) {
        (inside, Relation::GreaterOrEqual, 1) => Some(Items { every: false, is_denied: false, inside }),
        (MessageCondition::Not(inside), Relation::Equal | Relation::NotEqual, 0) => {
            Some(Items { every: true, is_denied: relation == Relation::NotEqual, inside })
        }
        _ => None,
    }
}

fn named(name: FieldName) -> Field {
    Field { name, span: NOWHERE }
}

/// A term in the words of the language.
fn term(from: &Term, name: Naming<'_>) -> syntax::Term {
    let of = |from: &Term| term(from, name);
    match from {
        Term::Field(field) => syntax::Term::Field(named(name(field))),
        Term::Value(value) => syntax::Term::Operand(operand(literal(value))),
        Term::Remembered(name) => {
            syntax::Term::Operand(Operand::Constant(Name { text: name.to_string(), span: NOWHERE }))
        }
        Term::Arithmetic(left, operator, right) => {
            syntax::Term::Arithmetic(Box::new(of(left)), *operator, Box::new(of(right)))
        }
        Term::Call(function, terms) => syntax::Term::Call(*function, terms.iter().map(of).collect(), NOWHERE),
        Term::Count(inside) => syntax::Term::Count(Box::new(of_item(inside, name)), NOWHERE),
    }
}

fn literal(value: &Value) -> Literal {
    match value {
        Value::Symbol(symbol) => Literal::Symbol(symbol.name().to_owned()),
        Value::Bool(truth) => Literal::Bool(*truth),
        Value::Int(number) => Literal::Int(*number),
        Value::Real(number) => Literal::Real(*number),
        Value::Text(text) => Literal::Text(text.to_string()),
        // Never: a property can neither write a list nor remember one.
        Value::List(_) => Literal::Text(value.to_string()),
    }
}

impl Bound {
    /// θ as a duration, if it is one: as the property writes it, or in the largest unit in which it has at most three
    /// decimals.
    pub(crate) fn duration(self, is_timed: bool) -> Option<Literal> {
        if let Some((nanos, unit)) = self.written {
            return Some(Literal::Duration { nanos, unit });
        }
        let nanos = is_timed.then_some(self.ticks)?;
        let is_short = |unit: &Unit| nanos >= unit.nanos() && nanos.is_multiple_of(unit.nanos() / 1000);
        let unit = Unit::ALL.into_iter().rev().find(is_short).unwrap_or(Unit::Milliseconds);
        Some(Literal::Duration { nanos, unit })
    }
}

fn operand(literal: Literal) -> Operand {
    Operand::Literal(literal, NOWHERE)
}
