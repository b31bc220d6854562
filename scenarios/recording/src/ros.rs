//! The messages on a robot's topics, in recordings and on the simulated robot, and what they are made from.

use std::time::Duration;

use maps::{Cell, Pose as MapPose, seen_from_above};
use robot::LaserSpec;
use ros_messages::messages;
pub use ros_messages::standard::*;

messages! {
    /// When a message was received: in which step, and after which tick.
    pub(crate) Moment = "steward_msgs/Event" { step: u64, tick: u64 }
    /// A part of a recording.
    pub(crate) Records = "steward_msgs/Records" { format: u32, checksum: u32, records: Vec<u8> }
}

/// The frame of the map.
pub const MAP: &str = "map";
/// The frame in which odometry measures.
pub const ODOM: &str = "odom";
/// The frame of the robot.
pub const BASE: &str = "base_link";

/// The frame of a laser.
#[must_use]
pub fn laser_frame(laser: &LaserSpec) -> String {
    let letters = laser.name.chars().map(|letter| if letter.is_ascii_alphanumeric() { letter } else { '_' });
    format!("laser_{}", letters.collect::<String>())
}

/// A point of a plane.
#[must_use]
pub fn point(point: &maps::Point) -> Point {
    Point { x: point.x, y: point.y, z: 0.0 }
}

/// The same direction in space.
fn quaternion(pose: &MapPose) -> Quaternion {
    let half = pose.rotation.powf(0.5);
    Quaternion { x: 0.0, y: 0.0, z: half.im, w: half.re }
}

/// A pose in a plane.
#[must_use]
pub fn pose(pose: &MapPose) -> Pose {
    Pose { position: point(&pose.translation.vector.into()), orientation: quaternion(pose) }
}

/// The pose as [seen from above](seen_from_above).
#[must_use]
pub fn in_plane(Pose { position: Point { x, y, .. }, orientation: turn }: &Pose) -> MapPose {
    seen_from_above([*x, *y], [turn.x, turn.y, turn.z, turn.w])
}

/// A pose in a frame.
pub fn pose_stamped(time: Duration, frame: impl Into<Frame>, of: &MapPose) -> PoseStamped {
    PoseStamped { header: Header::new(time, frame), pose: pose(of) }
}

/// The pose of one frame in another.
pub fn transform(time: Duration, frame: impl Into<Frame>, child: impl Into<Frame>, pose: &MapPose) -> TransformStamped {
    let translation = Vector { x: pose.translation.x, y: pose.translation.y, z: 0.0 };
    let transform = Transform { translation, rotation: quaternion(pose) };
    TransformStamped { header: Header::new(time, frame), child_frame_id: child.into(), transform }
}

/// Points in a plane.
pub fn point_cloud(
    time: Duration,
    frame: impl Into<Frame>,
    points: impl IntoIterator<Item = maps::Point>,
) -> PointCloud {
    /// The value of `datatype` for 32-bit floating point.
    const FLOAT32: u8 = 7;
    const POINT_BYTES: u32 = 12;
    let coordinate =
        |(name, offset): (&str, u32)| PointField { name: name.to_owned(), offset, datatype: FLOAT32, count: 1 };
    let mut data = Vec::new();
    // A cloud has three dimensions, and its viewers expect single precision.
    for point in points {
        for number in [point.x as f32, point.y as f32, 0.0] {
            data.extend_from_slice(&number.to_le_bytes());
        }
    }
    let row_step = data.len() as u32;
    PointCloud {
        header: Header::new(time, frame),
        height: 1,
        width: row_step / POINT_BYTES,
        fields: [("x", 0), ("y", 4), ("z", 8)].map(coordinate).to_vec(),
        is_bigendian: false,
        point_step: POINT_BYTES,
        row_step,
        data,
        is_dense: true,
    }
}

