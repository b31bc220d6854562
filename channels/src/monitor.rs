//! Monitored transitions: monitors move with the messages they watch and disturb nobody.

use std::any::Any;
use std::fmt::Debug;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::graph::{GraphProcess, LocationId, ProgramGraph};
use crate::{Event, EventKind, Message, TransitionId, Value};

/// What a monitor can say while the run goes on. True and false are final.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
pub enum Verdict {
    /// However the run goes on, the property holds.
    True,
    /// However the run goes on, the property is violated.
    False,
    /// It depends on how the run goes on.
    #[default]
    Inconclusive,
}

/// A monitor: it sees every event of the timed state sequence in the step in which it happens.
///
/// It is [`Any`], so that whoever knows what kind of monitor it is can ask it for more, and it can be copied, so that a
/// monitor that was made once watches any number of runs.
pub trait Monitor: Any + Debug + Send + Sync {
    /// The name of the property that is watched.
    fn name(&self) -> &str;

    /// A copy of the monitor as it stands.
    fn boxed_clone(&self) -> Box<dyn Monitor>;

    /// Moves with an event. It must be fast, and it must not depend on anything but the events.
    fn observe(&mut self, event: &Event);

    /// What can be said so far.
    fn verdict(&self) -> Verdict;

    /// Where the monitor stands, in a word.
    fn location(&self) -> String;

    /// Whether something is still owed: a run that ends now ends without an answer.
    fn is_open(&self) -> bool;

    /// The monitor as a program graph with its active location, where it has that form: for pictures and exports.
    fn graph(&self) -> Option<(&ProgramGraph, LocationId)> {
        None
    }

    /// The locations of the graph that mean that the property is violated.
    fn failures(&self) -> &[LocationId] {
        &[]
    }
}

impl Clone for Box<dyn Monitor> {
    fn clone(&self) -> Self {
        self.as_ref().boxed_clone()
    }
}

/// A program graph as a monitor.
///
/// It takes a receive transition when the message it waits for is received by the process it was meant for, in the
/// same step, and a tick transition when a tick is generated; without a matching transition it stays where it is. Its
/// internal moves then run to their end in that step, the first enabled one at a time (paper, section "Runtime
/// verification", the rule of the monitored transition).
#[derive(Clone, Debug)]
pub struct GraphMonitor {
    process: GraphProcess,
    failures: Vec<LocationId>,
    open: Vec<LocationId>,
    /// By location, how often it was entered.
    visits: Vec<u64>,
}

/// More internal moves than this in one step are taken to be endless.
const MAX_INTERNAL_MOVES: usize = 10_000;

impl GraphMonitor {
    /// The monitor that runs the graph; in a location of `failures` the property is violated, for good.
    #[must_use]
    pub fn new(graph: Arc<ProgramGraph>, failures: impl IntoIterator<Item = LocationId>) -> Self {
        let visits = vec![0; graph.locations().len()];
        Self { process: GraphProcess::new(graph), failures: failures.into_iter().collect(), open: Vec::new(), visits }
    }

    /// The monitor, in whose locations `open` something is still owed.
    #[must_use]
    pub fn with_open(mut self, open: impl IntoIterator<Item = LocationId>) -> Self {
        self.open = open.into_iter().collect();
        self
    }

    /// How often the location of that name was entered, also where the monitor left it in the same step.
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
}
