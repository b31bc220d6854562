//! The traces of faults in the bits of a run: none where they do not act, and none once they are over.

use std::time::Duration;

use maps::{Pose, Shape, pose};
use proptest::prelude::*;
use robot::{Reading, Robot, Streams, VelocityCommand};
use sim::{
    BatteryReport, Faults, LaserFault, LaserTrouble, ObstacleConfig, ObstacleMotion, OdometryFaults, SimConfig,
    Simulation,
};

use crate::determinism::noisy;
use crate::room;

/// When a fault begins, in steps.
const ONSET: usize = 300;
const END: usize = 500;
/// Of a run.
const STEPS: usize = 800;

/// All outputs of a run.
#[derive(Default)]
struct Run {
    truth: Vec<(Pose, f64)>,
    readings: Vec<Reading>,
}

impl Run {
    /// The readings of one kind, from a step on.
    fn of(&self, kind: fn(&Reading) -> bool, from_step: usize) -> Vec<&Reading> {
        let from = Duration::from_millis(20) * u32::try_from(from_step).expect("few steps");
        self.readings.iter().filter(|reading| kind(reading) && reading.time() >= from).collect()
    }
}

fn is_scan(reading: &Reading) -> bool {
    matches!(reading, Reading::Scan(_))
}

fn is_front_scan(reading: &Reading) -> bool {
    matches!(reading, Reading::Scan(scan) if scan.laser == 0)
}

fn is_odometry(reading: &Reading) -> bool {
    matches!(reading, Reading::Odometry(_))
}

fn is_battery(reading: &Reading) -> bool {
    matches!(reading, Reading::Battery(_))
}

/// A noisy run in which the robot meets a person, pushes a box, and has these faults for a while.
fn run(faults: impl Fn(&mut Faults)) -> Run {
    let start = pose(1.0, 1.0, 0.3);
    let mut sim = Simulation::new(&noisy(), &room(8.0, 6.0), start, start, &Streams::new(1)).expect("a good start");
    let mut run = Run::default();
    for step in 0..STEPS {
        match step {
            ONSET => faults(sim.faults_mut()),
            END => *sim.faults_mut() = Faults::default(),
            _ => {}
        }
        sim.drive(VelocityCommand { linear_mps: 0.4, angular_radps: [0.0, 0.5, -0.8, 0.2][step / 100 % 4] });
        sim.step();
        run.truth.push((sim.truth().pose(), sim.truth().battery().charge_pct));
        sim.read(&mut run.readings);
    }
    run
}

fn laser_fault(laser: &str, trouble: LaserTrouble) -> LaserFault {
    LaserFault { laser: Some(laser.to_owned()), trouble }
}

#[test]
fn a_scanner_recovers_fully_from_its_troubles_and_affects_nothing_else() {
    let unfaulted = run(|_| {});
    for trouble in [
        LaserTrouble::Dead,
        LaserTrouble::Stuck,
        LaserTrouble::Dropout { probability: 0.5 },
        LaserTrouble::Noise { sigma_m: 0.1 },
        LaserTrouble::RangeLimit { max_m: 2.0 },
        LaserTrouble::Mount { x_m: 0.0, y_m: 0.1, yaw_rad: 0.1 },
        LaserTrouble::Ghost { distance_m: 0.5, bearing_rad: 0.0, width_rad: 1.0 },
    ] {
        let faulted = run(|faults| faults.lasers.push(laser_fault("back", trouble)));
        assert_eq!(faulted.truth, unfaulted.truth, "{trouble:?}");
        for others in [is_odometry, is_battery, is_front_scan] {
            assert_eq!(faulted.of(others, 0), unfaulted.of(others, 0), "{trouble:?}");
        }
        assert_ne!(faulted.of(is_scan, 0), unfaulted.of(is_scan, 0), "{trouble:?}");
        // The scan that is due in the last step of the fault still shows it.
        assert_eq!(faulted.of(is_scan, END + 1), unfaulted.of(is_scan, END + 1), "{trouble:?}");
    }
}

