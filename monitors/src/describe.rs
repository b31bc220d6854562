//! Formulas in the words of the language, and clauses of them.

use channels::{ChannelId, Relation, Topology, Value};

use crate::clause::{EventId, Form, Literal, Part, Vocabulary};
use crate::formula::{Event, MessageCondition};
use crate::syntax::print::ascii;

/// An event as the language writes it.
pub(crate) fn event(event: &Event, topology: &Topology) -> String {
    let (source, target) = topology.ends(event.channel);
    format!("({source}, {target}, {})", condition(&event.condition))
}

/// A condition as the language writes it.
pub(crate) fn condition(condition: &MessageCondition) -> String {
    match condition {
        MessageCondition::True => "true".to_owned(),
        MessageCondition::False => "false".to_owned(),
        MessageCondition::Compare { field, relation, value } => {
            format!("m[{field}] {} {value}", ascii(*relation))
        }
        MessageCondition::Not(part) => format!("not {}", inside(part)),
        MessageCondition::And(parts) => parts.iter().map(inside).collect::<Vec<_>>().join(" and "),
        MessageCondition::Or(parts) => parts.iter().map(inside).collect::<Vec<_>>().join(" or "),
        MessageCondition::Implies(a, b) => format!("{} implies {}", inside(a), inside(b)),
    }
}

fn inside(part: &MessageCondition) -> String {
    match part {
        MessageCondition::And(_) | MessageCondition::Or(_) | MessageCondition::Implies(..) => {
            format!("({})", condition(part))
        }
        _ => condition(part),
    }
}

/// The antecedent of a clause: what it denies, all of which must hold before it asks for anything.
pub(crate) fn antecedent(clause: &Part, vocabulary: &Vocabulary, topology: &Topology) -> String {
    let denied = denied(clause).map(|id| event(vocabulary.get(id), topology));
    denied.collect::<Vec<_>>().join(" and ")
}

/// The events that a clause denies.
pub(crate) fn denied(clause: &Part) -> impl Iterator<Item = EventId> + '_ {
    clause.iter().filter_map(|literal| match literal {
        Literal::Event { event, holds: false } => Some(*event),
        _ => None,
    })
}

/// The events that an answer to the clause would be.
pub(crate) fn answers(clause: &Part) -> impl Iterator<Item = EventId> + '_ {
    clause.iter().filter_map(|literal| match literal {
        Literal::Event { event, holds: true } | Literal::Time { event, holds: true, .. } => Some(*event),
        _ => None,
    })
}

/// A formula from its clauses.
pub(crate) fn form(form: &Form, vocabulary: &Vocabulary, topology: &Topology) -> String {
    let clauses: Vec<String> = form.iter().map(|part| clause(part, vocabulary, topology)).collect();
    if clauses.is_empty() { "true".to_owned() } else { clauses.join(" and ") }
}

/// An operator with its operands.
pub(crate) fn operator(operator: &Literal, vocabulary: &Vocabulary, topology: &Topology) -> String {
    literal(operator, vocabulary, topology)
}

/// A clause as the language writes it: an implication where it denies something and wants something.
pub(crate) fn clause(clause: &Part, vocabulary: &Vocabulary, topology: &Topology) -> String {
    let is_denied = |literal: &&Literal| matches!(literal, Literal::Event { holds: false, .. });
    let wanted: Vec<String> =
        clause.iter().filter(|literal| !is_denied(literal)).map(|part| literal(part, vocabulary, topology)).collect();
    match (antecedent(clause, vocabulary, topology), denied(clause).count()) {
        (_, 0) if wanted.is_empty() => "false".to_owned(),
        (_, 0) => wanted.join(" or "),
        (antecedent, 1) if wanted.is_empty() => format!("not {antecedent}"),
        (antecedent, _) if wanted.is_empty() => format!("not ({antecedent})"),
        (antecedent, _) => format!("{antecedent} implies {}", wanted.join(" or ")),
    }
}

/// A product as the language writes it.
fn product(product: &Part, vocabulary: &Vocabulary, topology: &Topology) -> String {
    let literals: Vec<String> = product.iter().map(|part| literal(part, vocabulary, topology)).collect();
    if literals.is_empty() { "true".to_owned() } else { literals.join(" and ") }
}

/// The parts of a form, as an operand: in parentheses where there is more than one literal.
fn operand(form: &Form, word: &str, write: impl Fn(&Part) -> String) -> String {
    let inside = |part: &Part| if part.len() > 1 { format!("({})", write(part)) } else { write(part) };
    match form.iter().collect::<Vec<_>>()[..] {
        [] => if word == " and " { "true" } else { "false" }.to_owned(),
        [part] => inside(part),
        _ => format!("({})", form.iter().map(inside).collect::<Vec<_>>().join(word)),
    }
}

