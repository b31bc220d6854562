//! The definition by examples: the result of each operator on short runs.
//!
//! A run is written in words: `tick` is a generated tick, `a+` a message on channel A that satisfies the event a, `a-`
//! one that does not. The first tick is number 0.

use std::sync::Arc;

use channels::{Capacity, ChannelId, Domain, Event, EventKind, FieldKind, Message, Relation, Shape, Topology, Value};
use monitors::{Bound, Formula, MessageCondition, holds, holds_endlessly};

use crate::support::event;

/// Channels a, b and c, each with messages `[true]` and `[false]`.
fn topology() -> Arc<Topology> {
    let mut topology = Topology::default();
    let watched = topology.process("watched").expect("a new process");
    for name in ["a", "b", "c"] {
        let source = topology.process(name).expect("a new process");
        let domain = Domain::new([Shape::new([("holds", FieldKind::Bool)])]);
        topology.channel(source, watched, Capacity::One, domain).expect("a new channel");
    }
    Arc::new(topology)
}

fn channel(name: &str) -> ChannelId {
    topology().find_channel(name, "watched").expect("a, b or c")
}

/// The run in words, as events.
fn run(words: &str) -> Vec<Event> {
    let mut ticks = 0_u64;
    let words = words.split_whitespace().enumerate();
    let events = words.map(|(step, word)| {
        let kind = match word.split_at(1) {
            ("t", _) => {
                ticks += 1;
                EventKind::Tick
            }
            (name, sign) => {
                EventKind::Received { channel: channel(name), message: Message::new([Value::Bool(sign == "+")]) }
            }
        };
        event(step as u64, ticks.saturating_sub(1), kind)
    });
    events.collect()
}

fn atom(name: &str) -> monitors::EventAtom {
    let condition = MessageCondition::Compare { field: 1.into(), relation: Relation::Equal, value: Value::Bool(true) };
    monitors::EventAtom { channel: channel(name), condition }
}

fn is(name: &str) -> Formula {
    Formula::Event(atom(name))
}

fn soon(name: &str, relation: Relation, ticks: u64) -> Formula {
    Formula::TimeUntil { event: atom(name), bound: Bound::new(relation, ticks) }
}

fn next(inside: Formula) -> Formula {
    Formula::Next(Box::new(inside))
}

fn eventually(inside: Formula) -> Formula {
    Formula::Eventually(Box::new(inside))
}

fn until(a: Formula, b: Formula) -> Formula {
    Formula::Until(Box::new(a), Box::new(b))
}

fn once(bound: Bound, inside: Formula) -> Formula {
    Formula::Once(bound, Box::new(inside))
}

fn within(relation: Relation, ticks: u64) -> Bound {
    Bound::new(relation, ticks)
}

fn and(a: Formula, b: Formula) -> Formula {
    Formula::And(vec![a, b])
}

fn or(a: Formula, b: Formula) -> Formula {
    Formula::Or(vec![a, b])
}

#[track_caller]
fn check(formula: &Formula, yes: &[&str], no: &[&str]) {
    for words in yes {
        assert!(holds(formula, &run(words)).expect("small"), "should hold on: {words}");
    }
    for words in no {
        assert!(!holds(formula, &run(words)).expect("small"), "should not hold on: {words}");
    }
}

#[test]
fn always_is_checked_at_messages_on_its_channel() {
    check(&is("a").always(), &["", "t", "t b- t", "a+ t a+"], &["a-", "t a+ t a-", "a- a+"]);
    check(&is("a").negated().always(), &["", "t b+", "a- t"], &["a+", "a- b- a+"]);
}

#[test]
fn a_clause_of_two_channels_is_checked_at_messages_on_either() {
    let both = or(is("a"), is("b")).always();
    check(&both, &["a+", "a+ b-", "b+ a-", "t t"], &["a-", "b+ a- b-", "a+ b- a-"]);
    let implied = is("a").implies(is("b")).always();
    // Before its first message an event is false: `a+` finds b false; `a-` and `b-` violate nothing.
    check(&implied, &["a-", "b- a-", "b+ a+"], &["a+", "b+ a+ b-", "a+ b+"]);
}

