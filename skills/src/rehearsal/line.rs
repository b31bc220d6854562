//! The output of a machine that runs alone, as text and as JSON.

use std::fmt;
use std::time::Duration;

use crate::Datum;
use crate::chart::Chart;
use crate::event::Outgoing;
use crate::machine::{Machine, Note, Status};

/// Something that happened in a rehearsal. Its `Display` form is a line for people, [`to_json`](Self::to_json) one for
/// programs.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct RehearsalLine {
    /// Since the start of the run.
    pub at: Duration,
    /// What happened.
    pub kind: RehearsalLineKind,
}

/// The events of a rehearsal.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum RehearsalLineKind {
    /// The machine entered a configuration.
    Entered(Situation),
    /// A note; an error also has its position: line and column of the file, from 1.
    Note(Note, Option<(usize, usize)>),
    /// It sent an event, which nothing receives.
    Sent(Outgoing),
    /// The end.
    Final(Situation),
}

/// The state of a machine.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Situation {
    /// The active states, in document order.
    pub configuration: Vec<String>,
    /// Those without children.
    pub active: Vec<String>,
    /// The machine's status.
    pub status: Status,
    /// The data of the final state in which it ended.
    pub result: Datum,
}

impl Situation {
    pub(super) fn of(machine: &Machine) -> Self {
        let ids = machine.configuration().map(|state| machine.chart().state(state).id().to_owned());
        Self {
            configuration: ids.collect(),
            active: machine.active_ids().map(str::to_owned).collect(),
            status: machine.status(),
            result: machine.result().clone(),
        }
    }

    fn status_name(&self) -> &'static str {
        match self.status {
            Status::Ready => "ready",
            Status::Running => "waiting",
            Status::Done => "done",
            Status::Stuck => "stuck",
        }
    }
}

/// RehearsalLine and column of a byte of the chart's file, from 1.
pub(super) fn place(chart: &Chart, offset: usize) -> (usize, usize) {
    let before = chart.file().text().get(..offset).unwrap_or_default();
    let line = before.rsplit('\n').next().unwrap_or_default();
    (before.matches('\n').count() + 1, line.chars().count() + 1)
}

impl fmt::Display for RehearsalLine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.3} s  ", self.at.as_secs_f64())?;
        match &self.kind {
            RehearsalLineKind::Entered(situation) => write!(f, "in {}", situation.active.join(", ")),
            RehearsalLineKind::Note(note, place) => write_note(note, *place, f),
            RehearsalLineKind::Sent(outgoing) => {
                let (target, event) = (outgoing.target.as_deref(), outgoing.event.as_deref());
                write!(f, "sends {}", event.unwrap_or("a content"))?;
                match target {
                    Some(target) => write!(f, " to {target}")?,
                    None => f.write_str(" without a target")?,
                }
                if outgoing.data == Datum::Undefined { Ok(()) } else { write!(f, " {}", outgoing.data) }
            }
            RehearsalLineKind::Final(situation) => {
                let Situation { active, result, .. } = situation;
                write!(f, "final configuration: {} ({})", active.join(", "), situation.status_name())?;
                if *result == Datum::Undefined { Ok(()) } else { write!(f, " {result}") }
            }
        }
    }
}

fn write_note(note: &Note, place: Option<(usize, usize)>, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    match note {
        Note::Log { label, text } if label.is_empty() => write!(f, "log {text}"),
        Note::Log { label, text } => write!(f, "log {label}: {text}"),
        Note::Error { event, reason, .. } => match place {
            Some((line, column)) => write!(f, "{event} at {line}:{column}: {reason}"),
            None => write!(f, "{event}: {reason}"),
        },
        Note::UnhandledError { event } => write!(f, "{event} is not handled"),
        Note::Unheard { event } => write!(f, "sends {event} to itself, but no transition handles it"),
        Note::Invoked { id, note } => {
            write!(f, "[{id}] ")?;
            write_note(note, None, f)
        }
        Note::Stuck { microsteps } => write!(f, "did not come to rest: stopped after {microsteps} microsteps"),
    }
}

impl RehearsalLine {
    /// The line as a JSON object: `time_s` and one of `configuration` (with `active`), `log`, `error`, `unhandled`,
    /// `unheard`, `sent`, `stuck`, `invoked` and `final` (with `active`, `status` and `result`).
    #[must_use]
    pub fn to_json(&self) -> String {
        let mut members = vec![("time_s", Datum::from(self.at.as_secs_f64()))];
        match &self.kind {
            RehearsalLineKind::Entered(situation) => {
                members.push(("configuration", list(&situation.configuration)));
                members.push(("active", list(&situation.active)));
            }
            RehearsalLineKind::Note(note, place) => members.extend(note_members(note, *place)),
            RehearsalLineKind::Sent(Outgoing { processor, target, event, send_id, data, .. }) => {
                let optional = |text: &Option<std::sync::Arc<str>>| text.clone().map_or(Datum::Null, Datum::Text);
                let sent = [
                    ("type", Datum::Text(std::sync::Arc::clone(processor))),
                    ("target", optional(target)),
                    ("event", optional(event)),
                    ("sendid", optional(send_id)),
                    ("data", data.clone()),
                ];
                members.push(("sent", object(sent)));
            }
            RehearsalLineKind::Final(situation) => {
                members.push(("final", list(&situation.configuration)));
                members.push(("active", list(&situation.active)));
                members.push(("status", situation.status_name().into()));
                members.push(("result", situation.result.clone()));
            }
        }
        object(members).to_json()
    }
}

fn note_members(note: &Note, place: Option<(usize, usize)>) -> Vec<(&'static str, Datum)> {
    let text = |text: &str| Datum::text(text);
    match note {
        Note::Log { label, text: line } => {
            vec![("log", object([("label", text(label)), ("text", text(line))]))]
        }
        Note::Error { event, reason, .. } => {
            let mut error = vec![("event", text(event)), ("reason", text(reason))];
            if let Some((line, column)) = place {
                error.extend([("line", Datum::from(line as f64)), ("column", Datum::from(column as f64))]);
            }
            vec![("error", object(error))]
        }
        Note::UnhandledError { event } => vec![("unhandled", text(event))],
        Note::Unheard { event } => vec![("unheard", text(event))],
        Note::Invoked { id, note } => {
            let mut inner = vec![("id", text(id))];
            inner.extend(note_members(note, None));
            vec![("invoked", object(inner))]
        }
        Note::Stuck { microsteps } => vec![("stuck", Datum::from(f64::from(*microsteps)))],
    }
}

fn object(members: impl IntoIterator<Item = (&'static str, Datum)>) -> Datum {
    // A note is a few members around one of the machine's values; only a value of maximum size does not fit.
    Datum::object(members).unwrap_or_default()
}

fn list(ids: &[String]) -> Datum {
    Datum::array(ids.iter().map(|id| Datum::text(id))).unwrap_or_default()
}
