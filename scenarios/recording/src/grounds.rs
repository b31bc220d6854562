//! What a source of messages vouches for, channel by channel.

use std::sync::Arc;
use std::time::Duration;

use channels::{ChannelId, Event, EventKind, Flaw, Gap, Ground, Monitor, Topology};
use monitors::{ScopeMonitor, scope_monitor};

use crate::{Certainty, Evidence};

/// On what ground the messages of each channel are known, and how far they have come.
///
/// A source that vouches for nothing gives no verdict, so that none is sure only because a possible error was
/// overlooked.
#[derive(Clone, Debug)]
pub struct Grounds {
    topology: Arc<Topology>,
    /// By the index of the channel: the ground, and when its newest message came.
    channels: Vec<(Ground, Option<Duration>)>,
    has_events: bool,
}

/// What is known about a verdict besides its grounds.
pub(crate) struct Circumstances<'k> {
    /// Why it is unsure, if messages are missing.
    pub(crate) doubt: Option<&'k str>,
    /// Whether it is a violation by a single message, whatever else there was.
    pub(crate) is_by_message: bool,
    /// Whether any messages of this channel, at any time, could change it.
    pub(crate) is_open_to: &'k dyn Fn(ChannelId) -> bool,
    /// Whether it would be unsure if messages had been lost in all of these gaps.
    pub(crate) could_change: &'k dyn Fn(&[Gap]) -> bool,
}

impl Grounds {
    /// Nothing vouches for any message.
    #[must_use]
    pub fn none(topology: &Arc<Topology>) -> Self {
        let channels = topology.channels().map(|_| (Ground::default(), None)).collect();
        Self { topology: Arc::clone(topology), channels, has_events: false }
    }

    /// The messages are computed by a simulation. Whatever else happens, no message comes that is not known.
    #[must_use]
    pub fn computed(topology: &Arc<Topology>) -> Self {
        let mut grounds = Self { has_events: true, ..Self::none(topology) };
        grounds.vouch_for_all(&Ground::Complete);
        grounds
    }

    /// From the start of the events, the messages of this channel are known on this ground.
    pub fn vouch(&mut self, channel: ChannelId, ground: Ground) {
        self.channels[channel.index()].0 = ground;
    }

    /// The same for the messages of all channels.
    pub fn vouch_for_all(&mut self, ground: &Ground) {
        self.channels.iter_mut().for_each(|(of, _)| of.clone_from(ground));
    }

    /// The messages of these components, which are nodes of ROS 2, have also come over DDS.
    pub(crate) fn weaken_for(&mut self, nodes: &[String]) {
        for (channel, (ground, _)) in self.topology.channels().zip(&mut self.channels) {
            let (from, _) = self.topology.ends(channel);
            if nodes.iter().any(|node| node == from) {
                let delivered = Ground::Assumed(format!("DDS delivers every message of the nodes of {from}"));
                *ground = std::mem::take(ground).weaker(delivered);
            }
        }
    }

    /// Takes note of an event.
    pub fn observe(&mut self, event: &Event) {
        self.has_events = true;
        if let EventKind::Received { channel, .. } = event.kind {
            self.channels[channel.index()].1 = Some(event.time);
        }
    }

    /// Whether nothing vouches for the messages of one of these channels.
    pub(crate) fn lack(&self, watched: &Watched) -> bool {
        watched.channels.iter().any(|channel| matches!(self.of(*channel).0, Ground::Missing(_)))
    }

    /// What a monitor's verdict rests on, if no message is known to be missing.
    #[must_use]
    pub fn evidence(&self, monitor: &dyn Monitor) -> Evidence {
        let (is_open_to, could_change) = (&|_| true, &|_: &[Gap]| true);
        let known = Circumstances { doubt: None, is_by_message: false, is_open_to, could_change };
        self.evidence_about(&Watched::of(monitor, &self.topology), &known)
    }

