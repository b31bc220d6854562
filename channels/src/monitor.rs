//! Monitored transitions: monitors move with the messages that they watch and change nothing.

use std::any::Any;
use std::fmt::Debug;
use std::hash::{Hash, Hasher};
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::graph::{GraphProcess, LocationId, ProgramGraph};
use crate::{Event, EventKind, Message, NoNormalForm, TransitionId, Value};

/// A monitor's verdict while the run continues. True and false are final.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
pub enum Verdict {
    /// The property holds however the run continues.
    True,
    /// The property is violated however the run continues.
    False,
    /// The verdict depends on how the run continues.
    #[default]
    Inconclusive,
}

/// A monitor: it sees every event of the timed state sequence in the step in which the event happens.
///
/// A monitor is [`Any`], so code that has its type can get more from it. It can be copied, so a monitor needs to be
/// built only once for any number of runs.
pub trait Monitor: Any + Debug + Send + Sync {
    /// The name of the monitored property.
    fn name(&self) -> &str;

    /// A copy of the monitor in its current state.
    fn boxed_clone(&self) -> Box<dyn Monitor>;

    /// Processes an event. This must be fast and must depend on nothing but the events.
    fn observe(&mut self, event: &Event);

    /// The verdict so far.
    fn verdict(&self) -> Verdict;

    /// The monitor's current location, by name.
    fn location(&self) -> String;

    /// The verdict of a run that ends now. If the end decides nothing, this is the verdict so far.
    fn verdict_at_end(&self) -> Verdict {
        self.verdict()
    }

    /// Whether an obligation is still pending: a run that ends now ends without a verdict.
    fn is_open(&self) -> bool;

    /// The monitor as a program graph with its active location, for pictures and exports; `None` if it has no such
    /// form.
    fn graph(&self) -> Option<(&ProgramGraph, LocationId)> {
        None
    }

    /// The locations of the graph in which the property is violated.
    fn failures(&self) -> &[LocationId] {
        &[]
    }

    /// Brings the state into normal form: the last tick has the number 0, the next one has the number 1, and how the
    /// state was reached is forgotten. Needed only for proofs.
    ///
    /// # Errors
    /// [`NoNormalForm`] if the monitor has none; by default it has none.
    fn normalize(&mut self) -> Result<(), NoNormalForm> {
        Err(NoNormalForm::Unsupported {
            reason: "it does not define which of its states are alike".to_owned(),
            help: None,
        })
    }

    /// Whether the other monitor, of the same property, is in the same state; both are in normal form.
    fn same_state(&self, other: &dyn Monitor) -> bool {
        let _ = other;
        false
    }

    /// Feeds the state, which is in normal form, to a hasher.
    fn hash_state(&self, hasher: &mut dyn Hasher) {
        let _ = hasher;
    }
}

impl Clone for Box<dyn Monitor> {
    fn clone(&self) -> Self {
        self.as_ref().boxed_clone()
    }
}

/// A program graph as a monitor.
///
/// It takes a receive transition in the same step in which the receiver receives the message, and a tick transition
/// when a tick is generated. Without a matching transition it stays where it is. In the same step it then takes
/// internal transitions, always the first enabled one, until none is enabled (paper, section "Runtime verification",
/// the rule of the monitored transition).
#[derive(Clone, Debug)]
pub struct GraphMonitor {
    process: GraphProcess,
    failures: Vec<LocationId>,
    open: Vec<LocationId>,
    /// The number of times each location was entered.
    visits: Vec<u64>,
}

/// More internal transitions than this in one step are considered endless: chosen, not measured.
const MAX_INTERNAL_MOVES: usize = 10_000;

impl GraphMonitor {
    /// The monitor that runs the graph. Once a location of `failures` is reached, the property is violated for good.
    ///
    /// # Panics
    /// If the graph does not have one of these locations: what can never be reached would never be violated.
    #[must_use]
    pub fn new(graph: Arc<ProgramGraph>, failures: impl IntoIterator<Item = LocationId>) -> Self {
        let visits = vec![0; graph.locations().len()];
        let failures = locations_of(&graph, failures);
        Self { process: GraphProcess::new(graph), failures, open: Vec::new(), visits }
    }

