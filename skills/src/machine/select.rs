//! Selects the next transitions (SCXML 3.13).

use super::macrostep::Macrostep;
use crate::chart::{EventClass, StateKind, TransitionDomain};
use crate::ids::{StateId, TransitionId};
use crate::random;

impl Macrostep<'_, '_> {
    /// Puts the transitions enabled by an event of this class, or without an event, into `scratch.enabled`, except
    /// those that others preempt (selectTransitions, selectEventlessTransitions).
    pub(super) fn select(&mut self, class: Option<EventClass>) {
        self.machine.scratch.enabled.clear();
        let mut from = 0;
        while let Some(index) = self.machine.configuration.next_from(from) {
            from = index + 1;
            if self.chart.states[index].is_atomic()
                && let Some(transition) = self.first_enabled(StateId::new(index), class)
                && !self.machine.scratch.enabled.contains(&transition)
            {
                self.machine.scratch.enabled.push(transition);
            }
        }
        if self.machine.scratch.enabled.len() > 1 {
            self.remove_conflicts();
        }
    }

    /// The first enabled transition of an atomic state or, if it has none, of its ancestors, from the inside out.
    fn first_enabled(&mut self, atomic: StateId, class: Option<EventClass>) -> Option<TransitionId> {
        let chart = self.chart;
        let mut state = Some(atomic);
        while let Some(id) = state {
            let source = chart.state(id);
            let enabled = source.transitions.iter().find(|transition| self.is_enabled(**transition, class));
            if let Some(enabled) = enabled {
                return Some(*enabled);
            }
            state = source.parent;
        }
        None
    }

    fn is_enabled(&mut self, id: TransitionId, class: Option<EventClass>) -> bool {
        let transition = self.chart.transition(id);
        let matches = match class {
            Some(class) => transition.descriptors.iter().any(|descriptor| descriptor.matches.contains(class)),
            None => transition.descriptors.is_empty(),
        };
        let chance = transition.chance;
        matches
            && transition.condition.as_ref().is_none_or(|condition| {
                self.steps.begin();
                self.holds(condition)
            })
            && chance.is_none_or(|chance| random::next(&mut self.machine.random.position) < chance)
    }

    /// Of two transitions that would exit the same state, the one whose source is deeper is taken, or else the one
    /// found first (removeConflictingTransitions).
    fn remove_conflicts(&mut self) {
        let enabled = std::mem::take(&mut self.machine.scratch.enabled);
        let mut filtered = std::mem::take(&mut self.machine.scratch.filtered);
        filtered.clear();
        for candidate in &enabled {
            let source = self.chart.transition(*candidate).source;
            let deeper = |other: &TransitionId| self.chart.is_descendant(source, self.chart.transition(*other).source);
            let preempted = filtered.iter().any(|other| self.conflicts(*candidate, *other) && !deeper(other));
            if !preempted {
                filtered.retain(|other| !self.conflicts(*candidate, *other));
                filtered.push(*candidate);
            }
        }
        self.machine.scratch.enabled = filtered;
        self.machine.scratch.filtered = enabled;
    }

    /// Whether both transitions would exit some active state.
    fn conflicts(&self, one: TransitionId, other: TransitionId) -> bool {
        let (Some(one), Some(other)) = (self.domain(one), self.domain(other)) else {
            return false;
        };
        // Domains are nested or disjoint; both exit the active states inside the inner one.
        let (outer, inner) = if one <= other { (one, other) } else { (other, one) };
        let last = self.chart.state(inner).last.index();
        (outer == inner || self.chart.is_descendant(inner, outer))
            && self.machine.configuration.any_in(inner.index() + 1..=last)
    }

    /// The state within which a transition exits and enters states; `None` if it has no target (getTransitionDomain).
    pub(super) fn domain(&self, id: TransitionId) -> Option<StateId> {
        let transition = self.chart.transition(id);
        let domain = match transition.domain {
            TransitionDomain::Remembered => {
                let mut targets = Vec::new();
                self.effective_targets(&transition.targets, &mut targets);
                self.chart.domain_of(id, &targets)
            }
            known => known,
        };
        match domain {
            TransitionDomain::State(state) => Some(state),
            TransitionDomain::None | TransitionDomain::Remembered => None,
        }
    }

    /// The targets with history states replaced by what they remember, or by their defaults (getEffectiveTargetStates).
    pub(super) fn effective_targets(&self, targets: &[StateId], effective: &mut Vec<StateId>) {
        for target in targets {
            let state = self.chart.state(*target);
            match (state.kind, self.remembered(*target)) {
                (StateKind::History(_), Some(remembered)) => effective.extend(remembered.iter().map(StateId::new)),
                (StateKind::History(_), None) => self.effective_targets(state.initial(), effective),
                _ => effective.push(*target),
            }
        }
    }
}
