//! The battery and its charging.

use bevy_ecs::prelude::*;
use robot::{BatteryState, Reading};

use crate::clock::{Clock, Periodic};
use crate::config::BatteryConfig;
use crate::docking::{Dock, Station};
use crate::drive::{Drive, Motion, RobotPose};
use crate::faults::Faults;
use crate::simulation::Readings;

/// The battery.
#[derive(Component, Clone, Debug)]
pub(crate) struct Battery {
    config: BatteryConfig,
    charge_pct: f64,
    charging: bool,
    /// Full, and not used much since: not charged again as long as the robot stays at the dock.
    full: bool,
    due: Periodic,
}

impl Battery {
    pub(crate) fn new(config: &BatteryConfig) -> Self {
        let due = Periodic::new(config.period);
        Self { config: *config, charge_pct: config.initial_pct, charging: false, full: false, due }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.charge_pct <= 0.0
    }

    /// Sets the charge, clamped to 0 to 100; what is not a number changes nothing.
    pub(crate) fn set_charge(&mut self, charge_pct: f64) {
        if !charge_pct.is_nan() {
            self.charge_pct = charge_pct.clamp(0.0, 100.0);
        }
    }

    /// The state at that time.
    pub(crate) fn state(&self, clock: &Clock) -> BatteryState {
        BatteryState { time: clock.now, charge_pct: self.charge_pct, charging: self.charging }
    }

    /// Takes in one step. `drain_factor` multiplies what is drained.
    fn update(&mut self, docked: bool, powered: bool, drain_factor: f64, dt_s: f64) {
        let config = &self.config;
        let stays_full = self.full && self.charge_pct >= config.recharge_below_pct;
        self.full = docked && (stays_full || self.charge_pct >= config.full_pct);
        self.charging = docked && !self.full;
        self.charge_pct = if self.charging {
            (self.charge_pct + config.charge_pct_per_s * dt_s).min(config.full_pct)
        } else {
            let rate = if powered { config.drain_pct_per_s } else { config.standstill_drain_pct_per_s };
            (self.charge_pct - rate * drain_factor * dt_s).clamp(0.0, 100.0)
        };
    }
}

/// Docks, drains and charges.
pub(crate) fn update_battery(
    clock: Res<Clock>,
    faults: Res<Faults>,
    station: Single<&Station>,
    robot: Single<(&RobotPose, &Motion, &Drive, &mut Dock, &mut Battery)>,
) {
    let (pose, motion, drive, mut dock, mut battery) = robot.into_inner();
    dock.update(&pose.0, &station.0, motion.at_rest, clock.dt);
    battery.update(dock.is_docked(), drive.is_powered(), faults.battery.drain_factor, clock.dt_s());
}

/// Reports the battery's state if a reading is due.
pub(crate) fn report_battery(clock: Res<Clock>, mut readings: ResMut<Readings>, mut battery: Single<&mut Battery>) {
    if battery.due.is_due(clock.now) {
        readings.push(Reading::Battery(battery.state(&clock)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn battery(charge_pct: f64) -> Battery {
        Battery::new(&BatteryConfig { initial_pct: charge_pct, ..BatteryConfig::default() })
    }

    /// Lets whole seconds pass, step by step.
    fn pass(battery: &mut Battery, seconds: usize, docked: bool, powered: bool) {
        (0..seconds * 50).for_each(|_| battery.update(docked, powered, 1.0, 0.02));
    }

    fn assert_near(charge_pct: f64, expected_pct: f64) {
        assert!((charge_pct - expected_pct).abs() < 1e-9, "{charge_pct} instead of {expected_pct}");
    }

    #[test]
    fn driving_drains_and_standing_does_not() {
        let mut battery = battery(80.0);
        pass(&mut battery, 100, false, true);
        assert_near(battery.charge_pct, 75.0);
        pass(&mut battery, 100, false, false);
        assert_near(battery.charge_pct, 75.0);
    }

    #[test]
    fn standing_drains_if_told_to_and_never_below_0() {
        let config = BatteryConfig { initial_pct: 1.0, standstill_drain_pct_per_s: 0.1, ..BatteryConfig::default() };
        let mut battery = Battery::new(&config);
        pass(&mut battery, 5, false, false);
        assert_near(battery.charge_pct, 0.5);
        pass(&mut battery, 20, false, true);
        assert_eq!(battery.charge_pct, 0.0);
        assert!(battery.is_empty());
    }

    #[test]
    fn docked_it_charges_until_full_and_then_once_more_only_below_95() {
        let config = BatteryConfig { initial_pct: 99.0, standstill_drain_pct_per_s: 0.01, ..BatteryConfig::default() };
        let mut battery = Battery::new(&config);
        let mut switches = Vec::new();
        for _ in 0..1000 * 50 {
            let before = battery.charging;
            battery.update(true, false, 1.0, 0.02);
            if battery.charging != before {
                switches.push((battery.charging, (battery.charge_pct * 10.0).round() / 10.0));
            }
        }
        assert_eq!(switches, [(true, 99.0), (false, 99.7), (true, 95.0), (false, 99.7)]);
    }

    #[test]
    fn leaving_the_dock_lets_it_charge_again() {
        let mut battery = battery(99.69);
        pass(&mut battery, 2, true, false);
        assert!(!battery.charging);
        pass(&mut battery, 1, false, true);
        pass(&mut battery, 1, true, false);
        assert_near(battery.charge_pct, 99.7);
        assert!(battery.full || battery.charging);
    }

    #[test]
    fn a_charge_that_is_set_is_clamped() {
        let mut battery = battery(50.0);
        for (set, expected) in [(10.0, 10.0), (-3.0, 0.0), (140.0, 100.0), (f64::NAN, 100.0)] {
            battery.set_charge(set);
            assert_eq!(battery.charge_pct, expected);
        }
    }

    #[test]
    fn more_than_full_is_kept_at_the_dock() {
        let mut battery = battery(100.0);
        pass(&mut battery, 10, true, false);
        assert_eq!((battery.charge_pct, battery.charging), (100.0, false));
    }
}