    /// Sets the locations in which an obligation is pending.
    ///
    /// # Panics
    /// As [`new`](Self::new).
    #[must_use]
    pub fn with_open(mut self, open: impl IntoIterator<Item = LocationId>) -> Self {
        self.open = locations_of(self.process.graph(), open);
        self
    }

    /// How often the location with this name was entered, even if the monitor left it in the same step.
    #[must_use]
    pub fn visits(&self, location: &str) -> u64 {
        let locations = self.process.graph().locations().iter();
        locations.zip(&self.visits).filter(|(name, _)| *name == location).map(|(_, visits)| visits).sum()
    }

    fn failed(&self) -> bool {
        self.failures.contains(&self.process.location_id())
    }

    fn follow(&mut self, transition: TransitionId, message: Option<&Message>) {
        self.process.follow(transition, message);
        self.visits[self.process.location_id().index()] += 1;
    }

    fn run_internal_moves(&mut self) {
        for _ in 0..MAX_INTERNAL_MOVES {
            match self.process.internal() {
                Some(transition) if !self.failed() => self.follow(transition, None),
                _ => return,
            }
        }
    }
}

/// These locations, all of which the graph has.
fn locations_of(graph: &ProgramGraph, locations: impl IntoIterator<Item = LocationId>) -> Vec<LocationId> {
    let checked = locations.into_iter().inspect(|location| {
        let is_here = location.index() < graph.locations().len();
        assert!(is_here, "the program graph {} does not have location {}", graph.name(), location.index());
    });
    checked.collect()
}

impl Monitor for GraphMonitor {
    fn name(&self) -> &str {
        self.process.graph().name()
    }

    fn boxed_clone(&self) -> Box<dyn Monitor> {
        Box::new(self.clone())
    }

    fn observe(&mut self, event: &Event) {
        if self.failed() {
            return;
        }
        match &event.kind {
            EventKind::Received { channel, message } => {
                if let Some(transition) = self.process.receiving(*channel, message) {
                    self.follow(transition, Some(message));
                    self.run_internal_moves();
                }
            }
            EventKind::Tick => {
                if let Some(transition) = self.process.ticking() {
                    let number = i64::try_from(event.tick).unwrap_or(i64::MAX);
                    let tick = Message::new([Value::symbol("tick"), Value::Int(number)]);
                    self.follow(transition, Some(&tick));
                    self.run_internal_moves();
                }
            }
        }
    }

    fn verdict(&self) -> Verdict {
        if self.failed() { Verdict::False } else { Verdict::Inconclusive }
    }

    fn location(&self) -> String {
        crate::Process::location(&self.process)
    }

    fn is_open(&self) -> bool {
        self.open.contains(&self.process.location_id())
    }

    fn graph(&self) -> Option<(&ProgramGraph, LocationId)> {
        Some((self.process.graph(), self.process.location_id()))
    }

    fn failures(&self) -> &[LocationId] {
        &self.failures
    }

    /// The graph's variables remain unchanged: a graph that stores tick numbers has infinitely many states.
    fn normalize(&mut self) -> Result<(), NoNormalForm> {
        self.visits.fill(0);
        Ok(())
    }

    fn same_state(&self, other: &dyn Monitor) -> bool {
        (other as &dyn Any).downcast_ref::<Self>().is_some_and(|other| self.process == other.process)
    }

    fn hash_state(&self, mut hasher: &mut dyn Hasher) {
        self.process.hash(&mut hasher);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[should_panic(expected = "the program graph small does not have location 1")]
    fn a_monitor_cannot_fail_in_a_location_of_another_graph() {
        let mut other = ProgramGraph::builder("other");
        let failure = ["a", "b"].map(|name| other.location(name))[1];
        let mut small = ProgramGraph::builder("small");
        let only = small.location("only");
        let small = small.initial(only).build().expect("a sound graph");
        let _ = GraphMonitor::new(Arc::new(small), [failure]);
    }
}
