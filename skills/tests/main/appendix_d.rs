//! A literal implementation of Appendix D, with sets, against which the fast one is checked.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use skills::{Chart, HistoryKind, StateId, StateKind, TransitionId};

/// Runs a chart whose transitions have at most one event and the condition `!In('state')`, and records which states are
/// entered (`+s`) and exited (`-s`) and which transitions are taken (`s>t`).
pub(crate) struct Interpreter<'c> {
    chart: &'c Chart,
    configuration: BTreeSet<StateId>,
    history_value: BTreeMap<StateId, Vec<StateId>>,
    internal_queue: VecDeque<String>,
    pub(crate) trace: Vec<String>,
    pub(crate) running: bool,
    microsteps: u32,
}

const MAX_MICROSTEPS: u32 = 10_000;

impl<'c> Interpreter<'c> {
    pub(crate) fn start(chart: &'c Chart) -> Self {
        let mut interpreter = Self {
            chart,
            configuration: BTreeSet::new(),
            history_value: BTreeMap::new(),
            internal_queue: VecDeque::new(),
            trace: Vec::new(),
            running: true,
            microsteps: 0,
        };
        let initial = chart.state(chart.root()).initial().to_vec();
        interpreter.enter_states(&[(initial, Some(chart.root()))]);
        interpreter.macrostep();
        interpreter
    }

    pub(crate) fn handle(&mut self, event: &str) {
        if !self.running || self.is_stuck() {
            return;
        }
        self.microsteps = 0;
        let enabled = self.select_transitions(Some(event));
        self.microstep(&enabled);
        self.macrostep();
    }

    pub(crate) fn is_stuck(&self) -> bool {
        self.microsteps >= MAX_MICROSTEPS
    }

    pub(crate) fn active(&self) -> Vec<&str> {
        self.configuration
            .iter()
            .filter(|state| self.is_atomic(**state))
            .map(|state| self.chart.state(*state).id())
            .collect()
    }

    fn macrostep(&mut self) {
        while self.running && !self.is_stuck() {
            let mut enabled = self.select_transitions(None);
            if enabled.is_empty() {
                let Some(event) = self.internal_queue.pop_front() else { return };
                enabled = self.select_transitions(Some(&event));
            }
            self.microstep(&enabled);
        }
        if !self.running {
            for state in self.configuration.iter().rev() {
                self.trace.push(format!("-{}", self.chart.state(*state).id()));
            }
        }
    }

    fn kind(&self, state: StateId) -> StateKind {
        self.chart.state(state).kind()
    }

    fn is_atomic(&self, state: StateId) -> bool {
        matches!(self.kind(state), StateKind::Atomic | StateKind::Final)
    }

    /// getProperAncestors, the root included unless it is the limit.
    fn proper_ancestors(&self, state: StateId, limit: Option<StateId>) -> Vec<StateId> {
        let parents =
            std::iter::successors(self.chart.state(state).parent(), |state| self.chart.state(*state).parent());
        parents.take_while(|state| Some(*state) != limit).collect()
    }

    fn is_descendant(&self, state: StateId, of: StateId) -> bool {
        self.proper_ancestors(state, None).contains(&of)
    }

    fn select_transitions(&self, event: Option<&str>) -> Vec<TransitionId> {
        let mut enabled = Vec::new();
        for state in self.configuration.iter().filter(|state| self.is_atomic(**state)) {
            let chain = std::iter::once(*state).chain(self.proper_ancestors(*state, None));
            let found =
                chain.flat_map(|state| self.chart.state(state).transitions()).find(|id| self.is_enabled(**id, event));
            if let Some(found) = found.filter(|found| !enabled.contains(*found)) {
                enabled.push(*found);
            }
        }
        self.remove_conflicting(&enabled)
    }

    fn is_enabled(&self, id: TransitionId, event: Option<&str>) -> bool {
        let transition = self.chart.transition(id);
        let matches = |descriptor: &str| {
            event.is_some_and(|event| event == descriptor || event.starts_with(&format!("{descriptor}.")))
        };
        let is_matched = match event {
            Some(_) => transition.events().any(matches),
            None => transition.events().next().is_none(),
        };
        let holds = transition.condition().is_none_or(|condition| {
            let id = condition.trim_start_matches("!In('").trim_end_matches("')");
            !self.configuration.contains(&self.chart.find_state(id).unwrap())
        });
        is_matched && holds
    }

    fn remove_conflicting(&self, enabled: &[TransitionId]) -> Vec<TransitionId> {
        let mut filtered: Vec<TransitionId> = Vec::new();
        for t1 in enabled {
            let mut preempted = false;
            let mut to_remove = Vec::new();
            for t2 in &filtered {
                if !self.exit_set(&[*t1]).is_disjoint(&self.exit_set(&[*t2])) {
                    let source = |id: &TransitionId| self.chart.transition(*id).source();
                    if self.is_descendant(source(t1), source(t2)) {
                        to_remove.push(*t2);
                    } else {
                        preempted = true;
                        break;
                    }
                }
            }
            if !preempted {
                filtered.retain(|t| !to_remove.contains(t));
                filtered.push(*t1);
            }
        }
        filtered
    }

    fn exit_set(&self, transitions: &[TransitionId]) -> BTreeSet<StateId> {
        let domains = transitions.iter().filter_map(|transition| self.domain(*transition));
        domains
            .flat_map(|domain| {
                self.configuration.iter().copied().filter(move |state| self.is_descendant(*state, domain))
            })
            .collect()
    }

    fn effective_targets(&self, targets: &[StateId]) -> Vec<StateId> {
        let effective = |target: &StateId| match (self.kind(*target), self.history_value.get(target)) {
            (StateKind::History(_), Some(value)) => value.clone(),
            (StateKind::History(_), None) => self.effective_targets(self.chart.state(*target).initial()),
            _ => vec![*target],
        };
        targets.iter().flat_map(effective).collect()
    }

