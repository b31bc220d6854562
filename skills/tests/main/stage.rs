//! A machine alone on a stage: events go in, states and log lines are inspected.

use std::time::Duration;

use skills::{Chart, Datum, Event, Machine, Note, Status, Strictness, Transcript};

use crate::layout::laid_out;

pub(crate) struct Stage {
    pub(crate) machine: Machine,
    pub(crate) host: Transcript,
    now: Duration,
}

/// A file with this content in its `<scxml>` element.
pub(crate) fn file(attributes: &str, content: &str) -> String {
    format!("<scxml xmlns=\"http://www.w3.org/2005/07/scxml\" version=\"1.0\" {attributes}>{content}</scxml>")
}

/// Starts a machine with this content in its `<scxml>` element.
pub(crate) fn stage(content: &str) -> Stage {
    stage_with("", content, Strictness::Strict)
}

/// The same for a machine with mistakes that are only run-time errors according to the recommendation.
pub(crate) fn lenient(content: &str) -> Stage {
    stage_with("", content, Strictness::Standard)
}

pub(crate) fn stage_with(attributes: &str, content: &str, strictness: Strictness) -> Stage {
    let text = file(attributes, content);
    // Every machine of these tests has a layout in which it is the same one.
    laid_out(&text);
    let chart = Chart::load_with("test.scxml", &text, strictness)
        .unwrap_or_else(|error| panic!("{:?}", miette::Report::new(error)));
    let mut stage = Stage { machine: Machine::new(chart), host: Transcript::default(), now: Duration::ZERO };
    stage.machine.start(stage.now, &mut stage.host);
    stage
}

impl Stage {
    pub(crate) fn send(&mut self, name: &str) -> &mut Self {
        self.send_event(Event::external(name))
    }

    pub(crate) fn send_with(&mut self, name: &str, members: &[(&str, Datum)]) -> &mut Self {
        let data = Datum::object(members.iter().cloned()).unwrap();
        self.send_event(Event::external(name).with_data(data))
    }

    pub(crate) fn send_event(&mut self, event: Event) -> &mut Self {
        self.machine.handle(event, self.now, &mut self.host);
        self
    }

    /// Advances the time of the run to this many milliseconds.
    pub(crate) fn at_ms(&mut self, now: u64) -> &mut Self {
        self.now = Duration::from_millis(now);
        self.machine.fire_timers(self.now, &mut self.host);
        self
    }

    /// The active states without children.
    pub(crate) fn active(&self) -> String {
        self.machine.active_ids().collect::<Vec<_>>().join(" ")
    }

    /// The log entries, in order.
    pub(crate) fn log(&self) -> String {
        self.host.log_lines().collect::<Vec<_>>().join(" ")
    }

    pub(crate) fn datum(&self, id: &str) -> Datum {
        self.machine.datum(id).unwrap().clone()
    }

    /// The error events that occurred, in order.
    pub(crate) fn errors(&self) -> Vec<&str> {
        let error = |note: &'_ Note| match note {
            Note::Error { event, .. } => Some(*event),
            _ => None,
        };
        self.host.notes.iter().filter_map(error).collect()
    }

    pub(crate) fn is_done(&self) -> bool {
        self.machine.status() == Status::Done
    }
}
