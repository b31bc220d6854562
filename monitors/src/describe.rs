//! Clauses as formulas and in the SCOPE language, and conditions in short form.

use channels::{Relation, Topology, Value};

use crate::clause::{EventId, Form, Literal, LiteralSet, Vocabulary, Window, bounds};
use crate::formula::{Bound, EventAtom, Formula, MessageCondition};

/// An event as the language writes it.
pub(crate) fn event(event: &EventAtom, topology: &Topology) -> String {
    Formula::Event(event.clone()).text(topology)
}

/// A formula in the SCOPE language.
pub(crate) fn text(formula: Formula, words: &Vocabulary, topology: &Topology) -> String {
    if words.is_timed { Formula::Timed(Box::new(formula)).text(topology) } else { formula.text(topology) }
}

/// A formula from its clauses.
pub(crate) fn form(form: &Form, words: &Vocabulary, topology: &Topology) -> String {
    text(clauses(form, true, words), words, topology)
}

/// An operator and its operands.
pub(crate) fn operator(operator: &Literal, words: &Vocabulary) -> Formula {
    literal(operator, true, words)
}

/// A timed event in a window of ticks from now, written as in the formula if the formula has exactly one such event.
pub(crate) fn awaited(event: EventId, window: Window, form: &Form, words: &Vocabulary) -> Formula {
    let bounds: Vec<Bound> = bounds(form, event).into_iter().collect();
    let event = words.get(event).clone();
    let timed = |bound| Formula::TimeUntil { event: event.clone(), bound };
    match (window, &bounds[..]) {
        (Window { first: 0, last: u64::MAX }, _) => Formula::Eventually(Box::new(Formula::Event(event))),
        (_, [bound]) => timed(*bound),
        (Window { first, last: u64::MAX }, _) => timed(Bound::new(Relation::GreaterOrEqual, first)),
        (Window { first, last }, _) if first == last => timed(Bound::new(Relation::Equal, first)),
        (Window { last, .. }, _) => timed(Bound::new(Relation::LessOrEqual, last)),
    }
}

/// A clause in the SCOPE language: an implication if it has both negative and positive literals.
pub(crate) fn clause(clause: &LiteralSet, words: &Vocabulary, topology: &Topology) -> String {
    text(any(clause, true, words), words, topology)
}

/// The antecedent of a clause: the negations of its negative literals, which must hold before it demands anything. Of
/// its events, only these.
pub(crate) fn antecedent(clause: &LiteralSet, events: u64, words: &Vocabulary, topology: &Topology) -> String {
    let is_meant = |denied: &&Literal| match denied {
        Literal::Event { event, .. } => !words.names(*event).is_empty() || events & 1 << event.0 != 0,
        _ => true,
    };
    let denied = denied(clause).into_iter().filter(is_meant).map(|denied| literal(denied, false, words));
    text(joined(denied, true), words, topology)
}

/// The literals that a clause negates: those under whose opposites it demands something.
pub(crate) fn denied(clause: &LiteralSet) -> Vec<&Literal> {
    split(clause, true).0
}

/// The events and past formulas that would answer the clause.
pub(crate) fn answers(clause: &LiteralSet, words: &Vocabulary, topology: &Topology) -> Vec<String> {
    let answers = split(clause, true).1.into_iter().filter_map(|wanted| match wanted {
        Literal::Event { event: id, holds: true }
        | Literal::Fresh { event: id, holds: true }
        | Literal::Time { event: id, holds: true, .. } => Some(event(words.get(*id), topology)),
        past => past.past().map(|_| text(literal(past, true, words), words, topology)),
    });
    answers.collect()
}

/// The literals of a clause that are denied, and the others. `historically` and `at most` deny something too, but read
/// better as they are, unless the clause has no other antecedent.
fn split(clause: &LiteralSet, holds: bool) -> (Vec<&Literal>, Vec<&Literal>) {
    let (denied, wanted): (Vec<&Literal>, Vec<&Literal>) = clause.iter().partition(|literal| match literal {
        Literal::Event { holds: polarity, .. }
        | Literal::Fresh { holds: polarity, .. }
        | Literal::Previous { holds: polarity, .. } => *polarity != holds,
        Literal::Since { hold, holds: polarity, .. } => *polarity != holds && !hold.is_empty(),
        _ => false,
    });
    let is_weak = |literal: &&Literal| literal.past().is_some_and(|(_, polarity)| polarity != holds);
    if !denied.is_empty() || wanted.iter().all(is_weak) {
        return (denied, wanted);
    }
    wanted.into_iter().partition(is_weak)
}

