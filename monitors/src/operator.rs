//! What the operators of formulas have in common, so that only what gives them a meaning matches on each of them.

use channels::{ChannelId, Relation};

use crate::formula::{Bound, EventAtom, Formula};

/// Which states an operator is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Tense {
    /// The state in which it is judged.
    Present,
    /// That state or later ones.
    Future,
    /// That state or earlier ones.
    Past,
}

/// An operator in front of its operand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Prefix {
    /// `not α`
    Not,
    /// `next α`
    Next,
    /// `always α`
    Always,
    /// `eventually α`
    Eventually,
    /// `once[⋈ bound] α`
    Once,
    /// `historically[⋈ bound] α`
    Historically,
    /// `previous[⋈ bound] α`
    Previous,
    /// `becomes α`: `α and not previous α`.
    Becomes,
}

/// An operator between its operands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Infix {
    /// `α until β`
    Until,
    /// `α since[⋈ bound] β`
    Since,
    /// `α implies β`
    Implies,
}

impl Prefix {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::Not,
        Self::Next,
        Self::Always,
        Self::Eventually,
        Self::Once,
        Self::Historically,
        Self::Previous,
        Self::Becomes,
    ];

    /// The word for it.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Not => "not",
            Self::Next => "next",
            Self::Always => "always",
            Self::Eventually => "eventually",
            Self::Once => "once",
            Self::Historically => "historically",
            Self::Previous => "previous",
            Self::Becomes => "becomes",
        }
    }

    /// Whether the paper's language has it, too.
    pub(crate) fn is_of_the_paper(self) -> bool {
        matches!(self, Self::Not | Self::Next | Self::Always | Self::Eventually)
    }

    /// Whether a bound may follow it.
    #[must_use]
    pub fn takes_bound(self) -> bool {
        matches!(self, Self::Once | Self::Historically | Self::Previous)
    }

    pub(crate) fn tense(self) -> Tense {
        match self {
            Self::Not => Tense::Present,
            Self::Next | Self::Always | Self::Eventually => Tense::Future,
            Self::Once | Self::Historically | Self::Previous | Self::Becomes => Tense::Past,
        }
    }

    /// The formula that it makes of an operand. The bound matters only if it takes one.
    pub(crate) fn of(self, bound: Bound, operand: Formula) -> Formula {
        let operand = Box::new(operand);
        match self {
            Self::Not => Formula::Not(operand),
            Self::Next => Formula::Next(operand),
            Self::Always => Formula::Always(operand),
            Self::Eventually => Formula::Eventually(operand),
            Self::Once => Formula::Once(bound, operand),
            Self::Historically => Formula::Historically(bound, operand),
            Self::Previous => Formula::Previous(bound, operand),
            Self::Becomes => {
                let before = Formula::Previous(Bound::NONE, operand.clone());
                Formula::And(vec![*operand, before.negated()])
            }
        }
    }
}

impl Infix {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Until, Self::Since, Self::Implies];

    /// The word for it.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Until => "until",
            Self::Since => "since",
            Self::Implies => "implies",
        }
    }

    /// Whether the paper's language has it, too.
    pub(crate) fn is_of_the_paper(self) -> bool {
        self != Self::Since
    }

    /// Whether a bound may follow it.
    #[must_use]
    pub fn takes_bound(self) -> bool {
        self == Self::Since
    }

    pub(crate) fn tense(self) -> Tense {
        match self {
            Self::Until => Tense::Future,
            Self::Since => Tense::Past,
            Self::Implies => Tense::Present,
        }
    }

    /// The formula that it makes of two operands. The bound matters only to `since`.
    pub(crate) fn of(self, bound: Bound, left: Formula, right: Formula) -> Formula {
        let (left, right) = (Box::new(left), Box::new(right));
        match self {
            Self::Until => Formula::Until(left, right),
            Self::Since => Formula::Since(bound, left, right),
            Self::Implies => Formula::Implies(left, right),
        }
    }
}

