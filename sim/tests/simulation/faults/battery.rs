//! Faults of the battery, its electronics and the charger.

use maps::pose;
use robot::{BatteryState, Reading, Robot};
use sim::{BatteryReport, SimConfig, Simulation};

use crate::{drive, in_a_room};

/// A robot at the station of the room, with this charge; the readings of time 0 have been read.
fn at_the_station(initial_pct: f64) -> Simulation {
    let mut config = SimConfig::default();
    config.battery.initial_pct = initial_pct;
    let mut sim = in_a_room(&config, pose(7.0, 5.0, 0.0));
    sim.read(&mut Vec::new());
    sim
}

/// The battery's readings while the robot stands for this many steps.
fn states(sim: &mut Simulation, steps: usize) -> Vec<BatteryState> {
    let readings = drive(sim, 0.0, 0.0, steps);
    readings.iter().filter_map(|r| if let Reading::Battery(state) = r { Some(*state) } else { None }).collect()
}

fn reported(report: BatteryReport) -> Simulation {
    let mut sim = at_the_station(50.0);
    sim.faults_mut().battery.reported = report;
    sim
}

#[test]
fn a_faded_battery_drains_and_charges_faster() {
    let charged = |capacity_factor: f64| {
        let mut sim = at_the_station(50.0);
        sim.faults_mut().battery.capacity_factor = capacity_factor;
        drive(&mut sim, 0.0, 0.0, 50 * 61);
        let charged_pct = sim.truth().battery().charge_pct;
        drive(&mut sim, 0.0, 1.0, 500);
        (charged_pct - 50.0, charged_pct - sim.truth().battery().charge_pct)
    };
    let (new, faded) = (charged(1.0), charged(0.25));
    assert!(new.0 > 2.9 && new.1 > 0.49, "{new:?}");
    assert!((faded.0 - 4.0 * new.0).abs() < 1e-9 && (faded.1 - 4.0 * new.1).abs() < 1e-9, "{new:?} {faded:?}");
}

#[test]
fn a_robot_docked_to_a_dead_station_reports_that_it_is_not_charging() {
    let mut sim = at_the_station(50.0);
    sim.faults_mut().battery.charger_factor = 0.0;
    let states = states(&mut sim, 500);
    assert!(sim.truth().is_docked());
    assert!(states.iter().all(|state| !state.charging && state.charge_pct == 50.0));
    sim.faults_mut().battery.charger_factor = 1.0;
    drive(&mut sim, 0.0, 0.0, 500);
    assert!((sim.truth().battery().charge_pct - 50.5).abs() < 1e-9);
}

#[test]
fn a_slow_station_charges_slowly() {
    let mut sim = at_the_station(50.0);
    drive(&mut sim, 0.0, 0.0, 100);
    let before_pct = sim.truth().battery().charge_pct;
    sim.faults_mut().battery.charger_factor = 0.2;
    drive(&mut sim, 0.0, 0.0, 500);
    assert!((sim.truth().battery().charge_pct - before_pct - 0.1).abs() < 1e-9);
}

#[test]
fn a_stuck_sensor_repeats_its_last_charge_with_new_times() {
    let mut sim = at_the_station(50.0);
    let before_pct = states(&mut sim, 200).last().expect("the battery reports").charge_pct;
    sim.faults_mut().battery.reported.stuck = true;
    let stuck = states(&mut sim, 500);
    assert!(stuck.iter().all(|state| state.charge_pct == before_pct && state.charging));
    assert!(stuck.is_sorted_by(|a, b| a.time < b.time) && stuck.len() == 100);
    assert!(sim.truth().battery().charge_pct > before_pct + 0.4);
    sim.faults_mut().battery.reported.stuck = false;
    assert!(states(&mut sim, 5)[0].charge_pct > before_pct + 0.4);
}

#[test]
fn an_offset_affects_only_the_readings() {
    let mut sim = reported(BatteryReport { offset_pct: -12.5, ..BatteryReport::default() });
    assert_eq!(states(&mut sim, 5)[0].charge_pct, 37.5);
    assert_eq!(sim.truth().battery().charge_pct, 50.0);
    sim.faults_mut().battery.reported.offset_pct = -60.0;
    assert_eq!(states(&mut sim, 5)[0].charge_pct, 0.0);
}

#[test]
fn noise_has_the_requested_spread() {
    let mut sim = reported(BatteryReport { sigma_pct: 3.0, ..BatteryReport::default() });
    sim.faults_mut().battery.charger_factor = 0.0;
    let states = states(&mut sim, 50 * 1000);
    let errors_pct = states.iter().map(|state| state.charge_pct - 50.0);
    let sigma_pct = (errors_pct.map(|error_pct| error_pct * error_pct).sum::<f64>() / states.len() as f64).sqrt();
    assert!((sigma_pct - 3.0).abs() < 0.1, "{sigma_pct}");
}

#[test]
fn missing_readings_are_lost() {
    let mut sim = reported(BatteryReport { missing: true, ..BatteryReport::default() });
    assert_eq!(states(&mut sim, 501), []);
    sim.faults_mut().battery.reported.missing = false;
    assert_eq!(states(&mut sim, 49).len(), 10);
}

#[test]
fn the_charging_status_can_be_wrong_both_ways() {
    let mut sim = reported(BatteryReport { charging: Some(true), ..BatteryReport::default() });
    let early = states(&mut sim, 20);
    assert!(early.iter().all(|state| state.charging) && !sim.truth().battery().charging);
    sim.faults_mut().battery.reported.charging = Some(false);
    let late = states(&mut sim, 100);
    assert!(late.iter().all(|state| !state.charging) && sim.truth().battery().charging);
}
