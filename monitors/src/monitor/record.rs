//! What a monitor remembers of the messages, to explain its verdict: the last one on each channel, and those that made
//! something owed.

use channels::{Event, EventKind, Topology, Verdict};

use crate::clause::{Literal, Part};
use crate::describe;
use crate::engine::Letter;
use crate::monitor::witness::{Moment, OpenObligation, Sighting, Witness};
use crate::synthesis::{Run, Synthesis};

#[derive(Clone, Debug)]
pub(crate) struct Record {
    /// The last message on each channel that the formula mentions.
    messages: Vec<Event>,
    /// The events of the formula that the last messages satisfy.
    last: u64,
    /// For each rule, or for the formula as a whole: the messages that made something owed, while it is.
    causes: Vec<Option<Vec<Event>>>,
    witness: Option<Box<Witness>>,
}

impl Record {
    pub(crate) fn new(synthesis: &Synthesis) -> Self {
        let rules = synthesis.compact().map_or(1, |compact| compact.rules().len());
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
        self.last = self.last & !letter.channel | letter.satisfied;
        if let Some(channel) = channel(event) {
            match self.messages.iter_mut().find(|known| self::channel(known) == Some(channel)) {
                Some(known) => known.clone_from(event),
                None => self.messages.push(event.clone()),
            }
        }
    }

    /// Notes what has begun to be owed, or is not any more, and why a verdict has fallen.
    pub(crate) fn follow(
        &mut self,
        event: &Event,
        run: &Run,
        verdict: Verdict,
        synthesis: &Synthesis,
        topology: &Topology,
        start: u64,
    ) {
        if verdict == Verdict::False {
            self.witness = Some(Box::new(self.explain(event, run, synthesis, topology, start)));
            return;
        }
        match run {
            Run::Compact(run) => {
                for rule in 0..self.causes.len() {
                    let clause = &run.compact().rules()[rule].clause;
                    self.note_cause(rule, run.is_armed(rule), |record| record.of_clause(clause, synthesis, event));
                }
            }
            _ => self.note_cause(0, !run.holds(), |record| record.everything(event)),
        }
    }

    fn note_cause(&mut self, rule: usize, owed: bool, cause: impl FnOnce(&Self) -> Vec<Event>) {
        if !owed {
            self.causes[rule] = None;
        } else if self.causes[rule].is_none() {
            self.causes[rule] = Some(cause(self));
        }
    }

    /// The last messages on the own channels of a clause; the event itself if it has none.
    fn of_clause(&self, clause: &Part, synthesis: &Synthesis, event: &Event) -> Vec<Event> {
        let own = crate::clause::own_channels(clause, &synthesis.vocabulary);
        if own.is_empty() {
            return vec![event.clone()];
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

    fn explain(&self, event: &Event, run: &Run, synthesis: &Synthesis, topology: &Topology, start: u64) -> Witness {
        match run {
            Run::Compact(run) if run.broken().is_some() => {
                let rule = run.broken().unwrap_or_default();
                self.blame(rule, &run.compact().rules()[rule].clause, event, synthesis, topology, start)
            }
            _ => Witness {
                clause: describe::form(&synthesis.form, &synthesis.vocabulary, topology),
                since: self.causes[0].as_ref().and_then(|cause| cause.last()).map(Moment::of),
                messages: sightings(&self.everything(event), topology),
                deadline_tick: None,
                missing: None,
                settled: Moment::of(event),
            },
        }
    }

    /// Why a clause is violated.
    fn blame(
        &self,
        rule: usize,
        clause: &Part,
        event: &Event,
        synthesis: &Synthesis,
        topology: &Topology,
        start: u64,
    ) -> Witness {
        let words = &synthesis.vocabulary;
        let mut messages = self.causes[rule].clone().unwrap_or_else(|| self.of_clause(clause, synthesis, event));
        let since = messages.last().cloned();
        let window = clause.iter().find_map(|literal| match literal {
            Literal::Time { window, holds, .. } => Some((window.last, *holds)),
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
            since: since.as_ref().map(Moment::of),
            messages: sightings(&messages, topology),
            deadline_tick: awaited.and_then(|(last, _)| due(last)),
            // What a clause of one literal misses is the clause.
            missing: (clause.len() > 1 && !missing.is_empty()).then(|| missing.join(" or ")),
            settled: Moment::of(event),
        }
    }

    /// What a rule, or the formula as a whole, owes.
    pub(crate) fn open(&self, rule: usize, what: String, until_tick: Option<u64>) -> OpenObligation {
        let since = self.causes.get(rule).and_then(Option::as_ref).and_then(|cause| cause.last()).map(Moment::of);
        OpenObligation { what, since, until_tick }
    }
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
