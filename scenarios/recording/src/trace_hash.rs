//! The hash of a run's trace.

use maps::Pose;
use robot::{BatteryState, LaserScan, Odometry};

/// Hashes what happened, bit for bit: every event, and every step's true pose, odometry, battery and scans.
///
/// Monitors, pictures and recording are not part of it.
#[derive(Debug, Default)]
pub struct TraceHash {
    hasher: blake3::Hasher,
}

impl TraceHash {
    /// Adds a line of the event log.
    pub fn line(&mut self, line: &str) {
        self.hasher.update(line.as_bytes());
    }

    /// Adds numbers by their bits.
    fn numbers(&mut self, numbers: impl IntoIterator<Item = f64>) {
        for number in numbers {
            self.hasher.update(&number.to_bits().to_le_bytes());
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
        for range in &scan.ranges_m {
            self.hasher.update(&range.to_bits().to_le_bytes());
        }
    }

    /// The hash of everything added so far, in hexadecimal.
    #[must_use]
    pub fn finish(&self) -> String {
        self.hasher.finalize().to_hex().to_string()
    }
}