#[test]
fn a_battery_gauge_recovers_fully_and_affects_nothing_else() {
    let unfaulted = run(|_| {});
    for report in [
        BatteryReport { stuck: true, ..BatteryReport::default() },
        BatteryReport { offset_pct: -3.0, ..BatteryReport::default() },
        BatteryReport { sigma_pct: 3.0, ..BatteryReport::default() },
        BatteryReport { missing: true, ..BatteryReport::default() },
        BatteryReport { charging: Some(true), ..BatteryReport::default() },
    ] {
        let faulted = run(|faults| faults.battery.reported = report);
        assert_eq!(faulted.truth, unfaulted.truth, "{report:?}");
        for others in [is_odometry, is_scan] {
            assert_eq!(faulted.of(others, 0), unfaulted.of(others, 0), "{report:?}");
        }
        assert_ne!(faulted.of(is_battery, 0), unfaulted.of(is_battery, 0), "{report:?}");
        assert_eq!(faulted.of(is_battery, END + 1), unfaulted.of(is_battery, END + 1), "{report:?}");
    }
}

#[test]
fn encoders_continue_after_a_fault_and_affect_nothing_else() {
    /// Speeds do not depend on earlier counts.
    fn speeds(run: &Run, from_step: usize) -> Vec<(f64, f64)> {
        let speed = |reading: &&Reading| match reading {
            Reading::Odometry(odometry) => (odometry.linear_mps, odometry.angular_radps),
            _ => unreachable!("only odometry is looked at"),
        };
        run.of(is_odometry, from_step).iter().map(speed).collect()
    }
    let unfaulted = run(|_| {});
    for wrong in [
        OdometryFaults { distance_bias: 0.1, ..OdometryFaults::default() },
        OdometryFaults { angle_bias: 0.1, ..OdometryFaults::default() },
        OdometryFaults { angle_bias_rad_per_m: 0.1, ..OdometryFaults::default() },
        OdometryFaults { frozen: true, ..OdometryFaults::default() },
    ] {
        let faulted = run(|faults| faults.odometry = wrong);
        assert_eq!(faulted.truth, unfaulted.truth, "{wrong:?}");
        for others in [is_battery, is_scan] {
            assert_eq!(faulted.of(others, 0), unfaulted.of(others, 0), "{wrong:?}");
        }
        assert_ne!(speeds(&faulted, 0), speeds(&unfaulted, 0), "{wrong:?}");
        assert_eq!(speeds(&faulted, END + 1), speeds(&unfaulted, END + 1), "{wrong:?}");
    }
}

/// A pillar out of the robot's way.
fn pillar() -> ObstacleConfig {
    ObstacleConfig {
        name: "pillar".to_owned(),
        shape: Shape::Disc { radius_m: 0.2 },
        pose: pose(7.0, 0.5, 0.0),
        motion: ObstacleMotion::Fixed,
    }
}

#[test]
fn a_body_that_the_robot_does_not_touch_only_affects_scans() {
    let (unfaulted, faulted) = (run(|_| {}), run(|faults| faults.bodies.push(pillar())));
    assert_eq!(faulted.truth, unfaulted.truth);
    assert_ne!(faulted.of(is_scan, 0), unfaulted.of(is_scan, 0));
    assert_eq!(faulted.of(is_scan, END + 1), unfaulted.of(is_scan, END + 1));
}

/// Faults of every field, each alone.
fn one_of_each() -> Vec<Faults> {
    let set: [fn(&mut Faults); 20] = [
        |faults| faults.battery.drain_factor = 3.0,
        |faults| faults.battery.capacity_factor = 0.3,
        |faults| faults.battery.charger_factor = 0.3,
        |faults| faults.battery.reported.stuck = true,
        |faults| faults.battery.reported.sigma_pct = 3.0,
        |faults| faults.battery.reported.missing = true,
        |faults| faults.lasers.push(laser_fault("front", LaserTrouble::Noise { sigma_m: 0.2 })),
        |faults| faults.lasers.push(laser_fault("front", LaserTrouble::Dropout { probability: 0.2 })),
        |faults| faults.odometry.distance_bias = 0.2,
        |faults| faults.odometry.frozen = true,
        |faults| faults.base.velocity_override = Some(VelocityCommand::STOP),
        |faults| faults.base.slip = 0.4,
        |faults| faults.base.left_wheel_factor = 0.4,
        |faults| faults.base.right_wheel_factor = 0.4,
        |faults| faults.base.speed_limit_mps = Some(0.1),
        |faults| faults.base.emergency_stop = true,
        |faults| faults.base.command_delay = Duration::from_secs(1),
        |faults| faults.bodies.push(pillar()),
        |faults| faults.stuck_doors.push("door".to_owned()),
        |faults| faults.station = Some(pose(4.0, 4.0, 0.0)),
    ];
    let fault = |set: &fn(&mut Faults)| {
        let mut faults = Faults::default();
        set(&mut faults);
        faults
    };
    set.iter().map(fault).collect()
}

