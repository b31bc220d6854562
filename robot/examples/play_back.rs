//! Plays back what a robot has sensed. In the crate's folder: `cargo run --example play_back -- examples/hallway.log`.

use std::error::Error;
use std::sync::Arc;

use maps::heading;
use robot::recorded::{OdometryErrors, RecordedRobot, Recording};
use robot::{Reading, Robot, Streams};

#[expect(clippy::print_stdout, reason = "a program that is run manually")]
fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("which log?")?;
    let recording = Arc::new(Recording::read(&std::fs::read(path)?)?);
    for complaint in recording.complaints() {
        println!("{complaint}");
    }

    // From here on it is a robot like any other, and software that drives robots can be tried on it.
    let exact = OdometryErrors::new(0.0, 0.0, Streams::new(1).stream("odometry"));
    let mut robot = RecordedRobot::new(recording, exact);
    let mut readings = Vec::new();
    while robot.advance().is_some() {
        robot.read(&mut readings);
        for reading in readings.drain(..) {
            let time_s = reading.time().as_secs_f64();
            match reading {
                Reading::Odometry(odometry) => {
                    let (at, heading_deg) = (odometry.pose.translation, heading(&odometry.pose).to_degrees());
                    println!("{time_s:.1} s  odometry {:.2} m, {:.2} m, {heading_deg:.1}°", at.x, at.y);
                }
                Reading::Scan(scan) => {
                    let hits = scan.ranges_m.iter().filter(|range_m| range_m.is_finite()).count();
                    let nearest_m = scan.ranges_m.iter().copied().fold(f32::INFINITY, f32::min);
                    println!("{time_s:.1} s  scan: {hits} of {} beams, nearest {nearest_m:.2} m", scan.ranges_m.len());
                }
                Reading::Battery(state) => println!("{time_s:.1} s  battery {:.1} %", state.charge_pct),
            }
        }
    }
    Ok(())
}
