//! A microstep: exiting states, executing the content of transitions, entering states (SCXML 3.13, Appendix D).

use std::sync::Arc;

use super::macrostep::Macrostep;
use super::{Event, EventKind, Status};
use crate::bit_set::BitSet;
use crate::chart::{Binding, HistoryKind, StateKind};
use crate::ids::{StateId, TransitionId};

impl Macrostep<'_, '_> {
    /// Takes the transitions in `scratch.enabled`.
    ///
    /// Appendix D computes a transition's domain twice: before exiting and before entering states. In between, a
    /// history state among its targets may come to remember something else. The second domain could then lie inside the
    /// states just exited, and nothing around it would be entered. Therefore the first domain is used for both.
    pub(super) fn microstep(&mut self) {
        let enabled = std::mem::take(&mut self.machine.scratch.enabled);
        let mut domains = std::mem::take(&mut self.machine.scratch.domains);
        domains.clear();
        domains.extend(enabled.iter().map(|transition| self.domain(*transition)));
        self.exit_states(&domains);
        for transition in &enabled {
            self.machine.scratch.taken.insert(transition.index());
            self.execute(&self.chart.transition(*transition).content);
        }
        self.begin_entry();
        for (transition, domain) in enabled.iter().zip(&domains) {
            self.add_targets(*transition, *domain);
        }
        self.enter_states();
        self.machine.scratch.enabled = enabled;
        self.machine.scratch.domains = domains;
    }

    /// Enters the initial states of the machine.
    pub(super) fn enter_initially(&mut self) {
        self.begin_entry();
        let targets = self.chart.state(StateId::ROOT).initial();
        targets.iter().for_each(|target| self.add_with_descendants(*target));
        targets.iter().for_each(|target| self.add_ancestors(*target, StateId::ROOT));
        self.enter_states();
    }

    /// Records the history of the states that the transitions exit, then exits them from the inside out.
    fn exit_states(&mut self, domains: &[Option<StateId>]) {
        let mut leaving = std::mem::take(&mut self.machine.scratch.leaving);
        leaving.clear();
        for domain in domains.iter().flatten() {
            let last = self.chart.state(*domain).last.index();
            let mut from = domain.index() + 1;
            while let Some(index) = self.machine.configuration.next_from(from).filter(|index| *index <= last) {
                leaving.push(StateId::new(index));
                from = index + 1;
            }
        }
        leaving.sort_unstable();
        leaving.dedup();
        // History is recorded before anything is exited: it is about the configuration as it was (exitStates).
        for state in leaving.iter().rev() {
            self.record_history(*state);
        }
        for state in leaving.iter().rev() {
            for block in &self.chart.state(*state).on_exit {
                self.execute(block);
            }
            let invokes = !self.chart.state(*state).invokes.is_empty();
            if invokes {
                self.cancel_invoked(*state);
                self.machine.to_invoke.remove(state.index());
            }
            self.machine.configuration.remove(state.index());
        }
        self.machine.scratch.leaving = leaving;
    }

    fn record_history(&mut self, state: StateId) {
        for history in &self.chart.state(state).histories {
            let is_deep = self.chart.state(*history).kind == StateKind::History(HistoryKind::Deep);
            let mut remembered = BitSet::new(self.chart.states.len());
            for active in self.machine.configuration.iter().map(StateId::new) {
                let particulars = self.chart.state(active);
                let counts = if is_deep {
                    particulars.is_atomic() && self.chart.is_descendant(active, state)
                } else {
                    particulars.parent == Some(state)
                };
                if counts {
                    remembered.insert(active.index());
                }
            }
            self.machine.remembered[history.index()] = Some(remembered);
        }
    }

    fn begin_entry(&mut self) {
        let scratch = &mut *self.machine.scratch;
        scratch.entering.clear();
        scratch.by_default.clear();
        scratch.histories.clear();
    }

    /// Adds the states that a transition enters within its domain (computeEntrySet).
    fn add_targets(&mut self, transition: TransitionId, domain: Option<StateId>) {
        let targets = &self.chart.transition(transition).targets;
        let Some(domain) = domain else {
            return;
        };
        targets.iter().for_each(|target| self.add_with_descendants(*target));
        let is_history = |target: &StateId| matches!(self.chart.state(*target).kind, StateKind::History(_));
        if targets.iter().any(is_history) {
            let mut effective = Vec::new();
            self.effective_targets(targets, &mut effective);
            effective.iter().for_each(|target| self.add_ancestors(*target, domain));
        } else {
            targets.iter().for_each(|target| self.add_ancestors(*target, domain));
        }
    }

