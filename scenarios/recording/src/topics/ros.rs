//! The ROS 2 message types of the topics. Each is a struct, from which both its definition and its encoding are made.
//!
//! The fields are those of ROS 2 Humble and later: the packages `builtin_interfaces` and `rcl_interfaces`
//! (`ros2/rcl_interfaces`, Apache-2.0), `std_msgs`, `geometry_msgs`, `sensor_msgs`, `nav_msgs`, `diagnostic_msgs` and
//! `visualization_msgs` (`ros2/common_interfaces`, Apache-2.0), and `tf2_msgs` (`ros2/geometry2`, BSD). Constants and
//! comments are left out: they do not affect the encoding.

use std::borrow::Cow;
use std::fmt::Write as _;
use std::time::Duration;

use maps::Pose as MapPose;

use super::cdr::Cdr;

/// What may be in a message.
pub(crate) trait Field {
    /// The type's name in definitions: `float64`, `std_msgs/Header`.
    fn name() -> String;

    /// Adds the definitions of this type and of those that it contains, each once: name and fields.
    fn define(_definitions: &mut Vec<(String, String)>) {}

    fn write(&self, cdr: &mut Cdr);

    /// Writes several values, one after the other.
    fn write_all(items: &[Self], cdr: &mut Cdr)
    where
        Self: Sized,
    {
        items.iter().for_each(|item| item.write(cdr));
    }
}

/// The definition of a message in the `ros2msg` encoding: its fields, then those of the types in it.
pub(crate) fn definition<T: Field>() -> String {
    let mut definitions = Vec::new();
    T::define(&mut definitions);
    let mut types = definitions.into_iter();
    let mut text = types.next().map(|(_, fields)| fields).unwrap_or_default();
    types.for_each(|(name, fields)| add_definition(&mut text, &name, &fields));
    text
}

/// Adds the definition of another type.
pub(crate) fn add_definition(text: &mut String, name: &str, fields: &str) {
    // Writing to a string cannot fail.
    let _ = write!(text, "{}\nMSG: {name}\n{fields}", "=".repeat(80));
}

macro_rules! numbers {
    ($($number:ty = $name:literal),*) => {$(
        impl Field for $number {
            fn name() -> String {
                $name.to_owned()
            }

            fn write(&self, cdr: &mut Cdr) {
                cdr.number(self.to_le_bytes());
            }

            fn write_all(items: &[Self], cdr: &mut Cdr) {
                cdr.numbers(items.iter().map(|item| item.to_le_bytes()));
            }
        }
    )*};
}

numbers!(u8 = "uint8", i8 = "int8", u16 = "uint16", i32 = "int32", u32 = "uint32", i64 = "int64", u64 = "uint64");
numbers!(f32 = "float32", f64 = "float64");

impl Field for bool {
    fn name() -> String {
        "bool".to_owned()
    }

    fn write(&self, cdr: &mut Cdr) {
        cdr.number([u8::from(*self)]);
    }
}

impl Field for String {
    fn name() -> String {
        "string".to_owned()
    }

    fn write(&self, cdr: &mut Cdr) {
        cdr.text(self);
    }
}

/// The name of a frame; that of most is known at compile time.
pub(crate) type Frame = Cow<'static, str>;

impl Field for Frame {
    fn name() -> String {
        String::name()
    }

    fn write(&self, cdr: &mut Cdr) {
        cdr.text(self);
    }
}

impl<T: Field> Field for Vec<T> {
    fn name() -> String {
        T::name() + "[]"
    }

    fn define(definitions: &mut Vec<(String, String)>) {
        T::define(definitions);
    }

    fn write(&self, cdr: &mut Cdr) {
        cdr.length(self.len());
        T::write_all(self, cdr);
    }
}

/// ROS's `byte`: eight bits without a meaning.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Byte(pub(crate) u8);

impl Field for Byte {
    fn name() -> String {
        "byte".to_owned()
    }

    fn write(&self, cdr: &mut Cdr) {
        self.0.write(cdr);
    }
}

macro_rules! messages {
    ($($message:ident = $name:literal { $($field:ident: $kind:ty),* $(,)? })*) => {$(
        #[derive(Clone, Debug, Default, PartialEq)]
        pub(crate) struct $message {
            $(pub(crate) $field: $kind,)*
        }

        impl Field for $message {
            fn name() -> String {
                $name.to_owned()
            }

            fn define(definitions: &mut Vec<(String, String)>) {
                if definitions.iter().any(|(name, _)| name == $name) {
                    return;
                }
                let mut fields = String::new();
                $(
                    fields += &format!("{} {}\n", <$kind>::name(), stringify!($field).trim_start_matches("r#"));
                )*
                definitions.push(($name.to_owned(), fields));
                $(<$kind>::define(definitions);)*
            }

            fn write(&self, cdr: &mut Cdr) {
                $(self.$field.write(cdr);)*
            }
        }
    )*};
}

