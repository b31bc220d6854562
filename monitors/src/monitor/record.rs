//! The messages that a monitor remembers in order to explain its verdict: the last one on each channel, and those that
//! caused an obligation.

use std::collections::BTreeSet;

use channels::{Event, EventKind, Topology, Verdict};

use crate::clause::{Bound, EventId, Form, Literal, Part, bounds};
use crate::describe;
use crate::engine::{Anticipation, Clause, CompactRun, Letter, Obligation, Operators};
use crate::monitor::witness::{EventTime, OpenObligation, Sighting, Witness};
use crate::synthesis::{RunningMonitor, Synthesis};

/// A state of the run, with everything needed to describe it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Told<'a> {
    pub(crate) event: &'a Event,
    pub(crate) synthesis: &'a Synthesis,
    pub(crate) topology: &'a Topology,
    /// τ at the first state.
    pub(crate) start: u64,
}

#[derive(Clone, Debug)]
pub(crate) struct Record {
    /// The last message on each channel that the formula mentions.
    messages: Vec<Event>,
    /// The events of the formula that the last messages satisfy.
    last: u64,
    /// For each rule, or for the formula as a whole: the messages that caused its pending obligation, if any.
    causes: Vec<Option<Vec<Event>>>,
    witness: Option<Box<Witness>>,
}

impl Record {
    pub(crate) fn new(synthesis: &Synthesis) -> Self {
        let rules = synthesis.rules().map_or(1, |compact| compact.rules().len().max(1));
        Self { messages: Vec::new(), last: 0, causes: vec![None; rules], witness: None }
    }

    /// The events of the formula that the last messages satisfy.
    pub(crate) fn last(&self) -> u64 {
        self.last
    }

    pub(crate) fn witness(&self) -> Option<&Witness> {
        self.witness.as_deref()
    }

    /// Notes a message.
    pub(crate) fn see(&mut self, event: &Event, letter: Letter) {
        self.last = letter.after(self.last);
        if let Some(channel) = channel(event) {
            match self.messages.iter_mut().find(|known| self::channel(known) == Some(channel)) {
                Some(known) => known.clone_from(event),
                None => self.messages.push(event.clone()),
            }
        }
    }

    /// Notes why a formula that no run can satisfy is violated, in the very first state.
    pub(crate) fn doom(&mut self, told: &Told) {
        self.witness = Some(Box::new(self.explain(None, told)));
    }

    /// Notes which obligations began or ended, and why a verdict was reached. `rules` are the clauses of a machine that
    /// does not distinguish them.
    pub(crate) fn follow(&mut self, told: &Told, run: &RunningMonitor, rules: Option<&CompactRun>, verdict: Verdict) {
        let rules = match run {
            RunningMonitor::Compact(run) => Some(run),
            _ => rules,
        };
        match rules {
            Some(rules) => {
                for rule in 0..rules.compact().rules().len() {
                    let clause = &rules.compact().rules()[rule].clause;
                    self.note_cause(rule, rules.is_armed(rule), |record| record.of_clause(clause, told));
                }
            }
            None => {
                self.note_cause(0, verdict == Verdict::False || !run.holds(), |record| record.everything(told.event))
            }
        }
        if verdict == Verdict::False {
            let witness = match rules {
                Some(rules) => match rules.broken() {
                    Some(rule) => self.blame(rule, &rules.compact().rules()[rule].clause, told),
                    None => self.contradiction(rules, told),
                },
                None => self.explain(run.missed(), told),
            };
            self.witness = Some(Box::new(witness));
        }
    }

    fn note_cause(&mut self, rule: usize, owed: bool, cause: impl FnOnce(&Self) -> Vec<Event>) {
        if !owed {
            self.causes[rule] = None;
        } else if self.causes[rule].is_none() {
            self.causes[rule] = Some(cause(self));
        }
    }

    /// The last messages on a clause's own channels; the event itself if it has none.
    fn of_clause(&self, clause: &Part, told: &Told) -> Vec<Event> {
        let own = crate::clause::own_channels(clause, &told.synthesis.vocabulary);
        if own.is_empty() {
            return vec![told.event.clone()];
        }
        let own = self.messages.iter().filter(|message| channel(message).is_some_and(|channel| own.contains(&channel)));
        sorted(own.cloned().collect())
    }

    fn everything(&self, event: &Event) -> Vec<Event> {
        let mut events = self.messages.clone();
        if channel(event).is_none() {
            events.push(event.clone());
        }
        sorted(events)
    }

    /// Why a formula without distinguishable clauses is violated: the messages when an obligation began, the last
    /// messages, and what did not come in time.
    fn explain(&self, missed: Option<&Clause>, told: &Told) -> Witness {
        let words = &told.synthesis.vocabulary;
        let cause = self.causes[0].clone().unwrap_or_default();
        let deadline = missed.and_then(|clause| clause.iter().filter_map(end).max());
        let since = match missed.map(Vec::as_slice) {
            // The missed obligation need not be the first pending one: its window tells.
            Some([Obligation::Passes { event, last, .. }]) => {
                let window = length(&told.synthesis.form, *event);
                let begun = window.and_then(|window| last.checked_sub(window)).map(|tick| tick + told.start);
                cause.last().filter(|first| Some(first.tick) == begun)
            }
            Some(_) => None,
            None => cause.last(),
        };
        let missing: Vec<String> = missed.into_iter().flatten().filter_map(|owed| name(owed, told)).collect();
        let mut messages = cause.clone();
        messages.extend(self.everything(told.event).into_iter().filter(|event| !cause.contains(event)));
        Witness {
            clause: describe::form(&told.synthesis.form, words, told.topology),
            since: since.map(EventTime::of),
            messages: sightings(&sorted(messages), told.topology),
            deadline_tick: deadline.map(|tick| tick.saturating_add(told.start)),
            missing: (!missing.is_empty()).then(|| missing.join(" or ")),
            settled: EventTime::of(told.event),
        }
    }

