//! Properties for which nothing comes after the end of a run.

use channels::{Event, EventKind, Monitor, Verdict};
use monitors::{EventTime, OpenObligation, ScopeMonitor, Witness, scope_monitor};
use recording::{Decision, Ended, MonitorEnd, MonitorState};

/// Whether a run that ended like this has come to its own end.
pub(crate) fn is_the_end(ended: &Ended) -> bool {
    match ended {
        Ended::Arrival(_) | Ended::Violation(_) | Ended::Settled | Ended::TimeLimit(_) => true,
        Ended::Scheduled | Ended::Interrupted | Ended::Recorded | Ended::CutOff(_) => false,
    }
}

/// The violation of a property by the end of a run at this time, if something is pending that no deadline after the
/// end can still meet; `formula` is the property's.
pub(crate) fn violation(monitor: &dyn Monitor, formula: &str, at: EventTime) -> Option<Decision> {
    if monitor.verdict_at_end() != Verdict::Inconclusive || !monitor.is_open() {
        return None;
    }
    let open = scope_monitor(monitor).map(ScopeMonitor::open_obligations).unwrap_or_default();
    // Any other monitor does not report what it waits for.
    let endless = match open.is_empty() {
        true => None,
        false => Some(open.into_iter().find(|owed| !owed.has_deadline)?),
    };
    let witness = endless.map(|OpenObligation { what, since, .. }| Witness {
        clause: formula.to_owned(),
        messages: Vec::new(),
        since,
        deadline_tick: None,
        missing: Some(what),
        settled: at,
    });
    let event = Event { step: at.step, tick: at.tick, time: at.time, kind: EventKind::Tick };
    Some(Decision { verdict: Verdict::False, event, witness })
}

/// The end of a monitor whose property the end of the run violates.
pub(crate) fn violated(end: MonitorEnd) -> MonitorEnd {
    let state = MonitorState { verdict: Verdict::False, is_open: false, ..end.state };
    MonitorEnd { state, vacuous: Vec::new(), ..end }
}
