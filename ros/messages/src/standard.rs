//! Types of ROS's common packages, as Rust types.
//!
//! The fields are those of ROS 2 Humble and later: the packages `builtin_interfaces`, `rcl_interfaces`,
//! `rosgraph_msgs`, `action_msgs` and `lifecycle_msgs` (`ros2/rcl_interfaces`, Apache-2.0), `unique_identifier_msgs`
//! (`ros2/unique_identifier_msgs`, BSD), `std_msgs`, `geometry_msgs`, `sensor_msgs`, `nav_msgs`, `diagnostic_msgs` and
//! `visualization_msgs` (`ros2/common_interfaces`, Apache-2.0), `tf2_msgs` (`ros2/geometry2`, BSD), and
//! `ros_gz_interfaces` (`gazebosim/ros_gz`, Apache-2.0); those of `nav2_msgs` are from Jazzy
//! (`ros-navigation/navigation2`, Apache-2.0). Constants and comments are left out: they do not affect the encoding.
#![expect(missing_docs, reason = "the packages document their types")]

use std::borrow::Cow;
use std::time::Duration;

use crate::definition::Type;
use crate::messages;
use crate::reader::CdrReader;
use crate::rust::{Byte, RosType};
use crate::value::Mismatch;
use crate::writer::CdrWriter;

/// The name of a frame; that of most is known at compile time.
pub type Frame = Cow<'static, str>;

messages! {
    pub Time = "builtin_interfaces/Time" { sec: i32, nanosec: u32 }
    pub Span = "builtin_interfaces/Duration" { sec: i32, nanosec: u32 }
    pub Header = "std_msgs/Header" { stamp: Time, frame_id: Frame }
    pub Text = "std_msgs/String" { data: String }
    pub Number = "std_msgs/UInt32" { data: u32 }
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
    pub TwistStamped = "geometry_msgs/TwistStamped" { header: Header, twist: Twist }
    pub TwistWithCovariance = "geometry_msgs/TwistWithCovariance" { twist: Twist, covariance: Covariance }
    pub Wrench = "geometry_msgs/Wrench" { force: Vector, torque: Vector }
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
    pub JointState = "sensor_msgs/JointState" {
        header: Header,
        name: Vec<String>,
        position: Vec<f64>,
        velocity: Vec<f64>,
        effort: Vec<f64>,
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
    pub LifecycleState = "lifecycle_msgs/State" { id: u8, label: String }
    pub Uuid = "unique_identifier_msgs/UUID" { uuid: [u8; 16] }
    pub GoalInfo = "action_msgs/GoalInfo" { goal_id: Uuid, stamp: Time }
    pub GoalStatus = "action_msgs/GoalStatus" { goal_info: GoalInfo, status: i8 }
    pub GoalStatuses = "action_msgs/GoalStatusArray" { status_list: Vec<GoalStatus> }
    pub CancelRequest = "action_msgs/CancelGoal_Request" { goal_info: GoalInfo }
    pub CancelResponse = "action_msgs/CancelGoal_Response" { return_code: i8, goals_canceling: Vec<GoalInfo> }
    /// The response to a goal, which is the same for all actions.
    pub GoalResponse = "nav2_msgs/NavigateToPose_SendGoal_Response" { accepted: bool, stamp: Time }
    pub NavigateToPoseGoal = "nav2_msgs/NavigateToPose_Goal" { pose: PoseStamped, behavior_tree: String }
    pub NavigateToPoseResult = "nav2_msgs/NavigateToPose_Result" { error_code: u16, error_msg: String }
    pub NavigateToPoseResultResponse = "nav2_msgs/NavigateToPose_GetResult_Response" {
        status: i8,
        result: NavigateToPoseResult,
    }
    pub NavigateToPoseFeedback = "nav2_msgs/NavigateToPose_Feedback" {
        current_pose: PoseStamped,
        navigation_time: Span,
        estimated_time_remaining: Span,
        number_of_recoveries: i16,
        distance_remaining: f32,
    }
    pub NavigateToPoseFeedbackMessage = "nav2_msgs/NavigateToPose_FeedbackMessage" {
        goal_id: Uuid,
        feedback: NavigateToPoseFeedback,
    }
    pub Particle = "nav2_msgs/Particle" { pose: Pose, weight: f64 }
    pub Particles = "nav2_msgs/ParticleCloud" { header: Header, particles: Vec<Particle> }
    pub Entity = "ros_gz_interfaces/Entity" { id: u64, name: String, r#type: u8 }
    pub JointWrench = "ros_gz_interfaces/JointWrench" {
        header: Header,
        body_1_name: Text,
        body_1_id: Number,
        body_2_name: Text,
        body_2_id: Number,
        body_1_wrench: Wrench,
        body_2_wrench: Wrench,
    }
    pub Contact = "ros_gz_interfaces/Contact" {
        collision1: Entity,
        collision2: Entity,
        positions: Vec<Vector>,
        normals: Vec<Vector>,
        depths: Vec<f64>,
        wrenches: Vec<JointWrench>,
    }
    pub Contacts = "ros_gz_interfaces/Contacts" { header: Header, contacts: Vec<Contact> }
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
        <[f64; 36]>::kind()
    }

    fn write(&self, cdr: &mut CdrWriter) {
        self.0.write(cdr);
    }

    fn read(cdr: &mut CdrReader<'_>) -> Result<Self, Mismatch> {
        RosType::read(cdr).map(Self)
    }
}

const NS_PER_S: i64 = 1_000_000_000;

impl Time {
    /// The time this many nanoseconds after 1970, or before; the last possible one if it is later.
    #[must_use]
    pub fn of_ns(ns: i64) -> Self {
        let sec = i32::try_from(ns.div_euclid(NS_PER_S)).unwrap_or(i32::MAX);
        Self { sec, nanosec: ns.rem_euclid(NS_PER_S) as u32 }
    }

    /// The nanoseconds since 1970.
    #[must_use]
    pub fn ns(&self) -> i64 {
        i64::from(self.sec) * NS_PER_S + i64::from(self.nanosec)
    }
}

impl From<Duration> for Time {
    fn from(time: Duration) -> Self {
        Self { sec: i32::try_from(time.as_secs()).unwrap_or(i32::MAX), nanosec: time.subsec_nanos() }
    }
}

/// Negative seconds count as none.
impl From<Time> for Duration {
    fn from(time: Time) -> Self {
        Self::new(u64::try_from(time.sec).unwrap_or_default(), time.nanosec)
    }
}

impl From<Duration> for Span {
    fn from(span: Duration) -> Self {
        let Time { sec, nanosec } = span.into();
        Self { sec, nanosec }
    }
}

impl Header {
    #[must_use]
    pub fn new(time: Duration, frame: impl Into<Frame>) -> Self {
        Self { stamp: time.into(), frame_id: frame.into() }
    }
}
