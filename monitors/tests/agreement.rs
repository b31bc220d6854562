//! Every monitor agrees with the oracle on every prefix of random sequences.

use std::hash::{DefaultHasher, Hasher};

use channels::{Event, EventKind, Message, Monitor, Relation, Value, Verdict};
use monitors::{Bound, Choice, Formula, MessageCondition, Method, Outcome, ScopeMonitor, holds};

use crate::cases::{cases, demanded};
use crate::support::check::check;
use crate::support::classes::{CLASSES, Class, Pair, Topologies, stretched};
use crate::support::definition::Definition;
use crate::support::tally::Tally;
use crate::support::{
    self, Choose, Dice, formula_over, formula_with, limits_divided_by, numbers, random_event, random_formula,
    random_sequence, topology,
};

/// Checks this many pairs of a class.
fn agree(class: Class, first: u64, pairs: u64, states: u64, words: u64) -> Tally {
    let topologies = Topologies::new();
    let mut tally = Tally::default();
    for seed in first..first + pairs {
        let pair = topologies.pair(class, seed, states);
        if let Err(what) = check(&pair, words, &mut tally) {
            panic!("{class}: {what}\n{pair}");
        }
    }
    eprintln!("{class}: {tally}");
    tally
}

#[test]
#[ignore = "long: .ci/run runs it"]
fn monitors_agree_with_the_oracle_on_ten_thousand_random_pairs() {
    let pairs = cases(10_000);
    let tally = agree(Class::Small, 0, pairs, 12, 30);
    agree(Class::Named, 1_000_000, pairs / 10, 12, 5);
    let enough = [(tally.graphs, 50), (tally.automata, 2), (tally.settled, 10)];
    assert!(enough.iter().all(|(count, part)| count * part > pairs), "{tally}");
    let late: u64 = tally.late.values().flatten().sum();
    assert!(late * 1_000 < pairs && tally.again > 0, "{tally}");
}

/// Many fields, extreme constants, integers beyond 2⁵³, missing items and parts that are trivially true.
#[test]
fn monitors_of_many_extreme_numbers_agree_with_the_oracle() {
    let pairs = cases(2_000);
    let tally = agree(Class::Numbers, 0, pairs, 10, 5);
    assert!(tally.settled * 10 > pairs && tally.automata * 10 > pairs && tally.graphs * 10 > pairs, "{tally}");
}

/// Halving a limit, or leaving almost nothing of it, makes verdicts late. It changes none.
#[test]
fn no_limit_decides_a_verdict() {
    let (small, large) = (topology(), numbers::topology());
    let (mut late, mut settled) = (0, 0);
    for seed in 0..cases(1_000) {
        let mut dice = Dice(seed + 60_000_000);
        let depth = 1 + seed as u32 % 3;
        let (formula, sequence, topology) = if seed % 2 == 0 {
            (numbers::formula(&mut dice, &large, depth), numbers::sequence(&mut dice, &large, 10), &large)
        } else {
            (random_formula(&mut dice, &small, depth), random_sequence(&mut dice, &small, 10), &small)
        };
        let make = |by| {
            let limits = limits_divided_by(by);
            ScopeMonitor::within(limits, "p", formula.clone(), topology, Choice::Best).expect("small")
        };
        let mut full = make(1);
        let mut limited = [2, 30, 300, 10_000_000].map(make);
        for event in &sequence {
            full.observe(event);
            for (index, limited) in limited.iter_mut().enumerate() {
                limited.observe(event);
                let verdict = limited.verdict();
                let changes = verdict != full.verdict() && verdict != Verdict::Inconclusive;
                assert!(!changes, "seed {seed}, limits {index}: {verdict:?} instead of {full:#?}");
                late += u64::from(verdict != full.verdict());
            }
        }
        settled += u64::from(full.verdict() != Verdict::Inconclusive);
        for limited in &limited {
            let outcome = limited.outcome();
            let changes = outcome != full.outcome() && outcome != Outcome::Inconclusive;
            assert!(!changes, "seed {seed}: {outcome} instead of {}\n{formula:#?}", full.outcome());
        }
    }
    assert!(late > 0 && settled * 4 > cases(1_000), "{late} late, {settled} settled");
}

#[test]
fn monitors_that_look_back_agree_with_the_oracle() {
    let pairs = cases(3_000);
    let tally = agree(Class::Back, 0, pairs, 14, 30);
    assert!(tally.automata * 2 > pairs && tally.settled * 10 > pairs && tally.again > 0, "{tally}");
}

