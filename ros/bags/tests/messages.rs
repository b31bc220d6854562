//! Messages of three types, with their definitions, encoded in CDR.

pub(crate) const TWIST: (&str, &str) = (
    "geometry_msgs/msg/Twist",
    "Vector3 linear\nVector3 angular\n===\nMSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n",
);
pub(crate) const ODD: (&str, &str) = (
    "odd_msgs/msg/Odd",
    "uint8 MODE_IDLE=0\nuint8 MODE_BUSY=1\nstd_msgs/Header header\nuint8 mode\nuint64 count\nuint8[4] id\nItem[] items\n\
     wstring wide\nbool[<=2] flags\n===\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n===\n\
     MSG: odd_msgs/Item\nstring name\nfloat32 weight\n",
);

/// Writes CDR, little- or big-endian.
#[derive(Default)]
pub(crate) struct Encoder {
    is_big: bool,
    bytes: Vec<u8>,
}

impl Encoder {
    pub(crate) fn put(&mut self, little: &[u8]) -> &mut Self {
        self.bytes.resize(self.bytes.len().next_multiple_of(little.len()), 0);
        let mut bytes = little.to_vec();
        if self.is_big {
            bytes.reverse();
        }
        self.bytes.extend(bytes);
        self
    }

    pub(crate) fn text(&mut self, text: &str) -> &mut Self {
        self.put(&(text.len() as u32 + 1).to_le_bytes());
        self.bytes.extend(text.bytes().chain([0]));
        self
    }

    pub(crate) fn message(&self) -> Vec<u8> {
        [&[0, u8::from(!self.is_big), 0, 0], self.bytes.as_slice()].concat()
    }
}

pub(crate) fn twist(x: f64) -> Vec<u8> {
    let mut encoder = Encoder::default();
    for number in [x, 0.0, 0.0, 0.0, 0.0, -x] {
        encoder.put(&number.to_le_bytes());
    }
    encoder.message()
}

/// One more than what a real number can be exactly.
pub(crate) const COUNT: u64 = (1 << 53) + 1;

/// An odd message with a stamp in milliseconds.
pub(crate) fn odd(is_big: bool, ms: u32, mode: u8, items: &[(&str, f32)]) -> Vec<u8> {
    let mut encoder = Encoder { is_big, ..Encoder::default() };
    encoder.put(&(ms / 1000).to_le_bytes()).put(&(ms % 1000 * 1_000_000).to_le_bytes()).text("map");
    encoder.put(&[mode]).put(&COUNT.to_le_bytes()).put(&[0xab]).put(&[0]).put(&[1]).put(&[0xff]);
    encoder.put(&(items.len() as u32).to_le_bytes());
    for (name, weight) in items {
        encoder.text(name).put(&weight.to_le_bytes());
    }
    let wide: Vec<u16> = "aß😀".encode_utf16().collect();
    encoder.put(&(wide.len() as u32).to_le_bytes());
    for unit in wide {
        encoder.put(&u32::from(unit).to_le_bytes());
    }
    encoder.put(&2_u32.to_le_bytes()).put(&[1]).put(&[0]);
    encoder.message()
}

pub(crate) const PLAIN: (&str, &str) = ("p/msg/P", "int64 whole\nuint64 natural\nuint8[] codes\n");

pub(crate) fn plain(whole: i64, natural: u64, codes: &[u8]) -> Vec<u8> {
    let mut encoder = Encoder::default();
    encoder.put(&whole.to_le_bytes()).put(&natural.to_le_bytes()).put(&(codes.len() as u32).to_le_bytes());
    encoder.bytes.extend(codes);
    encoder.message()
}

pub(crate) const BEHAVIOR_TREE_LOG: &str = "builtin_interfaces/Time timestamp\nBehaviorTreeStatusChange[] event_log\n===\n\
     MSG: nav2_msgs/BehaviorTreeStatusChange\nbuiltin_interfaces/Time timestamp\nstring node_name\nuint16 uid\n\
     string previous_status\nstring current_status\n";

/// A message in which these nodes begin to run.
pub(crate) fn behavior_tree_log(nodes: &[&str]) -> Vec<u8> {
    let mut encoder = Encoder::default();
    encoder.put(&1_i32.to_le_bytes()).put(&0_u32.to_le_bytes()).put(&(nodes.len() as u32).to_le_bytes());
    for (node, uid) in nodes.iter().zip(1_u16..) {
        encoder.put(&2_i32.to_le_bytes()).put(&0_u32.to_le_bytes()).text(node).put(&uid.to_le_bytes());
        encoder.text("IDLE").text("RUNNING");
    }
    encoder.message()
}

pub(crate) const TF: (&str, &str) = (
    "tf2_msgs/msg/TFMessage",
    "geometry_msgs/TransformStamped[] transforms\n===\nMSG: geometry_msgs/TransformStamped\nstd_msgs/Header header\n\
     string child_frame_id\nTransform transform\n===\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\n\
     string frame_id\n===\nMSG: geometry_msgs/Transform\nVector3 translation\nQuaternion rotation\n===\n\
     MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n===\nMSG: geometry_msgs/Quaternion\nfloat64 x 0\n\
     float64 y 0\nfloat64 z 0\nfloat64 w 1\n",
);

/// So many transforms, numbered.
pub(crate) fn tf(count: i64) -> Vec<u8> {
    let mut encoder = Encoder::default();
    encoder.put(&(count as u32).to_le_bytes());
    for index in 0..count {
        encoder.put(&1_i32.to_le_bytes()).put(&0_u32.to_le_bytes()).text("map").text("base");
        for number in [index as f64, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0] {
            encoder.put(&number.to_le_bytes());
        }
    }
    encoder.message()
}