    fn domain(&self, id: TransitionId) -> Option<StateId> {
        let transition = self.chart.transition(id);
        let targets = self.effective_targets(transition.targets());
        let source = transition.source();
        if targets.is_empty() {
            None
        } else if transition.is_internal()
            && self.kind(source) == StateKind::Compound
            && targets.iter().all(|target| self.is_descendant(*target, source))
        {
            Some(source)
        } else {
            let compound = |state: &StateId| self.kind(*state) == StateKind::Compound;
            let around = |state: &StateId| targets.iter().all(|target| self.is_descendant(*target, *state));
            self.proper_ancestors(source, None).into_iter().filter(compound).find(around)
        }
    }

    fn microstep(&mut self, enabled: &[TransitionId]) {
        self.microsteps += 1;
        let exit = self.exit_set(enabled);
        // Not word for word: Appendix D computes the domains once more after the exit, when history states may remember
        // something else, and then enters states without those around them.
        let domains: Vec<_> = enabled.iter().map(|id| self.domain(*id)).collect();
        self.exit_states(&exit);
        for id in enabled {
            let transition = self.chart.transition(*id);
            let ends: Vec<&str> = transition.targets().iter().map(|target| self.chart.state(*target).id()).collect();
            self.trace.push(format!("{}>{}", self.chart.state(transition.source()).id(), ends.join(",")));
        }
        let targets = enabled.iter().map(|id| self.chart.transition(*id).targets().to_vec());
        let entries: Vec<_> = targets.zip(domains).collect();
        self.enter_states(&entries);
    }

    fn exit_states(&mut self, exit: &BTreeSet<StateId>) {
        for state in exit {
            for history in self.chart.state(*state).histories() {
                let deep = self.kind(*history) == StateKind::History(HistoryKind::Deep);
                let counts = |active: &StateId| {
                    if deep {
                        self.is_atomic(*active) && self.is_descendant(*active, *state)
                    } else {
                        self.chart.state(*active).parent() == Some(*state)
                    }
                };
                let value: Vec<StateId> = self.configuration.iter().copied().filter(counts).collect();
                self.history_value.insert(*history, value);
            }
        }
        for state in exit.iter().rev() {
            self.trace.push(format!("-{}", self.chart.state(*state).id()));
            self.configuration.remove(state);
        }
    }

    fn enter_states(&mut self, entries: &[(Vec<StateId>, Option<StateId>)]) {
        let mut to_enter = BTreeSet::new();
        for (targets, domain) in entries {
            for target in targets {
                self.add_descendants(*target, &mut to_enter);
            }
            for target in self.effective_targets(targets) {
                self.add_ancestors(target, *domain, &mut to_enter);
            }
        }
        for state in to_enter {
            self.configuration.insert(state);
            self.trace.push(format!("+{}", self.chart.state(state).id()));
            if self.kind(state) == StateKind::Final {
                self.finish(state);
            }
        }
    }

    fn finish(&mut self, state: StateId) {
        let parent = self.chart.state(state).parent().unwrap();
        if parent == self.chart.root() {
            self.running = false;
            return;
        }
        self.internal_queue.push_back(format!("done.state.{}", self.chart.state(parent).id()));
        let Some(grandparent) = self.chart.state(parent).parent() else { return };
        if self.kind(grandparent) == StateKind::Parallel
            && self.chart.state(grandparent).children().iter().all(|child| self.is_in_final_state(*child))
        {
            self.internal_queue.push_back(format!("done.state.{}", self.chart.state(grandparent).id()));
        }
    }

    fn is_in_final_state(&self, state: StateId) -> bool {
        let children = self.chart.state(state).children();
        match self.kind(state) {
            StateKind::Compound => {
                children.iter().any(|child| self.kind(*child) == StateKind::Final && self.configuration.contains(child))
            }
            StateKind::Parallel => children.iter().all(|child| self.is_in_final_state(*child)),
            _ => false,
        }
    }

    fn add_descendants(&self, state: StateId, to_enter: &mut BTreeSet<StateId>) {
        let particulars = self.chart.state(state);
        match self.kind(state) {
            StateKind::History(_) => {
                let value = self.history_value.get(&state).map_or(particulars.initial(), Vec::as_slice);
                value.iter().for_each(|target| self.add_descendants(*target, to_enter));
                value.iter().for_each(|target| self.add_ancestors(*target, particulars.parent(), to_enter));
            }
            StateKind::Compound => {
                to_enter.insert(state);
                particulars.initial().iter().for_each(|target| self.add_descendants(*target, to_enter));
                particulars.initial().iter().for_each(|target| self.add_ancestors(*target, Some(state), to_enter));
            }
            StateKind::Parallel => {
                to_enter.insert(state);
                self.add_regions(state, to_enter);
            }
            StateKind::Atomic | StateKind::Final => {
                to_enter.insert(state);
            }
        }
    }

    fn add_regions(&self, parallel: StateId, to_enter: &mut BTreeSet<StateId>) {
        for child in self.chart.state(parallel).children() {
            if !to_enter.iter().any(|entered| self.is_descendant(*entered, *child)) {
                self.add_descendants(*child, to_enter);
            }
        }
    }

    fn add_ancestors(&self, state: StateId, limit: Option<StateId>, to_enter: &mut BTreeSet<StateId>) {
        for ancestor in self.proper_ancestors(state, limit) {
            to_enter.insert(ancestor);
            if self.kind(ancestor) == StateKind::Parallel {
                self.add_regions(ancestor, to_enter);
            }
        }
    }
}
