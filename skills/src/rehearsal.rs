//! Running a machine alone, with a list of events, in simulated time that jumps from one event to the next.

mod cues;
mod line;

use std::sync::Arc;
use std::time::Duration;

pub use cues::{Cue, Cues};
pub use line::{RehearsalLine, RehearsalLineKind};

use crate::chart::Chart;
use crate::event::Outgoing;
use crate::machine::{Host, Machine, Note, Status, Undelivered};

/// The maximum number of events and timers that may wake a machine: one that always sets a timer for now would never
/// reach a later time. Chosen, not measured.
const MAX_WAKES: u32 = 1_000_000;

/// How a rehearsal ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Ending {
    /// The machine's status: [`Status::Running`] if it ran out of events or time.
    pub status: Status,
    /// Whether error events occurred that no transition handled, here or in an invoked machine.
    pub unhandled_errors: bool,
    /// Whether time ran out with timers still pending.
    pub out_of_time: bool,
}

/// Runs a machine from its start through all cues and delayed events, until it reaches a final state, no events are
/// left, or simulated time is up. Every log line, error, sent message and configuration is passed to `record`; the last
/// configuration comes at the end. A cue at the same time as a delayed event comes after it.
///
/// ```
/// use std::time::Duration;
/// use skills::{Chart, Cues, rehearse};
///
/// let chart = Chart::load("Lamp.scxml", r#"<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0">
///   <state id="off"><transition event="press" target="on"/></state>
///   <state id="on">
///     <onentry><send event="dim" delay="10s"/></onentry>
///     <transition event="dim" target="off"/>
///   </state>
/// </scxml>"#)?;
/// let cues = Cues::parse("evening.jsonl", r#"{"event": "press", "time_s": 1}"#)?;
/// let mut lines = Vec::new();
/// rehearse(&chart, &cues, Duration::from_secs(60), &mut |line| lines.push(line.to_string()));
/// assert_eq!(lines[..3], ["0.000 s  in off", "1.000 s  in on", "11.000 s  in off"]);
/// assert_eq!(lines[3], "11.000 s  final configuration: off (waiting)");
/// # Ok::<(), skills::SkillError>(())
/// ```
pub fn rehearse(chart: &Arc<Chart>, cues: &Cues, until: Duration, record: &mut dyn FnMut(RehearsalLine)) -> Ending {
    let mut machine = Machine::new(Arc::clone(chart));
    let mut observer = Observer { chart, now: Duration::ZERO, record, unhandled_errors: false };
    machine.start(Duration::ZERO, &mut observer);
    let mut cues = cues.iter().peekable();
    let mut out_of_time = false;
    for _ in 0..MAX_WAKES {
        let cue = cues.peek().map(|cue| cue.at);
        let timer = machine.next_timer();
        let Some(next) = [timer, cue].into_iter().flatten().min().filter(|_| machine.status() == Status::Running)
        else {
            break;
        };
        if next > until {
            out_of_time = true;
            break;
        }
        observer.now = next;
        // Of a cue and a timer at the same time, the timer is first.
        if timer == Some(next) {
            machine.fire_timers(next, &mut observer);
        } else if let Some(cue) = cues.next() {
            machine.handle(cue.event.clone(), next, &mut observer);
        }
    }
    observer.record(RehearsalLineKind::Final(line::Situation::of(&machine)));
    Ending { status: machine.status(), unhandled_errors: observer.unhandled_errors, out_of_time }
}

struct Observer<'o> {
    chart: &'o Arc<Chart>,
    now: Duration,
    record: &'o mut dyn FnMut(RehearsalLine),
    unhandled_errors: bool,
}

impl Observer<'_> {
    fn record(&mut self, kind: RehearsalLineKind) {
        (self.record)(RehearsalLine { at: self.now, kind });
    }
}

impl Host for Observer<'_> {
    fn send(&mut self, outgoing: &Outgoing) -> Result<(), Undelivered> {
        self.record(RehearsalLineKind::Sent(outgoing.clone()));
        Ok(())
    }

    fn note(&mut self, note: Note) {
        let mut innermost = &note;
        while let Note::Invoked { note, .. } = innermost {
            innermost = note;
        }
        self.unhandled_errors |= matches!(innermost, Note::UnhandledError { .. });
        let place = match &note {
            Note::Error { span, .. } => Some(line::place(self.chart, span.start)),
            _ => None,
        };
        self.record(RehearsalLineKind::Note(note, place));
    }

    fn entered(&mut self, machine: &Machine) {
        self.record(RehearsalLineKind::Entered(line::Situation::of(machine)));
    }
}
