//! The messages that a monitor remembers in order to explain its verdict: the last one on each channel, and those that
//! caused an obligation.

use std::cmp::Ordering;
use std::collections::VecDeque;
use std::time::Duration;

use channels::{Event, EventKind, Topology, Verdict};
use smallvec::SmallVec;

use crate::clause::{Form, Literal, LiteralSet, trigger};
use crate::describe;
use crate::engine::{
    Anticipation, Clause, CompactRun, Letter, Memory, Obligation, Obligations, Operators, Past, State, order_at,
};
use crate::monitor::witness::{EventTime, OpenObligation, Sighting, Witness};
use crate::synthesis::{RunningMonitor, Synthesis};

/// A state of the run, with everything needed to describe it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Observation<'a> {
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
    /// Everything that matters for what comes.
    pub(crate) memory: Memory,
    /// For each operator that looks back, its bit, and the last messages at which its operand held.
    reasons: Vec<(u64, VecDeque<Event>)>,
    /// Without rules: the pending clauses in their order, each with the messages from which it began, at least one.
    begun: Vec<(Clause, Vec<Event>)>,
    /// For each rule, or for the formula as a whole: the messages that caused its pending obligation, if any.
    causes: Vec<Option<Vec<Event>>>,
    pub(crate) witness: Option<Box<Witness>>,
}

impl Observation<'_> {
    /// The tick that contains the moment `tau`, which counts from the first state.
    fn tick(&self, tau: u64) -> u64 {
        let tau = tau.saturating_add(self.start);
        if !self.synthesis.vocabulary.is_timed {
            return tau;
        }
        let before = self.event.kind == EventKind::Tick && tau < self.synthesis.vocabulary.tau(self.event);
        self.event.tick.saturating_sub(u64::from(before))
    }

    /// When the verdict was reached: at the deadline that has passed, even if nothing happened then.
    fn settled(&self, deadline: Option<u64>) -> EventTime {
        deadline.map_or(EventTime::of(self.event), |deadline| self.at(deadline))
    }

    /// A deadline that has passed, which counts from the first state: in a timed property, it may lie before this
    /// event. Otherwise, time passes only with events.
    pub(crate) fn at(&self, deadline: u64) -> EventTime {
        let mut at = EventTime::of(self.event);
        if self.synthesis.vocabulary.is_timed {
            at.time = at.time.min(Duration::from_nanos(deadline.saturating_add(self.start)));
            at.tick = self.tick(deadline);
        }
        at
    }
}

impl Record {
    pub(crate) fn new(synthesis: &Synthesis) -> Self {
        let rules = synthesis.rules.as_ref().map_or(1, |compact| compact.rules.len().max(1));
        let reasons = synthesis.past.reasons().map(|(bit, _)| (bit, VecDeque::new())).collect();
        Self {
            messages: Vec::new(),
            memory: synthesis.past.memory(),
            reasons,
            begun: Vec::new(),
            causes: vec![None; rules],
            witness: None,
        }
    }

    /// Nothing is pending, and what had been violated no longer counts.
    pub(crate) fn begin_anew(&mut self, memory: Memory) {
        self.memory = memory;
        self.begun.clear();
        self.causes.fill(None);
        self.witness = None;
    }

    /// The events of the formula that the last messages satisfy, and the operators that look back and hold.
    pub(crate) fn last(&self) -> u64 {
        self.memory.last
    }

    /// Notes a message or a tick, after τ has grown.
    pub(crate) fn see(&mut self, event: &Event, letter: Letter, past: &Past, by: u64) {
        past.advance(&mut self.memory, by);
        let begun = past.read(&mut self.memory, letter, Some(&event.kind));
        if begun != 0 && channel(event).is_some() {
            for ((bit, seen), (_, most)) in self.reasons.iter_mut().zip(past.reasons()) {
                if begun & *bit != 0 {
                    seen.push_back(event.clone());
                    seen.drain(..seen.len().saturating_sub(most));
                }
            }
        }
        self.note(event);
    }

    /// Notes the last message on its channel.
    pub(crate) fn note(&mut self, event: &Event) {
        if let Some(channel) = channel(event) {
            match self.messages.iter_mut().find(|known| self::channel(known) == Some(channel)) {
                Some(known) => known.clone_from(event),
                None => self.messages.push(event.clone()),
            }
        }
    }

    /// Notes why a formula that no run can satisfy is violated, in the very first state.
    pub(crate) fn doom(&mut self, observation: &Observation) {
        self.witness = Some(Box::new(self.explain(None, observation)));
    }

