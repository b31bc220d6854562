//! Localizes your own scans: `cargo run --example localize_scans`.
//!
//! A robot starts somewhere in a room of which it has a map, and drives. [`Robot`] stands in for yours: it delivers
//! drifting odometry and scans. Everything below `main` could come from a driver or from a file instead.

use std::time::Duration;

use maps::{Cell, CellIndex, OccupancyGrid, Point, Pose, heading, pose, wrap_angle};
use nav::{InitialPose, Localization, LocalizationParameters};
use robot::{LaserScan, LaserSpec, Odometry, RobotModel, Streams};

#[expect(clippy::print_stdout, reason = "a program that is run manually")]
fn main() -> Result<(), nav::Error> {
    let map = map();
    let laser = LaserSpec {
        name: "front".to_owned(),
        mount: pose(0.1, 0.0, 0.0),
        angle_min_rad: -120_f64.to_radians(),
        angle_increment_rad: 2_f64.to_radians(),
        beams: 121,
        period: Duration::from_millis(100),
        range_min_m: 0.1,
        range_max_m: 8.0,
    };
    let start = pose(2.5, 0.9, 0.2);
    let mut robot = Robot { pose: start, odometry: pose(0.0, 0.0, 0.0), laser: laser.clone() };
    let model = RobotModel { lasers: vec![laser], ..RobotModel::default() };

    // Its pose is unknown. If you know it, use `InitialPose::at(…)`.
    let random = Streams::new(1).stream("localization");
    let mut localization =
        Localization::new(&map, &model, LocalizationParameters::default(), &InitialPose::Anywhere, random)?;

    println!("time    estimate              off by          doubt  hypotheses");
    for step in 0..=160 {
        let time = Duration::from_millis(100 * step);
        // Odometry first, then the scan with the same time: the scan is placed by the odometry around it.
        localization.odometry(&robot.odometry(time));
        localization.scan(&robot.scan(time, &map));
        if step % 20 == 0 {
            let estimate = localization.estimate().pose;
            let off = estimate.inv_mul(&robot.pose);
            println!(
                "{:4.1} s  {:5.2} m {:5.2} m {:4.0}°  {:5.2} m {:5.1}°  {:5.2}  {}",
                time.as_secs_f64(),
                estimate.translation.x,
                estimate.translation.y,
                heading(&estimate).to_degrees(),
                off.translation.vector.norm(),
                heading(&off).to_degrees().abs(),
                localization.doubt(),
                localization.hypotheses().len(),
            );
        }
        robot.drive(0.1);
    }
    let drift_rad = wrap_angle(heading(&(start * robot.odometry)) - heading(&robot.pose));
    println!("by then odometry alone has drifted by {:.0}°", drift_rad.to_degrees());
    Ok(())
}

/// A room of 8 m × 5 m with a cupboard, a protruding wall and a pillar. `maps::load_map` loads your own maps, in the
/// format of ROS.
fn map() -> OccupancyGrid {
    let mut map = OccupancyGrid::new(160, 100, 0.05, pose(0.0, 0.0, 0.0));
    let mut fill = |(left, bottom): (usize, usize), (right, top): (usize, usize), cell| {
        for (column, row) in (bottom..top).flat_map(|row| (left..right).map(move |column| (column, row))) {
            map.set(CellIndex { column, row }, cell);
        }
    };
    fill((0, 0), (160, 100), Cell::Occupied);
    fill((2, 2), (158, 98), Cell::Free);
    fill((2, 80), (40, 98), Cell::Occupied);
    fill((100, 2), (104, 40), Cell::Occupied);
    fill((86, 60), (94, 68), Cell::Occupied);
    map
}

/// In your program, this is a real robot.
struct Robot {
    /// Its true pose.
    pose: Pose,
    /// Its pose according to its wheels.
    odometry: Pose,
    laser: LaserSpec,
}

impl Robot {
    /// Drives in a wide circle. Its odometry overestimates distances by 2 % and turns by 8 %.
    fn drive(&mut self, seconds: f64) {
        let (way_m, turn_rad) = (0.4 * seconds, 0.3 * seconds);
        self.pose *= pose(way_m, 0.0, turn_rad);
        self.odometry *= pose(1.02 * way_m, 0.0, 1.08 * turn_rad);
    }

    fn odometry(&self, time: Duration) -> Odometry {
        Odometry { time, pose: self.odometry, linear_mps: 0.4, angular_radps: 0.3 }
    }

    /// Follows each beam until it hits something.
    fn scan(&self, time: Duration, map: &OccupancyGrid) -> LaserScan {
        let range = |beam| {
            let ray = self.pose * self.laser.mount * pose(0.0, 0.0, self.laser.beam_angle_rad(beam));
            let hits = |range_m: &f64| {
                let met = map.index_of(&(ray * Point::new(*range_m, 0.0)));
                met.and_then(|index| map.cell(index)) != Some(Cell::Free)
            };
            let ranges =
                (0..).map(|step| 0.01 * f64::from(step)).take_while(|range_m| *range_m < self.laser.range_max_m);
            ranges.into_iter().find(hits).map_or(f32::INFINITY, |range_m| range_m as f32)
        };
        LaserScan { time, laser: 0, ranges_m: (0..self.laser.beams).map(range).collect() }
    }
}