    /// Adds a state and its descendants that are entered with it (addDescendantStatesToEnter).
    fn add_with_descendants(&mut self, id: StateId) {
        let chart = self.chart;
        let state = chart.state(id);
        match state.kind {
            StateKind::History(_) => return self.add_history(id),
            StateKind::Compound => {
                self.machine.scratch.entering.insert(id.index());
                self.machine.scratch.by_default.insert(id.index());
                state.initial().iter().for_each(|target| self.add_with_descendants(*target));
                state.initial().iter().for_each(|target| self.add_ancestors(*target, id));
            }
            StateKind::Parallel => {
                self.machine.scratch.entering.insert(id.index());
                self.add_missing_children(id);
            }
            StateKind::Atomic | StateKind::Final => {}
        }
        self.machine.scratch.entering.insert(id.index());
    }

    fn add_history(&mut self, id: StateId) {
        let state = self.chart.state(id);
        let parent = state.parent.unwrap_or(StateId::ROOT);
        let targets: Vec<StateId> = match self.remembered(id) {
            Some(remembered) => remembered.iter().map(StateId::new).collect(),
            None => {
                self.machine.scratch.histories.push(id);
                state.initial().to_vec()
            }
        };
        targets.iter().for_each(|target| self.add_with_descendants(*target));
        targets.iter().for_each(|target| self.add_ancestors(*target, parent));
    }

    /// Adds the ancestors of `state` inside `ancestor` (addAncestorStatesToEnter).
    fn add_ancestors(&mut self, state: StateId, ancestor: StateId) {
        let chart = self.chart;
        for around in chart.ancestors(state).take_while(|around| *around != ancestor) {
            self.machine.scratch.entering.insert(around.index());
            if chart.state(around).kind == StateKind::Parallel {
                self.add_missing_children(around);
            }
        }
    }

    /// Adds those children of a parallel state in which nothing is entered yet.
    fn add_missing_children(&mut self, parallel: StateId) {
        let chart = self.chart;
        for child in &chart.state(parallel).children {
            let last = chart.state(*child).last.index();
            if !self.machine.scratch.entering.any_in(child.index()..=last) {
                self.add_with_descendants(*child);
            }
        }
    }

    /// Enters the added states from the outside in (enterStates).
    fn enter_states(&mut self) {
        let mut from = 0;
        while let Some(index) = self.machine.scratch.entering.next_from(from) {
            from = index + 1;
            self.enter(StateId::new(index));
        }
        if from > 0 {
            self.host.entered(self.machine);
        }
    }

    fn enter(&mut self, id: StateId) {
        let chart = self.chart;
        let state = chart.state(id);
        self.machine.configuration.insert(id.index());
        self.machine.scratch.entered.insert(id.index());
        if !state.invokes.is_empty() {
            // Invoked at the end of the macrostep, unless the state has been exited by then (SCXML 6.4).
            self.machine.to_invoke.insert(id.index());
        }
        if chart.binding == Binding::Late {
            self.initialise_state(id);
        }
        for block in &state.on_entry {
            self.execute(block);
        }
        if let Some(initial) = state.initial.as_ref().filter(|_| self.machine.scratch.by_default.contains(id.index())) {
            self.execute(&initial.content);
        }
        for history in &state.histories {
            let taken = self.machine.scratch.histories.contains(history);
            if let Some(default) = chart.state(*history).initial.as_ref().filter(|_| taken) {
                self.execute(&default.content);
            }
        }
        if state.kind == StateKind::Final {
            self.finish(id);
        }
    }

    /// A final state ends its parent. The last child of a parallel state to end also ends the parallel state.
    fn finish(&mut self, id: StateId) {
        let chart = self.chart;
        let parent = chart.state(id).parent.unwrap_or(StateId::ROOT);
        if parent == StateId::ROOT {
            self.machine.status = Status::Done;
            return;
        }
        let data = self.payload(&chart.state(id).done_data);
        self.raise_done(parent, data);
        if let Some(around) =
            chart.state(parent).parent.filter(|around| chart.state(*around).kind == StateKind::Parallel)
            && chart.state(around).children.iter().all(|child| self.is_in_final_state(*child))
        {
            self.raise_done(around, crate::Datum::Undefined);
        }
    }

    fn raise_done(&mut self, state: StateId, data: crate::Datum) {
        let (name, class) = &self.chart.state(state).done_event;
        self.raise(Event::new(Arc::clone(name), EventKind::Platform).with_data(data), *class);
    }

    fn is_in_final_state(&self, id: StateId) -> bool {
        let state = self.chart.state(id);
        let is_final = |child: &StateId| self.chart.state(*child).kind == StateKind::Final && self.is_active(*child);
        match state.kind {
            StateKind::Compound => state.children.iter().any(is_final),
            StateKind::Parallel => state.children.iter().all(|child| self.is_in_final_state(*child)),
            _ => false,
        }
    }
}