/// Clauses, or their negation.
fn clauses(form: &Form, holds: bool, words: &Vocabulary) -> Formula {
    let part = if holds { any } else { all };
    joined(form.iter().map(|clause| part(clause, holds, words)), holds)
}

/// Products, or their negation.
fn products(form: &Form, holds: bool, words: &Vocabulary) -> Formula {
    let part = if holds { all } else { any };
    joined(form.iter().map(|product| part(product, holds, words)), !holds)
}

/// All literals of a part, or the negations of all of them.
fn all(part: &LiteralSet, holds: bool, words: &Vocabulary) -> Formula {
    joined(part.iter().map(|part| literal(part, holds, words)), true)
}

/// One literal of a part, or one of their negations: an implication from the negated events to the rest.
fn any(part: &LiteralSet, holds: bool, words: &Vocabulary) -> Formula {
    let (denied, wanted) = split(part, holds);
    let (is_plain, is_ban) = (denied.is_empty(), wanted.is_empty());
    let denied = joined(denied.into_iter().map(|part| literal(part, !holds, words)), true);
    let wanted = joined(wanted.into_iter().map(|part| literal(part, holds, words)), false);
    match (is_plain, is_ban) {
        (true, _) => wanted,
        (false, true) => denied.negated(),
        (false, false) => denied.implies(wanted),
    }
}

/// A literal, or its negation.
fn literal(literal: &Literal, holds: bool, words: &Vocabulary) -> Formula {
    match literal {
        Literal::Event { event, holds: polarity } => {
            unless(*polarity != holds, Formula::Event(words.get(*event).clone()))
        }
        Literal::Fresh { event, holds: polarity } => {
            unless(*polarity != holds, Formula::Fresh(words.get(*event).clone()))
        }
        Literal::Time { event, bound, holds: polarity } => {
            let event = words.get(*event).clone();
            unless(*polarity != holds, Formula::TimeUntil { event, bound: *bound })
        }
        // A `next` that may never come is the negation of one that must.
        Literal::Next { clauses: inside, strong } => {
            unless(*strong != holds, Formula::Next(Box::new(clauses(inside, *strong, words))))
        }
        Literal::Until { hold, goal } => until(hold, goal, holds, words),
        Literal::Release { escape, hold } => release(escape, hold, holds, words),
        Literal::Since { hold, goal, bound, holds: polarity } if hold.is_empty() => match *polarity == holds {
            true => Formula::Once(*bound, Box::new(products(goal, true, words))),
            false => Formula::Historically(*bound, Box::new(products(goal, false, words))),
        },
        Literal::Since { hold, goal, bound, holds: polarity } => {
            let (hold, goal) = (clauses(hold, true, words), products(goal, true, words));
            unless(*polarity != holds, Formula::Since(*bound, Box::new(hold), Box::new(goal)))
        }
        Literal::Previous { clauses: inside, bound, holds: polarity } => {
            unless(*polarity != holds, Formula::Previous(*bound, Box::new(clauses(inside, true, words))))
        }
        Literal::Count { event, count, bound, holds: polarity } => {
            let (event, is_at_most) = (words.get(*event).clone(), *polarity != holds);
            Formula::Count { event, is_at_most, count: count - u64::from(is_at_most), bound: *bound }
        }
    }
}

fn until(hold: &Form, goal: &Form, holds: bool, words: &Vocabulary) -> Formula {
    match (hold.is_empty(), holds) {
        (true, true) => Formula::Eventually(Box::new(products(goal, true, words))),
        (true, false) => products(goal, false, words).always(),
        (false, _) => {
            let (hold, goal) = (clauses(hold, true, words), products(goal, true, words));
            unless(!holds, Formula::Until(Box::new(hold), Box::new(goal)))
        }
    }
}

/// The language has no release: it is the negation of an `until` of negations.
fn release(escape: &Form, hold: &Form, holds: bool, words: &Vocabulary) -> Formula {
    match (escape.is_empty(), holds) {
        (true, true) => clauses(hold, true, words).always(),
        (true, false) => Formula::Eventually(Box::new(clauses(hold, false, words))),
        (false, _) => {
            let (escape, hold) = (products(escape, false, words), clauses(hold, false, words));
            unless(holds, Formula::Until(Box::new(escape), Box::new(hold)))
        }
    }
}

