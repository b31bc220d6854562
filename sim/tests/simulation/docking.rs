//! Docking and charging.

use maps::pose;
use robot::Reading;
use sim::SimConfig;

use crate::{drive, in_a_room};

fn at_charge(initial_pct: f64) -> SimConfig {
    let mut config = SimConfig::default();
    config.battery.initial_pct = initial_pct;
    config
}

#[test]
fn a_robot_at_the_station_charges_until_it_leaves() {
    let mut sim = in_a_room(&at_charge(50.0), pose(5.5, 5.0, 0.0));
    drive(&mut sim, 0.4, 0.0, 190);
    assert!(!sim.truth().is_docked(), "passing by");
    let readings = drive(&mut sim, 0.0, 0.0, 50 * 60);
    assert!(sim.truth().is_docked(), "{}", sim.truth().pose());
    let last = readings.iter().rev().find_map(|r| if let Reading::Battery(state) = r { Some(*state) } else { None });
    let last = last.expect("the battery reports");
    assert!(last.charging && last.charge_pct > 52.0, "{last:?}");
    drive(&mut sim, -0.4, 0.0, 10);
    assert!(!sim.truth().is_docked() && !sim.truth().battery().charging);
}

#[test]
fn driving_drains_while_current_flows() {
    let mut sim = in_a_room(&at_charge(50.0), pose(4.0, 3.0, 0.0));
    drive(&mut sim, 0.0, 0.5, 500);
    let after = sim.truth().battery().charge_pct;
    assert!((after - 49.5).abs() < 1e-9, "{after}");
    drive(&mut sim, 0.0, 0.0, 500);
    // From 0.5 rad/s, it brakes within 13 steps; the step in which the motors reach 0 consumes nothing.
    let rested = sim.truth().battery().charge_pct;
    assert!((after - rested - 12.0 * 0.001).abs() < 1e-9, "{rested}");
}

#[test]
fn a_faulty_battery_drains_faster_and_a_set_charge_is_read_next() {
    let mut sim = in_a_room(&at_charge(50.0), pose(4.0, 3.0, 0.0));
    sim.faults_mut().battery.drain_factor = 3.0;
    drive(&mut sim, 0.0, 0.5, 500);
    assert!((sim.truth().battery().charge_pct - 48.5).abs() < 1e-9);
    sim.set_battery_charge(10.0);
    let readings = drive(&mut sim, 0.0, 0.0, 5);
    let read =
        readings.iter().find_map(|r| if let Reading::Battery(state) = r { Some(state.charge_pct) } else { None });
    assert!(read.is_some_and(|charge_pct| (9.9..=10.0).contains(&charge_pct)), "{read:?}");
}
