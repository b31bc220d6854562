//! Writing logs.

use maps::{Pose, heading, pose};

use crate::{LaserScan, Odometry};

/// The range that a scan contains for "no hit", in meters: that of the lasers that recorded most logs.
const NOTHING_HIT_M: f32 = 81.83;

/// Writes a log in CARMEN's format, line by line.
///
/// ```
/// use std::time::Duration;
///
/// use maps::pose;
/// use robot::LaserScan;
/// use robot::recorded::{LogWriter, Recording};
///
/// let mut log = LogWriter::new("example");
/// log.param("robot_frontlaser_offset", 0.1);
/// let ranges_m = vec![1.0, 2.5, f32::INFINITY];
/// let scan = LaserScan { time: Duration::from_secs(3), laser: 0, ranges_m };
/// log.scan(&scan, &pose(0.0, 0.0, 0.0), &pose(7.0, 1.0, 0.5));
/// let recording = Recording::read(log.into_text().as_bytes())?;
/// assert_eq!(recording.records()[0].scan.as_ref().map(|scan| scan.ranges_m.clone()), Some(scan.ranges_m));
/// # Ok::<(), robot::recorded::RecordingError>(())
/// ```
#[derive(Clone, Debug)]
pub struct LogWriter {
    host: String,
    text: String,
    /// The positions of the front and the rear laser on the x axis, in meters.
    offsets_m: [f64; 2],
}

impl LogWriter {
    /// An empty log of a computer with this name.
    #[must_use]
    pub fn new(host: &str) -> Self {
        Self { host: host.to_owned(), text: String::new(), offsets_m: [0.0; 2] }
    }

    /// Writes a parameter. The lasers' positions must precede their scans.
    pub fn param(&mut self, name: &str, value: f64) {
        match name {
            "robot_frontlaser_offset" => self.offsets_m[0] = value,
            "robot_rearlaser_offset" => self.offsets_m[1] = value,
            _ => {}
        }
        let host = self.host.clone();
        self.write(format_args!("PARAM {name} {value} {host} 0\n"));
    }

    /// Writes odometry.
    pub fn odometry(&mut self, odometry: &Odometry) {
        let (at, tv, rv) = (fields(&odometry.pose), odometry.linear_mps, odometry.angular_radps);
        let time_s = odometry.time.as_secs_f64();
        let host = self.host.clone();
        self.write(format_args!("ODOM {at} {tv} {rv} 0 {time_s:.6} {host} {time_s:.6}\n"));
    }

    /// Writes a scan of the front laser (0) or the rear one (1), with the robot's odometry and its pose in the `map`
    /// frame.
    pub fn scan(&mut self, scan: &LaserScan, odometry: &Pose, corrected: &Pose) {
        let (keyword, mount) = match scan.laser {
            0 => ("FLASER", pose(self.offsets_m[0], 0.0, 0.0)),
            _ => ("RLASER", pose(self.offsets_m[1], 0.0, std::f64::consts::PI)),
        };
        let corrected = &(corrected * mount);
        self.write(format_args!("{keyword} {}", scan.ranges_m.len()));
        for range_m in &scan.ranges_m {
            let range_m = match range_m {
                nothing if *nothing == f32::INFINITY => NOTHING_HIT_M,
                near if *near == f32::NEG_INFINITY => 0.0,
                range_m => *range_m,
            };
            self.write(format_args!(" {range_m}"));
        }
        let (corrected, odometry, time_s) = (fields(corrected), fields(odometry), scan.time.as_secs_f64());
        let host = self.host.clone();
        self.write(format_args!(" {corrected} {odometry} {time_s:.6} {host} {time_s:.6}\n"));
    }

    /// The log.
    #[must_use]
    pub fn into_text(self) -> String {
        self.text
    }

    fn write(&mut self, line: std::fmt::Arguments<'_>) {
        self.text += &line.to_string();
    }
}

fn fields(pose: &Pose) -> String {
    format!("{} {} {}", pose.translation.x, pose.translation.y, heading(pose))
}
