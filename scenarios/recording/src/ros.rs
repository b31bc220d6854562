//! The ROS 2 message types of a robot's topics, and what they are made from: in recordings, and on the simulated robot.
//!
//! The fields are those of ROS 2 Humble and later: the packages `builtin_interfaces`, `rcl_interfaces` and
//! `rosgraph_msgs` (`ros2/rcl_interfaces`, Apache-2.0), `std_msgs`, `geometry_msgs`, `sensor_msgs`, `nav_msgs`,
//! `diagnostic_msgs` and `visualization_msgs` (`ros2/common_interfaces`, Apache-2.0), and `tf2_msgs` (`ros2/geometry2`,
//! BSD). Constants and comments are left out: they do not affect the encoding.
#![expect(missing_docs, reason = "the packages document their types")]

use std::borrow::Cow;
use std::time::Duration;

use maps::{Cell, Pose as MapPose};
use robot::LaserSpec;
use ros_messages::{Byte, CdrWriter, Count, RosType, Type, messages};

/// The name of a frame; that of most is known at compile time.
pub type Frame = Cow<'static, str>;

messages! {
    pub Time = "builtin_interfaces/Time" { sec: i32, nanosec: u32 }
    pub Span = "builtin_interfaces/Duration" { sec: i32, nanosec: u32 }
    pub Header = "std_msgs/Header" { stamp: Time, frame_id: Frame }
    pub Text = "std_msgs/String" { data: String }
    pub Color = "std_msgs/ColorRGBA" { r: f32, g: f32, b: f32, a: f32 }
    pub Point = "geometry_msgs/Point" { x: f64, y: f64, z: f64 }
    pub Vector = "geometry_msgs/Vector3" { x: f64, y: f64, z: f64 }
    pub Quaternion = "geometry_msgs/Quaternion" { x: f64, y: f64, z: f64, w: f64 }
    pub Pose = "geometry_msgs/Pose" { position: Point, orientation: Quaternion }
    pub PoseStamped = "geometry_msgs/PoseStamped" { header: Header, pose: Pose }
    pub PoseWithCovariance = "geometry_msgs/PoseWithCovariance" { pose: Pose, covariance: Covariance }
    pub PoseWithCovarianceStamped = "geometry_msgs/PoseWithCovarianceStamped" {
        header: Header,
        pose: PoseWithCovariance,
    }
    pub Twist = "geometry_msgs/Twist" { linear: Vector, angular: Vector }
    pub TwistWithCovariance = "geometry_msgs/TwistWithCovariance" { twist: Twist, covariance: Covariance }
    pub Transform = "geometry_msgs/Transform" { translation: Vector, rotation: Quaternion }
    pub TransformStamped = "geometry_msgs/TransformStamped" {
        header: Header,
        child_frame_id: Frame,
        transform: Transform,
    }
    pub Transforms = "tf2_msgs/TFMessage" { transforms: Vec<TransformStamped> }
    pub LaserScan = "sensor_msgs/LaserScan" {
        header: Header,
        angle_min: f32,
        angle_max: f32,
        angle_increment: f32,
        time_increment: f32,
        scan_time: f32,
        range_min: f32,
        range_max: f32,
        ranges: Vec<f32>,
        intensities: Vec<f32>,
    }
    pub PointField = "sensor_msgs/PointField" { name: String, offset: u32, datatype: u8, count: u32 }
    pub PointCloud = "sensor_msgs/PointCloud2" {
        header: Header,
        height: u32,
        width: u32,
        fields: Vec<PointField>,
        is_bigendian: bool,
        point_step: u32,
        row_step: u32,
        data: Vec<u8>,
        is_dense: bool,
    }
    pub Image = "sensor_msgs/Image" {
        header: Header,
        height: u32,
        width: u32,
        encoding: String,
        is_bigendian: u8,
        step: u32,
        data: Vec<u8>,
    }
    pub CompressedImage = "sensor_msgs/CompressedImage" { header: Header, format: String, data: Vec<u8> }
    pub BatteryState = "sensor_msgs/BatteryState" {
        header: Header,
        voltage: f32,
        temperature: f32,
        current: f32,
        charge: f32,
        capacity: f32,
        design_capacity: f32,
        percentage: f32,
        power_supply_status: u8,
        power_supply_health: u8,
        power_supply_technology: u8,
        present: bool,
        cell_voltage: Vec<f32>,
        cell_temperature: Vec<f32>,
        location: String,
        serial_number: String,
    }
    pub MapMetaData = "nav_msgs/MapMetaData" {
        map_load_time: Time,
        resolution: f32,
        width: u32,
        height: u32,
        origin: Pose,
    }
    pub OccupancyGrid = "nav_msgs/OccupancyGrid" { header: Header, info: MapMetaData, data: Vec<i8> }
    pub Odometry = "nav_msgs/Odometry" {
        header: Header,
        child_frame_id: Frame,
        pose: PoseWithCovariance,
        twist: TwistWithCovariance,
    }
    pub Path = "nav_msgs/Path" { header: Header, poses: Vec<PoseStamped> }
    pub TexturePoint = "visualization_msgs/UVCoordinate" { u: f32, v: f32 }
    pub MeshFile = "visualization_msgs/MeshFile" { filename: String, data: Vec<u8> }
    pub Marker = "visualization_msgs/Marker" {
        header: Header,
        ns: String,
        id: i32,
        r#type: i32,
        action: i32,
        pose: Pose,
        scale: Vector,
        color: Color,
        lifetime: Span,
        frame_locked: bool,
        points: Vec<Point>,
        colors: Vec<Color>,
        texture_resource: String,
        texture: CompressedImage,
        uv_coordinates: Vec<TexturePoint>,
        text: String,
        mesh_resource: String,
        mesh_file: MeshFile,
        mesh_use_embedded_materials: bool,
    }
    pub Markers = "visualization_msgs/MarkerArray" { markers: Vec<Marker> }
    pub KeyValue = "diagnostic_msgs/KeyValue" { key: String, value: String }
    pub Status = "diagnostic_msgs/DiagnosticStatus" {
        level: Byte,
        name: String,
        message: String,
        hardware_id: String,
        values: Vec<KeyValue>,
    }
    pub Statuses = "diagnostic_msgs/DiagnosticArray" { header: Header, status: Vec<Status> }
    pub Log = "rcl_interfaces/Log" {
        stamp: Time,
        level: u8,
        name: String,
        msg: String,
        file: String,
        function: String,
        line: u32,
    }
    pub Clock = "rosgraph_msgs/Clock" { clock: Time }
    pub Moment = "steward_msgs/Event" { step: u64, tick: u64 }
    pub Records = "steward_msgs/Records" { format: u32, checksum: u32, records: Vec<u8> }
}