/// Formulas that would have to keep messages forever are refused, as are those in which a name stands for two values.
#[test]
fn monitors_that_remember_values_agree_with_the_oracle() {
    for (class, pairs) in [(Class::Values, cases(1_500)), (Class::Sums, cases(1_500))] {
        let tally = agree(class, 0, pairs, 14, 5);
        assert!(tally.settled * 10 > pairs && tally.refused * 2 < pairs, "{tally}");
    }
}

/// A field that is called by its name is found by its name alone in the definition, whatever else a message has there.
#[test]
fn monitors_that_call_fields_by_name_agree_with_the_oracle() {
    let pairs = cases(2_000);
    let tally = agree(Class::Named, 0, pairs, 14, 5);
    assert!(tally.settled * 4 > pairs && tally.automata * 20 > pairs && tally.refused * 4 < pairs, "{tally}");
}

#[test]
fn timed_monitors_agree_with_the_oracle() {
    let pairs = cases(500);
    let tally = agree(Class::Timed, 0, pairs, 14, 5);
    assert!(tally.settled * 4 > pairs, "{tally}");
}

/// The classes take turns. A verdict is checked on fewer random words than in the other tests, and on more pairs.
#[test]
#[ignore = "long: PAIRS=1000000 SEED=0 cargo test --release -p steward-monitors monitors_agree_on_demand -- --ignored --nocapture"]
fn monitors_agree_on_demand() {
    let (seeds, first) = (demanded("PAIRS", 140_000) / CLASSES.len() as u64, demanded("SEED", 1_000_000));
    let topologies = Topologies::new();
    let mut tallies = CLASSES.map(|class| (class, Tally::default()));
    for seed in first..first + seeds {
        for (class, tally) in &mut tallies {
            let pair = topologies.pair(*class, seed, 12);
            check(&pair, 5, tally).unwrap_or_else(|what| panic!("{class}: {what}\n{pair}"));
        }
        if (seed + 1 - first).is_multiple_of(50_000) {
            println!("{} pairs agree …", (seed + 1 - first) * CLASSES.len() as u64);
        }
    }
    for (class, tally) in &tallies {
        println!("{class}: {tally}");
    }
    println!("none of {} verdicts is wrong", tallies.iter().map(|(_, tally)| tally.settled).sum::<u64>());
}

/// For each random formula and each prefix of a random sequence, a verdict is checked on hundreds of random endless
/// words. If there is no verdict, the automaton names an endless word for either outcome, and the definition confirms
/// both. This shows that no verdict is wrong or too early; late ones are counted.
#[test]
#[ignore = "long: FORMULAS=100000 SEED=0 cargo test --release -p steward-monitors verdicts_anticipate_on_demand -- --ignored --nocapture"]
fn verdicts_anticipate_on_demand() {
    let (formulas, first) = (demanded("FORMULAS", 10_000), demanded("SEED", 0));
    for class in [Class::Small, Class::Numbers] {
        agree(class, first, formulas / 2, 7, 300);
    }
}

/// A monitor that is brought into normal form after each event gives the same verdict at every event.
#[test]
fn a_monitor_and_its_normal_form_are_indistinguishable() {
    let topology = topology();
    let mut settled = 0;
    for seed in 0..cases(10_000) {
        let mut dice = Dice(seed + 12_000_000);
        let formula = if seed % 3 == 0 {
            let events = [0; 3].map(|_| random_event(&mut dice, &topology));
            formula_with(&mut dice, &events, 1 + seed as u32 % 3, Choose { ahead: true, back: true }).always()
        } else {
            random_formula(&mut dice, &topology, 1 + seed as u32 % 3)
        };
        let choice = *dice.pick(&[Choice::Best, Choice::Automaton, Choice::Progression]);
        let mut plain = ScopeMonitor::with("p", formula.clone(), &topology, choice).expect("small");
        let mut normal = plain.clone();
        let mut has_ticked = false;
        for mut event in random_sequence(&mut dice, &topology, 24) {
            if matches!(event.kind, EventKind::Received { .. }) && dice.roll(30) == 0 {
                let channel = topology.channels().nth(2).expect("C → D");
                event.kind = EventKind::Received { channel, message: Message::symbols(["neither"]) };
            }
            plain.observe(&event);
            let is_tick = event.kind == EventKind::Tick;
            event.tick = u64::from(is_tick && has_ticked);
            has_ticked |= is_tick;
            normal.observe(&event);
            normal.normalize().expect("it has a normal form");
            let mut of_plain = plain.clone();
            of_plain.normalize().expect("it has a normal form");
            let reported = |monitor: &ScopeMonitor| (monitor.verdict(), monitor.is_open(), monitor.holds_so_far());
            assert_eq!(reported(&plain), reported(&normal), "seed {seed}, {choice:?}\n{formula:#?}");
            assert!(of_plain.same_state(&normal), "seed {seed}, {choice:?}\n{of_plain:#?}\n{normal:#?}");
            assert_eq!(hash(&of_plain), hash(&normal));
        }
        settled += u64::from(plain.verdict() != Verdict::Inconclusive);
    }
    assert!(settled > cases(10_000) / 4, "{settled} settled");
}

