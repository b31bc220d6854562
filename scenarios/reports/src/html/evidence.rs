//! Why a property is violated: which messages caused it, and which one was missing.

use std::collections::BTreeSet;
use std::time::Duration;

use channels::{ChannelId, Event, Topology};
use monitors::{EventAtom, EventTime, Formula, Sighting, Witness};
use recording::RunView;

use super::words;
use crate::timeline::Episode;

#[derive(Clone, Debug)]
pub(super) struct Evidence<'a> {
    /// The property's name.
    pub(super) name: &'a str,
    /// What it requires.
    pub(super) summary: &'a str,
    /// Whether it is known when the tree was ticked.
    pub(super) knows_ticks: bool,
    /// The violation with the events around it.
    pub(super) episode: &'a Episode,
    /// The messages that caused it, oldest first.
    pub(super) causes: Vec<Seen>,
    /// When an answer became due.
    pub(super) since: Option<EventTime>,
    /// The last tick at which it would have been in time.
    pub(super) deadline_tick: Option<u64>,
    /// The answers of which at least one should have come.
    pub(super) missing: Vec<Missing>,
    /// What was still pending at the end of the run, if that is why it is violated, in the property's language.
    pub(super) pending: Option<String>,
    /// The processes that the property mentions, by name.
    pub(super) concerned: Vec<String>,
}

/// A message that was received.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Seen {
    pub(super) at: EventTime,
    pub(super) from: String,
    pub(super) to: String,
    pub(super) message: String,
}

impl Seen {
    /// The message of an event; `None` if it is a tick.
    pub(super) fn of(event: &Event, topology: &Topology) -> Option<Self> {
        Sighting::of(event, topology).as_ref().map(Self::from)
    }
}

impl From<&Sighting> for Seen {
    fn from(seen: &Sighting) -> Self {
        Self { at: seen.at, from: seen.from.clone(), to: seen.to.clone(), message: seen.message_in_words() }
    }
}

/// A message that should have come.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Missing {
    pub(super) channel: ChannelId,
    pub(super) from: String,
    pub(super) to: String,
    pub(super) message: String,
}

impl<'a> Evidence<'a> {
    /// The evidence of the violation that ended an episode.
    pub(super) fn of(episode: &'a Episode, view: &'a RunView) -> Self {
        let monitor = view.monitor(episode.property);
        let topology = view.topology();
        let decided = Seen::of(&episode.decided, topology);
        let mut evidence = Self {
            name: monitor.name(),
            summary: &monitor.about.summary,
            knows_ticks: view.header().knows_ticks(),
            episode,
            causes: decided.iter().cloned().collect(),
            since: None,
            deadline_tick: None,
            missing: Vec::new(),
            pending: None,
            concerned: decided.into_iter().flat_map(|seen| [seen.from, seen.to]).collect(),
        };
        if let Some(formula) = &monitor.about.formula {
            let witness = monitor.decision.and_then(|decision| decision.witness.as_ref());
            evidence.explain(formula, witness, topology);
        }
        evidence.concerned.sort();
        evidence.concerned.dedup();
        evidence
    }

    /// Adds what the property concerns and, if the monitor explains its verdict, the explanation.
    fn explain(&mut self, formula: &Formula, witness: Option<&Witness>, topology: &Topology) {
        let ends = |channel: ChannelId| {
            let (from, to) = topology.ends(channel);
            [from.to_owned(), to.to_owned()]
        };
        formula.events(&mut |event| self.concerned.extend(ends(event.channel)));
        let Some(witness) = witness else { return };
        self.since = witness.since;
        self.deadline_tick = witness.deadline_tick.filter(|_| self.knows_ticks);
        self.causes = witness.messages.iter().map(Seen::from).collect();
        // Whatever else is missing has a deadline.
        self.pending = witness.missing.clone().filter(|_| witness.deadline_tick.is_none());
        // The witness names what is missing in the property's language, with the values that were remembered.
        let named = witness.missing.as_ref().filter(|_| witness.deadline_tick.is_some());
        let text = named.map_or(String::new(), |named| format!("property missing := eventually ({named})"));
        let named = monitors::formulas("missing", &text, topology, Duration::from_secs(1)).unwrap_or_default();
        let mut awaited = BTreeSet::new();
        formula.awaited(&mut |event| _ = awaited.insert(event.channel));
        let mut missing = |EventAtom { channel, condition }: &EventAtom| {
            if awaited.contains(channel) {
                let [from, to] = ends(*channel);
                let message = words::wanted(condition, topology.get(*channel).domain.shapes());
                self.missing.push(Missing { channel: *channel, from, to, message });
            }
        };
        named.iter().for_each(|(_, formula)| formula.events(&mut missing));
        // What came later did not cause the obligation, but belongs to the wait for the answer.
        if let Some(since) = self.since.filter(|_| !self.missing.is_empty()) {
            self.causes.retain(|seen| seen.at.step <= since.step);
        }
    }

    /// When it happened.
    pub(super) fn decided(&self) -> EventTime {
        EventTime::of(&self.episode.decided)
    }

    /// The first tick that belongs to the story.
    pub(super) fn first_tick(&self) -> u64 {
        let causes = self.causes.iter().map(|seen| seen.at.tick);
        causes.chain(self.since.map(|since| since.tick)).min().unwrap_or(self.episode.decided.tick)
    }
}
