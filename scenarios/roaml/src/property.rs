//! Properties: JANI properties about the probability of a formula about the latest messages.

mod formula;
mod read;

use std::any::Any;
use std::collections::BTreeMap;
use std::hash::{Hash, Hasher};
use std::sync::Arc;

use bt::{NodeState, Outcome, Status};
use channels::{ChannelId, Event, EventKind, Monitor, NoNormalForm, Topology, Verdict};
use diagnostics::{Problem, Source, Span, Spanned};

use formula::{Path, Valuation, Variable};

use crate::instance::{Fields, RECORDER};
use crate::machine::nested;

/// A property of a model: in a run it is true or false, and over many runs it has a probability.
#[derive(Clone, Debug)]
pub struct Property {
    /// Its name.
    pub name: String,
    /// Its formula, as text.
    pub formula: String,
    /// Where its file names it.
    pub place: Span,
    path: Path,
}

impl Property {
    /// Reads the properties of a file.
    ///
    /// # Errors
    /// Everything that is wrong with the file, and what is not supported in JANI.
    pub(crate) fn read(file: &Source, events: &BTreeMap<String, Fields>) -> Result<Vec<Self>, Vec<Problem>> {
        let property = |(Spanned { value: name, span: place }, path): (_, Path)| {
            let formula = path.to_string();
            Self { name, formula, place, path }
        };
        Ok(read::properties(file, events)?.into_iter().map(property).collect())
    }

    pub(crate) fn events(&self) -> impl Iterator<Item = &str> {
        let mut found = Vec::new();
        self.visit(&mut |variable| {
            if let Variable::Valid(event) | Variable::Field(event, ..) = variable {
                found.push(event.as_str());
            }
        });
        found.into_iter()
    }

    fn asks_for_nodes(&self) -> bool {
        let mut asks = false;
        self.visit(&mut |variable| asks |= matches!(variable, Variable::Node(_)));
        asks
    }

    fn visit<'p>(&'p self, visit: &mut dyn FnMut(&'p Variable)) {
        [&self.path.left, &self.path.right].into_iter().for_each(|expression| expression.visit(visit));
    }
}

/// A property that watches a run: the monitor of a formula about the latest messages.
#[derive(Clone, Debug)]
pub struct PropertyMonitor {
    property: Arc<Property>,
    /// The channels that carry the formula's messages, and the fields of these messages.
    channels: Arc<[ChannelId]>,
    fields: Arc<BTreeMap<String, Fields>>,
    state: Valuation,
    verdict: Option<bool>,
}

impl PropertyMonitor {
    /// The monitor in a system with this topology. `events` are the fields of the model's events.
    pub(crate) fn new(property: &Property, events: &BTreeMap<String, Fields>, topology: &Topology) -> Self {
        let recorder = topology.find_process(RECORDER);
        let channels = topology.channels().filter(|channel| Some(topology.get(*channel).target) == recorder);
        let fields = property.events().filter_map(|event| Some((event.to_owned(), events.get(event)?.clone())));
        let mut monitor = Self {
            property: Arc::new(property.clone()),
            channels: channels.collect(),
            fields: Arc::new(fields.collect()),
            state: Valuation::default(),
            verdict: None,
        };
        monitor.judge(0);
        monitor
    }

    /// Updates the status of the tree's nodes after a tick has finished, after `step` communications.
    pub fn see_tree(&mut self, nodes: &[NodeState], step: u64) {
        self.state.nodes.resize(nodes.len(), 0);
        for (known, node) in self.state.nodes.iter_mut().zip(nodes) {
            match node.outcome {
                Some(Outcome::Answered(Status::Success)) => *known = 1,
                Some(Outcome::Answered(Status::Failure)) => *known = 2,
                Some(Outcome::Answered(Status::Running)) => *known = 3,
                _ => {}
            }
        }
        self.judge(step);
    }

    /// Judges the current state, after `step` communications.
    fn judge(&mut self, step: u64) {
        if self.verdict.is_none() {
            self.verdict = self.property.path.verdict(&self.state, step);
        }
    }
}

fn in_words(verdict: Option<bool>) -> Verdict {
    match verdict {
        Some(true) => Verdict::True,
        Some(false) => Verdict::False,
        None => Verdict::Inconclusive,
    }
}

impl Monitor for PropertyMonitor {
    fn name(&self) -> &str {
        &self.property.name
    }

    fn boxed_clone(&self) -> Box<dyn Monitor> {
        Box::new(self.clone())
    }

    fn observe(&mut self, event: &Event) {
        let EventKind::Received { channel, message } = &event.kind else { return };
        if self.verdict.is_some() {
            return;
        }
        if self.channels.contains(channel)
            && let Some((head, fields)) = message.head().and_then(|head| self.fields.get_key_value(head))
        {
            let values = fields.iter().zip(message.fields().iter().skip(1));
            let values = values.map(|((name, kind), value)| (name.clone(), kind.datum(value)));
            self.state.latest.insert(head.clone(), nested(values.collect()));
        } else if !self.property.path.counts_steps() {
            return;
        }
        self.judge(event.step);
    }

    fn verdict(&self) -> Verdict {
        in_words(self.verdict)
    }

    fn verdict_at_end(&self) -> Verdict {
        in_words(self.verdict.or(Some(self.property.path.at_end)))
    }

    fn normalize(&mut self) -> Result<(), NoNormalForm> {
        let refused = |reason: &str, help: &str| {
            Err(NoNormalForm::Unsupported { reason: reason.to_owned(), help: Some(help.to_owned()) })
        };
        if self.property.path.counts_steps() {
            return refused("it counts steps, which never repeat", "leave out `step-bounds`");
        }
        if self.property.asks_for_nodes() {
            return refused(
                "it asks about the nodes of the tree, which only a run shows",
                "ask about messages instead",
            );
        }
        Ok(())
    }

    fn same_state(&self, other: &dyn Monitor) -> bool {
        let other = (other as &dyn Any).downcast_ref::<Self>();
        other.is_some_and(|other| self.verdict == other.verdict && self.state == other.state)
    }

    fn hash_state(&self, mut hasher: &mut dyn Hasher) {
        (self.verdict, &self.state).hash(&mut hasher);
    }

    fn location(&self) -> String {
        self.verdict.map_or_else(|| "undecided".to_owned(), |verdict| verdict.to_string())
    }

    fn is_open(&self) -> bool {
        self.verdict.is_none() && !self.property.path.at_end
    }
}
