//! A localization update while tracking and while lost, on an office floor.

#[path = "../tests/drives/floor.rs"]
#[expect(dead_code, reason = "shared with the tests")]
mod floor;
#[path = "../tests/drives/unicycle.rs"]
#[expect(dead_code, reason = "shared with the tests")]
mod unicycle;

use std::sync::Arc;

use divan::{AllocProfiler, Bencher};
use maps::pose;
use nav::{Atlas, InitialPose, Localization, LocalizationParameters};
use robot::{LaserScan, Streams, VelocityCommand};
use unicycle::{Noise, Unicycle};

/// Counts allocations as well: an update makes none.
#[global_allocator]
static ALLOCATOR: AllocProfiler = AllocProfiler::system();

fn main() {
    divan::main();
}

/// A robot in the corridor with the scans that it sees, and a localization that updates with every scan.
fn set_up(initial: &InitialPose, parameters: LocalizationParameters) -> (Localization, Unicycle, Vec<LaserScan>) {
    let mut robot = Unicycle::new(floor::office(), pose(13.9, 9.3, 0.3), Noise { laser_m: 0.01, ..Noise::default() });
    let rng = Streams::new(1).stream("localization");
    let mut localization =
        Localization::new(&robot.world, &robot.model, parameters, initial, rng).expect("the parameters are valid");
    localization.odometry(&robot.odometry());
    let scans = robot.scans();
    (localization, robot, scans)
}

/// Drives back and forth for 0.1 s each; each drive ends in an update with 120 beams.
fn drive_and_update(localization: &mut Localization, robot: &mut Unicycle, scans: &mut [LaserScan]) {
    for linear_mps in [0.45, -0.45] {
        for _ in 0..5 {
            robot.step(VelocityCommand { linear_mps, angular_radps: 0.0 });
        }
        localization.odometry(&robot.odometry());
        for scan in &mut *scans {
            scan.time = robot.time;
            localization.scan(scan);
        }
    }
}

/// Two updates with this many particles and 120 beams, including everything around them.
#[divan::bench(args = [500, 1000, 2000])]
fn two_updates(bencher: Bencher, particles: usize) {
    let parameters =
        LocalizationParameters { min_particles: particles, update_min_d: 0.0, ..LocalizationParameters::default() };
    let (mut localization, mut robot, mut scans) = set_up(&InitialPose::at(pose(13.9, 9.3, 0.3)), parameters);
    let before = localization.updates();
    drive_and_update(&mut localization, &mut robot, &mut scans);
    assert_eq!(localization.updates(), before + 2);
    bencher.bench_local(|| drive_and_update(&mut localization, &mut robot, &mut scans));
}

/// The first update of a global localization: poses are drawn anywhere, and the best are matched to the scan.
#[divan::bench]
fn first_update_anywhere(bencher: Bencher) {
    let (localization, robot, scans) = set_up(&InitialPose::Anywhere, LocalizationParameters::default());
    drop(robot);
    bencher.with_inputs(|| localization.clone()).bench_local_values(|mut localization| {
        localization.scan(&scans[0]);
        localization
    });
}

/// A scan while the robot stands still.
#[divan::bench]
fn scan_at_rest(bencher: Bencher) {
    let initial = InitialPose::at(pose(13.9, 9.3, 0.3));
    let (mut localization, _robot, scans) = set_up(&initial, LocalizationParameters::default());
    bencher.bench_local(|| localization.scan(&scans[0]));
}

/// Creating a localization on a prepared map.
#[divan::bench]
fn start_on_an_atlas(bencher: Bencher) {
    let model = robot::RobotModel::default();
    let atlas = Atlas::new(Arc::new(floor::office()), &model, LocalizationParameters::default());
    let atlas = Arc::new(atlas.expect("the parameters are valid"));
    let initial = InitialPose::at(pose(13.9, 9.3, 0.3));
    bencher.bench_local(|| Localization::on(&atlas, &initial, Streams::new(1).stream("localization")));
}

/// Building the fields of the map.
#[divan::bench(sample_count = 20)]
fn start(bencher: Bencher) {
    bencher.bench_local(|| set_up(&InitialPose::at(pose(13.9, 9.3, 0.3)), LocalizationParameters::default()));
}
