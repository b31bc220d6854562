//! Events outside any property, for which a fault or a picture waits.

use std::time::Duration;

use channels::Topology;
use diagnostics::{Problem, Source};

use crate::formula::{EventAtom, Formula};
use crate::load::formulas;
use crate::problem::ScopeError;

/// Reads one or more events in the SCOPE language, joined by `or`. A message matches if it satisfies one of them.
///
/// ```
/// use channels::{Capacity, Domain, FieldKind, Shape, Topology};
///
/// let mut topology = Topology::default();
/// let [reader, skill] = [topology.process("BatteryReader")?, topology.process("BatteryLevel")?];
/// let level = Shape::new([("status", FieldKind::symbols(["ok"])), ("level", FieldKind::Real)]);
/// topology.channel(reader, skill, Capacity::One, Domain::new([level]))?;
///
/// let events = monitors::occurrences("when", "(BatteryReader, BatteryLevel, level < 30)", &topology)?;
/// assert_eq!(events.len(), 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// Everything that is wrong with the text; diagnostics show it as a file with this name.
pub fn occurrences(name: &str, text: &str, topology: &Topology) -> Result<Vec<EventAtom>, ScopeError> {
    let before = "property event := eventually (";
    let read = formulas(name, &format!("{before}{text})"), topology, Duration::from_secs(1));
    let read = read.map_err(|error| of_part(&error, name, text, before.len()))?;
    let events = match read.into_iter().next() {
        Some((_, Formula::Eventually(waited_for))) => match *waited_for {
            Formula::Event(event) => Some(vec![event]),
            Formula::Or(parts) => parts.into_iter().map(event).collect(),
            _ => None,
        },
        _ => None,
    };
    events.ok_or_else(|| {
        let problem = Problem::new("this is not an event").at(0..text.len(), "here");
        let problem = problem.with_help("write `(sender, receiver, condition)`, or several such events joined by `or`");
        ScopeError::new(Source::new(name, text), vec![problem])
    })
}

/// The error of a text, moved to the part of it that begins at byte `start`.
fn of_part(error: &ScopeError, name: &str, part: &str, start: usize) -> ScopeError {
    let inside = |offset: usize| offset.saturating_sub(start).min(part.len());
    let moved = |problem: &Problem| problem.clone().moved(|place| inside(place.start)..inside(place.end));
    ScopeError::new(Source::new(name, part), error.problems().iter().map(moved).collect())
}

fn event(formula: Formula) -> Option<EventAtom> {
    if let Formula::Event(event) = formula { Some(event) } else { None }
}

#[cfg(test)]
mod tests {
    use channels::{Capacity, Domain, FieldKind, Message, Shape, Value};

    use super::*;

    fn topology() -> Topology {
        let mut topology = Topology::default();
        let reader = topology.process("BatteryReader").expect("a new name");
        let skill = topology.process("BatteryLevel").expect("a new name");
        let level = Shape::new([("status", FieldKind::symbols(["ok"])), ("level", FieldKind::Real)]);
        topology.channel(reader, skill, Capacity::One, Domain::new([level])).expect("a new channel");
        topology
    }

    #[test]
    fn events_joined_by_or_are_read_one_by_one() {
        let low = "(BatteryReader, BatteryLevel, m[2] < 30)";
        let events = occurrences("when", &format!("{low} or {low}"), &topology()).expect("two events");
        assert_eq!(events.len(), 2);
        let level = |level: f64| Message::new([Value::symbol("ok"), level.into()]);
        assert!(events[0].condition.holds(&level(29.9)) && !events[0].condition.holds(&level(30.0)));
    }

    #[test]
    fn text_that_is_not_an_event_is_refused() {
        for text in ["not (BatteryReader, BatteryLevel, true)", "true", "always (BatteryReader, BatteryLevel, true)"] {
            let error = occurrences("when", text, &topology()).expect_err(text);
            assert_eq!(error.problems().len(), 1, "{text}: {error}");
        }
        let error = occurrences("when", "(BatteryReader, BatteryLevl, true)", &topology()).expect_err("a slip");
        assert!(format!("{error:?}").contains("BatteryLevel"));
        assert_eq!(error.problems()[0].offset(), "(BatteryReader, ".len(), "the place lies in the text");
        let unfinished = occurrences("when", "(BatteryReader, ", &topology()).expect_err("no end");
        assert!(unfinished.problems().iter().all(|problem| problem.offset() <= "(BatteryReader, ".len()));
    }
}
