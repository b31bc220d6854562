//! The ticks of an event log, on which bounds of properties depend.

use std::time::Duration;

use bags::Found;
use campaigns::Error;
use channels::EventKind;
use diagnostics::seconds;
use monitors::{Bound, Formula, Property, ScopeMonitor};

/// The ticks of a log so far, and what properties need to know of them.
pub(super) struct Ticks {
    /// Whether properties count ticks.
    are_counted: bool,
    /// How long a tick takes in the scenario, if the log does not say so and bounds in seconds were made ticks with it.
    assumed: Option<Duration>,
    has_message: bool,
    /// The numbers and times of the first and the last.
    span: Option<[(u64, Duration); 2]>,
}

impl Ticks {
    /// Of a log, before its first event. How long a tick takes may be assumed.
    pub(super) fn new(properties: &[Property], assumed: Option<Duration>) -> Self {
        let mut bounds = Vec::new();
        let formulas = properties.iter().filter_map(Property::scope_monitor).map(ScopeMonitor::formula);
        formulas.for_each(|formula| bounds_in_ticks(formula, &mut bounds));
        let has_duration = bounds.iter().any(|bound| bound.is_duration());
        Self {
            are_counted: !bounds.is_empty(),
            assumed: assumed.filter(|_| has_duration),
            has_message: false,
            span: None,
        }
    }

    /// Takes note of an event.
    pub(super) fn note(&mut self, found: &Result<Found, Error>) {
        let Ok(Found::Event(event)) = found else { return };
        if event.kind == EventKind::Tick {
            let tick = (event.tick, event.time);
            self.span = Some([self.span.map_or(tick, |[first, _]| first), tick]);
        } else {
            self.has_message = true;
        }
    }

    /// At the end of the log: why other numbers of ticks may have passed than properties count, in words.
    pub(super) fn unfit(self) -> Option<String> {
        let Some([(first, begun), (last, ended)]) = self.span else {
            return (self.are_counted && self.has_message)
                .then(|| "the log has no ticks, and properties count them".to_owned());
        };
        let (assumed, count) = (self.assumed?, last.saturating_sub(first).max(1) as f64);
        let found_s = (seconds(ended) - seconds(begun)) / count;
        let is_fit = last == first || (found_s - seconds(assumed)).abs() * count < seconds(assumed) / 4.0;
        (!is_fit).then(|| {
            let assumed_s = seconds(assumed);
            format!(
                "a tick takes {found_s:.3} s in the log and {assumed_s} s in the scenario, with which bounds in seconds \
                 were counted: the log's first line, which says how long one takes, may be missing"
            )
        })
    }
}

/// Adds the bounds that count ticks.
fn bounds_in_ticks(formula: &Formula, bounds: &mut Vec<Bound>) {
    match formula {
        // Its bounds are durations.
        Formula::Timed(_) => return,
        Formula::TimeUntil { bound, .. }
        | Formula::Once(bound, _)
        | Formula::Historically(bound, _)
        | Formula::Previous(bound, _)
        | Formula::Since(bound, ..)
        | Formula::Count { bound, .. } => bounds.extend((*bound != Bound::NONE).then_some(*bound)),
        _ => {}
    }
    formula.operands().into_iter().for_each(|operand| bounds_in_ticks(operand, bounds));
}