    /// Why no continuation can meet all clauses although none of them is violated yet: the clauses that contradict each
    /// other.
    fn contradiction(&self, rules: &CompactRun, told: &Told) -> Witness {
        let known = rules.compact().rules();
        let core = self.contradicting(rules, told.synthesis);
        let clauses: Form = core.iter().map(|rule| known[*rule].clause.clone()).collect();
        let causes = core.iter().filter_map(|rule| self.causes[*rule].as_ref());
        let since = causes.clone().filter_map(|cause| cause.last()).min_by_key(|event| (event.step, event.tick));
        let mut messages: Vec<Event> = Vec::new();
        for event in causes.flatten() {
            if !messages.contains(event) {
                messages.push(event.clone());
            }
        }
        let due = rules.owed().filter(|(rule, _)| core.contains(rule)).map(|(_, due)| due).min();
        Witness {
            clause: describe::form(&clauses, &told.synthesis.vocabulary, told.topology),
            since: since.map(EventTime::of),
            messages: sightings(&sorted(messages), told.topology),
            deadline_tick: due.map(|due| told.start.saturating_add(due).saturating_sub(1)),
            missing: None,
            settled: EventTime::of(told.event),
        }
    }

    /// A minimal set of rules that contradict each other now: without any one of them, the others can still be met.
    fn contradicting(&self, rules: &CompactRun, synthesis: &Synthesis) -> Vec<usize> {
        let known = rules.compact().rules();
        let always = |rule: &usize| {
            let hold = Form::from([known[*rule].clause.clone()]);
            Part::from([Literal::Release { escape: Form::new(), hold }])
        };
        let can_be_kept = |kept: &[usize]| {
            let form: Form = kept.iter().map(always).collect();
            let operators = Operators::new(&form, &synthesis.vocabulary, &synthesis.alphabet);
            let owed = operators.going().and(rules.begun(kept));
            let possible = Anticipation::new(&operators, &synthesis.alphabet, true).possible(&[(&owed, self.last)]);
            possible.map_or(true, |possible| possible[0])
        };
        let mut core: Vec<usize> = (0..known.len()).collect();
        for rule in 0..known.len() {
            let fewer: Vec<usize> = core.iter().copied().filter(|kept| *kept != rule).collect();
            if !can_be_kept(&fewer) {
                core = fewer;
            }
        }
        core
    }

    /// Why a clause is violated.
    fn blame(&self, rule: usize, clause: &Part, told: &Told) -> Witness {
        let &Told { event, synthesis, topology, start } = told;
        let words = &synthesis.vocabulary;
        let mut messages = self.causes[rule].clone().unwrap_or_else(|| self.of_clause(clause, told));
        let since = messages.last().cloned();
        let window = clause.iter().find_map(|literal| match literal {
            Literal::Time { bound, holds, .. } => bound.end().map(|end| (end, *holds)),
            _ => None,
        });
        let due = |last: u64| since.as_ref().map(|event| event.tick.max(start).saturating_add(last));
        let awaited = window.filter(|(_, holds)| *holds);
        if channel(event).is_some() && awaited.is_none() && !messages.contains(event) {
            messages.push(event.clone());
        }
        let missing: Vec<String> =
            describe::answers(clause).map(|answer| describe::event(words.get(answer), topology)).collect();
        Witness {
            clause: describe::clause(clause, words, topology),
            since: since.as_ref().map(EventTime::of),
            messages: sightings(&messages, topology),
            deadline_tick: awaited.and_then(|(last, _)| due(last)),
            // If a clause has a single literal, the clause itself is what is missing.
            missing: (clause.len() > 1 && !missing.is_empty()).then(|| missing.join(" or ")),
            settled: EventTime::of(event),
        }
    }

    /// The pending obligation of a rule, or of the formula as a whole.
    pub(crate) fn open(&self, rule: usize, what: String, until_tick: Option<u64>) -> OpenObligation {
        let since = self.causes.get(rule).and_then(Option::as_ref).and_then(|cause| cause.last()).map(EventTime::of);
        OpenObligation { what, since, until_tick }
    }
}

/// The last tick at which an obligation can be met.
fn end(obligation: &Obligation) -> Option<u64> {
    match obligation {
        Obligation::Passes { last, .. } => Some(*last),
        _ => None,
    }
}

/// The event that an obligation waits for.
fn name(obligation: &Obligation, told: &Told) -> Option<String> {
    match obligation {
        Obligation::Passes { event, .. } => Some(describe::event(told.synthesis.vocabulary.get(*event), told.topology)),
        _ => None,
    }
}

/// The length, in ticks, of the windows of a timed event; `None` if they differ.
fn length(form: &Form, event: EventId) -> Option<u64> {
    let mut ends: BTreeSet<u64> = bounds(form, event).into_iter().filter_map(Bound::end).collect();
    ends.pop_first().filter(|_| ends.is_empty())
}

fn sightings(events: &[Event], topology: &Topology) -> Vec<Sighting> {
    events.iter().filter_map(|event| Sighting::of(event, topology)).collect()
}

fn channel(event: &Event) -> Option<channels::ChannelId> {
    match &event.kind {
        EventKind::Received { channel, .. } => Some(*channel),
        EventKind::Tick => None,
    }
}

fn sorted(mut events: Vec<Event>) -> Vec<Event> {
    events.sort_by_key(|event| (event.step, event.tick));
    events
}
