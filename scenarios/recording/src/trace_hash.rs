//! The hash of a run's trace.

use channels::{Event, Topology};
use maps::Pose;
use robot::{BatteryState, LaserScan, Odometry};

use crate::event_log;

/// Hashes what happened, bit for bit: every event, and every step's true pose, odometry, battery and scans.
///
/// Monitors, pictures and recording are not part of it.
#[derive(Debug, Default)]
pub struct TraceHash {
    hasher: blake3::Hasher,
    /// What the hasher has not got yet: it is several times faster with many bytes at once.
    waiting: Vec<u8>,
}

/// So many bytes at once keep the hasher's vector instructions busy.
const BLOCK_BYTES: usize = 1 << 14;

impl TraceHash {
    /// Adds an event: its line in the event log, with the time as older versions wrote it. Hashes remain comparable.
    pub fn event(&mut self, event: &Event, topology: &Topology) {
        self.waiting.extend_from_slice(event_log::line(event, topology, event.time.as_secs_f64()).as_bytes());
        self.pass_on();
    }

    /// Adds numbers by their bits.
    fn numbers(&mut self, numbers: impl IntoIterator<Item = f64>) {
        self.waiting.extend(numbers.into_iter().flat_map(f64::to_le_bytes));
        self.pass_on();
    }

    fn pass_on(&mut self) {
        if self.waiting.len() >= BLOCK_BYTES {
            self.hasher.update(&self.waiting);
            self.waiting.clear();
        }
    }

    /// Adds the true pose.
    pub fn pose(&mut self, pose: &Pose) {
        self.numbers([pose.translation.x, pose.translation.y, pose.rotation.re, pose.rotation.im]);
    }

    /// Adds odometry.
    pub fn odometry(&mut self, odometry: &Odometry) {
        self.pose(&odometry.pose);
        self.numbers([odometry.linear_mps, odometry.angular_radps]);
    }

    /// Adds the state of the battery.
    pub fn battery(&mut self, battery: &BatteryState) {
        self.numbers([battery.charge_pct, f64::from(u8::from(battery.charging))]);
    }

    /// Adds a scan.
    pub fn scan(&mut self, scan: &LaserScan) {
        self.waiting.extend(scan.ranges_m.iter().flat_map(|range| range.to_le_bytes()));
        self.pass_on();
    }

    /// The hash of everything added so far, in hexadecimal.
    #[must_use]
    pub fn finish(&self) -> String {
        self.hasher.clone().update(&self.waiting).finalize().to_hex().to_string()
    }
}
