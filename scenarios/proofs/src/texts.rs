//! What a property does with texts that components choose.

use channels::{ChannelId, FieldKind, Monitor, Relation, Topology, Value};
use diagnostics::Problem;
use monitors::{MessageCondition, ScopeMonitor, Term, scope_monitor};
use scenarios::scenario::{Carrier, MachineMonitor, Scenario};

/// # Errors
/// The problem of a property that may tell more texts apart than are tried.
///
/// The texts that a proof tries are as many as a property may remember. That is enough if one message decides each of
/// them: in `always`, a single position violates the property. It is not if the property has to fail at every position,
/// each with another text.
pub(super) fn check(scenario: &Scenario, topology: &Topology, monitor: &dyn Monitor) -> Result<(), Problem> {
    let carriers = &scenario.samples.carriers;
    if carriers.is_empty() {
        return Ok(());
    }
    let name = monitor.name();
    if let Some(words) = scenario.samples.unfollowed.get(name) {
        let problem = Problem::new(format!(
            "the property {name} compares {words} with a text that is not known, which a proof cannot follow"
        ));
        return Err(problem.with_help("compare it with constants, or with what it is sent as"));
    }
    let texts = Texts { topology, carriers };
    let is_followed = match (MachineMonitor::of(monitor), scope_monitor(monitor)) {
        (Some(machine), _) => !topology.channels().any(|id| texts.on(id) && machine.watches(id)),
        (None, Some(scope)) => texts.follows(scope),
        (None, None) => true,
    };
    if is_followed {
        return Ok(());
    }
    let from: Vec<&str> = carriers.iter().map(|carrier| carrier.from.as_str()).collect();
    let mut from: Vec<&str> = from.into_iter().filter(|from| *from != recording::TREE).collect();
    from.sort_unstable();
    from.dedup();
    let problem = Problem::new(format!(
        "the property {name} does more with texts from {} than a proof can follow",
        from.join(" and ")
    ));
    Err(problem.with_help(
        "compare them with constants, or with texts that `always` remembers of one message; a text that is remembered \
         at each of many positions cannot be followed",
    ))
}

struct Texts<'a> {
    topology: &'a Topology,
    carriers: &'a [Carrier],
}

impl Texts<'_> {
    fn carriers_on(&self, channel: ChannelId) -> impl Iterator<Item = &Carrier> {
        let (from, to) = self.topology.ends(channel);
        let is_on = move |carrier: &&Carrier| carrier.from == from && carrier.to.as_deref().is_none_or(|it| it == to);
        self.carriers.iter().filter(is_on)
    }

    /// Whether messages on the channel may have such a text.
    fn on(&self, channel: ChannelId) -> bool {
        self.carriers_on(channel).next().is_some()
    }

    /// Whether the field with this number may be such a text.
    fn in_field(&self, channel: ChannelId, number: usize) -> bool {
        let shapes = self.topology.get(channel).domain.shapes();
        let fields = shapes.iter().filter_map(|shape| shape.fields().get(number.checked_sub(1)?));
        let carried = |name: &str| {
            self.carriers_on(channel).any(|carrier| carrier.field.as_deref().is_none_or(|field| field == name))
        };
        fields.into_iter().any(|(name, kind)| *kind.present() == FieldKind::Text && carried(name))
    }

    /// Whether the property does nothing but compare such texts.
    fn follows(&self, scope: &ScopeMonitor) -> bool {
        let mut follows = true;
        scope.formula().roles(&mut |event, role| {
            follows &= self.compares(&event.condition, event.channel, role.many);
        });
        follows
    }

    /// Whether a condition does nothing but compare such texts; `many` means that many positions together decide
    /// whether the property holds.
    fn compares(&self, condition: &MessageCondition, channel: ChannelId, many: bool) -> bool {
        let has_text = |term: &Term| {
            let mut has_text = false;
            term.fields(&mut |field| has_text |= self.in_field(channel, field.number));
            has_text
        };
        let is_plain = |term: &Term| matches!(term, Term::Field(_) | Term::Value(_) | Term::Remembered(_));
        match condition {
            MessageCondition::Remember { field, .. } => !many || !self.in_field(channel, field.number),
            MessageCondition::Relate { left, relation, right } => {
                let is_equality = matches!(relation, Relation::Equal | Relation::NotEqual);
                is_equality && is_plain(left) && is_plain(right) || !has_text(left) && !has_text(right)
            }
            // No text is less or greater than a number: whatever it is, such a comparison is false.
            MessageCondition::Compare { field, relation, value } => {
                matches!(relation, Relation::Equal | Relation::NotEqual)
                    || !matches!(value, Value::Text(_))
                    || !self.in_field(channel, field.number)
            }
            MessageCondition::True | MessageCondition::False | MessageCondition::Is { .. } => true,
            MessageCondition::Not(_)
            | MessageCondition::And(_)
            | MessageCondition::Or(_)
            | MessageCondition::Implies(..) => {
                condition.operands().into_iter().all(|part| self.compares(part, channel, many))
            }
        }
    }
}
