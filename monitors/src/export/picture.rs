//! The program graph of a monitor, and the monitor's current location in it.

use std::sync::Arc;

use channels::{ChannelId, Condition, LocationId, ProgramGraph, Topology, VariableId, Verdict};

use crate::clause::Vocabulary;
use crate::engine::CompactRun;
use crate::formula::MessageCondition;
use crate::synthesis::RunningMonitor;

#[derive(Clone, Debug)]
pub(crate) struct Picture {
    pub(crate) graph: Arc<ProgramGraph>,
    /// No obligation is pending here.
    pub(super) rest: LocationId,
    /// An obligation or a ban is active here.
    pub(super) waiting: Option<LocationId>,
    /// The location of each state of an automaton.
    pub(super) states: Vec<LocationId>,
    /// The locations with a pending answer.
    pub(crate) owing: Vec<LocationId>,
    /// The locations that mean that the property is violated.
    pub(crate) failures: Vec<LocationId>,
}

impl Picture {
    /// The monitor's location after a state, when its internal transitions are done.
    pub(crate) fn location(&self, run: &RunningMonitor, verdict: Verdict) -> LocationId {
        let waits = |run: &CompactRun| run.is_armed(0);
        match (verdict, run, self.waiting, self.failures.first()) {
            (Verdict::False, .., Some(failure)) => *failure,
            (_, RunningMonitor::Compact(run), Some(waiting), _) if waits(run) => waiting,
            (_, RunningMonitor::Automaton(run), ..) => {
                run.state().and_then(|state| self.states.get(state)).copied().unwrap_or(self.rest)
            }
            _ => self.rest,
        }
    }
}

/// A channel's name among those of a formula: its sender's, with the receiver's if the sender has several channels.
pub(super) fn channel_name(channel: ChannelId, words: &Vocabulary, topology: &Topology) -> String {
    let (source, target) = topology.ends(channel);
    let of_source = words.channels().iter().filter(|other| topology.ends(**other).0 == source).count();
    if of_source > 1 { format!("{source} to {target}") } else { source.to_owned() }
}

pub(super) fn any(mut conditions: Vec<Condition>) -> Condition {
    if conditions.len() == 1 { conditions.remove(0) } else { Condition::Or(conditions) }
}

/// A condition on a message as a condition on the variable that holds it.
pub(super) fn translate(condition: &MessageCondition, variable: VariableId) -> Condition {
    by_position(&condition.spelled_out(), variable)
}

fn by_position(condition: &MessageCondition, variable: VariableId) -> Condition {
    let part = |part: &MessageCondition| by_position(part, variable);
    match condition {
        MessageCondition::True => Condition::True,
        MessageCondition::False => Condition::True.negated(),
        MessageCondition::Compare { field, relation, value } => {
            variable.field(field.number).compare(*relation, value.clone())
        }
        MessageCondition::Relate { .. } | MessageCondition::Remember { .. } | MessageCondition::Is { .. } => {
            unreachable!("a property that compares several values has no graph")
        }
        MessageCondition::Not(inside) => part(inside).negated(),
        MessageCondition::And(parts) => Condition::And(parts.iter().map(part).collect()),
        MessageCondition::Or(parts) => Condition::Or(parts.iter().map(part).collect()),
        MessageCondition::Implies(a, b) => part(a).negated().or(part(b)),
    }
}
