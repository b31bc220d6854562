//! Random definitions.

use proptest::collection::{btree_map, vec};
use proptest::option;
use proptest::prelude::*;
use proptest::strategy::Union;
use ros_messages::{Action, Base, Bundle, Constant, Count, Field, Message, Primitive, Service, Type, TypeName, Value};

/// Letters that occur in definitions, and some others that must be tolerated.
const LETTERS: &str = "[ -~\\n\\t\\r#=@\"'\\\\\\[\\]<>ü€\u{0}]{0,200}";

fn primitive() -> impl Strategy<Value = Primitive> {
    let names = "bool byte char int8 uint8 int16 uint16 int32 uint32 int64 uint64 float32 float64 string wstring";
    let primitive =
        |name: &str| match Message::parse("a type", &format!("{name} x")).expect("a field").fields[0].kind.base {
            Base::Primitive(primitive) => primitive,
            Base::Message(_) => unreachable!("these are not messages"),
        };
    prop::sample::select(names.split(' ').map(primitive).collect::<Vec<_>>())
}

fn base() -> impl Strategy<Value = Base> {
    let bound = 1_usize..9;
    let name = (option::of("[a-z](_?[a-z0-9]){0,3}"), "[A-Z][A-Za-z0-9]{0,5}");
    prop_oneof![
        4 => primitive().prop_map(Base::Primitive),
        1 => bound.clone().prop_map(|bound| Base::Primitive(Primitive::String(Some(bound)))),
        1 => bound.prop_map(|bound| Base::Primitive(Primitive::WString(Some(bound)))),
        2 => name.prop_map(|(package, name)| Base::Message(TypeName::new(package.as_deref(), &name))),
    ]
}

fn count() -> impl Strategy<Value = Count> {
    prop_oneof![
        Just(Count::One),
        (1_usize..4).prop_map(Count::Exactly),
        (1_usize..4).prop_map(Count::UpTo),
        Just(Count::Any),
    ]
}

/// A value of one item of this type. Strings contain only what ROS can write.
fn value(kind: Primitive) -> BoxedStrategy<Value> {
    if let Some((least, greatest)) = kind.range() {
        return (least..=greatest).prop_map(Value::Int).boxed();
    }
    let letters = "[ !-\"$-~ü€\\\\'\"]";
    let text = |most: usize| {
        let text = proptest::string::string_regex(&format!("{letters}{{0,{most}}}")).expect("an expression");
        text.prop_map(|text| Value::Text(text.trim_end_matches('\\').to_owned())).boxed()
    };
    match kind {
        Primitive::Bool => any::<bool>().prop_map(Value::Bool).boxed(),
        Primitive::Float32 | Primitive::Float64 => {
            let finite = any::<f64>().prop_filter("NaN differs from itself", |number| !number.is_nan());
            finite.prop_map(Value::Real).boxed()
        }
        Primitive::String(bound) | Primitive::WString(bound) => text(bound.unwrap_or(12)),
        _ => unreachable!("the others are integers"),
    }
}

fn default(kind: &Type) -> BoxedStrategy<Option<Value>> {
    let Base::Primitive(primitive) = kind.base else { return Just(None).boxed() };
    let sizes = match kind.count {
        Count::One => return option::of(value(primitive)).boxed(),
        Count::Exactly(count) => count..=count,
        Count::UpTo(count) => 0..=count,
        Count::Any => 0..=4,
    };
    option::of(vec(value(primitive), sizes).prop_map(Value::List)).boxed()
}

fn field() -> impl Strategy<Value = Field> {
    let kind = (base(), count()).prop_map(|(base, count)| Type { base, count });
    let with_default = kind.prop_flat_map(|kind| (default(&kind), Just(kind)));
    (with_default, any::<bool>(), any::<bool>()).prop_map(|((default, kind), is_optional, is_key)| Field {
        default,
        is_optional,
        is_key,
        ..Field::new("", kind)
    })
}

fn constant() -> impl Strategy<Value = Constant> {
    let valued = primitive().prop_flat_map(|kind| (value(kind), Just(kind)));
    valued.prop_map(|(value, kind)| Constant { name: String::new(), kind, value })
}

pub(crate) fn message() -> impl Strategy<Value = Message> {
    let constants = btree_map("[A-Z](_?[A-Z0-9]){0,4}", constant(), 0..4);
    let fields = btree_map("[a-z](_?[a-z0-9]){0,4}", field(), 0..5);
    (constants, fields).prop_map(|(constants, fields)| Message {
        constants: constants.into_iter().map(|(name, constant)| Constant { name, ..constant }).collect(),
        fields: fields.into_iter().map(|(name, field)| Field { name, ..field }).collect(),
    })
}

/// Lines that are almost a definition: words of definitions in any order.
fn almost() -> impl Strategy<Value = String> {
    let words = [
        "int8",
        "string",
        "string<=3",
        "[3]",
        "[<=2]",
        "[]",
        "[",
        "]",
        "a",
        "b_c",
        "A",
        "=",
        "3",
        "-1",
        "0x1F",
        "\"",
        "'",
        "'x'",
        "[1, 2]",
        ",",
        "#",
        "---",
        "\n",
        " ",
        "\t",
        "geometry_msgs/Pose",
        "Pose",
        "/",
        "@key",
        "@optional",
        "@",
        "ü",
        "1e5",
        "true",
        "\\",
        "\r\n",
    ];
    let word = Union::new(words.map(Just));
    vec(word, 0..60).prop_map(|words| words.concat())
}

proptest! {
    #[test]
    fn what_is_printed_can_be_read_again(request in message(), response in message(), feedback in message()) {
        let action = Action { goal: request.clone(), result: response.clone(), feedback };
        prop_assert_eq!(&Action::parse("printed", &action.to_string()).unwrap(), &action);
        prop_assert_eq!(&Message::parse("printed", &request.to_string()).unwrap(), &request);
        let service = Service { request, response };
        prop_assert_eq!(&Service::parse("printed", &service.to_string()).unwrap(), &service);
    }

    #[test]
    fn a_printed_bundle_can_be_read_again(message in message(), types in btree_map("[A-Z][a-z]{0,3}", message(), 0..4)) {
        let types = types.into_iter().map(|(name, message)| (TypeName::new(Some("some_msgs"), &name), message)).collect();
        let bundle = Bundle { message, types };
        prop_assert_eq!(Bundle::parse("printed", &bundle.to_string()).unwrap(), bundle);
    }

    #[test]
    fn comments_and_spaces_change_nothing(message in message(), comment in "[ -~]{0,20}") {
        let spread = message.to_string().replace('\n', &format!("\t # {comment}\r\n\n"));
        prop_assert_eq!(Message::parse("spread", &spread).unwrap(), message);
    }

    #[test]
    fn any_text_is_either_read_or_refused(text in prop_oneof![LETTERS.prop_map(|text| text), almost()]) {
        let read = Message::parse("a text", &text);
        let again = read.as_ref().map(|message| Message::parse("printed", &message.to_string()).unwrap());
        // Debug text, since NaN differs from itself.
        prop_assert_eq!(again.ok().map(|message| format!("{message:?}")), read.ok().map(|message| format!("{message:?}")));
        let _ = Service::parse("a text", &text);
        let _ = Action::parse("a text", &text);
        let _ = Bundle::parse("a text", &text.replace("---", "===\nMSG: a/B"));
    }
}