fn unless(is_negated: bool, formula: Formula) -> Formula {
    if is_negated { formula.negated() } else { formula }
}

/// The parts joined by `and` (or by `or`).
fn joined(parts: impl Iterator<Item = Formula>, and: bool) -> Formula {
    let mut parts: Vec<Formula> = parts.collect();
    match (parts.len(), and) {
        (1, _) => parts.remove(0),
        (0, true) => Formula::True,
        (0, false) => Formula::False,
        (_, true) => Formula::And(parts),
        (_, false) => Formula::Or(parts),
    }
}

/// A condition in as few words as a picture has room for: `running`, `≤ 30`. `<ok>` is omitted if there is more
/// about the message.
pub(crate) fn brief(condition: &MessageCondition) -> String {
    let list = |parts: &[MessageCondition], word: &str| {
        let informative: Vec<&MessageCondition> = parts.iter().filter(|part| !is_ok(part)).collect();
        let informative = if informative.is_empty() { parts.iter().collect() } else { informative };
        informative.into_iter().map(brief).collect::<Vec<_>>().join(word)
    };
    match condition {
        MessageCondition::Compare { relation: Relation::Equal, value: Value::Symbol(symbol), .. } => {
            symbol.name().to_owned()
        }
        MessageCondition::Compare { relation, value, .. } => format!("{relation} {value}"),
        MessageCondition::Relate { .. } | MessageCondition::Remember { .. } | MessageCondition::Is { .. } => {
            condition.text(&[])
        }
        MessageCondition::Not(part) => brief_not(part),
        MessageCondition::And(parts) => list(parts, " and "),
        MessageCondition::Or(parts) => parts.iter().map(brief).collect::<Vec<_>>().join(" or "),
        MessageCondition::Implies(a, b) if is_ok(a) => brief(b),
        MessageCondition::Implies(a, b) => format!("{} implies {}", brief(a), brief(b)),
        MessageCondition::True => "any message".to_owned(),
        MessageCondition::False => "no message".to_owned(),
    }
}

/// The negation of a condition, in short form.
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
            brief(&MessageCondition::Compare { field: field.clone(), relation, value: value.clone() })
        }
        other => format!("not {}", brief_inside(other)),
    }
}

fn brief_inside(condition: &MessageCondition) -> String {
    let text = brief(condition);
    if text.contains(' ') { format!("({text})") } else { text }
}

fn is_ok(condition: &MessageCondition) -> bool {
    matches!(condition, MessageCondition::Compare { field, relation: Relation::Equal, value }
        if field.number == 1 && value.is_symbol("ok"))
}

/// The condition under which a clause demands something, in short form: its negated events hold, and its other present
/// events do not.
pub(crate) fn brief_antecedent(clause: &LiteralSet, vocabulary: &Vocabulary) -> String {
    let parts = clause.iter().filter_map(|literal| match literal {
        Literal::Event { event, holds: false } => Some(brief(&vocabulary.get(*event).condition)),
        Literal::Event { event, holds: true } => Some(brief_not(&vocabulary.get(*event).condition)),
        _ => None,
    });
    let parts: Vec<String> = parts.collect();
    if parts.is_empty() { "true".to_owned() } else { parts.join(" and ") }
}

