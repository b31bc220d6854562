//! The trace of a run: its hash and its event log.

use std::io::{self, Write};
use std::time::Duration;

use channels::{Event, EventKind, Message, Topology, Value};
use nalgebra::Isometry2;
use robot::{BatteryState, LaserScan, Odometry};
use serde_json::json;

/// Hashes what happened, bit for bit: every event, and every step's true pose, odometry, battery and scans.
///
/// Monitors, pictures and recording do not enter.
#[derive(Debug, Default)]
pub struct TraceHash {
    hasher: blake3::Hasher,
}

impl TraceHash {
    /// Enters a line of the event log.
    pub fn line(&mut self, line: &str) {
        self.hasher.update(line.as_bytes());
    }

    /// Enters numbers by their bits.
    fn numbers(&mut self, numbers: impl IntoIterator<Item = f64>) {
        for number in numbers {
            self.hasher.update(&number.to_bits().to_le_bytes());
        }
    }

    /// Enters the true pose.
    pub fn pose(&mut self, pose: &Isometry2<f64>) {
        self.numbers([pose.translation.x, pose.translation.y, pose.rotation.re, pose.rotation.im]);
    }

    /// Enters odometry.
    pub fn odometry(&mut self, odometry: &Odometry) {
        self.pose(&odometry.pose);
        self.numbers([odometry.linear_mps, odometry.angular_radps]);
    }

    /// Enters the state of the battery.
    pub fn battery(&mut self, battery: &BatteryState) {
        self.numbers([battery.charge_pct, f64::from(u8::from(battery.charging))]);
    }

    /// Enters a scan.
    pub fn scan(&mut self, scan: &LaserScan) {
        for range in &scan.ranges_m {
            self.hasher.update(&range.to_bits().to_le_bytes());
        }
    }

    /// The hash of all that was entered, in hexadecimal.
    #[must_use]
    pub fn finish(&self) -> String {
        self.hasher.finalize().to_hex().to_string()
    }
}

/// An event as a line of the event log, without the line's end.
#[must_use]
pub fn event_line(event: &Event, topology: &Topology) -> String {
    let time_s = event.time.as_secs_f64();
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

/// A message as the event log writes it: `[{"sym":"ok"},83.2]`.
#[must_use]
pub fn message_json(message: &Message) -> serde_json::Value {
    let value = |value: &Value| match value {
        Value::Symbol(symbol) => json!({ "sym": symbol.name() }),
        Value::Bool(truth) => json!(truth),
        Value::Int(number) => json!(number),
        Value::Real(number) => json!(number),
        Value::Text(text) => json!(&**text),
    };
    message.fields().iter().map(value).collect()
}

/// Writes the event log, JSON Lines: a line that describes the run, then one a communication, one a tick generated,
/// and one for the tree's statuses whenever they have changed.
pub struct Recorder {
    output: Box<dyn Write>,
    last_statuses: serde_json::Value,
}

impl Recorder {
    /// Begins a log with the line that describes the run.
    ///
    /// # Errors
    /// What the system says.
    pub fn new(output: impl Write + 'static, description: &serde_json::Value) -> io::Result<Self> {
        let mut recorder = Self { output: Box::new(output), last_statuses: serde_json::Value::Null };
        recorder.line(&description.to_string())?;
        Ok(recorder)
    }

    /// Writes an event's line.
    ///
    /// # Errors
    /// What the system says.
    pub fn line(&mut self, line: &str) -> io::Result<()> {
        writeln!(self.output, "{line}")
    }

    /// Writes the tree's statuses, if they are not what they were.
    ///
    /// # Errors
    /// What the system says.
    pub fn statuses(&mut self, tick: u64, time: Duration, statuses: serde_json::Value) -> io::Result<()> {
        if self.last_statuses != statuses {
            self.line(&json!({ "tick": tick, "time_s": time.as_secs_f64(), "tree": statuses }).to_string())?;
            self.last_statuses = statuses;
        }
        Ok(())
    }

    /// Ends the log.
    ///
    /// # Errors
    /// What the system says.
    pub fn finish(mut self) -> io::Result<()> {
        self.output.flush()
    }
}