#[test]
fn a_fresh_event_is_a_message_and_not_what_was_last_said() {
    let fresh = |name| Formula::Fresh(atom(name));
    let implied = fresh("a").implies(is("b")).always();
    check(&implied, &["", "a- b-", "b- b+ a+", "b+ a+ b-", "b+ a+ t b- a-"], &["a+", "a+ b+", "b+ a+ b- a+"]);
    // Alone, it is checked where the event is.
    check(&fresh("a").always(), &["", "t a+ t b- a+"], &["a-", "a+ a-"]);
    check(&next(fresh("a")), &["t a+", "a- b+ a+"], &["", "a+", "t a-"]);
    check(&eventually(and(fresh("a"), is("b"))), &["b+ a+", "a+ b+ a+"], &["a+ b+", "b+ a-"]);
    check(&until(fresh("a"), is("b")), &["a+ b+", "b+"], &["a- b+", "a+"]);
    check(&is("b").implies(once(Bound::NONE, fresh("a"))).always(), &["a+ a- b+"], &["b+ a+", "a- b+"]);
    check(&fresh("a").negated().always(), &["a- b+", ""], &["b+ a+"]);
}

#[test]
fn a_part_without_atoms_of_its_own_is_checked_at_ticks() {
    check(&Formula::False.always(), &["", "a+ a- b+"], &["t", "a+ t"]);
    check(&eventually(Formula::True), &["t", "a- t"], &["", "a+ b+"]);
    check(&eventually(is("a").always()), &["t", "a- t a+", "t a- t"], &["a+", "", "t a-"]);
    check(&soon("a", Relation::Less, 2).always(), &["", "t a+", "t t a+", "t a+ t a+"], &["t", "t a+ t", "t t t a+"]);
}

#[test]
fn clauses_are_checked_separately() {
    // `always (a and b)` checks a at messages on A and b at messages on B, not both at once.
    check(&and(is("a"), is("b")).always(), &["a+", "b+", "a+ b+ a+"], &["a-", "a+ b-", "b+ a-"]);
    check(&eventually(or(is("a"), is("b"))), &["a+", "b+", "a- b+"], &["", "a- b-", "t"]);
    // One product: checked at messages on either channel.
    check(&eventually(and(is("a"), is("b"))), &["a+ b+", "b+ a+", "a+ b- b+"], &["a+", "b+", "a+ b-", "a+ a- b+"]);
}

#[test]
fn next_is_the_next_message_on_its_own_channels() {
    check(&next(is("a")), &["t a+", "a- a+", "t b+ t a+ a-"], &["", "t", "a+", "t a- a+"]);
    // At the end of the run a `next` is false, and its negation true.
    check(&next(is("a")).negated(), &["", "t", "a+", "t a-"], &["t a+"]);
    check(&next(and(is("a"), is("b"))), &["b+ a+", "a+ b+"], &["t a+", "t b+ a+", "a- a+ b+"]);
    // Without own atoms it is the next tick: the first state is not the next one.
    check(&next(Formula::True), &["t t", "a+ t t"], &["", "t", "t a+", "a+ t"]);
    check(&next(soon("a", Relation::Less, 1)), &["t t a+", "t a- t a+"], &["t a+ t", "t t t a+", "a+"]);
    check(&is("a").implies(next(is("b"))).always(), &["t", "a+ b+", "a- b-", "a+ a+ b+"], &["a+", "a+ b-", "a+ b- b+"]);
}

