//! The limits of logs by BehaviorTree.CPP, and the properties that need more information.

use campaigns::Error;
use channels::Ground;
use monitors::{Formula, Need, Property, ScopeMonitor};

/// The note about the limits of verdicts on such a log.
pub(crate) const LEFT_OPEN: &str = "the log has the changes of status, and not the answers that repeat the one before: \
                                    what `time_until` waits for is a change; nor does it say whether it is whole";

pub(crate) fn ground() -> Ground {
    Ground::Assumed("the program logged every change of status".to_owned())
}

/// Refuses properties that need information which such a log does not contain.
pub(crate) fn refuse_unknown(properties: &[Property]) -> Result<(), Error> {
    for property in properties {
        let unknown = property.scope_monitor().map(ScopeMonitor::formula).and_then(unknown);
        if let Some((message, help)) = unknown {
            return Err(Error::refused(format!("`{}` {message}", property.name), help));
        }
    }
    Ok(())
}

/// The information that a formula needs and the log does not contain, and how to avoid this; none if there is none.
fn unknown(formula: &Formula) -> Option<(&'static str, &'static str)> {
    const TICKS: (&str, &str) = (
        "counts ticks, and a log of BehaviorTree.CPP does not have the times of its ticks",
        "write `timed property`, with durations: `< 300 ms`",
    );
    const REPEATED: (&str, &str) = (
        "depends on each message, with `next`, `previous`, `becomes`, `fresh`, `at most` or `at least`; a log of \
         BehaviorTree.CPP does not have the answers that repeat the one before",
        "say what must hold while a node has a status: `always`, `until`, `since`, `time_until`",
    );
    const WINDOW: (&str, &str) = (
        "looks back a certain time, at answers of which a log of BehaviorTree.CPP has only the changes",
        "leave out the limit, or look ahead: `time_until`",
    );
    formula.needs().into_iter().find_map(|need| match need {
        Need::EachMessage(_) => Some(REPEATED),
        Need::Ago => Some(WINDOW),
        Need::Soon => (!formula.is_timed()).then_some(TICKS),
    })
}
