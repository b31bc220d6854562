//! The checks of one pair of a formula and a sequence.

use std::time::Duration;

use channels::{Event, EventKind, Monitor, Verdict};
use monitors::{Choice, Continuation, Limits, Method, ScopeMonitor, Violation, holds, holds_endlessly};

use super::classes::Pair;
use super::definition::{Definition, order_of};
use super::tally::{Late, Tally};
use super::{Dice, continued, next_states, random_continuation};

/// A pair with everything that its checks need.
struct Checked<'a> {
    pair: &'a Pair,
    definition: Definition,
    /// Letters for continuations: those that the monitors know, those of the sequence, and others that neither has.
    alphabet: Vec<EventKind>,
    words: u64,
}

/// Checks all machines for a formula against the definition at every prefix of a sequence, and adds to the tally.
///
/// # Errors
/// What is wrong.
pub(crate) fn check(pair: &Pair, words: u64, tally: &mut Tally) -> Result<(), String> {
    let Pair { formula, sequence, topology, messages, limits, .. } = pair;
    let make = |limits, choice| ScopeMonitor::within(limits, "random", formula.clone(), topology, choice);
    let Ok(mut best) = make(*limits, Choice::Best) else {
        tally.refused += 1;
        return if pair.may_be_refused { Ok(()) } else { Err("the formula is refused".to_owned()) };
    };
    let [mut automaton, mut progression] = [Choice::Automaton, Choice::Progression]
        .map(|choice| make(Limits::default(), choice).expect("it is not refused"));
    // Exporting a large automaton takes longer than everything else.
    let small = !matches!(best.method(), Method::Automaton { states } if states > 30);
    let mut graph = small.then(|| best.to_graph_monitor()).flatten();
    let mut alphabet: Vec<EventKind> = automaton.samples().chain(messages.iter().cloned()).collect();
    if !automaton.method().anticipates() {
        alphabet.extend(sequence.iter().map(|event| event.kind.clone()));
    }
    alphabet.push(EventKind::Tick);
    let checked = Checked { pair, definition: Definition::new(formula, topology), alphabet, words };
    tally.begin(best.method());
    let mut before = [Verdict::Inconclusive; 3];
    let mut late = Late::new(formula);
    for length in 0..=sequence.len() {
        let prefix = &sequence[..length];
        if let Some(event) = prefix.last() {
            for monitor in [&mut best as &mut dyn Monitor, &mut automaton, &mut progression] {
                monitor.observe(event);
            }
            if let Some(graph) = &mut graph {
                graph.observe(event);
            }
        }
        tally.prefixes += 1;
        let now = [best.verdict(), automaton.verdict(), progression.verdict()];
        let place = |what: &str| Err(format!("{what} after {length} states: {now:?}"));
        if before.iter().zip(&now).any(|(before, now)| *before != Verdict::Inconclusive && before != now) {
            return place("a verdict changed");
        }
        let truth = checked.definition.holds(prefix);
        if holds(formula, prefix) != Ok(truth) {
            return place(&format!("the definition gives {truth} of the run so far, and the crate's oracle does not"));
        }
        for monitor in [&best, &automaton, &progression] {
            let settled = monitor.verdict() != Verdict::Inconclusive;
            let reported = if settled { monitor.verdict() == Verdict::True } else { monitor.holds_so_far() };
            if reported != truth {
                return place(&format!(
                    "{:?} reports {reported} of the run so far, the definition {truth}",
                    monitor.method()
                ));
            }
        }
        if best.method().anticipates() && automaton.method().anticipates() && now[0] != now[1] {
            return place("graph and automaton differ");
        }
        if automaton.method().anticipates() && now[2] != Verdict::Inconclusive && now[2] != now[1] {
            return place("progression and automaton differ");
        }
        if let Some(graph) = &graph {
            // A graph cannot know that a message of the first kind can never come again.
            let same =
                graph.verdict() == now[0] || (now[0] == Verdict::True && graph.verdict() == Verdict::Inconclusive);
            let open = graph.is_open() == best.is_open();
            let from_0 = prefix.first().is_none_or(|first| first.tick == 0);
            if from_0 && (!same || !open) {
                return place(&format!("the program graph reports {:?}, open: {}", graph.verdict(), graph.is_open()));
            }
        }
        let settled = |verdicts: [Verdict; 3]| verdicts.into_iter().find(|verdict| *verdict != Verdict::Inconclusive);
        match (settled(before), settled(now)) {
            (None, Some(verdict)) => checked.is_final(prefix, verdict).or_else(|what| place(&what))?,
            (None, None) => checked.is_open(prefix, &automaton, &mut late, tally).or_else(|what| place(&what))?,
            _ => {}
        }
        late.follow(best.verdict(), settled(now));
        before = now;
    }
    tally.end(late);
    for monitor in [&best, &automaton, &progression] {
        checked.all_violations(monitor, tally)?;
    }
    Ok(())
}