fn literal(literal: &Literal, vocabulary: &Vocabulary, topology: &Topology) -> String {
    let clauses = |form: &Form| operand(form, " and ", |part| clause(part, vocabulary, topology));
    let products = |form: &Form| operand(form, " or ", |part| product(part, vocabulary, topology));
    let not = |holds: bool| if holds { "" } else { "not " };
    match literal {
        Literal::Event { event: id, holds } => format!("{}{}", not(*holds), event(vocabulary.get(*id), topology)),
        Literal::Time { event: id, window, holds } => {
            let bound = match (window.first, window.last) {
                (first, u64::MAX) => format!(">= {first}"),
                (first, last) if first == last && first > 0 => format!("= {first}"),
                (_, last) => format!("< {}", last + 1),
            };
            format!("{}time_until {} {bound}", not(*holds), event(vocabulary.get(*id), topology))
        }
        Literal::Next { clauses: inside, .. } => format!("next {}", clauses(inside)),
        Literal::Until { hold, goal } if hold.is_empty() => format!("eventually {}", products(goal)),
        Literal::Until { hold, goal } => format!("{} until {}", clauses(hold), products(goal)),
        Literal::Release { escape, hold } if escape.is_empty() => format!("always {}", clauses(hold)),
        Literal::Release { escape, hold } => {
            format!("not (not {} until not {})", products(escape), clauses(hold))
        }
    }
}

/// A condition in as few words as a picture has room for: `running`, `≤ 30`. That a message is `<ok>` goes without
/// saying where something else is said of it.
pub(crate) fn brief(condition: &MessageCondition) -> String {
    let list = |parts: &[MessageCondition], word: &str| {
        let telling: Vec<&MessageCondition> = parts.iter().filter(|part| !is_ok(part)).collect();
        let telling = if telling.is_empty() { parts.iter().collect() } else { telling };
        telling.into_iter().map(brief).collect::<Vec<_>>().join(word)
    };
    match condition {
        MessageCondition::Compare { relation: Relation::Equal, value: Value::Symbol(symbol), .. } => {
            symbol.name().to_owned()
        }
        MessageCondition::Compare { relation, value, .. } => format!("{relation} {value}"),
        MessageCondition::Not(part) => brief_not(part),
        MessageCondition::And(parts) => list(parts, " and "),
        MessageCondition::Or(parts) => parts.iter().map(brief).collect::<Vec<_>>().join(" or "),
        MessageCondition::Implies(a, b) if is_ok(a) => brief(b),
        MessageCondition::Implies(a, b) => format!("{} implies {}", brief(a), brief(b)),
        MessageCondition::True => "any message".to_owned(),
        MessageCondition::False => "no message".to_owned(),
    }
}

/// Not a condition, in few words.
pub(crate) fn brief_not(condition: &MessageCondition) -> String {
    match condition {
        MessageCondition::Implies(a, b) if is_ok(a) => brief_not(b),
        MessageCondition::Compare { field, relation, value } if value.as_number().is_some() => {
            let relation = match relation {
                Relation::Equal => Relation::NotEqual,
                Relation::NotEqual => Relation::Equal,
                Relation::Less => Relation::GreaterOrEqual,
                Relation::LessOrEqual => Relation::Greater,
                Relation::Greater => Relation::LessOrEqual,
                Relation::GreaterOrEqual => Relation::Less,
            };
            brief(&MessageCondition::Compare { field: *field, relation, value: value.clone() })
        }
        other => format!("not {}", brief_inside(other)),
    }
}

fn brief_inside(condition: &MessageCondition) -> String {
    let text = brief(condition);
    if text.contains(' ') { format!("({text})") } else { text }
}

fn is_ok(condition: &MessageCondition) -> bool {
    matches!(condition, MessageCondition::Compare { field: 1, relation: Relation::Equal, value } if value.is_symbol("ok"))
}

/// What makes a clause ask for something, in few words: what it denies holds, and what it wants now does not.
pub(crate) fn brief_antecedent(clause: &Part, vocabulary: &Vocabulary) -> String {
    let parts = clause.iter().filter_map(|literal| match literal {
        Literal::Event { event, holds: false } => Some(brief(&vocabulary.get(*event).condition)),
        Literal::Event { event, holds: true } => Some(brief_not(&vocabulary.get(*event).condition)),
        _ => None,
    });
    let parts: Vec<String> = parts.collect();
    if parts.is_empty() { "true".to_owned() } else { parts.join(" and ") }
}

/// That a clause of the present holds, in few words.
pub(crate) fn brief_clause(part: &Part, vocabulary: &Vocabulary) -> String {
    match part.iter().collect::<Vec<_>>()[..] {
        [Literal::Event { event, holds: true }] => brief(&vocabulary.get(*event).condition),
        [Literal::Event { event, holds: false }] => brief_not(&vocabulary.get(*event).condition),
        _ => format!("not ({})", brief_antecedent(part, vocabulary)),
    }
}

/// The names of a channel's ends.
pub(crate) fn ends(channel: ChannelId, topology: &Topology) -> (String, String) {
    let (source, target) = topology.ends(channel);
    (source.to_owned(), target.to_owned())
}