/// The condition that a clause without a deadline holds, in short form.
pub(crate) fn brief_clause(part: &LiteralSet, vocabulary: &Vocabulary) -> String {
    match part.iter().collect::<Vec<_>>()[..] {
        [Literal::Event { event, holds: true }] => brief(&vocabulary.get(*event).condition),
        [Literal::Event { event, holds: false }] => brief_not(&vocabulary.get(*event).condition),
        _ => format!("not ({})", brief_antecedent(part, vocabulary)),
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use channels::{Capacity, Domain, FieldKind, Shape};

    use super::*;
    use crate::clause;

    const BOUNDS: [(Relation, u64); 6] = [
        (Relation::Less, 3),
        (Relation::LessOrEqual, 2),
        (Relation::NotEqual, 2),
        (Relation::GreaterOrEqual, 1),
        (Relation::Less, 0),
        (Relation::Equal, 4),
    ];

    fn topology() -> Topology {
        let mut topology = Topology::default();
        let target = topology.process("T").unwrap();
        for name in ["P", "Q", "R"] {
            let source = topology.process(name).unwrap();
            let domain = Domain::new([Shape::new([("on", FieldKind::Bool)])]);
            topology.channel(source, target, Capacity::One, domain).unwrap();
        }
        topology
    }

    /// A formula for each seed; with `back`, it looks only back.
    fn formula(seed: &mut u64, topology: &Topology, depth: u32, back: bool) -> Formula {
        let mut roll = |sides: u64| {
            *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (*seed >> 33) % sides
        };
        let channel = topology.channels().nth(roll(3) as usize).unwrap();
        let condition = MessageCondition::Compare { field: 1.into(), relation: Relation::Equal, value: true.into() };
        let event = EventAtom { channel, condition };
        let (relation, ticks) = BOUNDS[roll(6) as usize];
        let kind = match (depth, back) {
            (0, _) => roll(3),
            (_, false) => 2 + roll(13),
            (_, true) => [0, 3, 4, 5, 10, 11, 12, 13, 14][roll(9) as usize],
        };
        let bound = Bound::new(relation, ticks);
        let mut part = || formula(seed, topology, depth.saturating_sub(1), back || kind >= 10);
        match kind {
            0 | 1 => Formula::Event(event),
            2 if back => Formula::Event(event),
            2 => Formula::TimeUntil { event, bound },
            3 => part().negated(),
            4 => Formula::And(vec![part(), part()]),
            5 => Formula::Or(vec![part(), part()]),
            6 => Formula::Next(Box::new(part())),
            7 => part().always(),
            8 => Formula::Eventually(Box::new(part())),
            10 => Formula::Once(bound, Box::new(part())),
            11 => Formula::Historically(Bound::NONE, Box::new(part())),
            12 => Formula::Previous(bound, Box::new(part())),
            13 => Formula::Since(bound, Box::new(part()), Box::new(part())),
            14 => {
                Formula::Count { event, is_at_most: ticks % 2 == 0, count: ticks, bound: Bound::new(Relation::Less, 3) }
            }
            _ => Formula::Until(Box::new(part()), Box::new(part())),
        }
    }

    fn read(text: &str, topology: &Topology) -> Formula {
        let read = crate::load::formulas("p", &format!("property p := {text}"), topology, Duration::from_secs(1));
        read.unwrap_or_else(|error| panic!("{text}: {:?}", error.problems())).remove(0).1
    }

    /// All operators of a form, including nested ones.
    fn operators<'a>(form: &'a Form, found: &mut Vec<&'a Literal>) {
        for literal in form.iter().flatten() {
            if matches!(literal, Literal::Event { .. } | Literal::Time { .. }) {
                continue;
            }
            literal.forms().into_iter().for_each(|inside| operators(inside, found));
            found.push(literal);
        }
    }

    #[test]
    fn clauses_and_obligations_read_back_as_themselves() {
        let topology = topology();
        let mut seen = 0;
        for start in 0..3_000 {
            let mut seed = start;
            let formula = formula(&mut seed, &topology, 1 + start as u32 % 4, false).always();
            let words = Vocabulary::of(&formula);
            let Ok(all) = clause::clauses(&formula, &words) else { continue };
            let printed = form(&all, &words, &topology);
            let again = clause::clauses(&read(&printed, &topology), &words);
            assert_eq!(again.as_ref(), Ok(&all), "{}\n{printed}", formula.text(&topology));
            let mut owed = Vec::new();
            operators(&all, &mut owed);
            for literal in owed {
                let looks_ahead = operator(literal, &words).looks_ahead();
                let printed = operator(literal, &words).text(&topology);
                if !looks_ahead {
                    // A property does not consist of it alone.
                    continue;
                }
                let again = clause::clauses(&read(&printed, &topology), &words);
                assert_eq!(again, Ok(Form::from([LiteralSet::from([literal.clone()])])), "{printed}");
                seen += 1;
            }
        }
        assert!(seen > 4_000, "{seen}");
    }

    #[test]
    fn formulas_are_printed_as_they_were_written() {
        let topology = topology();
        let [p, q, r] = ["(P, T, m.on = true)", "(Q, T, m.on = true)", "(R, T, m.on = true)"];
        for text in [
            format!("always (not {p} until {q})"),
            format!("eventually ({p} until {q})"),
            format!("({p} until {q}) until {r}"),
            format!("not ({q} until {p})"),
            format!("not next {p}"),
            format!("always ({p} implies time_until {q} <= 2)"),
            format!("always ({p} implies time_until {q} != 2)"),
        ] {
            let formula = read(&text, &topology);
            let words = Vocabulary::of(&formula);
            assert_eq!(form(&clause::clauses(&formula, &words).unwrap(), &words, &topology), text);
        }
    }
}
