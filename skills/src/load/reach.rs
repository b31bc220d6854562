//! Things that can never happen in a machine: states that are never entered, transitions that are never enabled.

use std::collections::BTreeMap;

use diagnostics::Problem;
use miette::SourceSpan;

use crate::bit_set::BitSet;
use crate::chart::{Chart, Matches, SCXML_PROCESSOR, StateKind, Transition, is_event_name};
use crate::expression::Scope;
use crate::ids::{StateId, TransitionId};

/// Warns of states that are never entered, transitions that are never taken and events that the machine sends to itself
/// and never handles, as far as the file alone shows.
pub(super) fn check(chart: &Chart, problems: &mut Vec<Problem>) {
    problems.extend(unheard(chart));
    problems.extend(nested_parallels(chart));
    let ends = Ends::of(chart);
    let mut never: Vec<Option<Problem>> = Vec::new();
    never.resize_with(chart.transitions.len(), || None);
    for state in std::iter::once(StateId::ROOT).chain(chart.states()) {
        let mut earlier = Vec::new();
        for id in chart.state(state).transitions().iter().copied() {
            let value = constant(chart, chart.transition(id));
            let taken = HandledEvents::by(chart, id);
            never[id.index()] = never_taken(chart, &taken, value, &earlier, &ends);
            if value == Some(true) && earlier.len() < MAX_EARLIER {
                earlier.push(taken);
            }
        }
    }
    // Which states are reached follows from the transitions that are never taken. Of those, only the ones in reached
    // states are reported, and of the states only the outermost: one warning is enough.
    let reached = reached(chart, &never);
    for id in chart.states().filter(|id| !reached.contains(id.index())) {
        let state = chart.state(id);
        let is_outermost = state.parent.is_none_or(|parent| reached.contains(parent.index()));
        if is_outermost && !matches!(state.kind, StateKind::History(_)) {
            let problem = Problem::new(format!("the state `{}` is never entered", state.id())).as_warning();
            let help = "no transition and no initial state leads to it";
            problems.push(problem.at(state.span, "unreachable").with_help(help));
        }
    }
    let sources = chart.transitions().map(|id| chart.transition(id).source);
    problems.extend(
        sources.zip(never).filter_map(|(source, problem)| problem.filter(|_| reached.contains(source.index()))),
    );
}

/// Parallel states right inside others whose end a transition waits for: SCXML notices the end of the outer one only
/// when a child that is not parallel ends last (Appendix D, enterStates).
fn nested_parallels(chart: &Chart) -> Vec<Problem> {
    let is_parallel = |id: &StateId| chart.state(*id).kind == StateKind::Parallel;
    let inner = chart.states().filter(is_parallel).filter_map(|id| {
        let (state, outer) = (chart.state(id), chart.state(id).parent.filter(is_parallel)?);
        let done = &chart.state(outer).done_event.0;
        let problem = Problem::new(format!("`{done}` does not occur if `{}` is done last", state.id())).as_warning();
        let problem = problem
            .at(state.span, "a parallel state in a parallel state")
            .with_help(format!("put it into a <state> that has a <final>, to which `done.state.{}` leads", state.id()));
        chart.names(done).then_some(problem)
    });
    inner.collect()
}

/// Events that the machine sends to itself and that no transition handles, each once.
fn unheard(chart: &Chart) -> Vec<Problem> {
    if chart.invokes().any(|invoke| invoke.auto_forward) {
        // An invoked machine may handle them.
        return Vec::new();
    }
    let mut sends: BTreeMap<&str, Vec<SourceSpan>> = BTreeMap::new();
    chart.visit_sends(&mut |send| {
        if let Some(event) = send.event.as_ref().and_then(|event| event.literal())
            && send.target.is_none()
            && send.processor.as_ref().is_none_or(|processor| processor.literal().is_some_and(|name| is_own(name)))
            && is_event_name(event)
            && !chart.handles(event)
        {
            sends.entry(event).or_default().push(send.span);
        }
    });
    let warning = |(event, spans): (&str, Vec<SourceSpan>)| {
        let more = match spans.len() - 1 {
            0 => String::new(),
            1 => ", here and in one other place".to_owned(),
            more => format!(", here and in {more} other places"),
        };
        let problem =
            Problem::new(format!("the machine sends itself the event `{event}`{more}, but no transition handles it"))
                .as_warning();
        let help = "without `target` and `type`, an event goes to the machine itself; <send type=\"channel\" target=\"BT\" \
                    event=\"success\"/> answers the tree";
        problem.at(spans[0], "comes back and is dropped").with_help(help)
    };
    sends.into_iter().map(warning).collect()
}

/// Whether this event I/O processor delivers a machine's events to the machine itself.
fn is_own(processor: &str) -> bool {
    [SCXML_PROCESSOR, "scxml"].contains(&processor)
}

