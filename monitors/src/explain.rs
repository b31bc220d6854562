//! Formulas in plain, patterned English.
//!
//! No two formulas with different meanings read alike: a nested part whose extent could be misread is in parentheses.

use std::borrow::Cow;

use channels::{ChannelId, Relation, Topology, Value};

use crate::WORLD;
use crate::formula::{Bound, EventAtom, Formula, Function, MessageCondition, MessageField, Term};
use crate::operator::Parts;
use crate::wording::{Items, by_name, edge, of_items};

/// A formula's requirement as a sentence; one sentence for each part of an outermost `and`.
#[must_use]
pub fn explain(formula: &Formula, topology: &Topology) -> String {
    match formula {
        Formula::Timed(formula) => explained(formula, topology, true),
        formula => explained(formula, topology, false),
    }
}

fn explained(formula: &Formula, topology: &Topology, is_timed: bool) -> String {
    match formula {
        Formula::And(parts) if !parts.is_empty() => {
            parts.iter().map(|part| explained(part, topology, is_timed)).collect::<Vec<_>>().join(" ")
        }
        formula => capitalised(Explainer { topology, is_timed }.sentence(formula)) + ".",
    }
}

fn capitalised(mut text: String) -> String {
    if let Some((at, first)) = text.char_indices().find(|(_, char)| *char != '(') {
        text.replace_range(at..at + first.len_utf8(), &first.to_uppercase().to_string());
    }
    text
}

/// Whether the antecedent is an event that still holds where messages on other channels are judged.
fn outlasts(antecedent: &Formula, consequence: &Formula) -> bool {
    let Formula::Event(event) = antecedent else { return false };
    let mut own = Vec::new();
    consequence.own_events(&mut |judged| own.push(judged.channel));
    own.into_iter().any(|channel| channel != event.channel)
}

struct Explainer<'a> {
    topology: &'a Topology,
    is_timed: bool,
}