#[test]
fn once_covers_the_present_and_the_past() {
    let formula = is("a").implies(once(Bound::NONE, is("b"))).always();
    check(&formula, &["", "tick a-", "b+ tick a+", "b+ b- tick a+ a+", "tick b+"], &["a+", "tick a+ b+", "b- a+"]);
    let recent = is("a").implies(once(within(Relation::Less, 2), is("b"))).always();
    check(&recent, &["tick b+ tick a+", "tick b+ a+"], &["tick b+ tick tick a+"]);
    let exactly = is("a").implies(once(within(Relation::Equal, 1), is("b"))).always();
    check(&exactly, &["tick b+ tick a+"], &["tick b+ a+", "tick b+ tick tick a+"]);
    // It is checked whenever a message that it mentions passes, and at ticks.
    check(&once(within(Relation::Less, 1), is("b")).always(), &["b+ c- b+", "b+ tick"], &["b-", "b+ tick tick"]);
}

#[test]
fn historically_covers_every_earlier_check() {
    let formula = is("a").implies(Formula::Historically(within(Relation::LessOrEqual, 1), Box::new(is("b")))).always();
    check(&formula, &["a+", "b+ a+", "b- tick tick tick b+ a+"], &["b- a+", "tick b- tick b+ a+"]);
}

#[test]
fn since_needs_its_condition_after_its_goal() {
    let since = Formula::Since(Bound::NONE, Box::new(is("b")), Box::new(is("c")));
    let formula = is("a").implies(since).always();
    check(&formula, &["c+ a+", "b- c+ b+ b+ a+", "c+ b- c+ a+"], &["a+", "b+ a+", "c+ b- a+", "c+ b- b+ a+"]);
}

#[test]
fn previous_is_the_last_message_before_on_its_own_channels() {
    let formula = is("a").implies(Formula::Previous(Bound::NONE, Box::new(is("a")))).always();
    check(&formula, &["a-", "a- a-"], &["a+", "a- tick a+", "a- a+"]);
    let other = is("a").implies(Formula::Previous(within(Relation::LessOrEqual, 1), Box::new(is("b")))).always();
    check(&other, &["b+ a+", "tick b+ tick a+"], &["b+ b- a+", "tick b+ tick tick a+"]);
}

#[test]
fn messages_are_counted_in_a_window_that_ends_now() {
    let count =
        |is_at_most, count| Formula::Count { event: atom("a"), is_at_most, count, bound: within(Relation::Less, 2) };
    check(&count(true, 1).always(), &["a+ a-", "tick a+ tick tick a+"], &["a+ a+", "tick a+ tick a+"]);
    let enough = is("b").implies(count(false, 2)).always();
    check(&enough, &["a+ a+ b+", "tick a+ tick a+ b+"], &["a+ b+", "a+ a- b+", "tick a+ tick tick a+ b+"]);
    // At ticks, too, since there may be no messages.
    check(&count(false, 1).always(), &["a+ tick tick"], &["tick", "a+ tick tick tick"]);
}

#[test]
fn operators_that_look_ahead_are_not_allowed_inside_those_that_look_back() {
    let formula = once(Bound::NONE, eventually(is("a"))).always();
    assert_eq!(holds(&formula, &[]), Err(monitors::FormulaError::LooksAhead));
}

#[test]
fn until_needs_its_goal_and_its_condition() {
    let way = until(is("a"), is("b"));
    check(&way, &["b+", "a+ b+", "a+ a+ t b+ a-", "t b+"], &["", "a+", "a- b+", "a+ b-", "a+ a- b+"]);
    // The goal counts only when it is checked, the condition only before it.
    check(&until(is("a"), is("a").negated()), &["a-", "a+ a-"], &["", "a+", "t"]);
    check(&until(Formula::False, is("b")), &["b+", "a- b+"], &["t b+", "t", ""]);
    check(&way.negated(), &["", "a- b+", "a+ b-"], &["b+", "a+ b+"]);
    check(&until(is("a"), or(is("b"), is("c"))), &["c+", "a+ b- c+"], &["a- c+", "b- c-"]);
    check(&until(and(is("a"), is("c")), is("b")), &["b+", "a+ c+ b+"], &["a+ c- b+", "c+ a- b+"]);
}

