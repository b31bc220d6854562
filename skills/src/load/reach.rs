//! What can never happen in a machine: states that nothing enters, transitions that nothing enables.

use crate::chart::{BitSet, Chart, Matches, StateId, StateKind, Transition, TransitionId};
use crate::expression::Scope;
use crate::problem::Problem;

/// Warns of states that are never entered and transitions that are never taken, as far as the file alone tells.
pub(super) fn check(chart: &Chart, problems: &mut Vec<Problem>) {
    let never: Vec<Option<Problem>> = chart.transitions().map(|id| never_taken(chart, id)).collect();
    let reached = reached(chart, &never);
    for id in chart.states().filter(|id| !reached.contains(id.index())) {
        let state = chart.state(id);
        let is_outermost = state.parent.is_none_or(|parent| reached.contains(parent.index()));
        if is_outermost && !matches!(state.kind, StateKind::History(_)) {
            let problem = Problem::new(format!("the state `{}` is never entered", state.id())).warning();
            let help = "no transition and no initial state leads here";
            problems.push(problem.at(state.span, "unreachable").help(help));
        }
    }
    let sources = chart.transitions().map(|id| chart.transition(id).source);
    problems.extend(
        sources.zip(never).filter_map(|(source, problem)| problem.filter(|_| reached.contains(source.index()))),
    );
}

/// Why a transition is never taken, if that can be told.
fn never_taken(chart: &Chart, id: TransitionId) -> Option<Problem> {
    let transition = chart.transition(id);
    let warning = |message: String| Problem::new(message).warning();
    if let Some(condition) = &transition.condition
        && constant(chart, transition) == Some(false)
    {
        return Some(warning("this condition never holds".to_owned()).at(condition.span, "always false"));
    }
    if let Some(first) = shadow(chart, id) {
        let problem = warning("this transition is never taken".to_owned()).at(transition.span, "comes too late");
        return Some(problem.at(chart.transition(first).span, "this one takes every such event"));
    }
    let hopeless = transition.descriptors.iter().map(|descriptor| hopeless(chart, &descriptor.text));
    let reasons: Vec<String> = hopeless.collect::<Option<_>>()?;
    let descriptor = transition.descriptors.first()?;
    Some(warning(reasons.into_iter().next()?).at(descriptor.span, "never comes"))
}

/// The value of a condition that is always the same; true if there is none.
fn constant(chart: &Chart, transition: &Transition) -> Option<bool> {
    let Some(condition) = &transition.condition else {
        return Some(true);
    };
    let scope = Scope { chart: Some(chart), ..Scope::default() };
    if condition.test.is_fixed(&|_| false) { condition.test.truth(&scope).ok() } else { None }
}

/// An earlier transition of the same state that takes every event that this one could take.
fn shadow(chart: &Chart, id: TransitionId) -> Option<TransitionId> {
    let transition = chart.transition(id);
    let earlier = chart.state(transition.source).transitions().iter().copied().take_while(|other| *other != id);
    let mut unconditional = earlier.filter(|other| constant(chart, chart.transition(*other)) == Some(true));
    unconditional.find(|other| {
        let other = chart.transition(*other);
        let covered = |matches: Matches| other.descriptors.iter().any(|wider| wider.matches.covers(matches));
        other.descriptors.is_empty() == transition.descriptors.is_empty()
            && transition.descriptors.iter().all(|descriptor| covered(descriptor.matches))
    })
}

/// Why an event never comes that only the processor makes.
fn hopeless(chart: &Chart, descriptor: &str) -> Option<String> {
    let name = descriptor.strip_prefix("done.state.")?;
    let name = name.strip_suffix(".*").or_else(|| name.strip_suffix('.')).unwrap_or(name);
    if name.is_empty() || name == "*" {
        return None;
    }
    // An id may contain dots, and the descriptor may be its beginning only.
    let meant = |id: &StateId| {
        let rest = chart.state(*id).id().strip_prefix(name);
        rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
    };
    let mut states = chart.states().filter(meant).peekable();
    if states.peek().is_none() {
        return Some(format!("there is no state `{name}` that could be done"));
    }
    let can_be_done = |id: StateId| match chart.state(id).kind {
        StateKind::Compound => {
            chart.state(id).children.iter().any(|child| chart.state(*child).kind == StateKind::Final)
        }
        kind => kind == StateKind::Parallel,
    };
    if states.any(can_be_done) { None } else { Some(format!("the state `{name}` is never done: it has no <final>")) }
}

/// The states that can be entered, if every transition is taken some time that is not known never to be.
fn reached(chart: &Chart, never: &[Option<Problem>]) -> BitSet {
    let mut reached = BitSet::new(chart.states.len());
    let mut open = vec![StateId::ROOT];
    while let Some(id) = open.pop() {
        if reached.contains(id.index()) {
            continue;
        }
        reached.insert(id.index());
        let state = chart.state(id);
        open.extend(state.parent);
        open.extend(state.initial());
        if state.kind == StateKind::Parallel {
            open.extend(&state.children);
        }
        let taken = state.transitions.iter().filter(|transition| never[transition.index()].is_none());
        open.extend(taken.flat_map(|transition| &chart.transition(*transition).targets));
    }
    reached
}