/// Whether `done.state.…` can ever occur for this state.
pub(crate) fn can_be_done(chart: &Chart, id: StateId) -> bool {
    match chart.state(id).kind {
        StateKind::Compound => {
            chart.state(id).children.iter().any(|child| chart.state(*child).kind == StateKind::Final)
        }
        kind => kind == StateKind::Parallel,
    }
}

/// A transition is compared with at most this many earlier transitions of its state: otherwise the time would grow with
/// the square of their number. Chosen, not measured.
const MAX_EARLIER: usize = 1000;

/// Why a transition is never taken, if that can be determined. `constant` is the value of its condition if it never
/// changes; `earlier` are the transitions before it in its state.
fn never_taken(
    chart: &Chart,
    taken: &HandledEvents,
    value: Option<bool>,
    earlier: &[HandledEvents],
    ends: &Ends<'_>,
) -> Option<Problem> {
    let transition = chart.transition(taken.transition);
    let warning = |message: String| Problem::new(message).as_warning();
    if let Some(condition) = &transition.condition
        && value == Some(false)
    {
        return Some(warning("this condition never holds".to_owned()).at(condition.span, "always false"));
    }
    if let Some(first) = earlier.iter().find(|first| first.covers(taken)) {
        let problem =
            warning("this transition is never taken".to_owned()).at(transition.span, "another transition comes first");
        return Some(problem.at(chart.transition(first.transition).span, "this one already handles every such event"));
    }
    let hopeless = transition.descriptors.iter().map(|descriptor| ends.hopeless(&descriptor.text));
    let reasons: Vec<String> = hopeless.collect::<Option<_>>()?;
    let descriptor = transition.descriptors.first()?;
    Some(warning(reasons.into_iter().next()?).at(descriptor.span, "never occurs"))
}

/// The value of a condition that never changes; true if there is no condition.
pub(crate) fn constant(chart: &Chart, transition: &Transition) -> Option<bool> {
    let Some(condition) = &transition.condition else {
        return Some(true);
    };
    let scope = Scope { ids: Some(&chart.ids), ..Scope::default() };
    if condition.test.is_fixed(&|_| false) { condition.test.truth(&scope).ok() } else { None }
}

struct HandledEvents {
    transition: TransitionId,
    /// The classes that its descriptors match, in ascending order and disjoint; empty if it handles no event.
    matches: Vec<Matches>,
}

impl HandledEvents {
    fn by(chart: &Chart, transition: TransitionId) -> Self {
        let descriptors = &chart.transition(transition).descriptors;
        let mut matches: Vec<Matches> = descriptors.iter().map(|descriptor| descriptor.matches).collect();
        // A covering descriptor comes before the covered ones.
        matches.sort();
        matches.dedup_by(|inner, outer| outer.covers(*inner));
        Self { transition, matches }
    }

    fn covers(&self, other: &Self) -> bool {
        // Two descriptors are disjoint, or one covers the other.
        let is_covered = |inner: &Matches| {
            let before = self.matches.partition_point(|outer| outer.begins_before(*inner));
            before.checked_sub(1).is_some_and(|place| self.matches[place].covers(*inner))
        };
        self.matches.is_empty() == other.matches.is_empty() && other.matches.iter().all(is_covered)
    }
}

/// The states that can be done.
struct Ends<'c> {
    /// Ids in alphabetical order, each with the number of states up to it that can be done.
    states: Vec<(&'c str, usize)>,
}

impl<'c> Ends<'c> {
    fn of(chart: &'c Chart) -> Self {
        let mut states: Vec<(&str, usize)> =
            chart.states().map(|id| (chart.state(id).id(), usize::from(can_be_done(chart, id)))).collect();
        states.sort_unstable();
        let mut done = 0;
        for (_, count) in &mut states {
            done += *count;
            *count = done;
        }
        Self { states }
    }

    /// Why an event that only the processor generates never occurs.
    fn hopeless(&self, descriptor: &str) -> Option<String> {
        let name = descriptor.strip_prefix("done.state.")?;
        let name = name.strip_suffix(".*").or_else(|| name.strip_suffix('.')).unwrap_or(name);
        if name.is_empty() || name == "*" {
            return None;
        }
        // An id may contain dots, and the descriptor may be only its beginning; `/` is the character after `.`.
        let up_to = |id: &str| self.states.partition_point(|(state, _)| *state < id);
        let done_in = |from: usize, to: usize| {
            let done = |end: usize| end.checked_sub(1).map_or(0, |last| self.states[last].1);
            done(to) - done(from)
        };
        let same = (up_to(name), up_to(&format!("{name}\0")));
        let longer = (up_to(&format!("{name}.")), up_to(&format!("{name}/")));
        if same.0 == same.1 && longer.0 == longer.1 {
            return Some(format!("unknown state `{name}`"));
        }
        let can_be_done = done_in(same.0, same.1) + done_in(longer.0, longer.1) > 0;
        (!can_be_done).then(|| format!("the state `{name}` is never done: it has no <final>"))
    }
}

/// The states that can be entered, assuming that every transition is taken at some point unless it is known never to
/// be.
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
