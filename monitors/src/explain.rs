//! Formulas in plain, patterned English.

use channels::{ChannelId, FieldKind, Relation, Topology, Value};

use crate::formula::{Event, Formula, MessageCondition};

/// What a formula asks for, in a sentence; one for each part of an outermost `and`.
#[must_use]
pub fn explain(formula: &Formula, topology: &Topology) -> String {
    match formula {
        Formula::And(parts) if !parts.is_empty() => {
            parts.iter().map(|part| explain(part, topology)).collect::<Vec<_>>().join(" ")
        }
        formula => capitalised(Explainer { topology }.sentence(formula)) + ".",
    }
}

fn capitalised(mut text: String) -> String {
    if let Some(first) = text.chars().next() {
        text.replace_range(..first.len_utf8(), &first.to_uppercase().to_string());
    }
    text
}

struct Explainer<'a> {
    topology: &'a Topology,
}

impl Explainer<'_> {
    fn sentence(&self, formula: &Formula) -> String {
        match formula {
            Formula::Always(body) => match &**body {
                Formula::Implies(antecedent, consequence) => {
                    format!("whenever {}, then {}", self.clause(antecedent), self.clause(consequence))
                }
                Formula::Event(event) => self.every_message(event),
                Formula::Not(inside) if matches!(**inside, Formula::Event(_)) => {
                    format!("it never happens that {}", self.clause(inside))
                }
                body => format!("at all times, {}", self.clause(body)),
            },
            other => self.clause(other),
        }
    }

    fn every_message(&self, event: &Event) -> String {
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

    /// A formula as the clause of a sentence.
    fn clause(&self, formula: &Formula) -> String {
        match formula {
            Formula::True => "nothing is asked".to_owned(),
            Formula::False => "this is impossible".to_owned(),
            Formula::Event(event) => self.event(event),
            Formula::TimeUntil { event, relation, ticks } => {
                format!("{}, {}", time(*relation, *ticks), self.event(event))
            }
            Formula::Not(inside) => match &**inside {
                Formula::TimeUntil { event, relation, ticks } => {
                    format!("{}, it does not happen that {}", time(*relation, *ticks), self.event(event))
                }
                inside => format!("it is not so that {}", self.clause(inside)),
            },
            Formula::And(parts) => self.list(parts, " and "),
            Formula::Or(parts) => self.list(parts, " or "),
            Formula::Implies(a, b) => format!("if {}, then {}", self.clause(a), self.clause(b)),
            Formula::Next(inside) => format!("the next time, {}", self.clause(inside)),
            Formula::Always(inside) => format!("from then on always {}", self.clause(inside)),
            Formula::Eventually(inside) => format!("at some time {}", self.clause(inside)),
            Formula::Until(a, b) => format!("{} until {}", self.clause(a), self.clause(b)),
        }
    }

    fn list(&self, parts: &[Formula], word: &str) -> String {
        parts.iter().map(|part| self.clause(part)).collect::<Vec<_>>().join(word)
    }

    fn event(&self, event: &Event) -> String {
        let (source, target) = self.topology.ends(event.channel);
        match &event.condition {
            MessageCondition::True => format!("{source} tells {target} something"),
            condition => format!("{source} tells {target} that {}", self.condition(condition, event.channel)),
        }
    }

    fn condition(&self, condition: &MessageCondition, channel: ChannelId) -> String {
        let join = |parts: &[MessageCondition], word: &str| {
            parts.iter().map(|part| self.condition(part, channel)).collect::<Vec<_>>().join(word)
        };
        match condition {
            MessageCondition::True => "anything at all".to_owned(),
            MessageCondition::False => "the impossible is so".to_owned(),
            MessageCondition::Compare { field, relation, value } => {
                format!("{} {} {}", self.field(*field, value, channel), verb(*relation), plain(value))
            }
            MessageCondition::Not(inside) => format!("it is not so that {}", self.condition(inside, channel)),
            MessageCondition::And(parts) => join(parts, " and "),
            MessageCondition::Or(parts) => join(parts, " or "),
            MessageCondition::Implies(a, b) => {
                format!("if {}, then {}", self.condition(a, channel), self.condition(b, channel))
            }
        }
    }

    /// A field by its name in the shapes whose field could have that value, or by its number.
    fn field(&self, field: usize, value: &Value, channel: ChannelId) -> String {
        let fits = |kind: &FieldKind| match kind {
            FieldKind::Symbol(symbols) => matches!(value, Value::Symbol(symbol) if symbols.contains(symbol)),
            FieldKind::Bool => matches!(value, Value::Bool(_)),
            FieldKind::Int | FieldKind::Real => value.as_number().is_some(),
            FieldKind::Text => matches!(value, Value::Text(_)),
        };
        let shapes = self.topology.get(channel).domain.shapes().iter();
        let fields = shapes.filter_map(|shape| shape.fields().get(field - 1)).filter(|(_, kind)| fits(kind));
        let mut names: Vec<&str> = fields.map(|(name, _)| name.as_str()).collect();
        names.dedup();
        match names[..] {
            [name] => format!("its {name}"),
            _ => format!("m[{field}]"),
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

fn plain(value: &Value) -> String {
    match value {
        Value::Symbol(symbol) => symbol.name().to_owned(),
        other => other.to_string(),
    }
}

/// When a timed event is due.
fn time(relation: Relation, ticks: u64) -> String {
    let count = if ticks == 1 { "1 tick".to_owned() } else { format!("{ticks} ticks") };
    match relation {
        Relation::Less => format!("within {count}"),
        Relation::LessOrEqual => format!("after {count} at the latest"),
        Relation::Equal => format!("exactly {count} later"),
        Relation::NotEqual => format!("at another time than {count} later"),
        Relation::Greater => format!("some time after more than {count}"),
        Relation::GreaterOrEqual => format!("some time after {count} or more"),
    }
}
