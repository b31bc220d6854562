//! The laws of logic, as properties of the oracle.

use channels::{ChannelId, Event, EventKind, Topology};
use monitors::{Formula, holds};

use crate::cases::cases;
use crate::support::{Dice, formula_over, random_event, random_formula, random_sequence, topology};

/// Random operands, and a random sequence that begins with a tick as runs do.
fn for_random(usual: u64, law: impl Fn(&[Formula; 3], &[Event], &Topology) -> Result<(), String>) {
    let topology = topology();
    for seed in 0..cases(usual) {
        let mut dice = Dice(seed + 77_000_000);
        let operands = [(); 3].map(|()| random_formula(&mut dice, &topology, 2));
        let length = dice.roll(14) as usize;
        let mut sequence = random_sequence(&mut dice, &topology, length);
        if let Some(first) = sequence.first_mut() {
            first.kind = EventKind::Tick;
        }
        if let Err(what) = law(&operands, &sequence, &topology) {
            panic!("seed {seed}: {what}\n{operands:#?}\n{sequence:#?}");
        }
    }
}

fn equal(name: &str, a: &Formula, b: &Formula, sequence: &[Event]) -> Result<(), String> {
    let [left, right] = [a, b].map(|formula| holds(formula, sequence).expect("small"));
    if left == right { Ok(()) } else { Err(format!("{name}: {left} and {right}\n{a:?}\n{b:?}")) }
}

fn and(a: &Formula, b: &Formula) -> Formula {
    Formula::And(vec![a.clone(), b.clone()])
}

fn or(a: &Formula, b: &Formula) -> Formula {
    Formula::Or(vec![a.clone(), b.clone()])
}

fn not(a: &Formula) -> Formula {
    a.clone().negated()
}

fn eventually(a: &Formula) -> Formula {
    Formula::Eventually(Box::new(a.clone()))
}

fn always(a: &Formula) -> Formula {
    a.clone().always()
}

fn until(a: &Formula, b: &Formula) -> Formula {
    Formula::Until(Box::new(a.clone()), Box::new(b.clone()))
}

fn next(a: &Formula) -> Formula {
    Formula::Next(Box::new(a.clone()))
}

fn implies(a: &Formula, b: &Formula) -> Formula {
    a.clone().implies(b.clone())
}

/// Pairs of formulas that are equal by a Boolean law.
fn rewritings([a, b, c]: &[Formula; 3]) -> Vec<(&'static str, Formula, Formula)> {
    vec![
        ("double negation", not(&not(a)), a.clone()),
        ("De Morgan, and", not(&and(a, b)), or(&not(a), &not(b))),
        ("De Morgan, or", not(&or(a, b)), and(&not(a), &not(b))),
        ("commuted and", and(a, b), and(b, a)),
        ("commuted or", or(a, b), or(b, a)),
        ("associated and", and(a, &and(b, c)), and(&and(a, b), c)),
        ("distributed and", and(a, &or(b, c)), or(&and(a, b), &and(a, c))),
        ("distributed or", or(a, &and(b, c)), and(&or(a, b), &or(a, c))),
        ("absorbed and", and(a, &or(a, b)), a.clone()),
        ("absorbed or", or(a, &and(a, b)), a.clone()),
        ("idempotent and", and(a, a), a.clone()),
        ("idempotent or", or(a, a), a.clone()),
        ("implication", implies(a, b), or(&not(a), b)),
        ("contraposition", implies(a, b), implies(&not(b), &not(a))),
        ("currying", implies(&and(a, b), c), implies(a, &implies(b, c))),
        ("true and", and(a, &Formula::True), a.clone()),
        ("false or", or(a, &Formula::False), a.clone()),
        ("false and", and(a, &Formula::False), Formula::False),
        ("not true", not(&Formula::True), Formula::False),
    ]
}

/// A formula without constants over events of two of the four channels: the first two, or the others.
fn random_formula_over_half(dice: &mut Dice, topology: &Topology, first_half: bool, depth: u32) -> Formula {
    let channels: Vec<ChannelId> = topology.channels().collect();
    let half = if first_half { &channels[..2] } else { &channels[2..] };
    loop {
        let events: Vec<monitors::EventAtom> = (0..3).map(|_| random_event(dice, topology)).collect();
        if events.iter().all(|event| half.contains(&event.channel)) {
            let formula = formula_over(dice, &events, depth);
            let text = format!("{formula:?}");
            if !text.contains("True") && !text.contains("False") {
                return formula;
            }
        }
    }
}

