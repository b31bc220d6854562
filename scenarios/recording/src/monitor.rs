//! Monitors as data: their graphs and states.

use channels::{ChannelId, GraphTransition, Label, LocationId, ProgramGraph, Topology, Verdict};
use monitors::Outcome;
use serde::{Deserialize, Serialize};

/// The state of a monitor.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct MonitorState {
    /// The verdict so far.
    pub verdict: Verdict,
    /// Whether an obligation is still pending.
    pub is_open: bool,
    /// Its location, in one word.
    pub location: String,
    /// The active location of its graph, if it has one.
    pub active: Option<usize>,
    /// Of a violation: unless which message was lost, in words, if that could not have been noticed yet.
    pub unless: Option<String>,
}

impl MonitorState {
    /// The current state of a monitor.
    #[must_use]
    pub fn of(monitor: &dyn channels::Monitor) -> Self {
        Self {
            verdict: monitor.verdict(),
            is_open: monitor.is_open(),
            location: monitor.location(),
            active: monitor.graph().map(|(_, active)| LocationId::index(active)),
            unless: None,
        }
    }

    /// The outcome of the property if the run ends now.
    #[must_use]
    pub fn outcome(&self) -> Outcome {
        match self.verdict {
            Verdict::False => Outcome::Violated,
            Verdict::Inconclusive if self.is_open => Outcome::Inconclusive,
            Verdict::True | Verdict::Inconclusive => Outcome::Satisfied,
        }
    }
}

/// A monitor's graph. Self-loops are omitted: a monitor without a matching transition stays in its location.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Graph {
    /// The locations.
    pub locations: Vec<Location>,
    /// The index of the initial location.
    pub initial: usize,
    /// The transitions between different locations.
    pub transitions: Vec<Transition>,
}

/// A location of a monitor's graph.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Location {
    /// Its name.
    pub name: String,
    /// Whether the property is violated in it.
    pub is_failure: bool,
}

/// A transition of a monitor's graph.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Transition {
    /// The index of the location that it leaves.
    pub from: usize,
    /// The index of the location that it enters.
    pub to: usize,
    /// Its trigger, in words.
    pub label: String,
}

impl Graph {
    /// The graph of a monitor on these channels, if the monitor has one.
    #[must_use]
    pub fn of(monitor: &dyn channels::Monitor, topology: &Topology) -> Option<Self> {
        let (graph, _) = monitor.graph()?;
        let is_failure = |index: usize| monitor.failures().iter().any(|failure| failure.index() == index);
        let locations = graph.locations().iter().enumerate();
        Some(Self {
            locations: locations
                .map(|(index, name)| Location { name: name.clone(), is_failure: is_failure(index) })
                .collect(),
            initial: graph.initial_locations().first().map_or(0, |initial| initial.index()),
            transitions: transitions(graph, topology),
        })
    }
}

/// The transitions as a picture shows them. A receive action is named by the content of the message, and the negation
/// of another transition's label is "else".
fn transitions(graph: &ProgramGraph, topology: &Topology) -> Vec<Transition> {
    let shown = || graph.transitions().iter().filter(|transition| transition.from != transition.to);
    let label = |transition: &GraphTransition| {
        let caption = graph.caption(transition, topology);
        match &transition.label {
            Label::Receive(channel, _) if caption == topology.describe(*channel) => what_passes(topology, *channel),
            _ => caption,
        }
    };
    shown()
        .map(|transition| {
            let own = label(transition);
            let is_else = shown()
                .filter(|other| other.from == transition.from && other.to != transition.to)
                .any(|other| own == format!("not ({})", label(other)));
            let label = if is_else { "else".to_owned() } else { own };
            Transition { from: transition.from.index(), to: transition.to.index(), label }
        })
        .collect()
}

/// The content of a channel's messages, in one word: `request`, or the last field of a reply, such as `level`.
fn what_passes(topology: &Topology, channel: ChannelId) -> String {
    let fields = topology.get(channel).domain.shapes().first().map_or(&[][..], |shape| shape.fields());
    let request = fields.first().filter(|(name, _)| name == "request");
    let content = request.or(fields.last()).map(|(name, _)| name.clone());
    content.unwrap_or_else(|| topology.ends(channel).0.to_owned())
}
