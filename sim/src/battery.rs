//! The battery and its charging.

use bevy_ecs::prelude::*;
use rand_chacha::ChaCha8Rng;
use robot::{BatteryState, Reading, normal};

use crate::clock::{Clock, Periodic};
use crate::config::BatteryConfig;
use crate::faults::{BatteryFaults, BatteryReport, Faults};
use crate::readings::Readings;

#[derive(Component, Clone, Debug)]
pub(crate) struct Battery {
    config: BatteryConfig,
    charge_pct: f64,
    charging: bool,
    /// Full, and hardly used since: not charged again as long as the robot stays at the dock.
    full: bool,
    due: Periodic,
    /// The charge in the last reading.
    reported_pct: Option<f64>,
    fault_rng: ChaCha8Rng,
}

impl Battery {
    /// `fault_rng` is only for faults.
    pub(crate) fn new(config: &BatteryConfig, fault_rng: ChaCha8Rng) -> Self {
        Self {
            config: *config,
            charge_pct: config.initial_pct,
            charging: false,
            full: false,
            due: Periodic::new(config.period),
            reported_pct: None,
            fault_rng,
        }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.charge_pct <= 0.0
    }

    /// Sets the charge, clamped to 0 to 100; NaN changes nothing.
    pub(crate) fn set_charge(&mut self, charge_pct: f64) {
        if !charge_pct.is_nan() {
            self.charge_pct = charge_pct.clamp(0.0, 100.0);
        }
    }

    pub(crate) fn state(&self, clock: &Clock) -> BatteryState {
        BatteryState { time: clock.now, charge_pct: self.charge_pct, charging: self.charging }
    }

    /// Processes one step.
    pub(crate) fn update(&mut self, docked: bool, powered: bool, faults: &BatteryFaults, dt_s: f64) {
        let config = &self.config;
        let stays_full = self.full && self.charge_pct >= config.recharge_below_pct;
        self.full = docked && (stays_full || self.charge_pct >= config.full_pct);
        self.charging = docked && !self.full && faults.charger_factor > 0.0;
        self.charge_pct = if self.charging {
            let rate = config.charge_pct_per_s * faults.charger_factor / faults.capacity_factor;
            (self.charge_pct + rate * dt_s).min(config.full_pct)
        } else {
            let rate = if powered { config.drain_pct_per_s } else { config.standstill_drain_pct_per_s };
            (self.charge_pct - rate * faults.drain_factor / faults.capacity_factor * dt_s).clamp(0.0, 100.0)
        };
    }

    /// The reading of the electronics.
    fn report(&mut self, clock: &Clock, faults: &BatteryReport) -> BatteryState {
        let truth = self.state(clock);
        let charge_pct = match self.reported_pct {
            Some(reported_pct) if faults.stuck => reported_pct,
            _ => self.measure(faults),
        };
        self.reported_pct = Some(charge_pct);
        BatteryState { charge_pct, charging: faults.charging.unwrap_or(truth.charging), ..truth }
    }

    /// The charge with its errors.
    fn measure(&mut self, faults: &BatteryReport) -> f64 {
        if faults.offset_pct == 0.0 && faults.sigma_pct == 0.0 {
            return self.charge_pct;
        }
        let random_pct = if faults.sigma_pct > 0.0 { faults.sigma_pct * normal(&mut self.fault_rng) } else { 0.0 };
        (self.charge_pct + faults.offset_pct + random_pct).clamp(0.0, 100.0)
    }
}