/// A formula as an operator and its operands.
pub(crate) enum Parts<'f> {
    /// It has no operands.
    Atom,
    Prefix(Prefix, Bound, &'f Formula),
    Infix(Infix, Bound, [&'f Formula; 2]),
    /// Operands joined by `and` or `or`.
    Joined(&'f [Formula]),
    Timed(&'f Formula),
}

/// What a formula depends on, besides the order in which the events of its channels begin and cease to hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Need {
    /// Each message, also one that repeats the one before: those on this channel, or on all of the formula's.
    EachMessage(Option<ChannelId>),
    /// How long ago something was.
    Ago,
    /// How soon something happens.
    Soon,
}

/// What an event means for the formula that contains it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Role {
    /// Whether it has to hold, rather than its negation.
    pub holds: bool,
    /// Whether it is required by itself, rather than as a condition or an alternative.
    pub alone: bool,
    /// Whether many states decide together whether the formula holds, rather than one of them.
    pub many: bool,
}

impl Role {
    /// The role of what is negated.
    #[must_use]
    pub fn negated(self) -> Self {
        Self { holds: !self.holds, ..self }
    }

    /// The role of a condition or an alternative.
    #[must_use]
    pub fn among_others(self) -> Self {
        Self { alone: false, ..self }
    }

    /// The role of what is judged at each of several states: all must satisfy it, or one of them.
    fn at_states(self, all: bool) -> Self {
        // One state refutes what must hold at all of them, and no state by itself refutes what must hold at one.
        let decides = all == self.holds;
        Self { alone: self.alone && decides, many: self.many || !decides, ..self }
    }
}

impl Formula {
    pub(crate) fn parts(&self) -> Parts<'_> {
        match self {
            Self::True
            | Self::False
            | Self::Event(_)
            | Self::Fresh(_)
            | Self::TimeUntil { .. }
            | Self::Count { .. } => Parts::Atom,
            Self::Not(a) => Parts::Prefix(Prefix::Not, Bound::NONE, a),
            Self::Next(a) => Parts::Prefix(Prefix::Next, Bound::NONE, a),
            Self::Always(a) => Parts::Prefix(Prefix::Always, Bound::NONE, a),
            Self::Eventually(a) => Parts::Prefix(Prefix::Eventually, Bound::NONE, a),
            Self::Once(bound, a) => Parts::Prefix(Prefix::Once, *bound, a),
            Self::Historically(bound, a) => Parts::Prefix(Prefix::Historically, *bound, a),
            Self::Previous(bound, a) => Parts::Prefix(Prefix::Previous, *bound, a),
            Self::Until(a, b) => Parts::Infix(Infix::Until, Bound::NONE, [a, b]),
            Self::Since(bound, a, b) => Parts::Infix(Infix::Since, *bound, [a, b]),
            Self::Implies(a, b) => Parts::Infix(Infix::Implies, Bound::NONE, [a, b]),
            Self::And(parts) | Self::Or(parts) => Parts::Joined(parts),
            Self::Timed(a) => Parts::Timed(a),
        }
    }

    /// Its immediate subformulas, in the order in which they are written.
    #[must_use]
    pub fn operands(&self) -> Vec<&Self> {
        match self.parts() {
            Parts::Atom => Vec::new(),
            Parts::Prefix(_, _, a) | Parts::Timed(a) => vec![a],
            Parts::Infix(_, _, operands) => operands.to_vec(),
            Parts::Joined(parts) => parts.iter().collect(),
        }
    }

    /// Which states its outermost operator is about.
    pub(crate) fn tense(&self) -> Tense {
        match (self, self.parts()) {
            (Self::TimeUntil { .. }, _) => Tense::Future,
            (Self::Count { .. }, _) => Tense::Past,
            (_, Parts::Prefix(operator, ..)) => operator.tense(),
            (_, Parts::Infix(operator, ..)) => operator.tense(),
            (_, Parts::Atom | Parts::Joined(_) | Parts::Timed(_)) => Tense::Present,
        }
    }

    /// The bound of its outermost operator, if there is one.
    fn bound(&self) -> Option<Bound> {
        let bound = match (self, self.parts()) {
            (Self::TimeUntil { bound, .. } | Self::Count { bound, .. }, _) => *bound,
            (_, Parts::Prefix(_, bound, _) | Parts::Infix(_, bound, _)) => bound,
            (_, Parts::Atom | Parts::Joined(_) | Parts::Timed(_)) => Bound::NONE,
        };
        (bound != Bound::NONE).then_some(bound)
    }

    /// Its bounds that count ticks: all but those of timed parts.
    #[must_use]
    pub fn bounds_in_ticks(&self) -> Vec<Bound> {
        if self.is_timed() {
            return Vec::new();
        }
        self.bound().into_iter().chain(self.operands().into_iter().flat_map(Self::bounds_in_ticks)).collect()
    }

    /// Whether the formula has no operators that look ahead or back.
    pub(crate) fn is_of_the_present(&self) -> bool {
        match self.parts() {
            Parts::Atom => matches!(self, Self::Event(_) | Self::Fresh(_)),
            Parts::Timed(_) => false,
            _ => self.tense() == Tense::Present && self.operands().into_iter().all(Self::is_of_the_present),
        }
    }

    pub(crate) fn looks_ahead(&self) -> bool {
        self.tense() == Tense::Future || self.operands().into_iter().any(Self::looks_ahead)
    }

    /// Whether an operator that looks ahead is inside one that looks back.
    pub(crate) fn looks_ahead_of_the_past(&self) -> bool {
        let is_past = self.tense() == Tense::Past;
        let looks_bad = |part: &Self| if is_past { part.looks_ahead() } else { part.looks_ahead_of_the_past() };
        self.operands().into_iter().any(looks_bad)
    }

    /// Whether its form shows that it is a safety property: every run that violates it has a beginning that does, too.
    /// A formula that requires something without a time limit is not one.
    #[must_use]
    pub fn is_safety(&self) -> bool {
        self.is_bounded(true)
    }

    /// The channel whose messages the formula judges, if it judges each by itself: it is `always` of conditions on the
    /// messages of one channel. No other message, and none before or after it, changes how it judges one.
    #[must_use]
    pub fn judges_each_message_on(&self) -> Option<ChannelId> {
        match self {
            Self::Always(part) if part.is_of_the_present() => {
                let mut channels = Vec::new();
                part.events(&mut |event| channels.push(event.channel));
                let first = *channels.first()?;
                channels.iter().all(|channel| *channel == first).then_some(first)
            }
            _ => None,
        }
    }

    /// Whether the formula is about messages on the channel.
    #[must_use]
    pub fn is_about(&self, channel: ChannelId) -> bool {
        let mut is_about = false;
        self.events(&mut |event| is_about |= event.channel == channel);
        is_about
    }

    /// Whether the formula (or its negation, unless `holds`) demands nothing unbounded.
    fn is_bounded(&self, holds: bool) -> bool {
        match self {
            Self::True | Self::False | Self::Event(_) | Self::Fresh(_) => true,
            Self::Once(..) | Self::Historically(..) | Self::Previous(..) | Self::Since(..) | Self::Count { .. } => true,
            Self::TimeUntil { bound, .. } => {
                !holds || matches!(bound.relation, Relation::Less | Relation::LessOrEqual | Relation::Equal)
            }
            Self::Timed(a) => a.is_bounded(holds),
            Self::Not(a) => a.is_bounded(!holds),
            Self::Next(a) => a.is_bounded(holds),
            Self::Always(a) => holds && a.is_bounded(true),
            Self::Eventually(a) => !holds && a.is_bounded(false),
            Self::Until(a, b) => !holds && a.is_bounded(false) && b.is_bounded(false),
            Self::And(parts) | Self::Or(parts) => parts.iter().all(|part| part.is_bounded(holds)),
            Self::Implies(a, b) => a.is_bounded(!holds) && b.is_bounded(holds),
        }
    }

    /// What it depends on besides the order of changes, in the order in which it is written.
    #[must_use]
    pub fn needs(&self) -> Vec<Need> {
        let own = match self {
            Self::True | Self::False | Self::Event(_) | Self::Timed(_) => None,
            Self::Not(_) | Self::And(_) | Self::Or(_) | Self::Implies(..) => None,
            Self::Always(_) | Self::Eventually(_) | Self::Until(..) => None,
            Self::Next(_) | Self::Previous(..) | Self::Count { .. } => Some(Need::EachMessage(None)),
            Self::Fresh(event) => Some(Need::EachMessage(Some(event.channel))),
            Self::Once(bound, _) | Self::Historically(bound, _) | Self::Since(bound, ..) => {
                (*bound != Bound::NONE).then_some(Need::Ago)
            }
            Self::TimeUntil { .. } => Some(Need::Soon),
        };
        own.into_iter().chain(self.operands().into_iter().flat_map(Self::needs)).collect()
    }

    /// Whether it makes no difference how often the last message on the channel is repeated, and when.
    #[must_use]
    pub fn is_steady(&self, channel: ChannelId) -> bool {
        let is_harmless = |need| matches!(need, Need::EachMessage(Some(other)) if other != channel);
        !self.is_timed() && self.needs().into_iter().all(is_harmless)
    }

    /// Calls `visit` with each event that is judged where the formula itself is: outside operators that look ahead or
    /// back.
    pub(crate) fn own_events<'a>(&'a self, visit: &mut impl FnMut(&'a EventAtom)) {
        match self {
            Self::Event(event) | Self::Fresh(event) => visit(event),
            _ if self.tense() == Tense::Present => {
                self.operands().into_iter().for_each(|operand| operand.own_events(visit));
            }
            _ => {}
        }
    }

    /// Calls `visit` with each event, including those inside `time_until`.
    pub fn events<'a>(&'a self, visit: &mut impl FnMut(&'a EventAtom)) {
        match self {
            Self::Event(event) | Self::Fresh(event) | Self::TimeUntil { event, .. } | Self::Count { event, .. } => {
                visit(event);
            }
            _ => self.operands().into_iter().for_each(|operand| operand.events(visit)),
        }
    }

    /// Calls `visit` with each event, including those inside `time_until`.
    pub(crate) fn events_mut(&mut self, visit: &mut dyn FnMut(&mut EventAtom)) {
        match self {
            Self::True | Self::False => {}
            Self::Event(event) | Self::Fresh(event) | Self::TimeUntil { event, .. } | Self::Count { event, .. } => {
                visit(event);
            }
            Self::Not(a) | Self::Next(a) | Self::Always(a) | Self::Eventually(a) | Self::Timed(a) => {
                a.events_mut(visit)
            }
            Self::Once(_, a) | Self::Historically(_, a) | Self::Previous(_, a) => a.events_mut(visit),
            Self::Until(a, b) | Self::Since(_, a, b) | Self::Implies(a, b) => {
                [a, b].into_iter().for_each(|part| part.events_mut(visit));
            }
            Self::And(parts) | Self::Or(parts) => parts.iter_mut().for_each(|part| part.events_mut(visit)),
        }
    }

    /// Calls `visit` with each event that a `time_until` waits for.
    pub fn awaited<'a>(&'a self, visit: &mut impl FnMut(&'a EventAtom)) {
        match self {
            Self::TimeUntil { event, .. } => visit(event),
            _ => self.operands().into_iter().for_each(|operand| operand.awaited(visit)),
        }
    }

    /// Calls `visit` with each event and its role, in the order in which they are written.
    pub fn roles<'a>(&'a self, visit: &mut dyn FnMut(&'a EventAtom, Role)) {
        self.roles_as(Role { holds: true, alone: true, many: false }, visit);
    }

    fn roles_as<'a>(&'a self, role: Role, visit: &mut dyn FnMut(&'a EventAtom, Role)) {
        let among_many = Role { alone: false, many: true, ..role };
        match self {
            Self::True | Self::False => {}
            Self::Event(event) | Self::Fresh(event) => visit(event, role),
            // What happens at most zero times never happens.
            Self::Count { event, is_at_most: true, count: 0, .. } if role.holds => {
                visit(event, Role { many: true, ..role.negated() });
            }
            Self::TimeUntil { event, .. } | Self::Count { event, .. } => visit(event, among_many),
            Self::Not(part) => part.roles_as(role.negated(), visit),
            Self::Timed(part) | Self::Next(part) => part.roles_as(role, visit),
            Self::Previous(_, part) => part.roles_as(role.among_others(), visit),
            Self::Always(part) | Self::Historically(_, part) => part.roles_as(role.at_states(true), visit),
            Self::Eventually(part) | Self::Once(_, part) => part.roles_as(role.at_states(false), visit),
            // `not (a and b)` is `a implies not b`.
            Self::And(parts) => parts.iter().for_each(|part| part.roles_as(role, visit)),
            Self::Or(parts) => {
                let role = if role.holds { role.among_others() } else { role };
                parts.iter().for_each(|part| part.roles_as(role, visit));
            }
            Self::Implies(part, never) if **never == Self::False => part.roles_as(role.negated(), visit),
            Self::Implies(condition, part) => {
                condition.roles_as(role.negated().among_others(), visit);
                part.roles_as(role, visit);
            }
            Self::Until(hold, goal) => {
                hold.roles_as(role.at_states(true).among_others(), visit);
                goal.roles_as(role.at_states(false).among_others(), visit);
            }
            Self::Since(_, hold, goal) => [hold, goal].into_iter().for_each(|part| part.roles_as(among_many, visit)),
        }
    }
}

#[cfg(test)]
mod tests {
    use channels::{Capacity, Domain, Topology};

    use super::*;
    use crate::formula::MessageCondition;

    #[test]
    fn a_property_that_judges_each_message_by_itself_is_about_one_channel() {
        let mut topology = Topology::default();
        let [a, b] = ["A", "B"].map(|name| topology.process(name).expect("a new name"));
        let mut channel = |from, to| {
            let made = topology.channel(from, to, Capacity::One, Domain::new([])).expect("a new channel");
            Formula::Event(EventAtom { channel: made, condition: MessageCondition::True })
        };
        let (there, back) = (channel(a, b), channel(b, a));
        let Formula::Event(EventAtom { channel, .. }) = there else { panic!("an event") };
        let judged = |formula: Formula| formula.always().judges_each_message_on();
        assert_eq!(judged(there.clone().implies(there.clone().negated())), Some(channel));
        assert_eq!(judged(there.clone().implies(back)), None);
        assert_eq!(judged(there.clone().implies(Formula::Next(Box::new(there.clone())))), None);
        assert_eq!(there.judges_each_message_on(), None);
    }

    #[test]
    fn a_demand_without_a_bound_is_not_a_safety_property() {
        let mut topology = Topology::default();
        let [from, to] = ["A", "B"].map(|name| topology.process(name).expect("a new name"));
        let channel = topology.channel(from, to, Capacity::One, Domain::new([])).expect("a new channel");
        let event = || EventAtom { channel, condition: MessageCondition::True };
        let seen = || Formula::Event(event());
        let within = |relation| Formula::TimeUntil { event: event(), bound: Bound::new(relation, 10) };
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

    #[test]
    fn the_role_of_an_event_follows_from_the_operators_around_it() {
        let mut topology = Topology::default();
        let [from, to] = ["A", "B"].map(|name| topology.process(name).expect("a new name"));
        let channel = topology.channel(from, to, Capacity::One, Domain::new([])).expect("a new channel");
        let event = || EventAtom { channel, condition: MessageCondition::True };
        let seen = || Formula::Event(event());
        let never = Formula::Count { event: event(), is_at_most: true, count: 0, bound: Bound::new(Relation::Less, 5) };
        let roles = |formula: Formula| {
            let mut roles = Vec::new();
            formula.roles(&mut |_, Role { holds, alone, many }| roles.push((holds, alone, many)));
            roles
        };
        for (formula, expected) in [
            (seen().always(), vec![(true, true, false)]),
            (seen().always().negated(), vec![(false, false, true)]),
            (Formula::Eventually(Box::new(seen())), vec![(true, false, true)]),
            (Formula::Eventually(Box::new(seen())).negated(), vec![(false, true, false)]),
            (seen().implies(seen()).always(), vec![(false, false, false), (true, true, false)]),
            (seen().implies(Formula::False).always(), vec![(false, true, false)]),
            (Formula::Or(vec![seen(), seen()]).always(), vec![(true, false, false); 2]),
            (Formula::Or(vec![seen(), seen()]).negated().always(), vec![(false, true, false); 2]),
            (Formula::Until(Box::new(seen()), Box::new(seen())), vec![(true, false, false), (true, false, true)]),
            (never.always(), vec![(false, true, true)]),
        ] {
            assert_eq!(roles(formula.clone()), expected, "{formula:?}");
        }
    }
}