messages! {
    Time = "builtin_interfaces/Time" { sec: i32, nanosec: u32 }
    Span = "builtin_interfaces/Duration" { sec: i32, nanosec: u32 }
    Header = "std_msgs/Header" { stamp: Time, frame_id: Frame }
    Text = "std_msgs/String" { data: String }
    Color = "std_msgs/ColorRGBA" { r: f32, g: f32, b: f32, a: f32 }
    Point = "geometry_msgs/Point" { x: f64, y: f64, z: f64 }
    Vector = "geometry_msgs/Vector3" { x: f64, y: f64, z: f64 }
    Quaternion = "geometry_msgs/Quaternion" { x: f64, y: f64, z: f64, w: f64 }
    Pose = "geometry_msgs/Pose" { position: Point, orientation: Quaternion }
    PoseStamped = "geometry_msgs/PoseStamped" { header: Header, pose: Pose }
    Transform = "geometry_msgs/Transform" { translation: Vector, rotation: Quaternion }
    TransformStamped = "geometry_msgs/TransformStamped" {
        header: Header,
        child_frame_id: Frame,
        transform: Transform,
    }
    Transforms = "tf2_msgs/TFMessage" { transforms: Vec<TransformStamped> }
    LaserScan = "sensor_msgs/LaserScan" {
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
    PointField = "sensor_msgs/PointField" { name: String, offset: u32, datatype: u8, count: u32 }
    PointCloud = "sensor_msgs/PointCloud2" {
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
    Image = "sensor_msgs/Image" {
        header: Header,
        height: u32,
        width: u32,
        encoding: String,
        is_bigendian: u8,
        step: u32,
        data: Vec<u8>,
    }
    CompressedImage = "sensor_msgs/CompressedImage" { header: Header, format: String, data: Vec<u8> }
    BatteryState = "sensor_msgs/BatteryState" {
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
    MapMetaData = "nav_msgs/MapMetaData" {
        map_load_time: Time,
        resolution: f32,
        width: u32,
        height: u32,
        origin: Pose,
    }
    OccupancyGrid = "nav_msgs/OccupancyGrid" { header: Header, info: MapMetaData, data: Vec<i8> }
    Path = "nav_msgs/Path" { header: Header, poses: Vec<PoseStamped> }
    TexturePoint = "visualization_msgs/UVCoordinate" { u: f32, v: f32 }
    MeshFile = "visualization_msgs/MeshFile" { filename: String, data: Vec<u8> }
    Marker = "visualization_msgs/Marker" {
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
    Markers = "visualization_msgs/MarkerArray" { markers: Vec<Marker> }
    KeyValue = "diagnostic_msgs/KeyValue" { key: String, value: String }
    Status = "diagnostic_msgs/DiagnosticStatus" {
        level: Byte,
        name: String,
        message: String,
        hardware_id: String,
        values: Vec<KeyValue>,
    }
    Statuses = "diagnostic_msgs/DiagnosticArray" { header: Header, status: Vec<Status> }
    Log = "rcl_interfaces/Log" {
        stamp: Time,
        level: u8,
        name: String,
        msg: String,
        file: String,
        function: String,
        line: u32,
    }
    Moment = "steward_msgs/Event" { step: u64, tick: u64 }
    Records = "steward_msgs/Records" { format: u32, checksum: u32, records: Vec<u8> }
}

impl From<Duration> for Time {
    fn from(time: Duration) -> Self {
        Self { sec: i32::try_from(time.as_secs()).unwrap_or(i32::MAX), nanosec: time.subsec_nanos() }
    }
}

impl Header {
    pub(crate) fn new(time: Duration, frame: impl Into<Frame>) -> Self {
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
    pub(crate) fn new(time: Duration, frame: impl Into<Frame>, pose: &MapPose) -> Self {
        Self { header: Header::new(time, frame), pose: pose.into() }
    }
}

impl TransformStamped {
    /// The pose of one frame in another.
    pub(crate) fn new(time: Duration, frame: impl Into<Frame>, child: impl Into<Frame>, pose: &MapPose) -> Self {
        let translation = Vector { x: pose.translation.x, y: pose.translation.y, z: 0.0 };
        let transform = Transform { translation, rotation: pose.into() };
        Self { header: Header::new(time, frame), child_frame_id: child.into(), transform }
    }
}

impl PointCloud {
    /// Points in a plane.
    pub(crate) fn new(time: Duration, frame: impl Into<Frame>, points: impl IntoIterator<Item = maps::Point>) -> Self {
        /// The value of `datatype` for 32-bit floating point.
        const FLOAT32: u8 = 7;
        const POINT_BYTES: u32 = 12;
        let coordinate =
            |(name, offset): (&str, u32)| PointField { name: name.to_owned(), offset, datatype: FLOAT32, count: 1 };
        let mut data = Vec::new();
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

#[cfg(test)]
mod tests {
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
        assert_eq!(definition::<PoseStamped>(), expected);
        assert!(definition::<Marker>().contains("int32 type\n"));
    }

    #[test]
    fn numbers_are_aligned_to_their_size_after_the_encoding() {
        let log = Log { level: 7, name: "a".to_owned(), line: 9, ..Log::default() };
        let mut cdr = Cdr::reusing(Vec::new());
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
        let mut cdr = Cdr::reusing(Vec::new());
        1_u8.write(&mut cdr);
        2.0_f64.write(&mut cdr);
        assert_eq!(cdr.bytes(), [&[0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0][..], &2.0_f64.to_le_bytes()].concat());
    }
}
