//! The ticks of an event log, on which bounds of properties depend.

use std::time::Duration;

use bags::Found;
use campaigns::Error;
use channels::EventKind;
use diagnostics::seconds;
use monitors::{Bound, Formula, Property, ScopeMonitor};

/// The ticks of a log so far, and what properties need of them.
pub(crate) struct Ticks {
    are_counted: bool,
    /// If the length of a tick is not in the log, and bounds in seconds were made ticks with that of the scenario:
    /// how long this is, and the largest of these bounds.
    assumed: Option<(Duration, u64)>,
    has_message: bool,
    /// The numbers and times of the first and the last.
    span: Option<[(u64, Duration); 2]>,
}

impl Ticks {
    /// Of a log, before its first event. How long a tick takes may be assumed.
    pub(crate) fn new(properties: &[Property], assumed: Option<Duration>) -> Self {
        let formulas = properties.iter().filter_map(Property::scope_monitor).map(ScopeMonitor::formula);
        let bounds: Vec<Bound> = formulas.flat_map(Formula::bounds_in_ticks).collect();
        let durations = bounds.iter().filter(|bound| bound.is_duration());
        let longest = durations.map(|bound| bound.ticks).max();
        Self { are_counted: !bounds.is_empty(), assumed: assumed.zip(longest), has_message: false, span: None }
    }

    pub(crate) fn note(&mut self, found: &Result<Found, Error>) {
        let Ok(Found::Event(event)) = found else { return };
        if event.kind == EventKind::Tick {
            let tick = (event.tick, event.time);
            self.span = Some([self.span.map_or(tick, |[first, _]| first), tick]);
        } else {
            self.has_message = true;
        }
    }

    /// At the end of the log: why other numbers of ticks may have passed than properties count, in words.
    pub(crate) fn unfit(self) -> Option<String> {
        let Some([(first, begun), (last, ended)]) = self.span else {
            return (self.are_counted && self.has_message)
                .then(|| "the log has no ticks, and properties count them".to_owned());
        };
        let (assumed, longest) = self.assumed?;
        let (count, assumed_s) = (last.saturating_sub(first), seconds(assumed));
        let found_s = (seconds(ended) - seconds(begun)) / count.max(1) as f64;
        // Ticks need not be exact: the largest bound must not become half a tick longer or shorter.
        let off_s = (found_s - assumed_s).abs() * count.min(longest) as f64;
        (off_s >= assumed_s / 2.0).then(|| {
            format!(
                "a tick takes {found_s:.3} s in the log and {assumed_s} s in the scenario, with which bounds in seconds \
                 were counted: the log's first line, with the time between ticks, may be missing"
            )
        })
    }
}
