//! Messages: their bytes, and the hashes of their types.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use proptest::prelude::*;
use ros_messages::{
    Base, Count, Decoder, Folders, Layout, Message, Mismatch, Primitive, Type, TypeName, Undefined, Value, Want,
    WideWidth,
};

use crate::random;

/// The type `p/T`, which may contain types of the same package.
fn layout(text: &str, others: &[(&str, &str)]) -> Result<Arc<Layout>, Undefined> {
    let parse = |text: &str| Message::parse("Test.msg", text).unwrap_or_else(|problems| panic!("{}", problems.plain()));
    let types: BTreeMap<&str, Message> =
        others.iter().copied().chain([("T", text)]).map(|(name, text)| (name, parse(text))).collect();
    Layout::resolve(&TypeName::new(Some("p"), "T"), &mut |name| {
        types.get(&*name.name).cloned().ok_or_else(|| Undefined::new(format!("there is no definition of {name}"), ""))
    })
}

/// Definitions of ROS 2, without comments.
const SHARE: [(&str, &str); 14] = [
    ("std_msgs/msg/Empty.msg", ""),
    ("std_msgs/msg/Byte.msg", "byte data"),
    ("std_msgs/msg/Char.msg", "char data"),
    ("std_msgs/msg/Header.msg", "builtin_interfaces/Time stamp\nstring frame_id"),
    ("std_msgs/msg/MultiArrayDimension.msg", "string label\nuint32 size\nuint32 stride"),
    ("std_msgs/msg/MultiArrayLayout.msg", "MultiArrayDimension[] dim\nuint32 data_offset"),
    ("std_msgs/msg/Float64MultiArray.msg", "MultiArrayLayout layout\nfloat64[] data"),
    ("geometry_msgs/msg/Point.msg", "float64 x\nfloat64 y\nfloat64 z"),
    ("geometry_msgs/msg/Quaternion.msg", "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1"),
    ("geometry_msgs/msg/Pose.msg", "Point position\nQuaternion orientation"),
    ("geometry_msgs/msg/PoseWithCovariance.msg", "Pose pose\nfloat64[36] covariance"),
    (
        "nav_msgs/msg/MapMetaData.msg",
        "builtin_interfaces/Time map_load_time\nfloat32 resolution\nuint32 width\nuint32 height\ngeometry_msgs/Pose origin",
    ),
    ("nav_msgs/msg/OccupancyGrid.msg", "std_msgs/Header header\nMapMetaData info\nint8[] data"),
    ("nav_msgs/srv/LoadMap.srv", "string map_url\n---\nuint8 RESULT_SUCCESS=0\nOccupancyGrid map\nuint8 result"),
];

/// As in `type_hashes` of the JSON files beside the definitions, in ROS 2 Jazzy.
const HASHES: [(&str, &str); 10] = [
    ("std_msgs/msg/Empty", "20b625256f32d5dbc0d04fee44f43c41e51c70d3502f84b4a08e7a9c26a96312"),
    ("std_msgs/msg/Byte", "41e1a3345f73fe93ede006da826a6ee274af23dd4653976ff249b0f44e3e798f"),
    ("std_msgs/msg/Char", "3ad2d04dd29ba19d04b16659afa3ccaedd691914b02a64e82e252f2fa6a586a9"),
    ("std_msgs/msg/Header", "f49fb3ae2cf070f793645ff749683ac6b06203e41c891e17701b1cb597ce6a01"),
    ("std_msgs/msg/Float64MultiArray", "1025ddc6b9552d191f89ef1a8d2f60f3d373e28b283d8891ddcc974e8c55397f"),
    ("geometry_msgs/msg/PoseWithCovariance", "9a7c0fd234b7f45c6098745ecccd773ca1085670e64107135397aee31c02e1bb"),
    ("builtin_interfaces/msg/Time", "b106235e25a4c5ed35098aa0a61a3ee9c9b18d197f398b0e4206cea9acf9c197"),
    ("service_msgs/msg/ServiceEventInfo", "41bcbbe07a75c9b52bc96bfd5c24d7f0fc0a08c0cb7921b3373c5732345a6f45"),
    ("nav_msgs/srv/LoadMap_Event", "a7907dcbaf7a052cc96c8c716992591dc006ad26ee2841329a7e06a4a33339c7"),
    ("nav_msgs/srv/LoadMap_Request", "0f8fe3aac433c977d7c2f8b57ab1c3a17677e24880d76919b69e4208e99f5132"),
];

#[test]
fn type_hashes_are_those_of_ros() {
    let read = |path: &Path| {
        let found = SHARE.iter().find(|(file, _)| path == Path::new("share").join(file));
        found.map(|(_, text)| text.as_bytes().to_vec()).ok_or_else(|| std::io::ErrorKind::NotFound.into())
    };
    let folders = Folders { paths: &[PathBuf::from("share")], read: &read };
    for (name, hash) in HASHES {
        let layout = folders.layout(&TypeName::parse(name).expect("a name")).expect("a definition");
        assert_eq!(layout.name.full(), name);
        assert_eq!(layout.type_hash(), format!("RIHS01_{hash}"), "{name}");
    }
}

