//! Faults of the laser scanners.

use maps::pose;
use robot::LaserScan;
use sim::{LaserFault, LaserTrouble, SimConfig, Simulation};

use crate::{drive, in_a_room, scans};

/// A robot in the middle of the room whose scanners have these troubles.
fn troubled(faults: &[(Option<&str>, LaserTrouble)]) -> Simulation {
    let mut sim = in_a_room(&SimConfig::default(), pose(4.0, 3.0, 0.0));
    let fault = |(laser, trouble): &(Option<&str>, LaserTrouble)| LaserFault {
        laser: laser.map(str::to_owned),
        trouble: *trouble,
    };
    sim.faults_mut().lasers = faults.iter().map(fault).collect();
    let mut readings = Vec::new();
    robot::Robot::read(&mut sim, &mut readings);
    sim
}

/// The scans of one scanner while the robot stands for this many steps.
fn scans_of(sim: &mut Simulation, laser: usize, steps: usize) -> Vec<LaserScan> {
    scans(&drive(sim, 0.0, 0.0, steps)).filter(|scan| scan.laser == laser).cloned().collect()
}

/// A scan of the front scanner with this trouble, and one without.
fn with_and_without(trouble: LaserTrouble) -> [Vec<f32>; 2] {
    [vec![(None, trouble)], Vec::new()].map(|faults| scans_of(&mut troubled(&faults), 0, 5).remove(0).ranges_m)
}

#[test]
fn one_of_two_scanners_dies_and_recovers() {
    let mut sim = troubled(&[(Some("back"), LaserTrouble::Dead)]);
    let readings = drive(&mut sim, 0.0, 0.0, 50);
    assert_eq!(scans(&readings).map(|scan| scan.laser).collect::<Vec<_>>(), [0; 10]);
    assert_eq!(sim.truth().scans().map(|scan| scan.laser).collect::<Vec<_>>(), [0], "a dead scanner has no scan");
    sim.faults_mut().lasers.clear();
    assert_eq!(scans_of(&mut sim, 1, 50).len(), 10);
    sim.faults_mut().lasers.push(LaserFault { laser: None, trouble: LaserTrouble::Dead });
    assert_eq!(scans(&drive(&mut sim, 0.0, 0.0, 50)).count(), 0);
}

#[test]
fn a_stuck_scanner_repeats_its_last_scan_with_new_times() {
    let mut sim = troubled(&[]);
    drive(&mut sim, 0.4, 0.0, 100);
    let before = sim.truth().scans().next().expect("a scan").ranges_m.clone();
    sim.faults_mut().lasers.push(LaserFault { laser: Some("front".to_owned()), trouble: LaserTrouble::Stuck });
    let readings = drive(&mut sim, 0.4, 0.0, 100);
    let (front, back): (Vec<_>, Vec<_>) = scans(&readings).partition(|scan| scan.laser == 0);
    assert!(front.iter().all(|scan| scan.ranges_m == before));
    assert!(front.is_sorted_by(|a, b| a.time < b.time) && front.len() == 20);
    assert!(
        back.iter().is_sorted_by(|a, b| a.ranges_m[180] < b.ranges_m[180]),
        "the other scanner sees the wall recede"
    );
    sim.faults_mut().lasers.clear();
    assert!(scans_of(&mut sim, 0, 5)[0].ranges_m[180] < before[180] - 0.5);
}

#[test]
fn some_beams_drop_out_and_the_others_are_unchanged() {
    let mut sim = troubled(&[(None, LaserTrouble::Dropout { probability: 0.3 })]);
    let [_, whole] = with_and_without(LaserTrouble::Stuck);
    let scans = scans_of(&mut sim, 0, 500);
    let lost = |scan: &LaserScan| scan.ranges_m.iter().filter(|range_m| **range_m == f32::INFINITY).count();
    let share = scans.iter().map(lost).sum::<usize>() as f64 / (scans.len() * 360) as f64;
    assert!((share - 0.3).abs() < 0.01, "{share}");
    assert!(scans.iter().all(|scan| scan.ranges_m.iter().zip(&whole).all(|(a, b)| a == b || a.is_infinite())));
    assert_ne!(scans[0].ranges_m, scans[1].ranges_m, "other beams in every scan");
}

#[test]
fn noise_has_the_requested_spread() {
    let mut sim = troubled(&[(Some("front"), LaserTrouble::Noise { sigma_m: 0.05 })]);
    let [_, exact] = with_and_without(LaserTrouble::Stuck);
    let scans = scans_of(&mut sim, 0, 500);
    let errors = scans.iter().flat_map(|scan| scan.ranges_m.iter().zip(&exact).map(|(a, b)| f64::from(a - b)));
    let sigma_m = (errors.map(|error_m| error_m * error_m).sum::<f64>() / (scans.len() * 360) as f64).sqrt();
    assert!((sigma_m - 0.05).abs() < 1e-3, "{sigma_m}");
}

#[test]
fn nothing_beyond_a_range_limit_is_seen() {
    let [limited, whole] = with_and_without(LaserTrouble::RangeLimit { max_m: 3.5 });
    for (limited, whole) in limited.iter().zip(&whole) {
        assert_eq!(*limited, if *whole > 3.5 { f32::INFINITY } else { *whole });
    }
    assert!(limited.iter().any(|range_m| range_m.is_infinite()) && limited.iter().any(|range_m| range_m.is_finite()));
}

#[test]
fn a_displaced_scanner_sees_from_its_true_mount() {
    let trouble = LaserTrouble::Mount { x_m: 0.05, y_m: -0.1, yaw_rad: 0.3 };
    let mut sim = troubled(&[(Some("back"), trouble)]);
    let displaced = scans_of(&mut sim, 1, 5).remove(0).ranges_m;
    // The back scanner faces backward, so its left is the robot's right.
    let mut config = SimConfig::default();
    let (x_m, y_m, heading_rad) = (-0.245 - 0.05, 0.1, std::f64::consts::PI + 0.3);
    config.model.lasers[1].mount = pose(x_m, y_m, heading_rad);
    let mut built_so = in_a_room(&config, pose(4.0, 3.0, 0.0));
    let expected = scans_of(&mut built_so, 1, 5).remove(0).ranges_m;
    assert!(displaced.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-5), "{displaced:?} {expected:?}");
    sim.faults_mut().lasers.clear();
    assert_eq!(scans_of(&mut sim, 1, 5), scans_of(&mut troubled(&[]), 1, 10)[1..]);
}

#[test]
fn a_ghost_is_fixed_to_the_scanner() {
    let [haunted, whole] = with_and_without(LaserTrouble::Ghost { distance_m: 1.5, bearing_rad: 0.0, width_rad: 0.2 });
    let changed: Vec<usize> = (0..360).filter(|beam| haunted[*beam] != whole[*beam]).collect();
    assert!(changed.iter().all(|beam| haunted[*beam] == 1.5));
    assert_eq!((changed[0], changed[changed.len() - 1]), (172, 187), "0.1 rad each way at 0.01313 rad per beam");
    let [behind_the_wall, whole] =
        with_and_without(LaserTrouble::Ghost { distance_m: 9.0, bearing_rad: 0.0, width_rad: 6.0 });
    assert_eq!(behind_the_wall, whole);
}
