//! The same bits every time, and independent noise.

use maps::{Point, Shape, pose};
use robot::{Reading, Robot, Streams, VelocityCommand};
use sim::{DriftNoise, ObstacleConfig, ObstacleMotion, RouteEnd, SimConfig, Simulation};

use crate::room;

/// FNV-1a over all data of a run's trace.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
struct Hash(u64);

impl Hash {
    fn add(&mut self, bits: u64) {
        for byte in bits.to_le_bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }

    fn add_pose(&mut self, pose: &maps::Pose) {
        [pose.translation.x, pose.translation.y, pose.rotation.re, pose.rotation.im]
            .iter()
            .for_each(|value| self.add(value.to_bits()));
    }
}

/// Hashes of the true poses, of the odometry and of the scans of a run with turns, walls, a box and a person.
fn run(config: &SimConfig, seed: u64, intervene: impl Fn(usize, &mut Simulation)) -> [Hash; 3] {
    let start = pose(1.0, 1.0, 0.3);
    let mut sim = Simulation::new(config, &room(8.0, 6.0), start, start, &Streams::new(seed)).expect("a good start");
    let mut hashes = [Hash(0xcbf2_9ce4_8422_2325); 3];
    let mut readings = Vec::new();
    for step in 0..3000 {
        let angular_radps = [0.0, 0.5, -0.8, 0.2][step / 100 % 4];
        sim.drive(VelocityCommand { linear_mps: 0.4, angular_radps });
        intervene(step, &mut sim);
        sim.step();
        hashes[0].add_pose(&sim.truth().pose());
        sim.read(&mut readings);
        for reading in readings.drain(..) {
            match reading {
                Reading::Odometry(odometry) => hashes[1].add_pose(&odometry.pose),
                Reading::Scan(scan) => scan.ranges_m.iter().for_each(|range| hashes[2].add(range.to_bits().into())),
                Reading::Battery(state) => hashes[0].add(state.charge_pct.to_bits()),
            }
        }
    }
    assert!(sim.truth().collisions() > 0, "the run is meant to touch things");
    hashes
}

fn busy() -> SimConfig {
    let person = ObstacleConfig {
        name: "person".to_owned(),
        shape: Shape::Disc { radius_m: 0.25 },
        pose: pose(6.0, 1.0, 0.0),
        motion: ObstacleMotion::Route {
            waypoints: vec![Point::new(6.0, 5.0), Point::new(2.0, 5.0)],
            speed_mps: 0.7,
            end: RouteEnd::BackAndForth,
        },
    };
    let movable = ObstacleConfig {
        name: "box".to_owned(),
        shape: Shape::Box { length_m: 0.5, width_m: 0.3 },
        pose: pose(2.6, 1.8, 0.4),
        motion: ObstacleMotion::Movable { mass_kg: 4.0 },
    };
    SimConfig { obstacles: vec![person, movable], ..SimConfig::default() }
}

pub(crate) fn noisy() -> SimConfig {
    let noise = DriftNoise {
        angle_per_sqrt_rad: 0.05,
        angle_per_sqrt_m: 0.03,
        distance_per_sqrt_m: 0.02,
        distance_per_sqrt_rad: 0.01,
    };
    let mut config = busy();
    config.drive.noise = noise;
    config.odometry.noise = noise;
    config.lasers.range_sigma_m = 0.01;
    config
}

#[test]
fn the_same_seed_gives_the_same_bits() {
    let runs = [run(&noisy(), 1, |_, _| {}), run(&noisy(), 1, |_, _| {}), run(&noisy(), 2, |_, _| {})];
    assert_eq!(runs[0], runs[1]);
    assert!((0..3).all(|n| runs[0][n] != runs[2][n]));
}

/// The numbers change when the simulation changes, but never between debug and release, or with `GLIBC_TUNABLES` that
/// disable FMA.
#[test]
fn the_bits_are_the_same_in_every_build() {
    let [truth, odometry, scans] = run(&noisy(), 1, |_, _| {});
    let expected = [9_094_498_526_689_973_048, 17_704_104_868_612_553_165, 13_621_153_423_780_037_378].map(Hash);
    assert_eq!([truth, odometry, scans], expected);
}

#[test]
fn noises_are_independent_of_each_other() {
    let [truth, odometry, scans] = run(&busy(), 1, |_, _| {});
    let mut config = busy();
    config.odometry.noise = noisy().odometry.noise;
    let with_odometry_noise = run(&config, 1, |_, _| {});
    assert_eq!([with_odometry_noise[0], with_odometry_noise[2]], [truth, scans]);
    assert_ne!(with_odometry_noise[1], odometry);
    let mut config = busy();
    config.lasers.range_sigma_m = 0.01;
    let with_laser_noise = run(&config, 1, |_, _| {});
    assert_eq!([with_laser_noise[0], with_laser_noise[1]], [truth, odometry]);
    assert_ne!(with_laser_noise[2], scans);
}

#[test]
fn without_noise_the_seed_does_not_matter() {
    assert_eq!(run(&busy(), 1, |_, _| {}), run(&busy(), 2, |_, _| {}));
}

#[test]
fn faults_that_are_reset_before_they_act_leave_no_trace() {
    let unfaulted = run(&noisy(), 1, |_, _| {});
    let taken_back = run(&noisy(), 1, |step, sim| {
        if step == 1000 {
            sim.faults_mut().battery.drain_factor = 7.0;
            sim.faults_mut().base.velocity_override = Some(VelocityCommand::STOP);
            *sim.faults_mut() = sim::Faults::default();
        }
    });
    assert_eq!(unfaulted, taken_back);
}

#[test]
fn a_lasers_noise_does_not_depend_on_the_other_lasers() {
    let front = |config: &SimConfig| {
        let start = pose(1.0, 1.0, 0.3);
        let mut sim = Simulation::new(config, &room(8.0, 6.0), start, start, &Streams::new(1)).expect("a good start");
        let readings = crate::drive(&mut sim, 0.2, 0.0, 100);
        crate::scans(&readings).filter(|scan| scan.laser == 0).cloned().collect::<Vec<_>>()
    };
    let both = noisy();
    let mut alone = noisy();
    alone.model.lasers.truncate(1);
    assert_eq!(front(&both), front(&alone));
}

#[test]
fn runs_can_move_to_other_threads() {
    fn is_send<T: Send>() {}
    is_send::<Simulation>();
}
