//! Checks the targets of transitions.

use diagnostics::Problem;

use crate::chart::{Chart, HistoryKind, StateKind, TransitionDomain};
use crate::ids::StateId;

/// Reports targets that cannot be active at once, and initial states outside their parent.
pub(super) fn check(chart: &Chart, problems: &mut Vec<Problem>) {
    let id = |state: &StateId| format!("`{}`", chart.state(*state).id());
    for transition in chart.transitions().map(|transition| chart.transition(transition)) {
        if !chart.are_orthogonal(&transition.targets) {
            let targets: Vec<String> = transition.targets.iter().map(id).collect();
            let problem = Problem::new(format!("{} cannot be active at once", targets.join(" and ")));
            let problem = problem.at(transition.span, "leads to all of them");
            problems.push(problem.with_help("several targets must be in different children of a <parallel>"));
        }
    }
    for state in std::iter::once(StateId::ROOT).chain(chart.states()) {
        check_initial(chart, state, problems);
    }
}

fn check_initial(chart: &Chart, id: StateId, problems: &mut Vec<Problem>) {
    let state = chart.state(id);
    let targets = state.initial();
    if targets.is_empty() {
        return;
    }
    // The default of a history state is in its parent (SCXML 3.10.2).
    let within = if let StateKind::History(_) = state.kind { state.parent.unwrap_or(StateId::ROOT) } else { id };
    let name = |state: StateId| {
        if state == StateId::ROOT { "the machine".to_owned() } else { format!("`{}`", chart.state(state).id()) }
    };
    let at = |problem: Problem| problem.at(state.span, "in here");
    for target in targets.iter().filter(|target| !chart.is_descendant(**target, within)) {
        problems.push(at(Problem::new(format!("{} is not inside {}", name(*target), name(within)))));
    }
    if !chart.are_orthogonal(targets) {
        let problem = Problem::new(format!("the initial states of {} cannot be active at once", name(within)));
        problems.push(at(problem).with_help("several initial states must be in different children of a <parallel>"));
    }
    let is_history = |target: &StateId| matches!(chart.state(*target).kind, StateKind::History(_));
    match state.kind {
        StateKind::History(_) if targets.iter().any(is_history) => {
            problems.push(at(Problem::new("the default of a history state must not be another history state")));
        }
        StateKind::History(HistoryKind::Shallow)
            if targets.iter().any(|target| chart.state(*target).parent != Some(within)) =>
        {
            let problem =
                Problem::new("the default of a shallow history state must be a child of its parent").as_warning();
            problems.push(at(problem));
        }
        _ => {}
    }
}

/// Computes the domain of each transition, once the states are known.
pub(super) fn resolve_domains(chart: &mut Chart) {
    let is_history = |target: &StateId| matches!(chart.state(*target).kind, StateKind::History(_));
    let domain = |transition| {
        let targets = &chart.transition(transition).targets;
        if targets.iter().any(is_history) { TransitionDomain::Remembered } else { chart.domain_of(transition, targets) }
    };
    let domains: Vec<TransitionDomain> = chart.transitions().map(domain).collect();
    for (transition, domain) in chart.transitions.iter_mut().zip(domains) {
        transition.domain = domain;
    }
}
