//! The robot of a scenario: its `[robot]`, `[battery]` and `[noise]`.

use diagnostics::document::Table;
use sim::{DriftNoise, SimConfig};

use super::STEP;

/// Reads the settings of the simulated robot.
pub(super) fn read_sim(root: Table<'_>) -> SimConfig {
    let mut sim = SimConfig { dt: STEP, ..SimConfig::default() };
    if let Some(battery) = root.table("battery").optional() {
        let defaults = sim.battery;
        let rate = |key, default| battery.number(key).within(0.0..=100.0).or(default);
        sim.battery.initial_pct = rate("initial_pct", defaults.initial_pct);
        sim.battery.drain_pct_per_s = rate("drain_pct_per_s", defaults.drain_pct_per_s);
        sim.battery.standstill_drain_pct_per_s =
            rate("standstill_drain_pct_per_s", defaults.standstill_drain_pct_per_s);
        sim.battery.charge_pct_per_s = rate("charge_pct_per_s", defaults.charge_pct_per_s);
    }
    if let Some(noise) = root.table("noise").optional() {
        sim.lasers.range_sigma_m = noise.number("laser_sigma_m").within(0.0..=1.0).or(0.0);
        sim.odometry.noise = noise.table("odometry").optional().map_or(DriftNoise::NONE, read_drift);
        sim.drive.noise = noise.table("motion").optional().map_or(DriftNoise::NONE, read_drift);
    }
    sim
}

fn read_drift(table: Table<'_>) -> DriftNoise {
    let sigma = |key| table.number(key).within(0.0..=1.0).or(0.0);
    DriftNoise {
        angle_per_sqrt_rad: sigma("angle_per_sqrt_rad"),
        angle_per_sqrt_m: sigma("angle_per_sqrt_m"),
        distance_per_sqrt_m: sigma("distance_per_sqrt_m"),
        distance_per_sqrt_rad: sigma("distance_per_sqrt_rad"),
    }
}
