//! Verdicts that missing messages could change.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use channels::{ChannelId, Gap, Monitor, Topology, Verdict};
use monitors::{Formula, Property, ScopeMonitor};

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
    /// When the verdict was reached.
    reached: Option<Duration>,
    /// Whether what began before a gap has been given up: a violation is then sure.
    is_anew: bool,
    /// Whether messages may be missing from now on, without an end.
    is_lasting: bool,
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

    /// The monitors that must see every event, besides those of the properties.
    pub fn monitors(&mut self) -> impl Iterator<Item = &mut dyn Monitor> {
        self.states.iter_mut().filter_map(|state| state.judge.as_mut()).map(|judge| judge as &mut dyn Monitor)
    }

    /// From here on, messages may be missing. They could change every verdict that is open, or was reached since they
    /// may be missing. Exceptions are properties that judge each message of another channel by itself; and, if the gap
    /// lies between messages, which leaves the ticks as they are, all that are about other channels.
    pub fn miss(&mut self, gap: &Gap, properties: &[Property]) {
        if let Some(channel) = gap.channel.filter(|_| gap.ends) {
            *self.gaps.entry(channel).or_default() += 1;
        }
        for (index, property) in properties.iter().enumerate() {
            let judged = judged(property);
            let is_elsewhere = gap.channel.is_some_and(|missing| {
                judged.is_some_and(|judged| judged != missing) || gap.ends && !is_about(property, missing)
            });
            if is_elsewhere {
                continue;
            }
            let verdict = self.verdict(index, property);
            let state = &mut self.states[index];
            state.is_lasting |= !gap.ends;
            state.is_anew = false;
            let was_reached_since = state.reached.zip(gap.since).is_some_and(|(reached, since)| reached > since);
            match verdict {
                // It was violated by a message that was there.
                Verdict::False if judged.is_some() => {}
                Verdict::True | Verdict::False if !was_reached_since => {
                    if verdict == Verdict::False {
                        state.later.get_or_insert_with(|| gap.why.clone());
                    }
                }
                _ => {
                    state.why.get_or_insert_with(|| gap.why.clone());
                }
            }
        }
    }

    /// A gap in the messages of this channel is over. Properties that can begin anew do so: what began before is given
    /// up, and what will be violated from now on is violated for sure.
    pub fn resume(&mut self, channel: ChannelId, properties: &mut [Property]) {
        let open = self.gaps.entry(channel).or_default();
        *open = open.saturating_sub(1);
        for (state, property) in self.states.iter_mut().zip(properties) {
            if !is_about(property, channel) {
                continue;
            }
            let is_complete = |(channel, open): (&ChannelId, &usize)| *open == 0 || !is_about(property, *channel);
            if state.why.is_none() || state.is_lasting || !self.gaps.iter().all(is_complete) {
                continue;
            }
            let judge = state.judge.as_mut().is_none_or(ScopeMonitor::begin_anew);
            if judge && property.scope_monitor_mut().is_some_and(ScopeMonitor::begin_anew) {
                (state.is_anew, state.reached) = (true, None);
            }
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
        self.states[index].judge.as_ref().map_or_else(|| property.monitor.verdict(), Monitor::verdict)
    }

    /// Call this after each event: a message that violates a property by itself does so whatever else is missing, and
    /// so does what began after a gap.
    pub fn settle(&mut self, time: Duration, properties: &[Property]) {
        for (index, property) in properties.iter().enumerate() {
            let verdict = self.verdict(index, property);
            let state = &mut self.states[index];
            if verdict == Verdict::Inconclusive || state.reached.is_some() {
                continue;
            }
            state.reached = Some(time);
            if verdict == Verdict::False && (state.is_anew || judged(property).is_some()) {
                state.why = None;
            }
        }
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

fn is_about(property: &Property, channel: ChannelId) -> bool {
    property.scope_monitor().is_none_or(|monitor| monitor.formula().is_about(channel))
}

fn judged(property: &Property) -> Option<ChannelId> {
    property.scope_monitor().map(|monitor| monitor.formula()).and_then(Formula::judges_each_message_on)
}
