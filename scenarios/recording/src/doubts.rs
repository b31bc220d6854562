//! Verdicts that missing messages could change.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use channels::{ChannelId, Event, Flaw, Gap, Ground, Monitor, Topology, Verdict};
use monitors::{Formula, Outcome, PossibleStates, Property, ScopeMonitor};

use crate::grounds::{Circumstances, Watched};
use crate::{Carried, Certainty, Evidence, Grounds};

/// How sure the verdicts of properties are, by the index of the property. What the source of the events vouches for
/// grants it, and what is missing takes it away.
#[derive(Debug)]
pub struct Doubts {
    states: Vec<State>,
    watched: Vec<Watched>,
    grounds: Grounds,
    /// How many gaps in each channel have not ended.
    gaps: BTreeMap<ChannelId, usize>,
}

/// What is known of a verdict.
#[derive(Clone, Debug, Default)]
struct State {
    why: Option<String>,
    /// Why violations after the first are unsure.
    later: Option<String>,
    /// Why it is unsure how often and how long it is violated, although each message that violates it does so surely.
    extent: Option<String>,
    /// The monitor that shows whether missing messages could change the verdict; without one, the property's own does.
    judge: Option<ScopeMonitor>,
    /// When the verdict was reached, and at which step of the run.
    reached: Option<(Duration, u64)>,
    /// Whether messages may be missing from now on, without an end.
    is_lasting: bool,
    /// Whether no message is sure to be what it seems.
    is_mixed: bool,
    /// What the monitor may have come to, if losses are counted, and why it may be more than one thing.
    possible: Option<PossibleStates>,
    gap: Option<String>,
    /// The monitor, and its judge, without what began before the last gap: a violation is then sure.
    anew: Option<(ScopeMonitor, Option<ScopeMonitor>)>,
}

impl Doubts {
    /// Nothing vouches for the messages of any channel yet. What may be missing is within the domains of the channels.
    #[must_use]
    pub fn new(properties: &[Property], topology: &Arc<Topology>) -> Self {
        Self::of(properties, topology, |_| State::default())
    }

    fn of(properties: &[Property], topology: &Arc<Topology>, state: impl Fn(&Property) -> State) -> Self {
        Self {
            states: properties.iter().map(state).collect(),
            watched: properties.iter().map(|property| Watched::of(property.monitor.as_ref(), topology)).collect(),
            grounds: Grounds::none(topology),
            gaps: BTreeMap::new(),
        }
    }

    /// Likewise. What may be missing can be any message, such as one that is missing because its channel could not
    /// carry it.
    ///
    /// A monitor foresees from the domains of the channels what may come, and may therefore reach its verdict before
    /// any such message. So a second monitor, without domains, determines whether the verdict is settled, unless they
    /// make no difference: it costs a quarter of the time of a bag.
    #[must_use]
    pub fn about_any_messages(properties: &[Property], topology: &Arc<Topology>) -> Self {
        let any = Arc::new(topology.without_shapes());
        let judge = |property: &Property| {
            let monitor = property.scope_monitor()?;
            let judge = ScopeMonitor::new(&property.name, monitor.formula().clone(), &any);
            let judge = judge.expect("whether a formula can be monitored does not depend on the domains");
            (!judge.foresees_as(monitor)).then_some(judge)
        };
        Self::of(properties, topology, |property| State { judge: judge(property), ..State::default() })
    }

    /// The same, for a source that reports which messages are missing: what they could change is worked out.
    #[must_use]
    pub fn about_losses(properties: &[Property], topology: &Arc<Topology>) -> Self {
        Self::about_any_messages(properties, topology).weighing(properties)
    }

    /// About a run whose messages are known on this ground, beside `nodes`: components that are nodes of ROS 2, whose
    /// messages come over DDS. What DDS loses could change is worked out.
    #[must_use]
    pub fn of_run(properties: &[Property], topology: &Arc<Topology>, ground: &Ground, nodes: &[String]) -> Self {
        let mut doubts = Self::new(properties, topology).on(ground);
        if !nodes.is_empty() {
            doubts = doubts.weighing(properties);
            doubts.grounds.weaken_for(nodes);
        }
        doubts
    }

