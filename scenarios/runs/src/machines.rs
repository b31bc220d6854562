//! Machines as they appear in records and pictures.

use recording::{Machine, MachineState};
use skills::{Chart, HistoryKind, StateId, StateKind};

/// The record of the machine that a process runs.
#[must_use]
pub fn record(process: &str, chart: &Chart) -> Machine {
    let mut states = Vec::new();
    add(chart, chart.root(), (None, false), &mut states);
    Machine { process: process.to_owned(), states }
}

/// Adds a state with everything inside it; `parent` is the state around it, and whether that enters this one first.
fn add(chart: &Chart, id: StateId, (parent, is_default): (Option<usize>, bool), states: &mut Vec<MachineState>) {
    let state = chart.state(id);
    let name = match state.kind() {
        _ if id == chart.root() => chart.name().to_owned(),
        StateKind::History(HistoryKind::Shallow) => format!("H  {}", state.id()),
        StateKind::History(HistoryKind::Deep) => format!("H*  {}", state.id()),
        _ => state.id().to_owned(),
    };
    let mut transitions: Vec<String> =
        state.transitions().iter().map(|transition| chart.label(chart.transition(*transition))).collect();
    if let StateKind::History(_) = state.kind() {
        let targets: Vec<&str> = state.initial().iter().map(|target| chart.state(*target).id()).collect();
        transitions.push(format!("-> {}", targets.join(", ")));
    }
    let place = states.len();
    states.push(MachineState {
        parent,
        name,
        transitions,
        is_default,
        is_parallel: state.kind() == StateKind::Parallel,
        is_final: state.kind() == StateKind::Final,
    });
    // In the order of the document: an id is a state's number there.
    let mut children: Vec<StateId> = state.children().iter().chain(state.histories()).copied().collect();
    children.sort_unstable();
    for child in children {
        let is_first = state.kind() == StateKind::Compound && chart.enters_first(id, child);
        add(chart, child, (Some(place), is_first), states);
    }
}