impl Explainer<'_> {
    fn sentence(&self, formula: &Formula) -> String {
        match formula {
            Formula::Always(body) => match &**body {
                Formula::Implies(antecedent, consequence) => {
                    let lasts = if outlasts(antecedent, consequence) { ", and until its next message" } else { "" };
                    format!("whenever {}{lasts}, then {}", self.clause(antecedent), self.clause(consequence))
                }
                Formula::Event(event) => self.every_message(event),
                Formula::Not(inside) if let Formula::Event(event) = &**inside => self.never(event),
                body => format!("at all times, {}", self.clause(body)),
            },
            other => self.clause(other),
        }
    }

    /// A message that must not occur. Without a condition: "never tells anything".
    fn never(&self, event: &EventAtom) -> String {
        if event.condition == MessageCondition::True {
            return self.statement("never tells", "anything", event);
        }
        let (source, target) = self.topology.ends(event.channel);
        let condition = self.condition(&event.condition, event.channel);
        format!("no message from {source} to {target} says that {condition}")
    }

    fn every_message(&self, event: &EventAtom) -> String {
        let (source, target) = self.topology.ends(event.channel);
        match &event.condition {
            MessageCondition::Implies(a, b) => format!(
                "whenever {source} tells {target} that {}, then {}",
                self.condition(a, event.channel),
                self.condition(b, event.channel)
            ),
            condition => format!(
                "every message from {source} to {target} says that {}",
                self.condition(condition, event.channel)
            ),
        }
    }

    fn clause(&self, formula: &Formula) -> String {
        match formula {
            Formula::True => "nothing is required".to_owned(),
            Formula::False => "this is impossible".to_owned(),
            Formula::Event(event) => self.statement("tells", "something", event),
            Formula::Fresh(event) => self.statement("has just told", "something", event),
            Formula::TimeUntil { event, bound } => {
                format!("{}, {}", self.time(*bound), self.statement("tells", "something", event))
            }
            Formula::Not(inside) => self.denial(inside),
            Formula::And(parts) if let Some(part) = edge(parts) => format!("it becomes true that {}", self.rest(part)),
            Formula::And(parts) => self.list(parts, " and ", |part| matches!(part, Formula::And(_))),
            Formula::Or(parts) => self.list(parts, " or ", |part| matches!(part, Formula::Or(_))),
            Formula::Implies(a, b) => format!("if {}, then {}", self.limb(a), self.limb(b)),
            Formula::Next(inside) => format!("the next time, {}", self.rest(inside)),
            Formula::Always(inside) => format!("from then on always {}", self.rest(inside)),
            Formula::Eventually(inside) => format!("at some point, {}", self.rest(inside)),
            Formula::Timed(inside) => Self { is_timed: true, ..*self }.clause(inside),
            Formula::Until(a, b) => format!("{} until {}", self.inside(a), self.rest(b)),
            Formula::Once(bound, a) => format!("{}, {}", self.ago("at some time", *bound), self.rest(a)),
            Formula::Historically(bound, a) => format!("{}, {}", self.ago("at all times", *bound), self.rest(a)),
            Formula::Previous(bound, a) if *bound == Bound::NONE => format!("the time before, {}", self.rest(a)),
            Formula::Previous(bound, a) => {
                format!("the time before and {}, {}", self.ago("", *bound).trim_start(), self.rest(a))
            }
            // Nothing has to hold since then.
            Formula::Since(bound, a, b) if matches!(**a, Formula::True) => {
                format!("{}, {}", self.ago("at some time", *bound), self.rest(b))
            }
            Formula::Since(bound, a, b) if *bound == Bound::NONE => {
                format!("{} ever since {}", self.inside(a), self.rest(b))
            }
            Formula::Since(bound, a, b) => {
                format!("{} ever since, {}, {}", self.inside(a), self.ago("at some time", *bound), self.rest(b))
            }
            Formula::Count { event, is_at_most, count, bound } => {
                let what = self.statement("tells", "something", event);
                let most = if *is_at_most { "at most" } else { "at least" };
                let times = if *count == 1 { "once".to_owned() } else { format!("{count} times") };
                let window = self.ago("", *bound);
                format!("{most} {times} {}, {what}", window.trim_start())
            }
        }
    }

    /// A formula that does not hold.
    fn denial(&self, formula: &Formula) -> String {
        match formula {
            Formula::TimeUntil { event, bound } => {
                let time = self.time(*bound);
                let time = time.trim_start_matches("eventually, ");
                format!("it does not happen {time} that {}", self.statement("tells", "something", event))
            }
            Formula::Event(event) => self.statement("does not tell", "anything", event),
            Formula::Fresh(event) => self.statement("has not just told", "anything", event),
            inside => format!("it is not the case that {}", self.rest(inside)),
        }
    }

    /// Parts joined by a word; nested lists of the same kind have no parentheses.
    fn list(&self, parts: &[Formula], word: &str, is_alike: impl Fn(&Formula) -> bool) -> String {
        let part = |part: &Formula| if is_alike(part) { self.clause(part) } else { self.inside(part) };
        parts.iter().map(part).collect::<Vec<_>>().join(word)
    }

    /// A side of `if …, then …`, which commas separate.
    fn limb(&self, formula: &Formula) -> String {
        if matches!(formula, Formula::Implies(..)) { self.inside(formula) } else { self.clause(formula) }
    }

    /// A formula at the end of another one.
    fn rest(&self, formula: &Formula) -> String {
        if matches!(formula.parts(), Parts::Prefix(..)) { self.clause(formula) } else { self.inside(formula) }
    }

    fn inside(&self, formula: &Formula) -> String {
        let is_one = match formula {
            Formula::True | Formula::False | Formula::Event(_) | Formula::Fresh(_) | Formula::TimeUntil { .. } => true,
            Formula::Not(inside) => {
                matches!(**inside, Formula::TimeUntil { .. } | Formula::Event(_) | Formula::Fresh(_))
            }
            Formula::And(parts) | Formula::Or(parts) => {
                matches!(&parts[..], [part] if matches!(part, Formula::Event(_) | Formula::Fresh(_)))
            }
            _ => false,
        };
        if is_one { self.clause(formula) } else { format!("({})", self.clause(formula)) }
    }

    /// Sender, verb, receiver and message; `whatever` if it may be any message. The world does not tell, but shows.
    fn statement(&self, verb: &str, whatever: &str, event: &EventAtom) -> String {
        let (source, target) = self.topology.ends(event.channel);
        let shown = || verb.replace("tell", "show").replace("told", "shown");
        let verb = if source == WORLD { shown() } else { verb.to_owned() };
        match &event.condition {
            MessageCondition::True => format!("{source} {verb} {target} {whatever}"),
            condition => format!("{source} {verb} {target} that {}", self.condition(condition, event.channel)),
        }
    }

    /// How long ago something was, after a word for when.
    fn ago(&self, when: &str, bound: Bound) -> String {
        let count = self.length(bound);
        match bound.relation {
            Relation::GreaterOrEqual if bound.ticks == 0 => format!("{when} so far"),
            Relation::Less if count == "1 tick" => format!("{when} in the last tick"),
            Relation::Less => format!("{when} in the last {count}"),
            Relation::LessOrEqual => format!("{when} at most {count} ago"),
            Relation::Equal => format!("{when} exactly {count} ago"),
            Relation::NotEqual => format!("{when} more or fewer than {count} ago"),
            Relation::Greater => format!("{when} more than {count} ago"),
            Relation::GreaterOrEqual => format!("{when} at least {count} ago"),
        }
    }

    /// When a timed event is due. `< 5` excludes the fifth tick from now, `<= 5` includes it.
    fn time(&self, bound: Bound) -> String {
        let count = self.length(bound);
        match bound.relation {
            Relation::Less => format!("in fewer than {count}"),
            Relation::LessOrEqual => format!("within {count}"),
            Relation::Equal => format!("after exactly {count}"),
            Relation::NotEqual => format!("after more or fewer than {count}"),
            Relation::Greater => format!("eventually, after more than {count}"),
            Relation::GreaterOrEqual => format!("eventually, after at least {count}"),
        }
    }

    /// A number of ticks, or a duration.
    fn length(&self, bound: Bound) -> String {
        match (bound.duration(self.is_timed), bound.ticks) {
            (Some(duration), _) => duration.to_string(),
            (None, 1) => "1 tick".to_owned(),
            (None, ticks) => format!("{ticks} ticks"),
        }
    }

    /// The condition, or the comparison by names that stands for it.
    fn as_called<'c>(&self, condition: &'c MessageCondition, channel: ChannelId) -> Cow<'c, MessageCondition> {
        let shapes = self.topology.get(channel).domain.shapes();
        by_name(condition, shapes).map_or(Cow::Borrowed(condition), Cow::Owned)
    }

    fn condition(&self, condition: &MessageCondition, channel: ChannelId) -> String {
        let condition = &*self.as_called(condition, channel);
        let join = |parts: &[MessageCondition], word: &str, is_alike: fn(&MessageCondition) -> bool| {
            let part = |part: &MessageCondition| match is_alike(part) {
                true => self.condition(part, channel),
                false => self.condition_inside(part, channel),
            };
            parts.iter().map(part).collect::<Vec<_>>().join(word)
        };
        match condition {
            MessageCondition::True => "anything holds".to_owned(),
            MessageCondition::False => "a contradiction holds".to_owned(),
            MessageCondition::Compare { field, relation, value } => {
                format!("{} {} {}", self.field(field, Some(value), channel), verb(*relation), plain(value))
            }
            MessageCondition::Relate { left, relation, right } => match of_items(left, *relation, right) {
                Some(items) => self.items(&items, channel),
                None => format!("{} {} {}", self.term(left, channel), verb(*relation), self.term(right, channel)),
            },
            MessageCondition::Remember { field, name } => format!("{} is {name}", self.field(field, None, channel)),
            MessageCondition::Is { .. } => condition.text(&[]),
            MessageCondition::Not(inside) => self.condition_denied(inside, channel),
            MessageCondition::And(parts) => join(parts, " and ", |part| matches!(part, MessageCondition::And(_))),
            MessageCondition::Or(parts) => join(parts, " or ", |part| matches!(part, MessageCondition::Or(_))),
            MessageCondition::Implies(a, b) => {
                format!("if {}, then {}", self.condition_limb(a, channel), self.condition_limb(b, channel))
            }
        }
    }

    fn condition_denied(&self, condition: &MessageCondition, channel: ChannelId) -> String {
        match condition {
            MessageCondition::Relate { left, relation, right } => match of_items(left, *relation, right) {
                Some(items) => self.items(&Items { is_denied: !items.is_denied, ..items }, channel),
                None => {
                    format!("{} {} {}", self.term(left, channel), negated_verb(*relation), self.term(right, channel))
                }
            },
            MessageCondition::Compare { field, relation, value } => {
                format!("{} {} {}", self.field(field, Some(value), channel), negated_verb(*relation), plain(value))
            }
            inside => format!("it is not the case that {}", self.condition_inside(inside, channel)),
        }
    }

    fn items(&self, items: &Items<'_>, channel: ChannelId) -> String {
        let which = match (items.every, items.is_denied) {
            (false, false) => "for some item",
            (false, true) => "for no item",
            (true, false) => "for every item",
            (true, true) => "not for every item",
        };
        format!("{which}, {}", self.condition_inside(items.inside, channel))
    }

    fn condition_limb(&self, condition: &MessageCondition, channel: ChannelId) -> String {
        match condition {
            MessageCondition::Implies(..) => self.condition_inside(condition, channel),
            condition => self.condition(condition, channel),
        }
    }

    fn condition_inside(&self, condition: &MessageCondition, channel: ChannelId) -> String {
        let condition = &*self.as_called(condition, channel);
        let is_one = match condition {
            MessageCondition::True | MessageCondition::False | MessageCondition::Remember { .. } => true,
            MessageCondition::Compare { .. } | MessageCondition::Relate { .. } => true,
            MessageCondition::Not(inside) => {
                matches!(**inside, MessageCondition::Compare { .. } | MessageCondition::Relate { .. })
            }
            _ => false,
        };
        let text = self.condition(condition, channel);
        if is_one { text } else { format!("({text})") }
    }

    fn term(&self, term: &Term, channel: ChannelId) -> String {
        match term {
            Term::Field(field) => self.field(field, None, channel),
            Term::Value(value) => plain(value),
            Term::Remembered(name) => name.to_string(),
            Term::Arithmetic(left, operator, right) => {
                let side = |side: &Term| match side {
                    Term::Arithmetic(..) => format!("({})", self.term(side, channel)),
                    side => self.term(side, channel),
                };
                format!("{} {} {}", side(left), operator.sign(), side(right))
            }
            Term::Call(function, terms) => {
                let terms: Vec<String> = terms.iter().map(|term| self.term(term, channel)).collect();
                match (function, &terms[..]) {
                    (Function::Distance, [x, y, u, v]) => format!("the distance between ({x}, {y}) and ({u}, {v})"),
                    (Function::Angle, [a, b]) => format!("the angle between {a} and {b}"),
                    (_, terms) => format!("the {} of ({})", function.signature().0, terms.join(", ")),
                }
            }
            Term::Count(condition) => {
                format!("the number of items for which {}", self.condition_inside(condition, channel))
            }
        }
    }

    /// A field by its name, if the property calls it by name or it has the same in all messages (in which it can be
    /// compared with the value); else by its number.
    fn field(&self, field: &MessageField, value: Option<&Value>, channel: ChannelId) -> String {
        let shapes = self.topology.get(channel).domain.shapes().iter();
        let fields = shapes.filter_map(|shape| shape.fields().get(field.number - 1));
        let fields = fields.filter(|(_, kind)| value.is_none_or(|value| kind.is_comparable_to(value)));
        let mut names: Vec<&str> = fields.map(|(name, _)| name.as_str()).collect();
        names.sort_unstable();
        names.dedup();
        match (&field.name, &names[..]) {
            (Some(name), _) => format!("`{name}`"),
            (None, [name]) => format!("`{name}`"),
            _ => format!("m[{}]", field.number),
        }
    }
}

fn verb(relation: Relation) -> &'static str {
    match relation {
        Relation::Equal => "is",
        Relation::NotEqual => "is not",
        Relation::Less => "is less than",
        Relation::LessOrEqual => "is at most",
        Relation::Greater => "is more than",
        Relation::GreaterOrEqual => "is at least",
    }
}

fn negated_verb(relation: Relation) -> &'static str {
    match relation {
        Relation::Equal => "is not",
        Relation::NotEqual => "is exactly",
        Relation::Less => "is not less than",
        Relation::LessOrEqual => "is not at most",
        Relation::Greater => "is not more than",
        Relation::GreaterOrEqual => "is not at least",
    }
}

fn plain(value: &Value) -> String {
    match value {
        Value::Symbol(symbol) => symbol.name().to_owned(),
        other => other.to_string(),
    }
}
