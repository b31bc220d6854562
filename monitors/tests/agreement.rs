//! Every monitor agrees with the oracle on every prefix of random sequences.

use channels::{EventKind, Monitor, Relation, Verdict};
use monitors::{Formula, Method, ScopeMonitor};

use crate::support::{self, Dice, Tally, check, random_event, random_formula, random_sequence, topology};

/// Ten thousand pairs, or as many as `AGREE_PAIRS` says: mutation testing takes fewer.
#[test]
fn monitors_agree_with_the_oracle_on_ten_thousand_random_pairs() {
    let topology = topology();
    let mut tally = Tally::default();
    let pairs = std::env::var("AGREE_PAIRS").ok().and_then(|pairs| pairs.parse().ok()).unwrap_or(10_000);
    for seed in 0..pairs {
        let mut dice = Dice(seed);
        let depth = 1 + seed as u32 % 3;
        let formula = random_formula(&mut dice, &topology, depth);
        let length = dice.roll(12) as usize;
        let sequence = random_sequence(&mut dice, &topology, length);
        if let Err(what) = check(&formula, &sequence, &topology, &mut tally) {
            panic!("pair {seed}: {what}\n{formula:#?}\n{sequence:#?}");
        }
    }
    let enough = [(tally.graphs, 50), (tally.automata, 2), (tally.settled, 10)];
    assert!(enough.iter().all(|(count, part)| count * part > pairs), "{tally:?}");
}

/// The formula with all bounds multiplied.
fn stretched(formula: &Formula, factor: u64) -> Formula {
    let of = |part: &Formula| Box::new(stretched(part, factor));
    let all = |parts: &[Formula]| parts.iter().map(|part| stretched(part, factor)).collect();
    match formula {
        Formula::TimeUntil { event, relation, ticks } => {
            Formula::TimeUntil { event: event.clone(), relation: *relation, ticks: ticks * factor }
        }
        Formula::Not(a) => Formula::Not(of(a)),
        Formula::Next(a) => Formula::Next(of(a)),
        Formula::Always(a) => Formula::Always(of(a)),
        Formula::Eventually(a) => Formula::Eventually(of(a)),
        Formula::And(parts) => Formula::And(all(parts)),
        Formula::Or(parts) => Formula::Or(all(parts)),
        Formula::Implies(a, b) => Formula::Implies(of(a), of(b)),
        Formula::Until(a, b) => Formula::Until(of(a), of(b)),
        atom => atom.clone(),
    }
}

#[test]
fn longer_bounds_and_sequences_agree_too() {
    let topology = topology();
    let mut tally = Tally::default();
    for seed in 0..400 {
        let mut dice = Dice(seed + 3_000_000);
        let formula = stretched(&random_formula(&mut dice, &topology, 2), 5);
        let sequence = random_sequence(&mut dice, &topology, 70);
        if let Err(what) = check(&formula, &sequence, &topology, &mut tally) {
            panic!("pair {seed}: {what}\n{formula:#?}\n{sequence:#?}");
        }
    }
}

/// Deadlines a long way off cost no more memory than near ones, and are met or missed to the tick.
#[test]
fn a_deadline_far_away_is_kept_to_the_tick() {
    let topology = topology();
    let mut dice = Dice(1);
    let event = random_event(&mut dice, &topology);
    for (relation, ticks, last_chance) in [(Relation::Less, 5_000, 4_999), (Relation::LessOrEqual, 5_000, 5_000)] {
        let answer = Formula::TimeUntil { event: event.clone(), relation, ticks };
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