#[test]
#[ignore = "long: .ci/run runs it"]
fn boolean_rewritings_change_nothing_under_any_operator() {
    for_random(1_500, |operands, sequence, _| {
        for (name, left, right) in rewritings(operands) {
            equal(name, &left, &right, sequence)?;
            equal(name, &always(&left), &always(&right), sequence)?;
            equal(name, &eventually(&left), &eventually(&right), sequence)?;
            equal(name, &next(&left), &next(&right), sequence)?;
            equal(name, &until(&left, &operands[2]), &until(&right, &operands[2]), sequence)?;
            equal(name, &until(&operands[2], &left), &until(&operands[2], &right), sequence)?;
        }
        Ok(())
    });
}

#[test]
fn temporal_operators_have_duals() {
    for_random(4_000, |[a, b, _], sequence, _| {
        equal("dual always", &not(&always(a)), &eventually(&not(a)), sequence)?;
        equal("dual eventually", &not(&eventually(a)), &always(&not(a)), sequence)?;
        equal("eventually is until", &eventually(a), &until(&Formula::True, a), sequence)?;
        // Connectives outside all operators combine verdicts.
        let [left, right] = [a, b].map(|formula| holds(&always(formula), sequence).expect("small"));
        let [both, either] =
            [and(&always(a), &always(b)), or(&always(a), &always(b))].map(|f| holds(&f, sequence).expect("small"));
        if (both, either) == (left && right, left || right) { Ok(()) } else { Err("connectives".to_owned()) }
    });
}

/// A clause that another subsumes is dropped: `always ((a or b) and a)` is `always a`. So the law holds if no clause of
/// one operand subsumes a clause of the other, for instance if they are over different channels. One direction of it
/// always holds.
#[test]
fn always_distributes_over_and_with_its_dual() {
    let topology = topology();
    for seed in 0..cases(4_000) {
        let mut dice = Dice(seed + 99_000_000);
        let mut half = |first| random_formula_over_half(&mut dice, &topology, first, 2);
        let (a, b, c) = (half(true), half(false), half(true));
        let length = dice.roll(14) as usize;
        let mut sequence = random_sequence(&mut dice, &topology, length);
        if let Some(first) = sequence.first_mut() {
            first.kind = EventKind::Tick;
        }
        let laws = [
            ("always and", always(&and(&a, &b)), and(&always(&a), &always(&b))),
            ("eventually or", eventually(&or(&a, &b)), or(&eventually(&a), &eventually(&b))),
            ("left of until", until(&and(&a, &b), &c), and(&until(&a, &c), &until(&b, &c))),
            ("right of until", until(&c, &or(&a, &b)), or(&until(&c, &a), &until(&c, &b))),
        ];
        for (name, left, right) in laws {
            equal(name, &left, &right, &sequence).unwrap_or_else(|what| panic!("seed {seed}: {what}\n{sequence:#?}"));
        }
    }
    for_random(4_000, |[a, b, _], sequence, _| {
        let [apart, together] =
            [and(&always(a), &always(b)), always(&and(a, b))].map(|f| holds(&f, sequence).expect("small"));
        if apart && !together { Err("always f and always g without always (f and g)".to_owned()) } else { Ok(()) }
    });
}

#[test]
fn always_and_eventually_are_idempotent_where_they_are_checked() {
    for_random(4_000, |[a, ..], sequence, _| {
        // `always always a` checks its inner `always` at ticks; from the first tick on, that is the whole run.
        equal("always always", &always(&always(a)), &always(a), sequence)?;
        equal("eventually eventually", &eventually(&eventually(a)), &eventually(a), sequence)
    });
}

#[test]
fn removing_an_unmentioned_channel_changes_nothing() {
    for_random(4_000, |[a, ..], sequence, topology| {
        let text = format!("{a:?}");
        let mentioned = |event: &Event| match &event.kind {
            EventKind::Tick => true,
            EventKind::Received { channel, .. } => text.contains(&format!("{channel:?}")),
        };
        let fewer: Vec<Event> = sequence.iter().filter(|event| mentioned(event)).cloned().collect();
        assert_eq!(topology.channels().count(), 4);
        let [all, some] = [sequence, &fewer].map(|sequence| holds(a, sequence).expect("small"));
        if all == some { Ok(()) } else { Err(format!("{all} with all channels, {some} without")) }
    });
}
