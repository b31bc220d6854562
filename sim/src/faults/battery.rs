//! Faults of the battery.

/// Faults of the battery.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BatteryFaults {
    /// Factor of the consumption, driving and standing; at least 0. Default 1.
    pub drain_factor: f64,
    /// Remaining share of the battery's capacity; greater than 0. Percentages refer to the remaining capacity: a full
    /// battery still has 100 %, but consumption and charging change the percentage 1/factor times as fast. Fading
    /// itself changes no percentage. Default 1.
    pub capacity_factor: f64,
    /// Factor of the charging rate: 0.2 is slow; at 0 the station is dead, and a docked robot does not charge. At least
    /// 0. Default 1.
    pub charger_factor: f64,
    /// The readings of the electronics.
    pub reported: BatteryReport,
}

impl Default for BatteryFaults {
    fn default() -> Self {
        Self { drain_factor: 1.0, capacity_factor: 1.0, charger_factor: 1.0, reported: BatteryReport::default() }
    }
}

/// Faults of the battery's readings. The battery itself is unaffected.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct BatteryReport {
    /// Readings repeat the last charge reported before the fault, without regard to offset and noise; their time and
    /// charging status are new. Default false.
    pub stuck: bool,
    /// Added to the reported charge, in percentage points; the result stays between 0 and 100. Default 0.
    pub offset_pct: f64,
    /// Standard deviation of a random error of the reported charge, in percentage points, drawn for every reading; the
    /// result stays between 0 and 100. Default 0.
    pub sigma_pct: f64,
    /// No readings come. Default false.
    pub missing: bool,
    /// The reported charging status. Default none: the true one.
    pub charging: Option<bool>,
}
