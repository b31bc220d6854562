//! The patterns against definitions that look at the messages alone.

use std::ops::Range;
use std::time::Duration;

use channels::{Capacity, ChannelId, Domain, EventKind, FieldKind, Message, Shape, Topology, Value};
use monitors::{Pattern, PatternEvents, Scope, holds};

use crate::support::{Dice, event};

const LETTERS: [&str; 5] = ["p", "s", "q", "r", "other"];

/// A run of messages: the channel and the symbol of each.
type Word = Vec<(usize, &'static str)>;

/// Which channel each of P, S, Q and R is on.
type Places = [usize; 4];

/// The positions in a word at which each of P, S, Q and R occurs.
fn occurrences(word: &Word, places: Places) -> [Vec<usize>; 4] {
    [0, 1, 2, 3].map(|event| (0..word.len()).filter(|at| word[*at] == (places[event], LETTERS[event])).collect())
}

/// The scopes of a word, each with the positions in it.
fn scopes(scope: Scope, q: &[usize], r: &[usize], end: usize) -> Vec<Range<usize>> {
    let next = |after: usize| r.iter().copied().find(|at| *at > after);
    match scope {
        Scope::Globally => std::iter::once(0..end).collect(),
        Scope::Before => r.first().map(|r| 0..*r).into_iter().collect(),
        Scope::After => q.first().map(|q| *q..end).into_iter().collect(),
        Scope::Between => q.iter().filter_map(|q| Some(*q..next(*q)?)).collect(),
        Scope::AfterUntil => q.iter().map(|q| *q..next(*q).unwrap_or(end)).collect(),
    }
}

/// Whether a word is as a pattern requires.
fn is_met(pattern: Pattern, scope: Scope, word: &Word, places: Places) -> bool {
    let [p, s, q, r] = occurrences(word, places);
    scopes(scope, &q, &r, word.len()).into_iter().all(|scope| {
        let in_scope = |all: &[usize]| all.iter().copied().filter(|at| scope.contains(at)).collect::<Vec<_>>();
        let (p, s) = (in_scope(&p), in_scope(&s));
        match pattern {
            Pattern::Absence => p.is_empty(),
            Pattern::Existence => !p.is_empty(),
            Pattern::Universality => scope.clone().all(|at| word[at].0 != places[0] || p.contains(&at)),
            Pattern::Precedence => p.first().is_none_or(|p| s.first().is_some_and(|s| s < p)),
            Pattern::Response => p.iter().all(|p| s.iter().any(|s| s > p)),
        }
    })
}

#[test]
fn patterns_mean_what_their_definitions_say_of_the_messages() {
    let mut topology = Topology::default();
    let receiver = topology.process("Receiver").expect("a new process");
    let channels: Vec<ChannelId> = (0..4)
        .map(|number| {
            let sender = topology.process(&format!("Sender{number}")).expect("a new process");
            let domain = Domain::new([Shape::new([("word", FieldKind::symbols(LETTERS))])]);
            topology.channel(sender, receiver, Capacity::One, domain).expect("a new channel")
        })
        .collect();
    let mut dice = Dice(3);
    let mut met = [0_usize; 2];
    for round in 0..400 {
        // Each on its own channel, and any on the same one.
        let places = if round % 2 == 0 { [0, 1, 2, 3] } else { [0; 4].map(|_| dice.roll(4) as usize) };
        let written: Vec<String> =
            (0..4).map(|event| format!("(Sender{}, Receiver, word = <{}>)", places[event], LETTERS[event])).collect();
        let events = PatternEvents { p: &written[0], s: &written[1], q: &written[2], r: &written[3] };
        for (pattern, scope) in Pattern::ALL.into_iter().flat_map(|pattern| Scope::ALL.map(|scope| (pattern, scope))) {
            if pattern == Pattern::Universality && places[2..].contains(&places[0]) {
                continue;
            }
            let text = format!("property p := {}", pattern.formula(scope, events));
            let formulas = monitors::formulas("p.scope", &text, &topology, Duration::from_secs(1));
            let formula = formulas.unwrap_or_else(|error| panic!("{text}: {:?}", error.problems())).remove(0).1;
            for _ in 0..12 {
                let word: Word = (0..dice.roll(9)).map(|_| (dice.roll(4) as usize, *dice.pick(&LETTERS))).collect();
                let received = word.iter().zip(0..).map(|((channel, letter), step)| {
                    let message = Message::new([Value::symbol(letter)]);
                    event(step, 0, EventKind::Received { channel: channels[*channel], message })
                });
                let sequence: Vec<_> = received.collect();
                let expected = is_met(pattern, scope, &word, places);
                met[usize::from(expected)] += 1;
                assert_eq!(holds(&formula, &sequence).expect("it is small"), expected, "{text} {word:?}");
            }
        }
    }
    assert!(met.iter().all(|times| *times > 10_000), "{met:?}");
}