    /// Works out what missing messages could change.
    fn weighing(mut self, properties: &[Property]) -> Self {
        for (state, property) in self.states.iter_mut().zip(properties) {
            state.possible = state.judge.as_ref().or(property.scope_monitor()).and_then(PossibleStates::of);
        }
        self
    }

    /// The same on this ground for all channels.
    #[must_use]
    pub fn on(mut self, ground: &Ground) -> Self {
        self.grounds.vouch_for_all(ground);
        self
    }

    /// The source had no channels for other messages than these.
    #[must_use]
    pub fn only(mut self, carried: &Carried, topology: &Topology) -> Self {
        for channel in carried.missing(topology) {
            let why = "when this was recorded, there was no such channel, or not with all of its messages";
            self.grounds.vouch(channel, Ground::Missing(why.to_owned()));
        }
        self
    }

    /// The source vouches for the messages of this channel.
    pub fn vouch(&mut self, channel: ChannelId, ground: Ground) {
        self.grounds.vouch(channel, ground);
    }

    /// How many properties have a second monitor.
    #[must_use]
    pub fn judges(&self) -> usize {
        self.states.iter().filter(|state| state.judge.is_some()).count()
    }

    /// From here on, messages may be missing. They could change every verdict that is open, or was reached since they
    /// may be missing; if they only come late, those of timed properties. Exceptions are properties that judge each
    /// message of another channel by itself; if the gap lies between messages, which leaves the ticks as they are, all
    /// that are about other channels; and those that come to the same whatever is missing.
    pub fn miss(&mut self, gap: &Gap, properties: &mut [Property]) {
        let ending = gap.channel.filter(|_| gap.ends);
        if let Some(channel) = ending {
            *self.gaps.entry(channel).or_default() += 1;
        }
        for (state, property) in self.states.iter_mut().zip(properties) {
            if state.miss(gap, property) {
                property.scope_monitor_mut().into_iter().for_each(ScopeMonitor::give_up_vacuity);
            }
        }
    }

    /// A gap in the messages of this channel is over.
    pub fn resume(&mut self, channel: ChannelId, properties: &[Property]) {
        let open = self.gaps.entry(channel).or_default();
        *open = open.saturating_sub(1);
        let is_over = *open == 0;
        for (state, property) in self.states.iter_mut().zip(properties) {
            state.possible.iter_mut().filter(|_| is_over).for_each(|possible| possible.resume(channel));
            state.begin_anew(property, &self.gaps);
        }
    }

    /// Lets an event that the properties have seen settle what it can: a message that violates a property by itself
    /// does so whatever else is missing, and so does what began after a gap.
    pub fn observe(&mut self, event: &Event, properties: &mut [Property]) {
        self.grounds.observe(event);
        for (state, property) in self.states.iter_mut().zip(properties) {
            state.observe(event);
            state.settle(event, property);
            state.begin_anew(property, &self.gaps);
        }
    }

    /// Why violations after the first are unsure, of a property that had been violated when messages went missing.
    #[must_use]
    pub fn why_later(&self, index: usize) -> Option<&str> {
        self.states[index].later.as_deref()
    }

    /// Why it is unsure how often and how long a property was violated, although each violation is sure.
    #[must_use]
    pub fn why_extent(&self, index: usize) -> Option<&str> {
        self.states[index].extent.as_deref()
    }

    /// The verdict that no missing message can change, or else inconclusive.
    #[must_use]
    pub fn verdict(&self, index: usize, property: &Property) -> Verdict {
        self.states[index].verdict(property)
    }

    /// What the verdict of a property rests on if the events end here.
    #[must_use]
    pub fn evidence(&self, index: usize, property: &Property) -> Evidence {
        let state = &self.states[index];
        let could_change = |gaps: &[Gap]| {
            let mut state = state.clone();
            gaps.iter().for_each(|gap| _ = state.miss(gap, property));
            state.why.is_some()
        };
        let known = Circumstances {
            doubt: state.why.as_deref(),
            is_by_message: state.is_by_message(property),
            is_open_to: &|channel| state.is_open_to(channel, property),
            could_change: &could_change,
        };
        self.grounds.evidence_about(&self.watched[index], &known)
    }