#[test]
fn a_fault_changes_nothing_before_it_begins() {
    let unfaulted = run(|_| {});
    let before = |run: &Run| run.readings.iter().filter(|r| r.time() <= Duration::from_secs(6)).cloned().collect();
    let expected: Vec<Reading> = before(&unfaulted);
    for faults in one_of_each() {
        let faulted = run(|place| place.clone_from(&faults));
        assert_eq!(faulted.truth[..ONSET], unfaulted.truth[..ONSET], "{faults:?}");
        assert_eq!(before(&faulted), expected, "{faults:?}");
    }
}

#[test]
fn the_same_faults_give_the_same_bits() {
    let all = |place: &mut Faults| {
        for faults in one_of_each() {
            place.lasers.extend(faults.lasers);
            place.bodies.extend(faults.bodies);
        }
        place.battery.reported.sigma_pct = 3.0;
        place.base.slip = 0.3;
    };
    let [first, second] = [run(all), run(all)];
    assert_eq!((first.truth, first.readings), (second.truth, second.readings));
}

/// Numbers of all kinds, most of them invalid.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        Just(f64::NAN),
        Just(f64::INFINITY),
        Just(f64::NEG_INFINITY),
        Just(0.0),
        Just(f64::MAX),
        Just(f64::MIN_POSITIVE),
        -5.0..5.0_f64
    ]
}

prop_compose! {
    fn nonsense()(
        battery in prop::array::uniform5(number()), laser in prop::array::uniform9(number()),
        odometry in prop::array::uniform3(number()), base in prop::array::uniform6(number()),
        body in prop::array::uniform5(number()), delay_ms in 0..1000_u64, radius_m in number()
    ) -> Faults {
        let mut faults = Faults::default();
        [faults.battery.drain_factor, faults.battery.capacity_factor, faults.battery.charger_factor,
         faults.battery.reported.offset_pct, faults.battery.reported.sigma_pct] = battery;
        let [probability, sigma_m, max_m, x_m, y_m, yaw_rad, distance_m, bearing_rad, width_rad] = laser;
        faults.lasers = [
            LaserTrouble::Dropout { probability }, LaserTrouble::Noise { sigma_m }, LaserTrouble::RangeLimit { max_m },
            LaserTrouble::Mount { x_m, y_m, yaw_rad }, LaserTrouble::Ghost { distance_m, bearing_rad, width_rad },
        ].map(|trouble| LaserFault { laser: None, trouble }).to_vec();
        [faults.odometry.distance_bias, faults.odometry.angle_bias, faults.odometry.angle_bias_rad_per_m] = odometry;
        let [linear_mps, angular_radps, slip, left, right, limit_mps] = base;
        faults.base.velocity_override = Some(VelocityCommand { linear_mps, angular_radps });
        (faults.base.slip, faults.base.speed_limit_mps) = (slip, Some(limit_mps));
        (faults.base.left_wheel_factor, faults.base.right_wheel_factor) = (left, right);
        faults.base.command_delay = Duration::from_millis(delay_ms);
        let [x_m, y_m, speed_mps, way_x_m, way_y_m] = body;
        let waypoints = vec![maps::Point::new(way_x_m, way_y_m)];
        let motion = ObstacleMotion::Route { waypoints, speed_mps, end: sim::RouteEnd::Loop };
        let shape = Shape::Disc { radius_m };
        faults.bodies.push(ObstacleConfig { name: "body".to_owned(), shape, pose: pose(x_m, y_m, 0.0), motion });
        faults.station = Some(pose(x_m, y_m, 0.0));
        faults
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn invalid_values_do_not_make_a_step_panic(faults in nonsense()) {
        let start = pose(2.0, 2.0, 0.0);
        let config = SimConfig::default();
        let mut sim = Simulation::new(&config, &room(8.0, 6.0), start, start, &Streams::new(1)).expect("a good start");
        *sim.faults_mut() = faults;
        crate::drive(&mut sim, 0.4, 0.1, 30);
        *sim.faults_mut() = Faults::default();
        crate::drive(&mut sim, 0.4, 0.1, 30);
        prop_assert_eq!(sim.truth().time(), Duration::from_millis(1200));
    }
}
