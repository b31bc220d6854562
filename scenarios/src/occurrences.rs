//! Events in the SCOPE language in a scenario: their problems are reported at their locations in its file.

use std::ops::Range;

use channels::{ChannelId, Topology};
use diagnostics::{Problem, Spanned};
use monitors::{EventAtom, ScopeError};

use crate::error::Complaints;

/// The events in a text: `(BatteryReader, BatteryLevel, m[2] < 30)`, or several joined by `or`.
pub fn occurrences(text: &Spanned<String>, topology: &Topology, complaints: &mut Complaints) -> Option<Vec<EventAtom>> {
    read(["", ""], text, topology, complaints)
}

/// The messages on a channel that satisfy a condition, as events.
pub fn messages(
    condition: &Spanned<String>,
    channel: ChannelId,
    topology: &Topology,
    complaints: &mut Complaints,
) -> Option<Vec<EventAtom>> {
    let (from, to) = topology.ends(channel);
    read([&format!("({from}, {to}, "), ")"], condition, topology, complaints)
}

/// Reads a text of the scenario between a prefix and a suffix.
fn read(
    [before, after]: [&str; 2],
    text: &Spanned<String>,
    topology: &Topology,
    complaints: &mut Complaints,
) -> Option<Vec<EventAtom>> {
    let events = monitors::occurrences("event", &format!("{before}{}{after}", text.value), topology);
    events.map_err(|error| located(&error, before.len(), text).for_each(|problem| complaints.push(problem))).ok()
}

/// The problems, moved to their locations in the scenario. The scenario's text begins at byte `start` of the text that
/// was read.
fn located<'e>(error: &'e ScopeError, start: usize, text: &'e Spanned<String>) -> impl Iterator<Item = Problem> + 'e {
    let place = move |place: Range<usize>| {
        let (from, to) = (place.start.checked_sub(start)?, place.end.checked_sub(start)?);
        // Inside its quotes, unless it contains escapes or does not occur literally in the file.
        let written = text.span.range().start + text.span.text().find(&text.value)?;
        (to <= text.value.len()).then(|| written + from..written + to)
    };
    let moved = move |problem: &Problem| {
        let problem = problem.clone().of(text.span.source());
        problem.moved(|stretch| place(stretch).unwrap_or_else(|| text.span.range()))
    };
    error.problems().iter().filter(|problem| problem.is_error()).map(moved)
}

#[cfg(test)]
mod tests {
    use diagnostics::document::Document;

    use super::*;

    /// The locations of the problems of `when` in the file.
    fn places(file: &str, before: &str) -> Vec<String> {
        let document = Document::parse_toml("scenario.toml", file).expect("a table");
        let text = document.read(|root| root.text("when").spanned().required()).expect("a text");
        let mut topology = Topology::default();
        let [reader, skill] = ["BatteryReader", "BatteryLevel"].map(|name| topology.process(name).expect("a new name"));
        let level = channels::Shape::new([("status", channels::FieldKind::symbols(["ok"]))]);
        let domain = channels::Domain::new([level]);
        topology.channel(reader, skill, channels::Capacity::One, domain).expect("a new channel");
        let error = monitors::occurrences("event", &format!("{before}{}", text.value), &topology).expect_err(file);
        located(&error, before.len(), &text).filter_map(|problem| Some(problem.span()?.text().to_owned())).collect()
    }

    #[test]
    fn an_error_in_an_event_points_to_its_position_in_the_scenario() {
        assert_eq!(places("# What for.\nwhen = \"(BatteryReader, BatteryLevl, true)\"", ""), ["BatteryLevl"]);
        assert_eq!(places("when = '(BatteryReeder, BatteryLevel, true)'", ""), ["BatteryReeder"]);
        let condition = "when = \"m[7] < 3)\"";
        assert!(places(condition, "(BatteryReader, BatteryLevel, ").iter().all(|place| condition.contains(place)));
    }

    #[test]
    fn an_error_without_a_position_points_to_the_whole_text() {
        let escaped = r#"when = "(BatteryReader, \u0042atteryLevl, true)""#;
        assert_eq!(places(escaped, ""), [r#""(BatteryReader, \u0042atteryLevl, true)""#]);
        assert_eq!(places("when = \"true)\"", "(BatteryReader, BatteryLevl, "), ["\"true)\""]);
    }
}