    /// Whether it has no verdict, since nothing vouches for messages that it is about.
    #[must_use]
    pub fn is_groundless(&self, index: usize, property: &Property) -> bool {
        self.grounds.lack(&self.watched[index])
            && matches!(self.evidence(index, property).certainty(), Certainty::Groundless(_))
    }

    /// Which message must not have been lost, in words, so that the property is violated as often as it seems to be.
    /// That it has not been lost shows when the next one of its channel comes.
    #[must_use]
    pub fn unless(&self, index: usize, property: &Property) -> Option<String> {
        let state = &self.states[index];
        let could_change = |gaps: &[Gap]| {
            let mut after = state.clone();
            gaps.iter().for_each(|gap| _ = after.miss(gap, property));
            after.why.is_some() || after.later != state.later
        };
        self.grounds.unnoticed(&self.watched[index], &could_change)
    }

    /// Why the verdict of a property is unsure, if it is because messages are missing.
    #[must_use]
    pub fn why(&self, index: usize) -> Option<&str> {
        self.states[index].why.as_deref()
    }

    /// The same for all.
    pub fn all(&self) -> impl Iterator<Item = Option<&str>> {
        self.states.iter().map(|state| state.why.as_deref())
    }
}

impl State {
    fn verdict(&self, property: &Property) -> Verdict {
        self.judge.as_ref().map_or_else(|| property.monitor.verdict(), Monitor::verdict)
    }

    fn observe(&mut self, event: &Event) {
        self.judge.iter_mut().for_each(|judge| judge.observe(event));
        self.possible.iter_mut().for_each(|possible| possible.observe(event));
        if let Some((monitor, judge)) = &mut self.anew {
            monitor.observe(event);
            judge.iter_mut().for_each(|judge| judge.observe(event));
        }
    }

    /// Messages are missing. Returns whether the property depends on them.
    fn miss(&mut self, gap: &Gap, property: &Property) -> bool {
        let judged = judged(property);
        let is_elsewhere = gap.channel.is_some_and(|missing| {
            judged.is_some_and(|judged| judged != missing) || gap.ends && !is_about(property, missing)
        });
        // Whenever a message was due, it was there; and its time counts beside others only.
        let is_there = |channel: &ChannelId| judged == Some(*channel);
        let is_harmless = gap.channel.as_ref().map_or(!is_timed(property), is_there);
        let is_uncounted = || gap.flaw == Flaw::Ticks && !counts_ticks(property);
        if is_elsewhere || gap.flaw == Flaw::Late && is_harmless || is_uncounted() {
            return false;
        }
        self.is_mixed |= gap.flaw == Flaw::Mixed;
        self.is_lasting |= !gap.ends;
        self.anew = None;
        let is_late = self.was_reached_since(gap) && self.verdict(property) == Verdict::False;
        match (&mut self.possible, gap.channel.filter(|_| gap.ends)) {
            // Where a displaced message belongs, it is missing; where it comes, it was not sent. Nor was a mixed one.
            (Some(possible), Some(channel)) if matches!(gap.flaw, Flaw::Missing | Flaw::Late) => {
                match gap.since.filter(|_| gap.flaw == Flaw::Late) {
                    Some(since) => possible.delay(channel, since),
                    None => possible.miss(channel, gap.since),
                }
                let is_elsewhen = is_late && possible.broken() != self.reached.map(|(_, step)| step);
                if possible.are_unknown() || is_elsewhen {
                    self.suspect(gap, property);
                } else {
                    self.gap.get_or_insert_with(|| gap.why.clone());
                    self.weigh(property);
                }
            }
            _ => self.suspect(gap, property),
        }
        true
    }

    /// Whether it is violated by a single message that was there, whatever else was.
    fn is_by_message(&self, property: &Property) -> bool {
        self.verdict(property) == Verdict::False && judged(property).is_some() && !self.is_mixed
    }

    /// Whether messages of this channel, at any time, could change the verdict.
    fn is_open_to(&self, channel: ChannelId, property: &Property) -> bool {
        let Some(mut possible) = self.possible.clone() else { return true };
        possible.miss(channel, Some(Duration::ZERO));
        possible.agreed() != Some((self.verdict(property), Outcome::of(property.monitor.as_ref())))
    }