fn hash(monitor: &ScopeMonitor) -> u64 {
    let mut hasher = DefaultHasher::new();
    monitor.hash_state(&mut hasher);
    hasher.finish()
}

/// The sequence with some ticks missing; time passes nevertheless.
fn with_gaps(dice: &mut Dice, sequence: &[Event]) -> Vec<Event> {
    let mut missing = 0;
    let events = sequence.iter().map(|known| {
        missing += u64::from(dice.roll(8) == 0);
        support::event(known.step, known.tick + missing, known.kind.clone())
    });
    events.collect()
}

/// In a run, time never passes without ticks, but a log may have lost some. Its events are judged nevertheless.
#[test]
fn logs_with_missing_ticks_are_judged_too() {
    let topology = topology();
    for seed in 0..cases(2_000) {
        let mut dice = Dice(seed + 9_000_000);
        let formula = random_formula(&mut dice, &topology, 1 + seed as u32 % 3);
        let sequence = random_sequence(&mut dice, &topology, 12);
        let sequence = with_gaps(&mut dice, &sequence);
        let truth = holds(&formula, &sequence).expect("small");
        for choice in [Choice::Automaton, Choice::Progression] {
            let mut monitor = ScopeMonitor::with("p", formula.clone(), &topology, choice).expect("small");
            sequence.iter().for_each(|event| monitor.observe(event));
            // An automaton's verdict assumes that no tick is missing.
            if choice == Choice::Progression || monitor.verdict() == Verdict::Inconclusive {
                assert_eq!(monitor.holds_so_far(), truth, "{choice:?}, seed {seed}\n{formula:#?}");
            }
        }
    }
}

/// A message outside its channel's domain leaves the automaton, but the rest of the run is judged nevertheless.
#[test]
fn messages_outside_the_domains_are_judged_too() {
    let topology = topology();
    let channel = topology.channels().nth(2).expect("C → D");
    let on =
        |value: bool| MessageCondition::Compare { field: 1.into(), relation: Relation::Equal, value: value.into() };
    let [is_on, is_off] = [true, false].map(|value| monitors::EventAtom { channel, condition: on(value) });
    let (mut automata, mut left) = (0, 0);
    for seed in 0..cases(4_000) {
        let mut dice = Dice(seed + 6_000_000);
        let events = [is_on.clone(), is_off.clone(), random_event(&mut dice, &topology)];
        let formula = formula_over(&mut dice, &events, 1 + seed as u32 % 2);
        let mut sequence = random_sequence(&mut dice, &topology, 16);
        for event in &mut sequence {
            if matches!(event.kind, EventKind::Received { .. }) && dice.roll(3) == 0 {
                event.kind = EventKind::Received { channel, message: Message::symbols(["neither"]) };
            }
        }
        for choice in [Choice::Best, Choice::Automaton, Choice::Progression] {
            let mut monitor = ScopeMonitor::with("p", formula.clone(), &topology, choice).expect("small");
            automata += u64::from(matches!(monitor.method(), Method::Automaton { .. }));
            for length in 0..=sequence.len() {
                let prefix = &sequence[..length];
                prefix.last().into_iter().for_each(|event| monitor.observe(event));
                let reported = match monitor.verdict() {
                    Verdict::Inconclusive => monitor.holds_so_far(),
                    settled => settled == Verdict::True,
                };
                let truth = holds(&formula, prefix).expect("small");
                assert_eq!(reported, truth, "{choice:?}, seed {seed}, after {length}\n{formula:#?}\n{sequence:#?}");
                if monitor.verdict() != Verdict::Inconclusive {
                    // A verdict assumes messages within the domains.
                    break;
                }
            }
            left += u64::from(monitor.verdict() == Verdict::Inconclusive && monitor.continuation(true).is_none());
        }
    }
    assert!(automata > cases(2_000) && left > cases(500), "{automata} automata, {left} left");
}

