//! Simulates a robot that your own code drives: `cargo run --example own_driver`.
//!
//! A robot wanders through a room with a box, a table leg and a person who walks up and down. [`decide`] determines its
//! actions from the robot's sensor readings alone.

use std::error::Error;

use maps::{Cell, CellIndex, OccupancyGrid, Point, Pose, Shape, pose};
use robot::{LaserScan, Reading, Robot, RobotModel, Streams, VelocityCommand};
use sim::{LaserConfig, ObstacleConfig, ObstacleMotion, OdometryConfig, RouteEnd, SimConfig, Simulation};

/// Drives on while there is room ahead, and otherwise turns left.
fn decide(scan: &LaserScan, model: &RobotModel) -> VelocityCommand {
    let laser = &model.lasers[scan.laser];
    let is_ahead = |beam: usize| laser.beam_angle_rad(beam).to_degrees().abs() < 45.0;
    let ahead = scan.ranges_m.iter().enumerate().filter(|(beam, _)| is_ahead(*beam)).map(|(_, range_m)| *range_m);
    if ahead.fold(f32::INFINITY, f32::min) > 0.7 {
        VelocityCommand { linear_mps: 0.4, angular_radps: 0.0 }
    } else {
        VelocityCommand { linear_mps: 0.0, angular_radps: 0.8 }
    }
}

#[expect(clippy::print_stdout, reason = "a program that is run manually")]
fn main() -> Result<(), Box<dyn Error>> {
    // Every setting has a default, and noise is off by default.
    let thing = |name: &str, shape, at, motion| ObstacleConfig { name: name.to_owned(), shape, pose: at, motion };
    let walk =
        ObstacleMotion::Route { waypoints: vec![Point::new(4.5, 3.2)], speed_mps: 0.5, end: RouteEnd::BackAndForth };
    let config = SimConfig {
        odometry: OdometryConfig { angle_bias: 0.02, ..OdometryConfig::default() },
        lasers: LaserConfig { range_sigma_m: 0.01 },
        obstacles: vec![
            thing("box", Shape::Box { length_m: 0.6, width_m: 0.4 }, pose(3.0, 1.2, 0.3), ObstacleMotion::Fixed),
            thing("leg", Shape::Disc { radius_m: 0.05 }, pose(2.0, 3.0, 0.0), ObstacleMotion::Fixed),
            thing("somebody", Shape::Disc { radius_m: 0.25 }, pose(4.5, 0.8, 0.0), walk),
        ],
        ..SimConfig::default()
    };
    let no_station: Option<Pose> = None;
    // The same seed gives the same run, bit for bit, on every machine of a target.
    let mut sim = Simulation::new(&config, &room(), pose(1.0, 1.0, 0.5), no_station, &Streams::new(1))?;

    let model = sim.model().clone();
    let mut readings = Vec::new();
    println!("time    really at        by odometry      charge  contacts");
    let mut odometry = pose(0.0, 0.0, 0.0);
    for step in 1..=3000_u32 {
        sim.step();
        sim.read(&mut readings);
        for reading in readings.drain(..) {
            match reading {
                Reading::Scan(scan) if scan.laser == 0 => sim.drive(decide(&scan, &model)),
                Reading::Odometry(reading) => odometry = reading.pose,
                Reading::Scan(_) | Reading::Battery(_) => {}
            }
        }
        if step % 500 == 0 {
            // For you, never for the robot.
            let truth = sim.truth();
            let [really, believed] = [truth.pose(), pose(1.0, 1.0, 0.5) * odometry].map(|pose| pose.translation);
            println!(
                "{:4.1} s  {:5.2} m {:5.2} m  {:5.2} m {:5.2} m  {:4.1} %  {}",
                sim.time().as_secs_f64(),
                really.x,
                really.y,
                believed.x,
                believed.y,
                truth.battery().charge_pct,
                truth.collisions(),
            );
        }
    }
    println!("{:.1} m driven", sim.truth().distance_m());
    Ok(())
}

/// A room of 6 m × 4 m. `maps::load_map` loads your own maps, in the format of ROS.
fn room() -> OccupancyGrid {
    let (columns, rows) = (120, 80);
    let mut room = OccupancyGrid::new(columns, rows, 0.05, pose(0.0, 0.0, 0.0));
    for (column, row) in (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row))) {
        let is_wall = column < 2 || row < 2 || column >= columns - 2 || row >= rows - 2;
        room.set(CellIndex { column, row }, if is_wall { Cell::Occupied } else { Cell::Free });
    }
    room
}
