//! Formulas in the words of the language, and clauses of them.

use std::fmt::Write as _;

use channels::{ChannelId, Topology, Value};

use crate::clause::{EventId, Literal, Part, Vocabulary};
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
            format!("m[{field}] {} {}", ascii(*relation), constant(value))
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

fn constant(value: &Value) -> String {
    value.to_string()
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
pub(crate) fn form(form: &crate::clause::Form, vocabulary: &Vocabulary, topology: &Topology) -> String {
    let clauses: Vec<String> = form.iter().map(|part| clause(part, vocabulary, topology)).collect();
    if clauses.is_empty() { "true".to_owned() } else { clauses.join(" and ") }
}

/// An operator with its operands.
pub(crate) fn operator(operator: &Literal, vocabulary: &Vocabulary, topology: &Topology) -> String {
    literal(operator, vocabulary, topology)
}

/// A clause as the language writes it: an implication where it denies something.
pub(crate) fn clause(clause: &Part, vocabulary: &Vocabulary, topology: &Topology) -> String {
    let is_denied = |literal: &&Literal| matches!(literal, Literal::Event { holds: false, .. });
    let wanted: Vec<String> =
        clause.iter().filter(|literal| !is_denied(literal)).map(|part| literal(part, vocabulary, topology)).collect();
    let wanted = if wanted.is_empty() { "false".to_owned() } else { wanted.join(" or ") };
    match antecedent(clause, vocabulary, topology) {
        antecedent if antecedent.is_empty() => wanted,
        antecedent => format!("{antecedent} implies {wanted}"),
    }
}

fn literal(literal: &Literal, vocabulary: &Vocabulary, topology: &Topology) -> String {
    let all = |form: &crate::clause::Form, word: &str| {
        let parts: Vec<String> = form.iter().map(|part| format!("({})", clause(part, vocabulary, topology))).collect();
        parts.join(word)
    };
    let products = |form: &crate::clause::Form| {
        let of = |part: &Part| {
            let literals: Vec<String> = part.iter().map(|part| self::literal(part, vocabulary, topology)).collect();
            format!("({})", if literals.is_empty() { "true".to_owned() } else { literals.join(" and ") })
        };
        form.iter().map(of).collect::<Vec<_>>().join(" or ")
    };
    let mut text = String::new();
    match literal {
        Literal::Event { event: id, holds } => {
            let _ = write!(text, "{}{}", if *holds { "" } else { "not " }, event(vocabulary.get(*id), topology));
        }
        Literal::Time { event: id, window, holds } => {
            let not = if *holds { "" } else { "not " };
            let bound = match (window.first, window.last) {
                (first, u64::MAX) => format!(">= {first}"),
                (first, last) if first == last => format!("= {first}"),
                (_, last) => format!("<= {last}"),
            };
            let _ = write!(text, "{not}time_until {} {bound}", event(vocabulary.get(*id), topology));
        }
        Literal::Next { clauses, .. } => text = format!("next {}", all(clauses, " and ")),
        Literal::Until { hold, goal } if hold.is_empty() => text = format!("eventually {}", products(goal)),
        Literal::Until { hold, goal } => text = format!("({}) until ({})", all(hold, " and "), products(goal)),
        Literal::Release { escape, hold } if escape.is_empty() => text = format!("always {}", all(hold, " and ")),
        Literal::Release { escape, hold } => {
            text = format!("not (not ({}) until not ({}))", products(escape), all(hold, " and "));
        }
    }
    text
}

/// What makes a clause ask for something, by its conditions alone: what it denies holds, and what it wants now does not.
pub(crate) fn clause_antecedent(clause: &Part, vocabulary: &Vocabulary) -> String {
    let parts = clause.iter().filter_map(|literal| match literal {
        Literal::Event { event, holds: false } => Some(condition(&vocabulary.get(*event).condition)),
        Literal::Event { event, holds: true } => {
            Some(format!("not ({})", condition(&vocabulary.get(*event).condition)))
        }
        _ => None,
    });
    let parts: Vec<String> = parts.collect();
    if parts.is_empty() { "true".to_owned() } else { parts.join(" and ") }
}

/// A clause by its conditions alone, where only one channel matters; else in full.
pub(crate) fn clause_in_short(part: &Part, vocabulary: &Vocabulary, topology: &Topology) -> String {
    match part.iter().collect::<Vec<_>>()[..] {
        [Literal::Event { event, holds: true }] => condition(&vocabulary.get(*event).condition),
        _ => clause(part, vocabulary, topology),
    }
}

/// The names of a channel's ends.
pub(crate) fn ends(channel: ChannelId, topology: &Topology) -> (String, String) {
    let (source, target) = topology.ends(channel);
    (source.to_owned(), target.to_owned())
}