/// Where the lasers are on the robot.
#[must_use]
pub fn laser_transforms(lasers: &[LaserSpec]) -> Transforms {
    let mount = |laser: &LaserSpec| transform(Duration::ZERO, BASE, laser_frame(laser), &laser.mount);
    Transforms { transforms: lasers.iter().map(mount).collect() }
}

/// A scan of a laser.
#[must_use]
pub fn laser_scan(laser: &LaserSpec, scan: &robot::LaserScan) -> LaserScan {
    LaserScan {
        header: Header::new(scan.time, laser_frame(laser)),
        angle_min: laser.angle_min_rad as f32,
        angle_max: laser.beam_angle_rad(laser.beams.saturating_sub(1)) as f32,
        angle_increment: laser.angle_increment_rad as f32,
        time_increment: 0.0,
        scan_time: laser.period.as_secs_f32(),
        range_min: laser.range_min_m as f32,
        range_max: laser.range_max_m as f32,
        ranges: scan.ranges_m.clone(),
        intensities: Vec::new(),
    }
}

/// A battery with this charge, in percent.
#[must_use]
pub fn battery_state(time: Duration, charge_pct: f64, charging: bool) -> BatteryState {
    /// The values of `power_supply_status` for discharging and charging.
    const CHARGING: [u8; 2] = [2, 1];
    BatteryState {
        header: Header::new(time, BASE),
        voltage: f32::NAN,
        temperature: f32::NAN,
        current: f32::NAN,
        charge: f32::NAN,
        capacity: f32::NAN,
        design_capacity: f32::NAN,
        percentage: (charge_pct / 100.0) as f32,
        power_supply_status: CHARGING[usize::from(charging)],
        present: true,
        ..BatteryState::default()
    }
}

/// A map, in its own frame.
#[must_use]
pub fn occupancy_grid(map: &maps::OccupancyGrid) -> OccupancyGrid {
    let occupancy = |cell: &Cell| match cell {
        Cell::Free => 0,
        Cell::Occupied => 100,
        Cell::Unknown => -1,
    };
    OccupancyGrid {
        header: Header::new(Duration::ZERO, MAP),
        info: MapMetaData {
            map_load_time: Time::default(),
            resolution: map.resolution_m() as f32,
            width: map.width() as u32,
            height: map.height() as u32,
            origin: pose(&map.origin()),
        },
        data: map.cells().iter().map(occupancy).collect(),
    }
}

/// A reading of odometry. Its covariances are 0.
#[must_use]
pub fn odometry(of: &robot::Odometry) -> Odometry {
    let linear = Vector { x: of.linear_mps, ..Vector::default() };
    let angular = Vector { z: of.angular_radps, ..Vector::default() };
    Odometry {
        header: Header::new(of.time, ODOM),
        child_frame_id: BASE.into(),
        pose: PoseWithCovariance { pose: pose(&of.pose), ..PoseWithCovariance::default() },
        twist: TwistWithCovariance { twist: Twist { linear, angular }, ..TwistWithCovariance::default() },
    }
}

/// The places of x, y and heading among the six coordinates of a covariance.
const AXES: [usize; 3] = [0, 1, 5];

/// A pose on the map, with the covariance of x, y and heading.
#[must_use]
pub fn estimate(time: Duration, at: &MapPose, of: [[f64; 3]; 3]) -> PoseWithCovarianceStamped {
    let mut covariance = Covariance::default();
    for (row, numbers) in AXES.into_iter().zip(of) {
        for (column, number) in AXES.into_iter().zip(numbers) {
            covariance.0[6 * row + column] = number;
        }
    }
    PoseWithCovarianceStamped {
        header: Header::new(time, MAP),
        pose: PoseWithCovariance { pose: pose(at), covariance },
    }
}

/// The covariance of x, y and heading.
#[must_use]
pub fn planar_covariance(Covariance(of): &Covariance) -> [[f64; 3]; 3] {
    AXES.map(|row| AXES.map(|column| of[6 * row + column]))
}