#[test]
fn a_type_is_refused_if_a_definition_is_missing_or_endless() {
    let why = |text, others| layout(text, others).expect_err("no type").to_string();
    assert_eq!(why("Other other", &[]), "there is no definition of p/Other");
    assert_eq!(why("Other other", &[("Other", "T[] more")]), "p/Other contains itself");
}

/// `WStrings` of `test_msgs`, as rclpy of Jazzy serializes it: with defaults, and with one more string in a sequence.
#[test]
fn wide_strings_are_those_of_ros() {
    let text = "wstring a\nwstring b \"Hello world!\"\nwstring[3] c\nwstring[<=3] d\nwstring[] e\n";
    let layout = layout(text, &[]).expect("a type");
    let texts = |texts: &[&str]| Value::List(texts.iter().map(|text| Value::Text((*text).to_owned())).collect());
    let [a, b] = ["aß😀", "Hello world!"].map(|text| Value::Text(text.to_owned()));
    let message = Value::Message(vec![a, b, texts(&["", "", ""]), texts(&["x"]), texts(&[])]);
    let units = |text: &str| -> Vec<u8> {
        let units: Vec<u16> = text.encode_utf16().collect();
        let length = (units.len() as u32).to_le_bytes();
        length.into_iter().chain(units.iter().flat_map(|unit| u32::from(*unit).to_le_bytes())).collect()
    };
    let one = [1, 0, 0, 0];
    let parts = [&units("aß😀")[..], &units("Hello world!"), &[0; 12], &one, &one, &[b'x', 0, 0, 0], &[0; 4]];
    let bytes = [&[0, 1, 0, 0][..], &parts.concat()].concat();
    assert_eq!(bytes[4..24], [4, 0, 0, 0, 0x61, 0, 0, 0, 0xdf, 0, 0, 0, 0x3d, 0xd8, 0, 0, 0, 0xde, 0, 0]);
    assert_eq!(layout.encode(&message), Ok(bytes.clone()));
    // The other width does not fit.
    assert_eq!(Decoder::new(&layout, &Want::All).decode(&bytes), Ok(message));
}

/// ROS writes two units for such a character, other programs one, whose lower half alone is another character.
#[test]
fn a_wide_character_above_16_bits_in_one_unit_is_not_shown_as_another() {
    let layout = layout("wstring w", &[]).expect("a type");
    let bytes = |units: &[u32]| {
        let length = (units.len() as u32).to_le_bytes();
        let units = units.iter().flat_map(|unit| unit.to_le_bytes());
        [0, 1, 0, 0].into_iter().chain(length).chain(units).collect::<Vec<u8>>()
    };
    let decode = |units: &[u32], width: Option<WideWidth>| {
        Decoder::new(&layout, &Want::All).with_width(width).decode(&bytes(units))
    };
    let text = |text: &str| -> Result<Value, Mismatch> { Ok(Value::Message(vec![Value::Text(text.to_owned())])) };
    let smile = u32::from('😀');
    assert_eq!(bytes(&[smile])[4..], [1, 0, 0, 0, 0x00, 0xf6, 0x01, 0x00]);
    assert_eq!(decode(&[smile], Some(WideWidth::Four)), text("😀"));
    assert_eq!(decode(&[smile], Some(WideWidth::Two)), text("\u{f600}"));
    assert_eq!(decode(&[smile], None), Err(Mismatch::Wide), "both fit");
    // With two bytes, the second character would be 0.
    assert_eq!(decode(&[u32::from('a'), smile], None), text("a😀"));
    // What ROS writes.
    assert_eq!(decode(&[0xd83d, 0xde00], None), text("😀"));
    // It is the last possible character; what follows it is none, so that only two bytes fit.
    assert_eq!(decode(&[0x10_ffff], Some(WideWidth::Four)), text("\u{10ffff}"));
    assert_eq!(decode(&[0x11_0061], Some(WideWidth::Four)), text("a"));
}

#[test]
fn values_that_do_not_fit_are_not_encoded() {
    let with = |kind: &str, value: Value| {
        let layout = layout(&format!("{kind} x"), &[("Empty", "")]).expect("a type");
        layout.encode(&Value::Message(vec![value])).map(|bytes| bytes[4..].to_vec())
    };
    let bytes = |count: usize| Value::List(vec![Value::Int(7); count]);
    assert_eq!(with("int16", Value::Int(-2)), Ok(vec![0xfe, 0xff]));
    assert_eq!(with("int8", Value::Int(128)), Err(Mismatch::Value));
    assert_eq!(with("uint64", Value::Int(-1)), Err(Mismatch::Value));
    assert_eq!(with("float32", Value::Int(1)), Err(Mismatch::Value));
    assert_eq!(with("string", Value::Passed), Err(Mismatch::Value));
    assert_eq!(with("string<=2", Value::Text("ab".to_owned())), Ok(vec![3, 0, 0, 0, b'a', b'b', 0]));
    assert_eq!(with("string<=2", Value::Text("aß".to_owned())), Err(Mismatch::Bound));
    assert_eq!(with("wstring<=1", Value::Text("😀".to_owned())), Err(Mismatch::Bound));
    assert_eq!(with("uint8[2]", bytes(2)), Ok(vec![7, 7]));
    assert_eq!(with("uint8[2]", bytes(3)), Err(Mismatch::Value));
    assert_eq!(with("uint8[<=2]", bytes(3)), Err(Mismatch::Bound));
    assert_eq!(with("uint8[]", Value::Int(7)), Err(Mismatch::Value));
    assert_eq!(with("Empty", Value::Message(Vec::new())), Ok(vec![0]));
    assert_eq!(with("Empty", Value::Message(vec![Value::Int(1)])), Err(Mismatch::Value));
}

