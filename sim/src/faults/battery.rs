//! What can be wrong with the battery.

/// What can be wrong with the battery.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BatteryFaults {
    /// Factor of what is drained, driving and standing; at least 0. Default 1.
    pub drain_factor: f64,
    /// Share of its capacity that is left to the battery; greater than 0. Percentages are of what is left: a full battery
    /// still has 100 %, but what is drained or charged changes the percentage by 1/factor as much. Fading changes no
    /// percentage by itself. Default 1.
    pub capacity_factor: f64,
    /// Factor of what the charging station gives: 0.2 is slow; at 0 the station is dead, and a docked robot is not
    /// charging. At least 0. Default 1.
    pub charger_factor: f64,
    /// What the electronics report.
    pub reported: BatteryReport,
}

impl Default for BatteryFaults {
    fn default() -> Self {
        Self { drain_factor: 1.0, capacity_factor: 1.0, charger_factor: 1.0, reported: BatteryReport::default() }
    }
}

/// What can be wrong with the readings of the battery. The battery itself, what it drains and when it charges, is as it is.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct BatteryReport {
    /// Readings repeat the charge that the last reading before told, whatever its offset and noise are now; their time
    /// and their charging status are new. Default false.
    pub stuck: bool,
    /// Added to the charge, in percentage points; what is reported stays from 0 to 100. Default 0.
    pub offset_pct: f64,
    /// Standard deviation of a random error of the charge, in percentage points, new at every reading; what is reported
    /// stays from 0 to 100. Default 0.
    pub sigma_pct: f64,
    /// No readings come. Default false.
    pub missing: bool,
    /// What readings claim about charging. Default none: what is so.
    pub charging: Option<bool>,
}