    /// Notes which rules' obligations began or ended, or when the formula ceased to hold, and why a verdict was
    /// reached. `rules` are the clauses, if they are distinguished.
    pub(crate) fn follow(
        &mut self,
        observation: &Observation,
        run: &RunningMonitor,
        rules: Option<&CompactRun>,
        verdict: Verdict,
    ) {
        match rules {
            Some(rules) => {
                for rule in 0..rules.compact.rules.len() {
                    let clause = &rules.compact.rules[rule].clause;
                    self.note_cause(rule, rules.is_armed(rule), |record| record.of_clause(clause, observation));
                }
            }
            None => {
                // Without distinguishable clauses, there is one cause: the last messages when the formula
                // ceased to hold.
                self.note_cause(0, verdict == Verdict::False || !run.holds(), |record| {
                    everything(&record.messages, observation.event)
                })
            }
        }
        if verdict == Verdict::False {
            let witness = match rules.map(|rules| (rules, rules.broken)) {
                Some((rules, Some(rule))) => self.blame(rule, &rules.compact.rules[rule].clause, observation),
                Some((rules, None)) => self.contradiction(rules, observation),
                None => self.explain(run.missed(), observation),
            };
            self.witness = Some(Box::new(witness));
        }
    }

    /// Notes the messages from which the pending clauses began: the present ones, or those of the clause that has
    /// become this one. The clauses before a verdict are kept, because they may explain it.
    pub(crate) fn note_beginnings(
        &mut self,
        observation: &Observation,
        run: &RunningMonitor,
        letter: Letter,
        now: u64,
    ) {
        let Some((owed, since)) = run.owed() else { return };
        if run.verdict() != Verdict::Inconclusive {
            return;
        }
        // Both are sorted.
        let (mut place, mut over) = (0, SmallVec::<[_; 1]>::new());
        for clause in owed.clauses() {
            let order = loop {
                let known = self.begun.get(place);
                match known.map_or(Ordering::Less, |(known, _)| order_at(clause, since, known)) {
                    Ordering::Greater => over.push(self.begun.remove(place)),
                    order => break order,
                }
            };
            if order == Ordering::Less {
                self.begun.insert(place, (clause.iter().map(|owed| owed.at(since)).collect(), Vec::new()));
            }
            place += 1;
        }
        over.extend(self.begun.drain(place..));
        if self.begun.iter().all(|(_, messages)| !messages.is_empty()) {
            return;
        }
        let operators = &observation.synthesis.operators;
        let state = State::present(letter, &self.memory, now);
        let became = |clause: Clause| operators.step(operators.advance(Obligations::any(clause), now), state);
        let over: Vec<_> = over.into_iter().map(|(clause, messages)| (became(clause), messages)).collect();
        for (clause, messages) in self.begun.iter_mut().filter(|(_, messages)| messages.is_empty()) {
            let before = over.iter().find(|(became, _)| became.clauses().contains(clause));
            *messages = match before {
                Some((_, messages)) => messages.clone(),
                None => everything(&self.messages, observation.event),
            };
        }
    }

    /// The messages from which a clause began, if it is pending.
    fn beginning(&self, clause: &Clause) -> Option<&Vec<Event>> {
        let place = self.begun.binary_search_by(|(known, _)| known.cmp(clause)).ok()?;
        Some(&self.begun[place].1)
    }

    fn note_cause(&mut self, rule: usize, owed: bool, cause: impl FnOnce(&Self) -> Vec<Event>) {
        if !owed {
            self.causes[rule] = None;
        } else if self.causes[rule].is_none() {
            self.causes[rule] = Some(cause(self));
        }
    }

    /// The last messages on a clause's own channels; the event itself if it has none.
    fn of_clause(&self, clause: &LiteralSet, observation: &Observation) -> Vec<Event> {
        let own = trigger(clause, &observation.synthesis.vocabulary).channels;
        if own.is_empty() {
            return vec![observation.event.clone()];
        }
        let own = self.messages.iter().filter(|message| channel(message).is_some_and(|channel| own.contains(&channel)));
        let mut messages: Vec<Event> = own.cloned().collect();
        if channel(observation.event).is_none() {
            messages.push(observation.event.clone());
        }
        for literal in clause {
            // Facts about the past that the clause denies.
            let denied =
                observation.synthesis.past.bit(literal).filter(|(bit, holds)| !holds && self.last() & bit != 0);
            let seen = self.reasons.iter().filter(|(bit, _)| denied.is_some_and(|(denied, _)| denied == *bit));
            messages.extend(seen.flat_map(|(_, seen)| seen.iter().cloned()));
        }
        sorted(messages)
    }

    /// Why a formula without distinguishable clauses is violated: the messages when an obligation began, the last
    /// messages, and what did not happen in time.
    fn explain(&self, missed: Option<&Clause>, observation: &Observation) -> Witness {
        let words = &observation.synthesis.vocabulary;
        let cause = missed.and_then(|missed| self.beginning(missed)).or(self.causes[0].as_ref());
        let cause = cause.cloned().unwrap_or_default();
        let deadline = missed.and_then(|clause| clause.iter().filter_map(end).max());
        let since = latest(&cause);
        let missing: Vec<String> = missed.into_iter().flatten().filter_map(|owed| name(owed, observation)).collect();
        let mut messages = cause.clone();
        messages
            .extend(everything(&self.messages, observation.event).into_iter().filter(|event| !cause.contains(event)));
        Witness {
            clause: describe::form(&observation.synthesis.form, words, observation.topology),
            since: since.map(EventTime::of),
            messages: sightings(&sorted(messages), observation.topology),
            deadline_tick: deadline.map(|last| observation.tick(last)),
            missing: (!missing.is_empty()).then(|| missing.join(" or ")),
            settled: observation
                .settled(missed.and_then(|clause| clause.iter().filter_map(Obligation::deadline).max())),
        }
    }