/// A value of this type.
pub(crate) fn value(layout: &Layout) -> BoxedStrategy<Value> {
    let mut fields = Just(Vec::new()).boxed();
    for field in &layout.fields {
        let value = of_type(&field.kind);
        fields = (fields, value).prop_map(|(fields, value)| [fields, vec![value]].concat()).boxed();
    }
    fields.prop_map(Value::Message).boxed()
}

fn of_type(kind: &Type<Arc<Layout>>) -> BoxedStrategy<Value> {
    let item = match &kind.base {
        Base::Message(layout) => value(layout),
        Base::Primitive(Primitive::Bool) => any::<bool>().prop_map(Value::Bool).boxed(),
        Base::Primitive(Primitive::Float32) => any::<f32>().prop_map(|number| Value::Real(number.into())).boxed(),
        Base::Primitive(Primitive::Float64) => any::<f64>().prop_map(Value::Real).boxed(),
        Base::Primitive(Primitive::String(bound) | Primitive::WString(bound)) => {
            let letters = format!("[a-z\\u{{0}}]{{0,{}}}", bound.unwrap_or(9));
            proptest::string::string_regex(&letters).expect("an expression").prop_map(Value::Text).boxed()
        }
        Base::Primitive(integer) => {
            let (least, greatest) = integer.range().expect("the others are integers");
            (least..=greatest).prop_map(Value::Int).boxed()
        }
    };
    let sizes = match kind.count {
        Count::One => return item,
        Count::Exactly(count) => count..=count,
        Count::UpTo(bound) => 0..=bound,
        Count::Any => 0..=4,
    };
    prop::collection::vec(item, sizes).prop_map(Value::List).boxed()
}

/// A message type, with messages in it.
fn types() -> impl Strategy<Value = Arc<Layout>> {
    (random::message(), random::message()).prop_map(|(outer, mut inner)| {
        inner.fields.retain(|field| matches!(field.kind.base, Base::Primitive(_)));
        let name = TypeName::new(Some("some_msgs"), "Random");
        Layout::resolve(&name, &mut |of| Ok(if *of == name { outer.clone() } else { inner.clone() }))
            .expect("all types are defined")
    })
}

proptest! {
    /// With the width of its distribution, any message is decoded; without it, only if there is no other reading.
    #[test]
    fn wide_strings_of_both_widths_are_decoded_or_refused((layout, message) in types().prop_flat_map(|layout| (Just(layout.clone()), value(&layout)))) {
        for width in [WideWidth::Two, WideWidth::Four] {
            let bytes = layout.encode_with(width, &message).expect("it is a message of that type");
            let decoder = Decoder::new(&layout, &Want::All);
            let decoded = decoder.clone().with_width(Some(width)).decode(&bytes);
            prop_assert_eq!(format!("{decoded:?}"), format!("Ok({message:?})"));
            match decoder.decode(&bytes) {
                // Of a string with a zero, another reading may have none.
                Ok(decoded) => {
                    let [decoded, message] = [decoded, message.clone()].map(|value| format!("{value:?}"));
                    prop_assert!(decoded == message || message.contains("\\0"), "{decoded} and not {message}");
                }
                Err(mismatch) => {
                    let other = if width == WideWidth::Two { WideWidth::Four } else { WideWidth::Two };
                    let other = decoder.with_width(Some(other)).decode(&bytes);
                    prop_assert!(mismatch == Mismatch::Wide && layout.has_wide_strings() && other.is_ok());
                }
            }
        }
    }

    #[test]
    fn what_is_encoded_is_decoded_again((layout, message) in types().prop_flat_map(|layout| (Just(layout.clone()), value(&layout)))) {
        let bytes = layout.encode(&message).expect("it is a message of that type");
        // Debug text, since NaN differs from itself.
        let decoder = Decoder::new(&layout, &Want::All).with_width(Some(WideWidth::Four));
        let decoded = decoder.decode(&bytes).expect("it is a message");
        prop_assert_eq!(format!("{decoded:?}"), format!("{message:?}"));
        prop_assert_eq!(Decoder::new(&layout, &Want::Nothing).decode(&bytes), Ok(Value::Message(vec![Value::Passed; layout.fields.len()])));
        // Without its last byte, it is not a message of that type.
        if !layout.has_wide_strings() {
            prop_assert_eq!(Decoder::new(&layout, &Want::Nothing).decode(&bytes[..bytes.len() - 1]), Err(Mismatch::Short));
        }
    }
}
