//! Verdicts that missing messages could change.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use channels::{ChannelId, Event, Flaw, Gap, Monitor, Topology, Verdict};
use monitors::{Formula, Outcome, PossibleStates, Property, ScopeMonitor};

/// Why the verdicts of properties are unsure, by the index of the property.
#[derive(Debug)]
pub struct Doubts {
    states: Vec<State>,
    /// How many gaps in each channel have not ended.
    gaps: BTreeMap<ChannelId, usize>,
}

/// What is known of a verdict.
#[derive(Debug, Default)]
struct State {
    why: Option<String>,
    /// Why violations after the first are unsure.
    later: Option<String>,
    /// The monitor that tells whether missing messages could change the verdict; without one, the property's own does.
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
    /// Nothing is missing for this many properties. What may be missing later is within the domains of the channels.
    #[must_use]
    pub fn none(properties: usize) -> Self {
        Self { states: std::iter::repeat_with(State::default).take(properties).collect(), gaps: BTreeMap::new() }
    }

    /// Nothing is missing. What may be missing later can be any message, such as one that is missing because its
    /// channel could not carry it.
    ///
    /// A monitor foresees from the domains of the channels what may come, and may therefore know its verdict before any
    /// such message. So whether the verdict is settled is asked of a second monitor, which knows no domains, unless
    /// they make no difference: it costs a quarter of the time of a bag.
    #[must_use]
    pub fn about_any_messages(properties: &[Property], topology: &Topology) -> Self {
        let any = Arc::new(topology.without_shapes());
        let judge = |property: &Property| {
            let monitor = property.scope_monitor()?;
            let judge = ScopeMonitor::new(&property.name, monitor.formula().clone(), &any);
            let judge = judge.expect("whether a formula can be monitored does not depend on the domains");
            (!judge.foresees_as(monitor)).then_some(judge)
        };
        let states = properties.iter().map(|property| State { judge: judge(property), ..State::default() });
        Self { states: states.collect(), gaps: BTreeMap::new() }
    }

    /// The same, for a source that tells which messages are missing: what they could change is worked out.
    #[must_use]
    pub fn about_losses(properties: &[Property], topology: &Topology) -> Self {
        let mut doubts = Self::about_any_messages(properties, topology);
        for (state, property) in doubts.states.iter_mut().zip(properties) {
            state.possible = state.judge.as_ref().or(property.scope_monitor()).and_then(PossibleStates::of);
        }
        doubts
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
            let judged = judged(property);
            let is_elsewhere = gap.channel.is_some_and(|missing| {
                judged.is_some_and(|judged| judged != missing) || gap.ends && !is_about(property, missing)
            });
            if is_elsewhere || gap.flaw == Flaw::Late && !is_timed(property) {
                continue;
            }
            state.is_mixed |= gap.flaw == Flaw::Mixed;
            property.scope_monitor_mut().into_iter().for_each(ScopeMonitor::give_up_vacuity);
            state.is_lasting |= !gap.ends;
            state.anew = None;
            let is_late = state.was_reached_since(gap) && state.verdict(property) == Verdict::False;
            match (&mut state.possible, ending) {
                (Some(possible), Some(channel)) => {
                    possible.miss(channel, gap.since);
                    let is_elsewhen = is_late && possible.broken() != state.reached.map(|(_, step)| step);
                    if possible.are_unknown() || is_elsewhen {
                        state.suspect(gap, property);
                    } else {
                        state.gap.get_or_insert_with(|| gap.why.clone());
                        state.weigh(property);
                    }
                }
                _ => state.suspect(gap, property),
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

    /// The same for all.
    pub fn later(&self) -> impl Iterator<Item = Option<&str>> {
        self.states.iter().map(|state| state.later.as_deref())
    }

    /// The verdict that no missing message can change, or else inconclusive.
    #[must_use]
    pub fn verdict(&self, index: usize, property: &Property) -> Verdict {
        self.states[index].verdict(property)
    }

    /// Why the verdict of a property is unsure, if it is.
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

    /// Whether the verdict was reached after messages had begun to be missing.
    fn was_reached_since(&self, gap: &Gap) -> bool {
        self.reached.zip(gap.since).is_some_and(|((reached, _), since)| reached > since)
    }

    /// Messages may be missing, and what they could change is not worked out.
    fn suspect(&mut self, gap: &Gap, property: &Property) {
        self.possible = None;
        let verdict = self.verdict(property);
        match verdict {
            // It was violated by a message that was there.
            Verdict::False if judged(property).is_some() && !self.is_mixed => {}
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
            if verdict == Verdict::False && judged(property).is_some() && !self.is_mixed {
                (self.why, self.anew) = (None, None);
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
    property.scope_monitor().is_none_or(|monitor| matches!(monitor.formula(), Formula::Timed(_)))
}

fn judged(property: &Property) -> Option<ChannelId> {
    property.scope_monitor().map(|monitor| monitor.formula()).and_then(Formula::judges_each_message_on)
}