#[test]
fn time_until_is_about_any_message_that_passes() {
    let at_first = |relation, ticks| soon("a", relation, ticks);
    // j = i counts.
    check(&at_first(Relation::Less, 1), &["a+", "t a+", "a- a+"], &["", "t", "t t a+", "a-"]);
    check(&at_first(Relation::Less, 0), &[], &["a+", "t a+"]);
    check(&at_first(Relation::LessOrEqual, 0), &["a+", "t a- a+"], &["t t a+"]);
    check(&at_first(Relation::LessOrEqual, 1), &["t t a+"], &["t t t a+"]);
    // Any message, not the first one.
    check(&at_first(Relation::Equal, 1), &["t t a+", "t a+ t a+"], &["t a+", "t a+ t t a+", "t t a-"]);
    check(&at_first(Relation::NotEqual, 1), &["t a+", "t t t a+", "t t a+ t a+"], &["t t a+", "t"]);
    check(&at_first(Relation::NotEqual, 1).negated(), &["t t a+", "t", ""], &["t a+", "t t t a+"]);
    check(&at_first(Relation::GreaterOrEqual, 2), &["t t t a+", "t a+ t t t a+"], &["t t a+", "t"]);
    check(&at_first(Relation::Greater, 1), &["t t t a+"], &["t t a+", "a+"]);
    // The last message counts only when it passes.
    check(&is("b").implies(at_first(Relation::Less, 1)).always(), &["b+ a+", "b-"], &["a+ b+", "b+ t t a+"]);
    check(&at_first(Relation::Less, 1).negated(), &["", "t", "t t a+"], &["a+", "t a+"]);
}

/// The part that contains a bound is checked in the same states for any bound: `< 0` is never true, but not a constant.
#[test]
fn a_bound_that_nothing_can_meet_is_not_special() {
    let never = soon("a", Relation::Less, 0).implies(is("a"));
    check(&next(never), &["t a+", "t a-"], &["t", "t t"]);
    check(&soon("a", Relation::Less, 0).negated().always(), &["", "t", "t a+"], &[]);
    check(&eventually(or(soon("a", Relation::Greater, u64::MAX), is("b"))), &["b+"], &["a+ t", "b-"]);
    // `!=` is one atom: it is checked at messages on its own channel.
    let other = and(soon("a", Relation::Less, 3), or(soon("a", Relation::NotEqual, 3), is("b")));
    check(&other.always(), &["", "t a+", "t a+ b- a+", "t b+ a+"], &["t a+ b-"]);
}

/// The verdict of a formula on endless runs: a stem, then a repeated cycle.
#[track_caller]
fn says_endlessly(formula: &Formula, yes: &[[&str; 2]], no: &[[&str; 2]]) {
    let judged = |[stem, cycle]: &[&str; 2]| {
        let cycle: Vec<EventKind> = run(cycle).into_iter().map(|event| event.kind).collect();
        holds_endlessly(formula, &run(stem), &cycle).expect("small")
    };
    yes.iter().for_each(|words| assert!(judged(words), "should hold on {words:?}"));
    no.iter().for_each(|words| assert!(!judged(words), "should not hold on {words:?}"));
}

#[test]
fn endless_runs_are_judged_by_everything_that_follows() {
    let again = eventually(is("a")).always();
    says_endlessly(&again, &[["t", "t a+"], ["a-", "a- a+"], ["t a+", ""]], &[["t a+", "t"], ["t", ""], ["", "t a-"]]);
    says_endlessly(&is("a").implies(next(is("a"))).always(), &[["t", "a+"], ["a+", "t b- a+"]], &[["t a+", "t"]]);
    // The last message of one turn is still the last one in the next.
    let both = and(is("a"), is("b"));
    says_endlessly(&eventually(both), &[["", "b+ a+ b-"], ["a+", "b+ t"]], &[["", "a+ a- b+ b-"]]);
    says_endlessly(&until(is("a"), is("b")), &[["", "t a+ b+ a-"]], &[["", "a+ t b-"], ["", "a+ b- a- b+"]]);
}

