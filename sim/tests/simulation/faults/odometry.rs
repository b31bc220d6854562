//! Faults of the wheels' encoders.

use maps::{heading, pose, wrap_angle};
use proptest::prelude::*;
use robot::{Odometry, Reading};
use sim::{SimConfig, Simulation};

use crate::{drive, in_a_room};

fn odometry_of(readings: &[Reading]) -> Vec<Odometry> {
    readings.iter().filter_map(|r| if let Reading::Odometry(odometry) = r { Some(*odometry) } else { None }).collect()
}

/// How far the robot and its odometry have moved and turned since the start at (2, 3) along x.
fn really_and_measured(sim: &Simulation) -> [(f64, f64); 2] {
    let (truth, odometry) = (pose(2.0, 3.0, 0.0).inv_mul(&sim.truth().pose()), sim.truth().odometry().pose);
    [truth, odometry].map(|pose| (pose.translation.vector.norm(), heading(&pose)))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(20))]

    #[test]
    fn a_distance_bias_affects_the_distance(distance_bias in -0.5..0.5_f64, built_in in -0.2..0.2_f64) {
        let mut config = SimConfig::default();
        config.odometry.distance_bias = built_in;
        let mut sim = in_a_room(&config, pose(2.0, 3.0, 0.0));
        sim.faults_mut().odometry.distance_bias = distance_bias;
        drive(&mut sim, 0.4, 0.0, 200);
        let [(really_m, _), (measured_m, measured_rad)] = really_and_measured(&sim);
        prop_assert!((measured_m - really_m * (1.0 + distance_bias + built_in)).abs() < 1e-9);
        prop_assert_eq!(measured_rad, 0.0);
    }

    #[test]
    fn angle_biases_affect_turns_and_straight_lines(bias in -0.5..0.5_f64) {
        let mut sim = in_a_room(&SimConfig::default(), pose(2.0, 3.0, 0.0));
        sim.faults_mut().odometry.angle_bias = bias;
        drive(&mut sim, 0.0, 0.5, 100);
        let [(_, really_rad), (_, measured_rad)] = really_and_measured(&sim);
        prop_assert!(wrap_angle(measured_rad - really_rad * (1.0 + bias)).abs() < 1e-9);

        let mut sim = in_a_room(&SimConfig::default(), pose(2.0, 3.0, 0.0));
        sim.faults_mut().odometry.angle_bias_rad_per_m = bias;
        drive(&mut sim, 0.4, 0.0, 200);
        let [(really_m, _), (_, measured_rad)] = really_and_measured(&sim);
        prop_assert!(wrap_angle(measured_rad - really_m * bias).abs() < 1e-9);
    }
}

#[test]
fn frozen_encoders_report_standstill_and_continue_from_there() {
    let mut sim = in_a_room(&SimConfig::default(), pose(2.0, 3.0, 0.0));
    drive(&mut sim, 0.4, 0.0, 100);
    let (before, at) = (sim.truth().odometry(), sim.truth().pose());
    sim.faults_mut().odometry.frozen = true;
    let frozen = odometry_of(&drive(&mut sim, 0.4, 0.0, 100));
    assert!(frozen.iter().all(|odometry| odometry.pose == before.pose && odometry.linear_mps == 0.0));
    assert!(frozen.is_sorted_by(|a, b| a.time < b.time) && frozen.len() == 100);
    let lost_m = (sim.truth().pose().translation.vector - at.translation.vector).norm();
    assert!((lost_m - 0.8).abs() < 1e-9, "{lost_m}");
    sim.faults_mut().odometry.frozen = false;
    drive(&mut sim, 0.4, 0.0, 100);
    let [(really_m, _), (measured_m, _)] = really_and_measured(&sim);
    assert!((really_m - measured_m - lost_m).abs() < 1e-9, "{really_m} {measured_m}");
}
