//! Faults of motors and wheels.

use std::time::Duration;

use maps::{Shape, heading, pose};
use proptest::prelude::*;
use robot::VelocityCommand;
use sim::{ObstacleConfig, ObstacleMotion, SimConfig, Simulation};

use crate::{drive, in_a_room};

fn at_the_left() -> Simulation {
    in_a_room(&SimConfig::default(), pose(2.0, 3.0, 0.0))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(20))]

    #[test]
    fn slip_moves_the_robot_less_than_the_encoders_count(slip in 0.0..1.0_f64, angular_radps in -0.5..0.5_f64) {
        let mut sim = at_the_left();
        sim.faults_mut().base.slip = slip;
        drive(&mut sim, 0.4, angular_radps, 100);
        let (truth, odometry) = (sim.truth(), sim.truth().odometry());
        prop_assert!((truth.linear_mps() - (1.0 - slip) * odometry.linear_mps).abs() < 1e-12);
        prop_assert!((truth.angular_radps() - (1.0 - slip) * odometry.angular_radps).abs() < 1e-12);
        prop_assert!((odometry.linear_mps - 0.4).abs() < 1e-12, "the motors keep their speed");
    }

    #[test]
    fn encoders_measure_the_actual_motion_of_a_weak_wheel(left in 0.0..1.0_f64, right in 0.0..1.0_f64) {
        let mut sim = at_the_left();
        (sim.faults_mut().base.left_wheel_factor, sim.faults_mut().base.right_wheel_factor) = (left, right);
        drive(&mut sim, 0.4, 0.0, 100);
        let off = (pose(2.0, 3.0, 0.0) * sim.truth().odometry().pose).inv_mul(&sim.truth().pose());
        prop_assert!(off.translation.vector.norm() < 1e-9, "{}", off);
        prop_assert!((sim.truth().linear_mps() - 0.2 * (left + right)).abs() < 1e-12);
        prop_assert!((sim.truth().angular_radps() - (right - left)).abs() < 1e-12);
    }
}

#[test]
fn fully_slipping_wheels_spin_in_place() {
    let mut sim = at_the_left();
    sim.faults_mut().base.slip = 1.0;
    drive(&mut sim, 0.4, 0.0, 200);
    assert_eq!(sim.truth().pose(), pose(2.0, 3.0, 0.0));
    assert!(sim.truth().odometry().pose.translation.x > 1.0);
    assert!(sim.truth().battery().charge_pct < 99.9, "spinning costs as much as driving");
    assert_eq!(sim.truth().distance_m(), 0.0);
}

#[test]
fn slipping_wheels_continue_to_count_at_a_wall() {
    let pillar = ObstacleConfig {
        name: "pillar".to_owned(),
        shape: Shape::Disc { radius_m: 0.2 },
        pose: pose(2.6, 3.0, 0.0),
        motion: ObstacleMotion::Fixed,
    };
    let mut sim = in_a_room(&SimConfig { obstacles: vec![pillar], ..SimConfig::default() }, pose(2.0, 3.0, 0.0));
    sim.faults_mut().base.slip = 0.5;
    drive(&mut sim, 0.4, 0.0, 500);
    let (really_m, measured_m) = (sim.truth().pose().translation.x - 2.0, sim.truth().odometry().pose.translation.x);
    assert!((really_m - 0.1).abs() < 0.01, "{really_m}");
    assert!(measured_m > 2.0 * really_m + 0.01, "{measured_m} for {really_m}");
}

#[test]
fn a_weak_left_wheel_pulls_to_the_left() {
    let mut sim = at_the_left();
    sim.faults_mut().base.left_wheel_factor = 0.8;
    drive(&mut sim, 0.4, 0.0, 100);
    assert!(heading(&sim.truth().pose()) > 0.1 && sim.truth().pose().translation.y > 3.0);
    let turned_rad = heading(&sim.truth().pose());
    sim.faults_mut().base.left_wheel_factor = 1.0;
    drive(&mut sim, 0.4, 0.0, 50);
    assert!((heading(&sim.truth().pose()) - turned_rad).abs() < 1e-9, "straight on with good wheels");
}

#[test]
fn a_speed_limit_slows_the_robot_until_it_is_removed() {
    let mut sim = at_the_left();
    drive(&mut sim, 0.4, 0.0, 100);
    sim.faults_mut().base.speed_limit_mps = Some(0.1);
    drive(&mut sim, 0.4, 0.0, 10);
    assert!((sim.truth().linear_mps() - 0.3).abs() < 1e-9, "it brakes as fast as it can");
    drive(&mut sim, 0.4, 0.3, 50);
    assert!((sim.truth().linear_mps() - 0.1).abs() < 1e-12 && (sim.truth().angular_radps() - 0.3).abs() < 1e-12);
    sim.faults_mut().base.velocity_override = Some(VelocityCommand { linear_mps: -0.4, angular_radps: 0.0 });
    drive(&mut sim, 0.0, 0.0, 50);
    assert!((sim.truth().linear_mps() + 0.1).abs() < 1e-12, "the joypad is limited too");
    *sim.faults_mut() = sim::Faults::default();
    drive(&mut sim, 0.4, 0.0, 100);
    assert!((sim.truth().linear_mps() - 0.4).abs() < 1e-12);
}

#[test]
fn an_emergency_stop_stops_at_once_despite_the_joypad() {
    let mut sim = at_the_left();
    drive(&mut sim, 0.4, 0.3, 100);
    let (at, charge_pct) = (sim.truth().pose(), sim.truth().battery().charge_pct);
    sim.faults_mut().base.emergency_stop = true;
    sim.faults_mut().base.velocity_override = Some(VelocityCommand { linear_mps: 0.4, angular_radps: 0.0 });
    drive(&mut sim, 0.4, 0.3, 1);
    assert_eq!((sim.truth().pose(), sim.truth().linear_mps()), (at, 0.0));
    drive(&mut sim, 0.4, 0.3, 500);
    assert_eq!((sim.truth().pose(), sim.truth().battery().charge_pct), (at, charge_pct));
    sim.faults_mut().base.emergency_stop = false;
    drive(&mut sim, 0.4, 0.3, 1);
    assert!((sim.truth().linear_mps() - 0.01).abs() < 1e-12, "it starts from rest");
}

#[test]
fn delayed_commands_take_effect_late_and_in_order() {
    /// Forward speeds after each step of a drive that starts and stops again.
    fn speeds(command_delay: Duration) -> Vec<f64> {
        let mut sim = at_the_left();
        sim.faults_mut().base.command_delay = command_delay;
        let mut speed = |step: usize| {
            drive(&mut sim, if (10..60).contains(&step) { 0.4 } else { 0.0 }, 0.0, 1);
            sim.truth().linear_mps()
        };
        (0..150).map(&mut speed).collect()
    }
    let (prompt, late) = (speeds(Duration::ZERO), speeds(Duration::from_millis(500)));
    assert!(prompt[10] > 0.0 && late[..35].iter().all(|speed| *speed == 0.0));
    assert_eq!(late[25..], prompt[..125]);
}

#[test]
fn an_empty_battery_also_stops_the_joypad() {
    let mut sim = at_the_left();
    sim.set_battery_charge(0.0);
    sim.faults_mut().base.velocity_override = Some(VelocityCommand { linear_mps: 0.4, angular_radps: 0.0 });
    drive(&mut sim, 0.0, 0.0, 50);
    assert_eq!(sim.truth().pose(), pose(2.0, 3.0, 0.0));
}