#[test]
fn in_endless_runs_each_cycle_advances_time() {
    let later = |relation, ticks| soon("a", relation, ticks);
    says_endlessly(
        &later(Relation::GreaterOrEqual, 7),
        &[["t", "t t a+"], ["t", "a+ t"]],
        &[["t", "a+"], ["t a+", "t"]],
    );
    says_endlessly(
        &later(Relation::Equal, 7),
        &[["t", "t a+"], ["t", "t t t a+ t"]],
        &[["t", "t t a+"], ["t", "t t a+ t t"]],
    );
    // `a` comes at every third tick: after one, two or three ticks, depending on the state that asks.
    let asked = |relation, ticks| is("b").implies(later(relation, ticks)).always();
    let third = ["t", "t b+ t b+ t b+ a+"];
    says_endlessly(&asked(Relation::LessOrEqual, 2), &[third], &[]);
    says_endlessly(&asked(Relation::LessOrEqual, 1), &[], &[third]);
    says_endlessly(&later(Relation::Greater, 0).always(), &[["t", "t a+"]], &[["t", "a+"], ["t a+", "t"]]);
    // Without ticks, messages accumulate in one window, however many there are.
    let many = Formula::Count { event: atom("a"), is_at_most: false, count: 10, bound: within(Relation::Less, 1) };
    says_endlessly(&eventually(many), &[["t", "a+"]], &[["t", "a+ t"], ["t a+ a+", ""]]);
    // A run that ends in silence is judged like a finished one.
    says_endlessly(&next(Formula::True).always(), &[["", "t"]], &[["t", ""], ["t", "a+"]]);
}

#[test]
fn conditions_follow_boolean_logic() {
    let compare = |field: usize, relation, value: bool| MessageCondition::Compare {
        field: field.into(),
        relation,
        value: value.into(),
    };
    let (yes, no) = (compare(1, Relation::Equal, true), compare(1, Relation::Equal, false));
    let (plus, minus) = (Message::new([Value::Bool(true)]), Message::new([Value::Bool(false)]));
    let not = |part: &MessageCondition| MessageCondition::Not(Box::new(part.clone()));
    let implies = |a: &MessageCondition, b: &MessageCondition| {
        MessageCondition::Implies(Box::new(a.clone()), Box::new(b.clone()))
    };
    let both = MessageCondition::And(vec![yes.clone(), no.clone()]);
    let either = MessageCondition::Or(vec![yes.clone(), no.clone()]);
    // Each with its value on `[true]` and on `[false]`.
    let expected_of = [
        (&yes, [true, false]),
        (&not(&yes), [false, true]),
        (&both, [false, false]),
        (&not(&both), [true, true]),
        (&either, [true, true]),
        (&implies(&yes, &no), [false, true]),
        (&implies(&yes, &yes), [true, true]),
        (&implies(&MessageCondition::True, &yes), [true, false]),
        (&MessageCondition::False, [false, false]),
    ];
    for (condition, expected) in expected_of {
        assert_eq!([&plus, &minus].map(|message| condition.holds(message)), expected, "{condition:?}");
    }
    // A field that is absent or of another type: only `!=` holds, as the negation of `=`.
    for relation in
        [Relation::Equal, Relation::Less, Relation::LessOrEqual, Relation::Greater, Relation::GreaterOrEqual]
    {
        assert!(!compare(2, relation, true).holds(&plus), "{relation:?}");
        assert!(!compare(1, relation, true).holds(&Message::symbols(["true"])), "{relation:?}");
    }
    assert!(compare(2, Relation::NotEqual, true).holds(&plus));
    assert!(compare(1, Relation::NotEqual, true).holds(&Message::symbols(["true"])));
}

#[test]
fn unmentioned_channels_do_not_exist() {
    // The first state is the first one visible to the property: `b` is not mentioned.
    check(&next(is("a")), &["b+ a- a+"], &["b+ a+"]);
}