/// Reports the battery's state if a reading is due.
pub(crate) fn report_battery(
    clock: Res<Clock>,
    faults: Res<Faults>,
    mut readings: ResMut<Readings>,
    mut battery: Single<&mut Battery>,
) {
    let faults = &faults.battery.reported;
    if battery.due.is_due(clock.now) && !faults.missing {
        readings.push(Reading::Battery(battery.report(&clock, faults)));
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use proptest::prelude::*;
    use robot::Streams;

    use super::*;

    fn with(config: &BatteryConfig) -> Battery {
        Battery::new(config, Streams::new(1).stream("fault/battery"))
    }

    fn battery(initial_pct: f64) -> Battery {
        with(&BatteryConfig { initial_pct, ..BatteryConfig::default() })
    }

    /// Simulates whole seconds, step by step.
    fn pass(battery: &mut Battery, seconds: usize, docked: bool, powered: bool) {
        pass_faulty(battery, seconds, docked, powered, &BatteryFaults::default());
    }

    fn pass_faulty(battery: &mut Battery, seconds: usize, docked: bool, powered: bool, faults: &BatteryFaults) {
        (0..seconds * 50).for_each(|_| battery.update(docked, powered, faults, 0.02));
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
    fn standing_drains_only_if_configured_and_never_below_0() {
        let config = BatteryConfig { initial_pct: 1.0, standstill_drain_pct_per_s: 0.1, ..BatteryConfig::default() };
        let mut battery = with(&config);
        pass(&mut battery, 5, false, false);
        assert_near(battery.charge_pct, 0.5);
        pass(&mut battery, 20, false, true);
        assert_eq!(battery.charge_pct, 0.0);
        assert!(battery.is_empty());
    }

    #[test]
    fn a_docked_battery_charges_until_full_and_again_below_95() {
        let config = BatteryConfig { initial_pct: 99.0, standstill_drain_pct_per_s: 0.01, ..BatteryConfig::default() };
        let mut battery = with(&config);
        let mut switches = Vec::new();
        for _ in 0..1000 * 50 {
            let before = battery.charging;
            battery.update(true, false, &BatteryFaults::default(), 0.02);
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
    fn a_charge_above_full_is_kept_at_the_dock() {
        let mut battery = battery(100.0);
        pass(&mut battery, 10, true, false);
        assert_eq!((battery.charge_pct, battery.charging), (100.0, false));
    }

    #[test]
    fn a_dead_station_does_not_charge_and_a_slow_one_charges_slowly() {
        let mut battery = battery(50.0);
        let station = |charger_factor| BatteryFaults { charger_factor, ..BatteryFaults::default() };
        pass_faulty(&mut battery, 100, true, false, &station(0.0));
        assert_eq!((battery.charge_pct, battery.charging), (50.0, false));
        pass_faulty(&mut battery, 100, true, false, &station(0.2));
        assert_near(battery.charge_pct, 51.0);
        assert!(battery.charging);
    }

    #[test]
    fn a_faded_battery_charges_and_drains_faster_from_the_same_percentage() {
        let faded = BatteryFaults { capacity_factor: 0.5, ..BatteryFaults::default() };
        let mut battery = battery(50.0);
        pass_faulty(&mut battery, 100, false, true, &faded);
        assert_near(battery.charge_pct, 40.0);
        pass_faulty(&mut battery, 50, true, false, &faded);
        assert_near(battery.charge_pct, 45.0);
        pass_faulty(&mut battery, 1000, true, false, &faded);
        assert_near(battery.charge_pct, 99.7);
    }

    #[test]
    fn stuck_readings_repeat_the_last_charge() {
        let (mut battery, clock) = (battery(50.0), Clock { now: Duration::ZERO, dt: Duration::from_millis(20) });
        let stuck = BatteryReport { stuck: true, offset_pct: 9.0, ..BatteryReport::default() };
        let noisy = BatteryReport { sigma_pct: 2.0, ..BatteryReport::default() };
        let reported_pct = battery.report(&clock, &noisy).charge_pct;
        assert_ne!(reported_pct, 50.0);
        battery.set_charge(10.0);
        assert_eq!(battery.report(&clock, &stuck).charge_pct, reported_pct);
        assert_eq!(battery.report(&clock, &BatteryReport::default()).charge_pct, 10.0);
        assert_eq!(battery.report(&clock, &stuck).charge_pct, 10.0);
    }

    proptest! {
        #[test]
        fn readings_are_percentages_with_the_configured_offset(
            charge_pct in 0.0..100.0_f64, offset_pct in -120.0..120.0_f64, sigma_pct in 0.0..30.0_f64
        ) {
            let mut battery = battery(charge_pct);
            let offset = battery.measure(&BatteryReport { offset_pct, ..BatteryReport::default() });
            prop_assert_eq!(offset, (charge_pct + offset_pct).clamp(0.0, 100.0));
            let noisy = battery.measure(&BatteryReport { sigma_pct, offset_pct, ..BatteryReport::default() });
            prop_assert!((0.0..=100.0).contains(&noisy));
        }
    }
}