/// A covariance of x, y, z and the turns about these axes, row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct Covariance(pub [f64; 36]);

impl Default for Covariance {
    fn default() -> Self {
        Self([0.0; 36])
    }
}

impl RosType for Covariance {
    fn kind() -> Type {
        Type { count: Count::Exactly(36), ..f64::kind() }
    }

    fn write(&self, cdr: &mut CdrWriter) {
        f64::write_all(&self.0, cdr);
    }
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

impl From<Duration> for Time {
    fn from(time: Duration) -> Self {
        Self { sec: i32::try_from(time.as_secs()).unwrap_or(i32::MAX), nanosec: time.subsec_nanos() }
    }
}

impl Header {
    pub fn new(time: Duration, frame: impl Into<Frame>) -> Self {
        Self { stamp: time.into(), frame_id: frame.into() }
    }
}

impl From<&maps::Point> for Point {
    fn from(point: &maps::Point) -> Self {
        Self { x: point.x, y: point.y, z: 0.0 }
    }
}

impl From<&MapPose> for Quaternion {
    fn from(pose: &MapPose) -> Self {
        let half = pose.rotation.powf(0.5);
        Self { x: 0.0, y: 0.0, z: half.im, w: half.re }
    }
}

impl From<&MapPose> for Pose {
    fn from(pose: &MapPose) -> Self {
        Self { position: (&maps::Point::from(pose.translation.vector)).into(), orientation: pose.into() }
    }
}

impl PoseStamped {
    pub fn new(time: Duration, frame: impl Into<Frame>, pose: &MapPose) -> Self {
        Self { header: Header::new(time, frame), pose: pose.into() }
    }
}

impl TransformStamped {
    /// The pose of one frame in another.
    pub fn new(time: Duration, frame: impl Into<Frame>, child: impl Into<Frame>, pose: &MapPose) -> Self {
        let translation = Vector { x: pose.translation.x, y: pose.translation.y, z: 0.0 };
        let transform = Transform { translation, rotation: pose.into() };
        Self { header: Header::new(time, frame), child_frame_id: child.into(), transform }
    }
}

impl PointCloud {
    /// Points in a plane.
    pub fn new(time: Duration, frame: impl Into<Frame>, points: impl IntoIterator<Item = maps::Point>) -> Self {
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
        Self {
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
}

impl Transforms {
    /// Where the lasers are on the robot.
    #[must_use]
    pub fn of_lasers(lasers: &[LaserSpec]) -> Self {
        let mount =
            |laser| TransformStamped::new(Duration::ZERO, BASE, laser_frame(laser), &LaserSpec::clone(laser).mount);
        Self { transforms: lasers.iter().map(mount).collect() }
    }
}

impl LaserScan {
    #[must_use]
    pub fn of(laser: &LaserSpec, scan: &robot::LaserScan) -> Self {
        Self {
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
}

impl BatteryState {
    /// The charge is in percent.
    #[must_use]
    pub fn of(time: Duration, charge_pct: f64, charging: bool) -> Self {
        /// The values of `power_supply_status` for discharging and charging.
        const CHARGING: [u8; 2] = [2, 1];
        Self {
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
            ..Self::default()
        }
    }
}

impl OccupancyGrid {
    #[must_use]
    pub fn of(map: &maps::OccupancyGrid) -> Self {
        let occupancy = |cell: &Cell| match cell {
            Cell::Free => 0,
            Cell::Occupied => 100,
            Cell::Unknown => -1,
        };
        Self {
            header: Header::new(Duration::ZERO, MAP),
            info: MapMetaData {
                map_load_time: Duration::ZERO.into(),
                resolution: map.resolution_m() as f32,
                width: map.width() as u32,
                height: map.height() as u32,
                origin: (&map.origin()).into(),
            },
            data: map.cells().iter().map(occupancy).collect(),
        }
    }
}

impl Odometry {
    #[must_use]
    pub fn of(odometry: &robot::Odometry) -> Self {
        let forward =
            |x, z| Twist { linear: Vector { x, ..Vector::default() }, angular: Vector { z, ..Vector::default() } };
        Self {
            header: Header::new(odometry.time, ODOM),
            child_frame_id: BASE.into(),
            pose: PoseWithCovariance { pose: (&odometry.pose).into(), ..PoseWithCovariance::default() },
            twist: TwistWithCovariance {
                twist: forward(odometry.linear_mps, odometry.angular_radps),
                ..TwistWithCovariance::default()
            },
        }
    }
}

impl PoseWithCovarianceStamped {
    /// A pose on the map, with the covariance of x, y and heading.
    #[must_use]
    pub fn new(time: Duration, pose: &MapPose, of: [[f64; 3]; 3]) -> Self {
        /// The places of x, y and heading among the six coordinates.
        const AXES: [usize; 3] = [0, 1, 5];
        let mut covariance = Covariance::default();
        for (row, numbers) in AXES.into_iter().zip(of) {
            for (column, number) in AXES.into_iter().zip(numbers) {
                covariance.0[6 * row + column] = number;
            }
        }
        Self { header: Header::new(time, MAP), pose: PoseWithCovariance { pose: pose.into(), covariance } }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use ros_messages::{Bundle, Layout, Message, RosMessage, Undefined};

    use super::*;

    #[test]
    fn a_definition_has_each_nested_type_once() {
        let rule = "=".repeat(80);
        let expected = format!(
            "std_msgs/Header header\ngeometry_msgs/Pose pose\n{rule}\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\n\
             string frame_id\n{rule}\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n{rule}\nMSG: \
             geometry_msgs/Pose\ngeometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n{rule}\nMSG: \
             geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n{rule}\nMSG: geometry_msgs/Quaternion\nfloat64 x\n\
             float64 y\nfloat64 z\nfloat64 w\n"
        );
        assert_eq!(PoseStamped::definition().to_string(), expected);
        assert!(Marker::definition().to_string().contains("int32 type\n"));
    }

    /// A recording says that it comes from Humble.
    #[test]
    fn the_types_are_those_of_humble() {
        fn compare<T: RosMessage>() {
            let Bundle { message, types } = T::definition();
            let types: BTreeMap<_, _> = types.into_iter().chain([(T::name(), message)]).collect();
            let of_humble = |name: &_| Message::known(name, Some("humble"));
            let undefined = || Undefined::new("it is not on board".to_owned(), "");
            let theirs = Layout::resolve(&T::name(), &mut |name| of_humble(name).ok_or_else(undefined));
            let ours = Layout::resolve(&T::name(), &mut |name| Ok(types[name].clone()));
            let [ours, theirs] = [ours, theirs].map(|layout| layout.unwrap().type_hash());
            assert_eq!(ours, theirs, "{}", T::name());
        }
        compare::<Text>();
        compare::<PoseStamped>();
        compare::<Transforms>();
        compare::<LaserScan>();
        compare::<PointCloud>();
        compare::<Image>();
        compare::<CompressedImage>();
        compare::<BatteryState>();
        compare::<OccupancyGrid>();
        compare::<Path>();
        compare::<Odometry>();
        compare::<PoseWithCovarianceStamped>();
        compare::<Clock>();
        compare::<Markers>();
        compare::<Statuses>();
        compare::<Log>();
    }

    #[test]
    fn numbers_are_aligned_to_their_size_after_the_encoding() {
        let log = Log { level: 7, name: "a".to_owned(), line: 9, ..Log::default() };
        let mut cdr = CdrWriter::reusing(Vec::new());
        log.write(&mut cdr);
        let text = [1, 0, 0, 0, 0, 0, 0, 0];
        let expected = [
            &[0, 1, 0, 0][..],
            &[0; 8],
            &[7, 0, 0, 0],
            &[2, 0, 0, 0, b'a', 0, 0, 0],
            &text,
            &text,
            &text,
            &[9, 0, 0, 0],
        ];
        assert_eq!(cdr.bytes(), expected.concat());
        let mut cdr = CdrWriter::reusing(Vec::new());
        1_u8.write(&mut cdr);
        2.0_f64.write(&mut cdr);
        assert_eq!(cdr.bytes(), [&[0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0][..], &2.0_f64.to_le_bytes()].concat());
    }
}