/// Several answers with one deadline make a graph. With separate deadlines, or a ban beside an answer, one number is
/// not enough.
#[test]
fn answers_with_separate_deadlines_are_distinguished() {
    let topology = topology();
    let on = |channel, value: Value| monitors::EventAtom {
        channel: topology.channels().nth(channel).expect("four channels"),
        condition: MessageCondition::Compare { field: 1.into(), relation: Relation::Equal, value },
    };
    let asks = Formula::Event(on(0, Value::symbol("x")));
    let within = |channel, value, ticks| Formula::TimeUntil {
        event: on(channel, value),
        bound: Bound::new(Relation::Less, ticks),
    };
    let [yes, one] = [|ticks| (2, Value::Bool(true), ticks), |ticks| (3, Value::Int(1), ticks)];
    let timed = |(channel, value, ticks)| within(channel, value, ticks);
    let cases = [
        (timed(yes(2)), timed(one(2)), true),
        (timed(yes(2)), timed(one(4)), false),
        (timed(yes(4)), timed(one(2)), false),
        (timed(yes(3)), timed(one(3)).negated(), false),
    ];
    let mut tally = Tally::default();
    for (first, second, is_graph) in cases {
        let formula = asks.clone().implies(Formula::Or(vec![first, second])).always();
        let monitor = ScopeMonitor::new("p", formula.clone(), &topology).expect("small");
        assert_eq!(monitor.method() == Method::Graph, is_graph, "{formula:#?}");
        for seed in 0..60 {
            let sequence = random_sequence(&mut Dice(seed), &topology, 24);
            let pair = Pair::new(seed, formula.clone(), sequence, &topology);
            check(&pair, 30, &mut tally).unwrap_or_else(|what| panic!("{what}\n{pair}"));
        }
    }
    assert!(tally.settled > 30, "{tally:?}");
}

/// A clause that remembers very many last messages would need a large table; an automaton over the possible messages is
/// smaller.
#[test]
fn a_graph_with_too_many_states_is_left_to_an_automaton() {
    let topology = topology();
    let equals = |channel, field: usize, value: Value| {
        let condition = MessageCondition::Compare { field: field.into(), relation: Relation::Equal, value };
        Formula::Event(monitors::EventAtom {
            channel: topology.channels().nth(channel).expect("four channels"),
            condition,
        })
    };
    let method = |levels: u32, numbers: i64| {
        let words = ["w", "x", "y", "z"].map(|word| equals(0, 1, Value::symbol(word)));
        let levels = (0..levels).map(|level| equals(1, 2, Value::Real(level.into())));
        let numbers = (0..numbers).map(|number| equals(3, 1, Value::Int(number)));
        let any = Formula::Or(words.into_iter().chain(levels).chain(numbers).collect());
        ScopeMonitor::new("p", any.always(), &topology).expect("small").method()
    };
    assert_eq!(method(4, 4), Method::Graph);
    assert!(matches!(method(5, 4), Method::Automaton { states } if states < 500), "{:?}", method(5, 4));
}

/// Two clauses of the present that check the same last message: it must be remembered for both.
#[test]
fn a_message_that_two_clauses_check_is_remembered_for_both() {
    let topology = topology();
    let level = |relation, value: f64| MessageCondition::Compare { field: 2.into(), relation, value: value.into() };
    let high = monitors::EventAtom {
        channel: topology.channels().nth(1).expect("B → C"),
        condition: level(Relation::Greater, 50.0),
    };
    let on = |channel, value: Value| monitors::EventAtom {
        channel: topology.channels().nth(channel).expect("four channels"),
        condition: MessageCondition::Compare { field: 1.into(), relation: Relation::Equal, value },
    };
    let (x, yes) = (on(0, Value::symbol("x")), on(2, Value::Bool(true)));
    let either =
        |other: &monitors::EventAtom| Formula::Or(vec![Formula::Event(high.clone()), Formula::Event(other.clone())]);
    let formula = Formula::And(vec![either(&x), either(&yes)]).always();
    let mut monitor = ScopeMonitor::new("p", formula, &topology).expect("small");
    assert_eq!(monitor.method(), Method::Graph);
    let received = |event: &monitors::EventAtom, fields: Vec<Value>| EventKind::Received {
        channel: event.channel,
        message: Message::new(fields),
    };
    let ok = Value::symbol("ok");
    for kind in [
        received(&high, vec![ok.clone(), Value::Real(80.0)]),
        received(&x, vec![Value::symbol("y")]),
        received(&yes, vec![Value::Bool(false)]),
    ] {
        monitor.observe(&support::event(0, 0, kind));
        assert_eq!(monitor.verdict(), Verdict::Inconclusive);
    }
    monitor.observe(&support::event(1, 0, received(&high, vec![ok, Value::Real(20.0)])));
    assert_eq!(monitor.verdict(), Verdict::False);
}