    /// What a verdict about the messages of these channels rests on.
    pub(crate) fn evidence_about(&self, watched: &Watched, known: &Circumstances<'_>) -> Evidence {
        let Watched { channels, are_named } = watched;
        let assumption = |channel: &ChannelId| match &self.of(*channel).0 {
            Ground::Assumed(what) => Some(what.clone()),
            _ => None,
        };
        let mut assumptions: Vec<String> = channels.iter().filter_map(assumption).collect();
        assumptions.sort();
        assumptions.dedup();
        let silent = channels.iter().filter(|channel| *are_named && self.of(**channel).1.is_none());
        let silent = silent.map(|channel| self.name(*channel)).collect();
        Evidence::new(self.certainty(watched, known), assumptions, silent)
    }

    fn certainty(&self, watched: &Watched, known: &Circumstances<'_>) -> Certainty {
        if known.is_by_message {
            return Certainty::Sure;
        }
        if let Some(why) = watched.channels.iter().find_map(|channel| self.without_ground(*channel, known)) {
            return Certainty::Groundless(why);
        }
        if let Some(why) = known.doubt {
            return Certainty::Unsure(why.to_owned());
        }
        if !self.has_events {
            return Certainty::Groundless("there are no events".to_owned());
        }
        self.unnoticed(watched, known.could_change).map_or(Certainty::Sure, Certainty::Unless)
    }

    /// Which messages of these channels could have been lost without notice, one or several together, if that could
    /// change something.
    pub(crate) fn unnoticed(&self, watched: &Watched, could_change: &dyn Fn(&[Gap]) -> bool) -> Option<String> {
        let gaps: Vec<Gap> = watched.channels.iter().filter_map(|channel| self.unnoticed_on(*channel)).collect();
        let alone = gaps.iter().find(|gap| could_change(std::slice::from_ref(gap))).map(|gap| gap.why.clone());
        let all = || gaps.iter().map(|gap| gap.why.as_str()).collect::<Vec<_>>().join(", and ");
        alone.or_else(|| (gaps.len() > 1 && could_change(&gaps)).then(all))
    }

    /// Why nothing vouches for the messages of a channel, if that is so and they could change the verdict.
    fn without_ground(&self, channel: ChannelId, known: &Circumstances<'_>) -> Option<String> {
        let why = match self.of(channel) {
            (Ground::Missing(why), _) => why,
            (Ground::Numbered | Ground::NumberedApart, None) => "none has come, so that a loss would not be noticed",
            _ => return None,
        };
        (known.is_open_to)(channel).then(|| format!("nothing is known of messages {}: {why}", self.name(channel)))
    }

    fn unnoticed_on(&self, channel: ChannelId) -> Option<Gap> {
        let newest = match self.of(channel) {
            (Ground::Numbered, Some(newest)) => newest,
            (Ground::NumberedApart, Some(_)) => &Duration::ZERO,
            _ => return None,
        };
        let why = format!("a message {} was lost after {} s", self.name(channel), newest.as_secs_f64());
        let (flaw, channel, since) = (Flaw::Missing, Some(channel), Some(*newest));
        Some(Gap { flaw, why, channel, since, ends: true })
    }

    fn of(&self, channel: ChannelId) -> &(Ground, Option<Duration>) {
        &self.channels[channel.index()]
    }

    fn name(&self, channel: ChannelId) -> String {
        let (from, to) = self.topology.ends(channel);
        format!("from {from} to {to}")
    }
}

/// The channels that a monitor watches: all, if it does not name them.
#[derive(Debug)]
pub(crate) struct Watched {
    channels: Vec<ChannelId>,
    are_named: bool,
}

impl Watched {
    pub(crate) fn of(monitor: &dyn Monitor, topology: &Topology) -> Self {
        let formula = scope_monitor(monitor).map(ScopeMonitor::formula);
        let is_watched = |channel: &ChannelId| formula.is_none_or(|formula| formula.is_about(*channel));
        Self { channels: topology.channels().filter(is_watched).collect(), are_named: formula.is_some() }
    }
}
