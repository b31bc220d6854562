//! Formulas in plain, patterned English.
//!
//! No two formulas with different meanings read alike: a nested part whose extent could be misread is in parentheses.

use channels::{ChannelId, Relation, Topology, Value};

use crate::formula::{EventAtom, Formula, MessageCondition};

/// What a formula requires, as a sentence; one sentence for each part of an outermost `and`.
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
    if let Some((at, first)) = text.char_indices().find(|(_, char)| *char != '(') {
        text.replace_range(at..at + first.len_utf8(), &first.to_uppercase().to_string());
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
                Formula::Not(inside) if let Formula::Event(event) = &**inside => {
                    self.told("never tells", "anything", event)
                }
                body => format!("at all times, {}", self.clause(body)),
            },
            other => self.clause(other),
        }
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

    /// A formula as the clause of a sentence.
    fn clause(&self, formula: &Formula) -> String {
        match formula {
            Formula::True => "nothing is required".to_owned(),
            Formula::False => "this is impossible".to_owned(),
            Formula::Event(event) => self.told("tells", "something", event),
            Formula::TimeUntil { event, relation, ticks } => {
                format!("{}, {}", time(*relation, *ticks), self.told("tells", "something", event))
            }
            Formula::Not(inside) => match &**inside {
                Formula::TimeUntil { event, relation, ticks } => {
                    let time = time(*relation, *ticks);
                    let time = time.trim_start_matches("eventually, ");
                    format!("it does not happen {time} that {}", self.told("tells", "something", event))
                }
                Formula::Event(event) => self.told("does not tell", "anything", event),
                inside => format!("it is not the case that {}", self.rest(inside)),
            },
            Formula::And(parts) => self.list(parts, " and ", |part| matches!(part, Formula::And(_))),
            Formula::Or(parts) => self.list(parts, " or ", |part| matches!(part, Formula::Or(_))),
            Formula::Implies(a, b) => format!("if {}, then {}", self.limb(a), self.limb(b)),
            Formula::Next(inside) => format!("the next time, {}", self.rest(inside)),
            Formula::Always(inside) => format!("from then on always {}", self.rest(inside)),
            Formula::Eventually(inside) => format!("at some point, {}", self.rest(inside)),
            Formula::Until(a, b) => format!("{} until {}", self.inside(a), self.rest(b)),
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
        match formula {
            Formula::Not(_) | Formula::Next(_) | Formula::Always(_) | Formula::Eventually(_) => self.clause(formula),
            formula => self.inside(formula),
        }
    }

    /// A formula inside another one.
    fn inside(&self, formula: &Formula) -> String {
        let is_one = match formula {
            Formula::True | Formula::False | Formula::Event(_) | Formula::TimeUntil { .. } => true,
            Formula::Not(inside) => matches!(**inside, Formula::TimeUntil { .. } | Formula::Event(_)),
            Formula::And(parts) | Formula::Or(parts) => {
                matches!(&parts[..], [part] if matches!(part, Formula::Event(_)))
            }
            _ => false,
        };
        if is_one { self.clause(formula) } else { format!("({})", self.clause(formula)) }
    }

    /// Who `tells` whom what; `whatever` if it may be any message.
    fn told(&self, tells: &str, whatever: &str, event: &EventAtom) -> String {
        let (source, target) = self.topology.ends(event.channel);
        match &event.condition {
            MessageCondition::True => format!("{source} {tells} {target} {whatever}"),
            condition => format!("{source} {tells} {target} that {}", self.condition(condition, event.channel)),
        }
    }

    fn condition(&self, condition: &MessageCondition, channel: ChannelId) -> String {
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
                format!("{} {} {}", self.field(*field, value, channel), verb(*relation), plain(value))
            }
            MessageCondition::Not(inside) => match &**inside {
                MessageCondition::Compare { field, relation, value } => {
                    format!("{} {} {}", self.field(*field, value, channel), negated_verb(*relation), plain(value))
                }
                inside => format!("it is not the case that {}", self.condition_inside(inside, channel)),
            },
            MessageCondition::And(parts) => join(parts, " and ", |part| matches!(part, MessageCondition::And(_))),
            MessageCondition::Or(parts) => join(parts, " or ", |part| matches!(part, MessageCondition::Or(_))),
            MessageCondition::Implies(a, b) => {
                format!("if {}, then {}", self.condition_limb(a, channel), self.condition_limb(b, channel))
            }
        }
    }

    fn condition_limb(&self, condition: &MessageCondition, channel: ChannelId) -> String {
        match condition {
            MessageCondition::Implies(..) => self.condition_inside(condition, channel),
            condition => self.condition(condition, channel),
        }
    }

    /// A condition inside another one.
    fn condition_inside(&self, condition: &MessageCondition, channel: ChannelId) -> String {
        let is_one = match condition {
            MessageCondition::True | MessageCondition::False | MessageCondition::Compare { .. } => true,
            MessageCondition::Not(inside) => matches!(**inside, MessageCondition::Compare { .. }),
            _ => false,
        };
        let text = self.condition(condition, channel);
        if is_one { text } else { format!("({text})") }
    }

    /// A field by its name in the shapes whose field can hold this value, or by its number.
    fn field(&self, field: usize, value: &Value, channel: ChannelId) -> String {
        let shapes = self.topology.get(channel).domain.shapes().iter();
        let fields =
            shapes.filter_map(|shape| shape.fields().get(field - 1)).filter(|(_, kind)| kind.is_comparable_to(value));
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

/// When a timed event is due. `< 5` excludes the fifth tick from now, `<= 5` includes it.
fn time(relation: Relation, ticks: u64) -> String {
    let count = if ticks == 1 { "1 tick".to_owned() } else { format!("{ticks} ticks") };
    match relation {
        Relation::Less => format!("in fewer than {count}"),
        Relation::LessOrEqual => format!("within {count}"),
        Relation::Equal => format!("after exactly {count}"),
        Relation::NotEqual => format!("after more or fewer than {count}"),
        Relation::Greater => format!("eventually, after more than {count}"),
        Relation::GreaterOrEqual => format!("eventually, after at least {count}"),
    }
}