#[test]
#[ignore = "long: .ci/run runs it"]
fn longer_bounds_and_sequences_agree_too() {
    let topology = topology();
    let mut tally = Tally::default();
    for seed in 0..cases(400) {
        let mut dice = Dice(seed + 3_000_000);
        let formula = stretched(&random_formula(&mut dice, &topology, 2), 5);
        let sequence = random_sequence(&mut dice, &topology, 70);
        let pair = Pair::new(seed, formula, sequence, &topology);
        check(&pair, 30, &mut tally).unwrap_or_else(|what| panic!("{what}\n{pair}"));
    }
}

/// `always (a implies time_until b < theta)` for each pair of events.
fn answers(pairs: &[[monitors::EventAtom; 2]], theta: u64) -> Formula {
    let rule = |[asks, answer]: &[monitors::EventAtom; 2]| {
        let answered = Formula::TimeUntil { event: answer.clone(), bound: Bound::new(Relation::Less, theta) };
        Formula::Event(asks.clone()).implies(answered).always()
    };
    Formula::And(pairs.iter().map(rule).collect())
}

/// Two distant deadlines would need an automaton of more than ten thousand states. The two graphs side by side do not;
/// they are never wrong, but not always early.
#[test]
fn a_formula_too_large_for_an_automaton_is_monitored_without_one() {
    let topology = topology();
    let mut dice = Dice(7);
    let mut on = |channel| loop {
        let event = random_event(&mut dice, &topology);
        if Some(event.channel) == topology.channels().nth(channel) {
            break event;
        }
    };
    let pairs = [[on(0), on(1)], [on(2), on(3)]];
    let small = ScopeMonitor::new("small", answers(&pairs, 5), &topology).expect("small");
    assert!(matches!(small.method(), Method::Automaton { states } if states < 100) && small.method().anticipates());
    let large = ScopeMonitor::new("large", answers(&pairs, 5_000), &topology).expect("small");
    assert!(large.method() == Method::Graphs && !large.method().anticipates());
    let exactly = Formula::TimeUntil { event: pairs[0][1].clone(), bound: Bound::new(Relation::Equal, 50) };
    let exactly = Formula::Event(pairs[0][0].clone()).implies(exactly).always();
    let exactly = ScopeMonitor::new("exactly", exactly, &topology).expect("small");
    assert!(exactly.method() == Method::Progression && !exactly.method().anticipates());
}

/// Distant deadlines cost no more memory than near ones, and are exact to the tick.
#[test]
fn a_distant_deadline_is_exact_to_the_tick() {
    let topology = topology();
    let mut dice = Dice(1);
    let event = random_event(&mut dice, &topology);
    for (relation, ticks, last_chance) in [(Relation::Less, 5_000, 4_999), (Relation::LessOrEqual, 5_000, 5_000)] {
        let answer = Formula::TimeUntil { event: event.clone(), bound: Bound::new(relation, ticks) };
        let recurs = ScopeMonitor::new("recurs", answer.always(), &topology).expect("small");
        let mut monitor = recurs;
        assert_eq!(monitor.method(), Method::Graph);
        for tick in 0..=last_chance {
            monitor.observe(&support::event(tick, tick, EventKind::Tick));
            assert_eq!(monitor.verdict(), Verdict::Inconclusive, "tick {tick}");
        }
        monitor.observe(&support::event(last_chance + 1, last_chance + 1, EventKind::Tick));
        assert_eq!(monitor.verdict(), Verdict::False);
    }
}

/// A clause fails at a position or not, whatever failed before, and each deadline is missed once.
#[test]
fn every_deadline_that_is_missed_is_found_with_its_times() {
    let pairs = cases(2_000);
    let tally = agree(Class::Missed, 0, pairs, 20, 3);
    assert!(tally.again > pairs, "{tally}");
}

/// Random formulas that always hold, on long sequences.
#[test]
fn every_violation_is_found_and_lasts_until_the_property_holds_again() {
    let topologies = Topologies::new();
    let mut tally = Tally::default();
    for class in [Class::Small, Class::Back, Class::Values] {
        for seed in 0..cases(1_500) {
            let mut pair = topologies.pair(class, seed, 25);
            pair.formula = pair.formula.always();
            if Definition::new(&pair.formula, &pair.topology).violations(&pair.sequence).is_some() {
                check(&pair, 1, &mut tally).unwrap_or_else(|what| panic!("{class}: {what}\n{pair}"));
            }
        }
    }
    assert!(tally.again * 10 > cases(1_500), "{tally}");
}