    /// Whether the verdict was reached after messages had begun to be missing.
    fn was_reached_since(&self, gap: &Gap) -> bool {
        // A displaced message may belong before all that has come, which begins at time 0; a mixed one may itself be
        // another.
        let is_sharp = matches!(gap.flaw, Flaw::Missing | Flaw::Late);
        let is_since = |reached, since| reached > since || !is_sharp && reached == since;
        self.reached.zip(gap.since).is_some_and(|((reached, _), since)| is_since(reached, since))
    }

    /// Messages may be missing, and what they could change is not worked out.
    fn suspect(&mut self, gap: &Gap, property: &Property) {
        self.possible = None;
        let verdict = self.verdict(property);
        match verdict {
            _ if self.is_by_message(property) => {
                self.extent.get_or_insert_with(|| gap.why.clone());
            }
            Verdict::True | Verdict::False if !self.was_reached_since(gap) => {
                if verdict == Verdict::False {
                    self.later.get_or_insert_with(|| gap.why.clone());
                }
            }
            _ => {
                self.why.get_or_insert_with(|| gap.why.clone());
            }
        }
    }

    /// Compares what the monitor has come to with what it may have come to.
    fn weigh(&mut self, property: &Property) {
        let (Some(possible), Some(gap)) = (&self.possible, &self.gap) else { return };
        let (verdict, outcome) = (self.verdict(property), Outcome::of(property.monitor.as_ref()));
        let is_sure = !possible.are_several() || possible.agreed() == Some((verdict, outcome));
        if is_sure {
            if outcome == Outcome::Violated {
                self.later = Some(gap.clone());
            }
            if !possible.are_several() {
                self.gap = None;
            }
            (self.why, self.anew) = (None, None);
        } else {
            self.why.get_or_insert_with(|| gap.clone());
            if verdict == Verdict::False || possible.are_unknown() {
                // Whenever it is violated for sure, this is not why.
                self.possible = None;
            }
        }
    }

    /// Gives up what began before the gaps, once they are over.
    fn begin_anew(&mut self, property: &Property, gaps: &BTreeMap<ChannelId, usize>) {
        let is_complete = |(channel, open): (&ChannelId, &usize)| *open == 0 || !is_about(property, *channel);
        if self.why.is_none() || self.is_lasting || self.anew.is_some() || !gaps.iter().all(is_complete) {
            return;
        }
        let judge = self.judge.as_ref().map(ScopeMonitor::anew);
        let monitor = property.scope_monitor().and_then(ScopeMonitor::anew);
        self.anew = match (monitor, judge) {
            (Some(monitor), None) => Some((monitor, None)),
            (Some(monitor), Some(Some(judge))) => Some((monitor, Some(judge))),
            _ => None,
        };
    }

    fn settle(&mut self, event: &Event, property: &mut Property) {
        let at = (event.time, event.step);
        let is_violated = |(monitor, judge): &mut (ScopeMonitor, Option<ScopeMonitor>)| {
            judge.as_ref().unwrap_or(monitor).verdict() == Verdict::False
        };
        if let (Some((anew, judge)), Some(monitor)) = (self.anew.take_if(is_violated), property.scope_monitor_mut()) {
            *monitor = anew;
            (self.judge, self.possible) = (judge, None);
            (self.later, self.reached) = (self.why.take(), Some(at));
            return;
        }
        let verdict = self.verdict(property);
        if verdict != Verdict::Inconclusive && self.reached.is_none() {
            self.reached = Some(at);
            if self.is_by_message(property) {
                (self.extent, self.anew) = (self.why.take(), None);
            }
        }
        self.weigh(property);
    }
}

fn is_about(property: &Property, channel: ChannelId) -> bool {
    property.scope_monitor().is_none_or(|monitor| monitor.formula().is_about(channel))
}

/// Whether its verdict depends on when messages were sent, and not only on their order.
fn is_timed(property: &Property) -> bool {
    property.scope_monitor().is_none_or(|monitor| monitor.formula().is_timed())
}

/// Whether its verdict depends on how many ticks have passed.
fn counts_ticks(property: &Property) -> bool {
    property.scope_monitor().is_none_or(|monitor| !monitor.formula().bounds_in_ticks().is_empty())
}

fn judged(property: &Property) -> Option<ChannelId> {
    property.scope_monitor().map(|monitor| monitor.formula()).and_then(Formula::judges_each_message_on)
}
