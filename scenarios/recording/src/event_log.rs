//! The event log: a run's communications as JSON Lines.

use std::io::{self, BufWriter, Write};

use channels::{ChannelId, Event, EventKind, Flaw, Gap, Message, Topology, Value};
use diagnostics::seconds;
use monitors::WORLD;
use serde_json::json;

use crate::{Carried, Ended, Follower, Happening, RunView};

/// An event as a line of the event log, without the newline.
#[must_use]
pub fn event_line(event: &Event, topology: &Topology) -> String {
    line(event, topology, seconds(event.time))
}

/// The same, with this time in seconds.
pub(crate) fn line(event: &Event, topology: &Topology, time_s: f64) -> String {
    match &event.kind {
        EventKind::Tick => json!({ "step": event.step, "tick": event.tick, "time_s": time_s, "generated": "tick" }),
        EventKind::Received { channel, message } => {
            let (from, to) = topology.ends(*channel);
            let message = message_json(message);
            json!({ "step": event.step, "tick": event.tick, "time_s": time_s, "from": from, "to": to, "message": message })
        }
    }
    .to_string()
}

/// Whether it is what is true in the world, which is no step of the run.
fn is_of_world(event: &Event, topology: &Topology) -> bool {
    matches!(event.kind, EventKind::Received { channel, .. } if topology.ends(channel).0 == WORLD)
}

fn gap_line(gap: &Gap, topology: &Topology) -> serde_json::Value {
    let flaw = match gap.flaw {
        Flaw::Missing => "missing",
        Flaw::Late => "late",
        Flaw::Displaced => "displaced",
        Flaw::Ticks => "ticks",
        Flaw::Mixed => "mixed",
    };
    let mut line = json!({ "missing": gap.why, "flaw": flaw });
    if let Some(since) = gap.since {
        line["since_s"] = seconds(since).into();
    }
    if let Some(channel) = gap.channel {
        (line["channel"], line["ends"]) = (channel_json(channel, topology), gap.ends.into());
    }
    line
}

/// The end of the gaps in a channel as a line of the event log, without the newline.
fn resumed_line(channel: ChannelId, topology: &Topology) -> serde_json::Value {
    json!({ "resumed": channel_json(channel, topology) })
}

fn channel_json(channel: ChannelId, topology: &Topology) -> serde_json::Value {
    let (from, to) = topology.ends(channel);
    json!([from, to])
}

/// A message as the event log writes it: `[{"sym":"ok"},83.2]`. JSON has no number for infinity: `{"real":"-inf"}`.
#[must_use]
pub fn message_json(message: &Message) -> serde_json::Value {
    message.fields().iter().map(value_json).collect()
}

fn value_json(value: &Value) -> serde_json::Value {
    match value {
        Value::Symbol(symbol) => json!({ "sym": symbol.name() }),
        Value::Bool(truth) => json!(truth),
        Value::Int(number) => json!(number),
        Value::Real(number) if number.is_infinite() => json!({ "real": number.to_string() }),
        Value::Real(number) => json!(number),
        Value::Text(text) => json!(&**text),
        Value::List(items) => items.iter().map(value_json).collect(),
    }
}

/// Writes the event log as JSON Lines: one line that describes the run, then one line per communication, one per
/// generated tick, and one with the tree's statuses each time they change. The last line is about why and when the run
/// ended, and repeats the numbers of the last events, so that missing lines before it are noticed.
#[derive(Debug)]
pub struct EventLogWriter<W: Write> {
    output: BufWriter<W>,
    /// The tree's statuses as they were last written, at first unknown.
    statuses: Vec<Option<bt::Outcome>>,
    /// The step and the tick of the last event.
    last: (u64, Option<u64>),
    /// How many messages of the world have been written, and how many lines with gaps or their ends.
    of_world: u64,
    gaps: u64,
}

