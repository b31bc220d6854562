//! Relations between states (the predicates of SCXML Appendix D).

use super::{Chart, StateKind, TransitionDomain};
use crate::ids::{StateId, TransitionId};

impl Chart {
    /// Whether `state` is inside `ancestor`, at any depth.
    pub(crate) fn is_descendant(&self, state: StateId, ancestor: StateId) -> bool {
        ancestor < state && state <= self.state(ancestor).last
    }

    /// The ancestors of `state`, innermost first, the root last.
    pub(crate) fn ancestors(&self, state: StateId) -> impl Iterator<Item = StateId> + '_ {
        std::iter::successors(self.state(state).parent, |ancestor| self.state(*ancestor).parent)
    }

    /// The innermost compound state, or the root, that contains all of these states (findLCCA).
    pub(crate) fn common_ancestor(&self, first: StateId, others: &[StateId]) -> StateId {
        let is_compound = |state: &StateId| self.state(*state).kind == StateKind::Compound;
        let around_all = |ancestor: &StateId| others.iter().all(|state| self.is_descendant(*state, *ancestor));
        self.ancestors(first).filter(is_compound).find(around_all).unwrap_or(StateId::ROOT)
    }

    /// The state within which a transition to these states exits and enters states (getTransitionDomain).
    pub(crate) fn domain_of(&self, transition: TransitionId, targets: &[StateId]) -> TransitionDomain {
        let transition = self.transition(transition);
        let source = transition.source;
        if targets.is_empty() {
            return TransitionDomain::None;
        }
        let stays_inside = || targets.iter().all(|target| self.is_descendant(*target, source));
        if transition.internal && self.state(source).kind == StateKind::Compound && stays_inside() {
            return TransitionDomain::State(source);
        }
        TransitionDomain::State(self.common_ancestor(source, targets))
    }

    /// Whether the states can all be active at once: the innermost common ancestor of any two of them is parallel.
    pub(crate) fn are_orthogonal(&self, states: &[StateId]) -> bool {
        let around_both = |a: StateId, b: StateId| self.ancestors(a).find(|ancestor| self.is_descendant(b, *ancestor));
        let orthogonal = |a: StateId, b: StateId| {
            let nested = a == b || self.is_descendant(a, b) || self.is_descendant(b, a);
            !nested && around_both(a, b).is_some_and(|state| self.state(state).kind == StateKind::Parallel)
        };
        // The innermost common ancestor of any two of them is also that of two adjacent ones between them.
        let mut in_order = states.to_vec();
        in_order.sort_unstable();
        in_order.windows(2).all(|pair| orthogonal(pair[0], pair[1]))
    }
}