    /// Why no continuation can meet all clauses although none of them is violated yet: the clauses that contradict each
    /// other.
    fn contradiction(&self, rules: &CompactRun, observation: &Observation) -> Witness {
        let known = &rules.compact.rules;
        let core = self.contradicting(rules, observation.synthesis);
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
            clause: describe::form(&clauses, &observation.synthesis.vocabulary, observation.topology),
            since: since.map(EventTime::of),
            messages: sightings(&sorted(messages), observation.topology),
            deadline_tick: due.map(|due| observation.start.saturating_add(due).saturating_sub(1)),
            missing: None,
            settled: EventTime::of(observation.event),
        }
    }

    /// A minimal set of rules that contradict each other now: without any one of them, the others can still be met.
    fn contradicting(&self, rules: &CompactRun, synthesis: &Synthesis) -> Vec<usize> {
        let known = &rules.compact.rules;
        let always = |rule: &usize| {
            let hold = Form::from([known[*rule].clause.clone()]);
            LiteralSet::from([Literal::Release { escape: Form::new(), hold }])
        };
        let can_be_kept = |kept: &[usize]| {
            let form: Form = kept.iter().map(always).collect();
            let operators = Operators::new(&form, &synthesis.vocabulary, &synthesis.alphabet, &synthesis.past);
            let owed = operators.going().and(rules.begun(kept));
            let possible = Anticipation::new(&operators, &synthesis.alphabet, true).possible(&[(&owed, &self.memory)]);
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
    fn blame(&self, rule: usize, clause: &LiteralSet, observation: &Observation) -> Witness {
        let &Observation { event, synthesis, topology, start } = observation;
        let words = &synthesis.vocabulary;
        let mut messages = self.causes[rule].clone().unwrap_or_else(|| self.of_clause(clause, observation));
        let since = messages.last().cloned();
        let window = clause.iter().find_map(|literal| match literal {
            Literal::Time { bound, holds, .. } => bound.end().map(|end| (end, *bound, *holds)),
            _ => None,
        });
        let due = |last: u64| {
            let since = since.as_ref().map(|event| words.tau(event).max(start) - start);
            since.map(|since| since.saturating_add(last))
        };
        let awaited = window.filter(|(_, _, holds)| *holds);
        if channel(event).is_some() && awaited.is_none() && !messages.contains(event) {
            messages.push(event.clone());
        }
        let missing = describe::answers(clause, words, topology);
        let deadline = awaited.and_then(|(_, bound, _)| due(bound.ticks));
        let due = awaited.and_then(|(last, ..)| due(last));
        Witness {
            clause: describe::clause(clause, words, topology),
            since: since.as_ref().map(EventTime::of),
            messages: sightings(&messages, topology),
            deadline_tick: due.map(|last| observation.tick(last)),
            // If a clause has a single literal, what is missing is the clause itself; its moment may lie between ticks.
            missing: ((clause.len() > 1 || words.is_timed) && !missing.is_empty()).then(|| missing.join(" or ")),
            settled: observation.settled(deadline),
        }
    }

    /// The pending obligation of a rule, or of the formula as a whole.
    pub(crate) fn open(
        &self,
        rule: usize,
        clause: Option<&Clause>,
        what: String,
        until: Option<u64>,
        is_timed: bool,
    ) -> OpenObligation {
        let cause = clause.and_then(|clause| self.beginning(clause)).or(self.causes.get(rule).and_then(Option::as_ref));
        let since = cause.and_then(|cause| latest(cause)).map(EventTime::of);
        match until.filter(|_| is_timed) {
            Some(until) => {
                let what = format!("{what}, due by {:.3} s", Duration::from_nanos(until).as_secs_f64());
                OpenObligation { what, since, until_tick: None, has_deadline: true }
            }
            None => OpenObligation { what, since, until_tick: until, has_deadline: until.is_some() },
        }
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
fn name(obligation: &Obligation, observation: &Observation) -> Option<String> {
    match obligation {
        Obligation::Passes { event, values, .. } => Some(describe::event(
            &observation.synthesis.vocabulary.get(*event).instantiated(values),
            observation.topology,
        )),
        _ => None,
    }
}

/// The last messages, and the event itself if it is none.
fn everything(messages: &[Event], event: &Event) -> Vec<Event> {
    let mut events = Vec::with_capacity(messages.len() + 1);
    events.extend_from_slice(messages);
    if channel(event).is_none() {
        events.push(event.clone());
    }
    events
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

fn latest(events: &[Event]) -> Option<&Event> {
    events.iter().max_by_key(|event| (event.step, event.tick))
}

fn sorted(mut events: Vec<Event>) -> Vec<Event> {
    events.sort_by_key(|event| (event.step, event.tick));
    events.dedup();
    events
}