impl<W: Write> EventLogWriter<W> {
    /// Starts the log of a run at its start, with the line that describes the run. Its steps must have
    /// [details](crate::Details).
    ///
    /// # Errors
    /// If writing fails.
    pub fn begin(output: W, view: &RunView) -> io::Result<Self> {
        let mut log =
            Self { output: BufWriter::new(output), statuses: Vec::new(), last: (0, None), of_world: 0, gaps: 0 };
        let header = view.header();
        let mut description = json!({
            "scenario": header.scenario,
            "seed": header.seed,
            "version": header.version,
            "provenance": header.provenance(),
            "tick_s": seconds(header.tick),
            "channels": Carried::by(view.topology()).written(),
            "has_end": true,
        });
        if !header.remote.is_empty() {
            description["remote"] = json!(header.remote);
        }
        writeln!(log.output, "{description}")?;
        log.follow(view)?;
        Ok(log)
    }

    /// Ends the log and returns its file.
    ///
    /// # Errors
    /// If writing fails.
    pub fn finish(self) -> io::Result<W> {
        self.output.into_inner().map_err(io::IntoInnerError::into_error)
    }
}

impl<W: Write> Follower for EventLogWriter<W> {
    type Error = io::Error;

    fn follow(&mut self, view: &RunView) -> io::Result<()> {
        for happening in view.happenings() {
            let line = match happening {
                Happening::Lost(gap) => gap_line(gap, view.topology()),
                Happening::Resumed(channel) => resumed_line(*channel, view.topology()),
                _ => continue,
            };
            writeln!(self.output, "{line}")?;
            self.gaps += 1;
        }
        let mut before_ticks = view.outcomes_before_ticks().iter().peekable();
        for event in view.events() {
            let is_tick = event.kind == EventKind::Tick;
            let before = before_ticks.next_if(|_| is_tick);
            // Before the first tick, no node has a status.
            if let Some(outcomes) = before.filter(|outcomes| outcomes.iter().any(Option::is_some)) {
                self.write_statuses(view, outcomes, event.tick.saturating_sub(1))?;
            }
            let mut line = event_line(event, view.topology());
            self.of_world += u64::from(is_of_world(event, view.topology()));
            if self.of_world > 0 {
                line.insert_str(line.len() - 1, &format!(",\"world\":{}", self.of_world));
            }
            writeln!(self.output, "{line}")?;
            self.last = (event.step, if is_tick { Some(event.tick) } else { self.last.1 });
        }
        self.write_statuses(view, view.outcomes(), view.ticks().saturating_sub(1))?;
        let is_whole = |ended: &&Ended| !matches!(ended, Ended::CutOff(_));
        if let Some(ended) = view.end().map(|end| &end.ended).filter(is_whole) {
            let (step, tick) = self.last;
            let mut end = json!({ "end": ended.name(), "step": step, "time_s": seconds(view.time()) });
            if let Some(tick) = tick {
                end["tick"] = tick.into();
            }
            if self.of_world > 0 {
                end["world"] = self.of_world.into();
            }
            if self.gaps > 0 {
                end["gaps"] = self.gaps.into();
            }
            writeln!(self.output, "{end}")?;
        }
        Ok(())
    }
}

impl<W: Write> EventLogWriter<W> {
    /// Writes the tree's statuses if they have changed.
    fn write_statuses(&mut self, view: &RunView, outcomes: &[Option<bt::Outcome>], tick: u64) -> io::Result<()> {
        // Before anything has happened, there is nothing to write.
        if self.statuses != outcomes && !(self.statuses.is_empty() && view.events().is_empty()) {
            let (time_s, tree) = (seconds(view.time()), statuses(view, outcomes));
            writeln!(self.output, "{}", json!({ "tick": tick, "time_s": time_s, "tree": tree }))?;
            outcomes.clone_into(&mut self.statuses);
        }
        Ok(())
    }
}

/// The tree's statuses, keyed by the node's number and name.
fn statuses(view: &RunView, outcomes: &[Option<bt::Outcome>]) -> serde_json::Value {
    let nodes = view.header().tree.iter().enumerate().zip(outcomes);
    let named = nodes.map(|((number, node), outcome)| {
        let outcome = outcome.map_or(serde_json::Value::Null, |outcome| outcome.name().into());
        (format!("{number} {}", node.process), outcome)
    });
    serde_json::Value::Object(named.collect())
}
