//! When and why a run ends.

use std::time::Duration;

use channels::Verdict;
use recording::{Ended, Happening, RunView};
use scenarios::scenario::{ScenarioFile, Stop};

#[derive(Debug, Default)]
pub(crate) struct Ending {
    /// The stop condition that has been met, and when the run ends because of it.
    met: Option<(Ended, Duration)>,
}

impl Ending {
    /// The reason why the run ends now, if it does.
    pub(crate) fn reached(&mut self, file: &ScenarioFile, view: &RunView) -> Option<Ended> {
        if self.met.is_none() {
            self.met = reason(&file.stop, view).map(|why| (why, view.time() + file.stop.after));
        }
        let limit = file.execution.max_time;
        let over = self.met.take_if(|(_, at)| view.time() >= *at).map(|(why, _)| why);
        over.or_else(|| (view.time() >= limit).then_some(Ended::TimeLimit(limit)))
    }
}

/// The stop condition met in this step: a violation takes precedence over an arrival, and both over final verdicts.
fn reason(stop: &Stop, view: &RunView) -> Option<Ended> {
    let violation = view.happenings().iter().find_map(|happening| match happening {
        Happening::Verdict { monitor, decision } if decision.verdict == Verdict::False => {
            let name = view.monitor(*monitor).name();
            stop.on_violation.has(name).then(|| Ended::Violation(name.to_owned()))
        }
        _ => None,
    });
    let arrival = || {
        view.happenings().iter().find_map(|happening| match happening {
            Happening::Arrival { place } => {
                let name = &view.header().places()[*place].name;
                stop.at.iter().any(|at| at.value == *name).then(|| Ended::Arrival(name.clone()))
            }
            _ => None,
        })
    };
    // Without monitors, nothing can settle: such a run would otherwise end at once.
    let settled = || {
        let mut monitors = view.monitors().filter(|monitor| stop.when_settled.has(monitor.name())).peekable();
        let some = monitors.peek().is_some();
        (some && monitors.all(|monitor| monitor.state.verdict != Verdict::Inconclusive)).then_some(Ended::Settled)
    };
    violation.or_else(arrival).or_else(settled)
}