impl Checked<'_> {
    /// Every violation of what always holds is found, with its times.
    fn all_violations(&self, monitor: &ScopeMonitor, tally: &mut Tally) -> Result<(), String> {
        let sequence = &self.pair.sequence;
        let Some(mut expected) = self.definition.violations(sequence) else { return Ok(()) };
        tally.again += expected.len().saturating_sub(1) as u64;
        let Some(found) = monitor.violations() else {
            let is_none = expected.is_empty() || monitor.verdict() == Verdict::Inconclusive;
            return if is_none { Ok(()) } else { Err(format!("no violations, not {expected:?}")) };
        };
        let mut all = found.first.clone();
        all.sort_by_key(order_of);
        // A violation is sometimes certain before it happens.
        let is_early = |first: &Violation| expected.first().is_none_or(|happens| first.from.step < happens.from.step);
        if all.first().is_some_and(is_early) {
            let first = all.remove(0);
            let happens = expected.iter().map(|violation| violation.from).next();
            let place = expected.iter().position(|one| Some(one.from) == happens && one.until == first.until);
            if let Some(place) = place {
                expected.remove(place);
            } else if happens.is_some() || first.until.is_some() {
                return Err(format!("a violation that was certain, {first:?}, is none of {expected:?}"));
            }
        }
        if all != expected || found.count != found.first.len() as u64 {
            return Err(format!("{} violations {all:?}, not {expected:?}", found.count));
        }
        let end = sequence.last().map_or(Duration::ZERO, |last| last.time);
        let (mut lasted, mut until) = (Duration::ZERO, Duration::ZERO);
        for violation in &found.first {
            let to = violation.until.map_or(end, |until| until.time);
            lasted += to.saturating_sub(violation.from.time.max(until));
            until = until.max(to);
        }
        if found.lasting(end) == lasted {
            Ok(())
        } else {
            Err(format!("lasting {:?}, not {lasted:?}", found.lasting(end)))
        }
    }

    fn holds(&self, prefix: &[Event], Continuation { stem, cycle }: &Continuation) -> bool {
        self.definition.holds_endlessly(&continued(prefix, stem), cycle)
    }

    /// The same, if the crate's oracle agrees.
    fn holds_like_the_oracle(&self, prefix: &[Event], word: &Continuation) -> Result<bool, String> {
        let truth = self.holds(prefix, word);
        let oracle = holds_endlessly(&self.pair.formula, &continued(prefix, &word.stem), &word.cycle);
        if oracle == Ok(truth) { Ok(truth) } else { Err(format!("the definition gives {truth} of {word:?}")) }
    }

    /// Whether all continuations of up to `depth` states have this outcome.
    fn all_continuations(&self, sequence: &[Event], depth: u32, outcome: bool) -> bool {
        self.definition.holds(sequence) == outcome
            && (depth == 0
                || next_states(sequence, &self.alphabet)
                    .into_iter()
                    .all(|next| self.all_continuations(&continued(sequence, &[next]), depth - 1, outcome)))
    }

    /// Checks that a new verdict holds on all continuations.
    fn is_final(&self, prefix: &[Event], verdict: Verdict) -> Result<(), String> {
        let outcome = verdict == Verdict::True;
        let depth = if self.alphabet.len() > 16 { 1 } else { 2 };
        if !self.all_continuations(prefix, depth, outcome) {
            return Err(format!("a continuation does not give {outcome}"));
        }
        let mut dice = Dice(self.pair.seed + prefix.len() as u64);
        for number in 0..self.words {
            let word = random_continuation(&mut dice, prefix, &self.alphabet);
            let truth =
                if number == 0 { self.holds_like_the_oracle(prefix, &word)? } else { self.holds(prefix, &word) };
            if truth != outcome {
                return Err(format!("{outcome} is too early for {word:?}"));
            }
        }
        Ok(())
    }

    /// Without a verdict, an automaton knows an endless word for either outcome. Without an automaton, a verdict may
    /// be late.
    fn is_open(
        &self,
        prefix: &[Event],
        automaton: &ScopeMonitor,
        late: &mut Late,
        tally: &mut Tally,
    ) -> Result<(), String> {
        if !automaton.method().anticipates() {
            late.same_outcome = self.only_outcome(prefix);
            return Ok(());
        }
        late.same_outcome = None;
        for outcome in [true, false] {
            match automaton.continuation(outcome) {
                None => late.same_outcome = Some(!outcome),
                Some(word) if self.holds_like_the_oracle(prefix, &word)? != outcome => {
                    return Err(format!("the continuation {word:?} does not lead to {outcome}"));
                }
                Some(word) => tally.endless += u64::from(!word.cycle.is_empty()),
            }
        }
        Ok(())
    }

    /// The outcome of all continuations that are tried, if it is one.
    fn only_outcome(&self, prefix: &[Event]) -> Option<bool> {
        let outcome = self.definition.holds(prefix);
        let mut dice = Dice(self.pair.seed + prefix.len() as u64);
        let mut words = (0..self.words.max(30)).map(|_| random_continuation(&mut dice, prefix, &self.alphabet));
        let is_only =
            words.all(|word| self.holds(prefix, &word) == outcome) && self.all_continuations(prefix, 1, outcome);
        is_only.then_some(outcome)
    }
}
