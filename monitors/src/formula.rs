//! Formulas with resolved names, as the semantics uses them.

use channels::{ChannelId, Message, Relation, Value};
use serde::{Deserialize, Serialize};

/// A SCOPE constraint over the channels of a topology.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Formula {
    /// Always holds.
    True,
    /// Never holds.
    False,
    /// The last message on the channel satisfies the condition.
    Event(EventAtom),
    /// `time_until (event) ⋈ ticks`: a message that satisfies the event passes at some j ≥ i with τj − τi ⋈ ticks.
    TimeUntil {
        /// The event.
        event: EventAtom,
        /// ⋈
        relation: Relation,
        /// θ
        ticks: u64,
    },
    /// The operand does not hold.
    Not(Box<Formula>),
    /// All operands hold.
    And(Vec<Formula>),
    /// One operand holds.
    Or(Vec<Formula>),
    /// If the first holds, the second does.
    Implies(Box<Formula>, Box<Formula>),
    /// The operand holds at the next state at which it is checked.
    Next(Box<Formula>),
    /// The operand holds whenever it is checked.
    Always(Box<Formula>),
    /// The operand holds at some state at which it is checked.
    Eventually(Box<Formula>),
    /// The second operand holds at some state, and the first whenever it is checked before that.
    Until(Box<Formula>, Box<Formula>),
}

/// An event atom: a channel and a condition on its messages.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct EventAtom {
    /// The channel.
    pub channel: ChannelId,
    /// What a message must satisfy.
    pub condition: MessageCondition,
}

/// A condition on one message.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum MessageCondition {
    /// Any message.
    True,
    /// No message.
    False,
    /// `m[field] ⋈ value`. If the field is missing or of another type, every relation is false except `!=`, which means
    /// `not (m[field] = value)`.
    Compare {
        /// The field, counted from 1.
        field: usize,
        /// ⋈
        relation: Relation,
        /// The value that it is compared with.
        value: Value,
    },
    /// The operand does not hold.
    Not(Box<MessageCondition>),
    /// All operands hold.
    And(Vec<MessageCondition>),
    /// One operand holds.
    Or(Vec<MessageCondition>),
    /// If the first holds, the second does.
    Implies(Box<MessageCondition>, Box<MessageCondition>),
}

impl MessageCondition {
    /// Whether a message satisfies the condition.
    #[must_use]
    pub fn holds(&self, message: &Message) -> bool {
        match self {
            Self::True => true,
            Self::False => false,
            Self::Compare { field, relation, value } => {
                message.field(*field).map_or(*relation == Relation::NotEqual, |found| relation.holds(found, value))
            }
            Self::Not(condition) => !condition.holds(message),
            Self::And(conditions) => conditions.iter().all(|condition| condition.holds(message)),
            Self::Or(conditions) => conditions.iter().any(|condition| condition.holds(message)),
            Self::Implies(a, b) => !a.holds(message) || b.holds(message),
        }
    }

    /// Calls `visit` with the field, relation and constant of each comparison.
    pub fn comparisons<'a>(&'a self, visit: &mut impl FnMut(usize, Relation, &'a Value)) {
        match self {
            Self::True | Self::False => {}
            Self::Compare { field, relation, value } => visit(*field, *relation, value),
            Self::Not(condition) => condition.comparisons(visit),
            Self::And(conditions) | Self::Or(conditions) => {
                conditions.iter().for_each(|condition| condition.comparisons(visit));
            }
            Self::Implies(a, b) => {
                a.comparisons(visit);
                b.comparisons(visit);
            }
        }
    }
}

impl Formula {
    /// The negation of this formula.
    #[must_use]
    pub fn negated(self) -> Self {
        Self::Not(Box::new(self))
    }

    /// The formula that this one implies the other.
    #[must_use]
    pub fn implies(self, other: Self) -> Self {
        Self::Implies(Box::new(self), Box::new(other))
    }

    /// `always` this formula.
    #[must_use]
    pub fn always(self) -> Self {
        Self::Always(Box::new(self))
    }

    /// Whether its form shows that it is a safety property: every run that violates it has a beginning that does, too.
    /// A formula that demands something without a bound in time is none.
    #[must_use]
    pub fn is_safety(&self) -> bool {
        self.is_bounded(true)
    }

    /// Whether nothing unbounded is demanded by the formula, or by its negation.
    fn is_bounded(&self, holds: bool) -> bool {
        match self {
            Self::True | Self::False | Self::Event(_) => true,
            Self::TimeUntil { relation, .. } => {
                !holds || matches!(relation, Relation::Less | Relation::LessOrEqual | Relation::Equal)
            }
            Self::Not(a) => a.is_bounded(!holds),
            Self::Next(a) => a.is_bounded(holds),
            Self::Always(a) => holds && a.is_bounded(true),
            Self::Eventually(a) => !holds && a.is_bounded(false),
            Self::Until(a, b) => !holds && a.is_bounded(false) && b.is_bounded(false),
            Self::And(parts) | Self::Or(parts) => parts.iter().all(|part| part.is_bounded(holds)),
            Self::Implies(a, b) => a.is_bounded(!holds) && b.is_bounded(holds),
        }
    }

    /// Calls `visit` with each event, including those inside `time_until`.
    pub fn events<'a>(&'a self, visit: &mut impl FnMut(&'a EventAtom)) {
        match self {
            Self::True | Self::False => {}
            Self::Event(event) | Self::TimeUntil { event, .. } => visit(event),
            Self::Not(a) | Self::Next(a) | Self::Always(a) | Self::Eventually(a) => a.events(visit),
            Self::And(parts) | Self::Or(parts) => parts.iter().for_each(|part| part.events(visit)),
            Self::Implies(a, b) | Self::Until(a, b) => {
                a.events(visit);
                b.events(visit);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use channels::{Capacity, Domain, Topology};

    use super::*;

    #[test]
    fn what_demands_something_without_a_bound_is_no_safety_property() {
        let mut topology = Topology::default();
        let [from, to] = ["A", "B"].map(|name| topology.process(name).expect("a new name"));
        let channel = topology.channel(from, to, Capacity::One, Domain::new([])).expect("a new channel");
        let event = || EventAtom { channel, condition: MessageCondition::True };
        let seen = || Formula::Event(event());
        let within = |relation| Formula::TimeUntil { event: event(), relation, ticks: 10 };
        let eventually = |formula| Formula::Eventually(Box::new(formula));
        let until = |a, b| Formula::Until(Box::new(a), Box::new(b));
        for (formula, is_safety) in [
            (seen().implies(within(Relation::Less)).always(), true),
            (seen().implies(within(Relation::Greater)).always(), false),
            (within(Relation::Greater).negated().always(), true),
            (eventually(seen()), false),
            (eventually(seen()).negated(), true),
            (seen().implies(eventually(seen())).always(), false),
            (eventually(seen()).implies(seen()), true),
            (until(seen().negated(), seen()), false),
            (until(seen(), seen()).negated(), true),
            (Formula::Or(vec![seen().always().negated(), seen()]), false),
        ] {
            assert_eq!(formula.is_safety(), is_safety, "{formula:?}");
        }
    }
}
