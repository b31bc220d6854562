//! ROS definitions: their meaning, and the messages about their mistakes.

use ros_messages::{Action, Base, Bundle, Count, Message, Primitive, Service, Type, TypeName, Value};

fn message(text: &str) -> Message {
    Message::parse("Test.msg", text).unwrap_or_else(|problems| panic!("{}", problems.plain()))
}

fn problems(text: &str) -> String {
    Message::parse("Test.msg", text).expect_err("a definition with mistakes").plain()
}

fn defaults(text: &str) -> Vec<Value> {
    message(text).fields.into_iter().map(|field| field.default.expect("a default value")).collect()
}

fn text(text: &str) -> Value {
    Value::Text(text.to_owned())
}

#[test]
fn every_ros_type_is_read() {
    let simple = "bool byte char int8 uint8 int16 uint16 int32 uint32 int64 uint64 float32 float64 string wstring";
    for name in simple.split(' ') {
        for (count, printed) in
            [(Count::One, ""), (Count::Any, "[]"), (Count::Exactly(3), "[3]"), (Count::UpTo(5), "[<=5]")]
        {
            let read = message(&format!("{name}{printed} x"));
            assert_eq!(read.fields[0].kind.count, count);
            assert_eq!(read.fields[0].kind.to_string(), format!("{name}{printed}"));
        }
    }
    let kinds = message("string<=10[<=3] a\nwstring<=4 b\nPose c\ngeometry_msgs/Pose[2] d\ngeometry_msgs/msg/Pose e\n");
    let kinds: Vec<Type> = kinds.fields.into_iter().map(|field| field.kind).collect();
    let pose = |package| Base::Message(TypeName::new(package, "Pose"));
    assert_eq!(kinds[0], Type { base: Base::Primitive(Primitive::String(Some(10))), count: Count::UpTo(3) });
    assert_eq!(kinds[1], Type { base: Base::Primitive(Primitive::WString(Some(4))), count: Count::One });
    assert_eq!(kinds[2], Type { base: pose(None), count: Count::One });
    assert_eq!(kinds[3], Type { base: pose(Some("geometry_msgs")), count: Count::Exactly(2) });
    assert_eq!(kinds[4], Type { base: pose(Some("geometry_msgs")), count: Count::One });
    let stamped = message("time t\nduration d\n");
    assert_eq!(stamped, message("builtin_interfaces/Time t\nbuiltin_interfaces/Duration d\n"));
}

#[test]
fn comments_spaces_and_line_ends_are_ignored() {
    let read = message("# all\r\n\r\n  int8   x \t 5# the first\r\n\tint8 A = 3 # a constant\r\n#\r\n");
    assert_eq!(read, message("int8 A=3\nint8 x 5"));
    assert_eq!(message("# nothing\n"), Message::default());
}

#[test]
fn annotations_come_before_their_field() {
    let read = message("@optional int8 a\n@key\n# which\n@optional\nstring b x @key\nint8 c\n");
    let marks: Vec<(bool, bool)> = read.fields.iter().map(|field| (field.is_optional, field.is_key)).collect();
    assert_eq!(marks, [(true, false), (true, true), (false, false)]);
    assert_eq!(read.fields[1].default, Some(text("x @key")));
    assert_eq!(message(&read.to_string()), read);
    insta::assert_snapshot!(problems("@kay int8 a\n@key @key int8 b\n@key\nint8 A=1\n@optional\n"));
}

#[test]
fn values_are_read_as_in_ros() {
    let integers =
        "int32 a -200\nuint64 b 18446744073709551615\nint64 c -9223372036854775808\nbyte d 0xff\nint8 e 0b1_0\n";
    let expected = [-200, i128::from(u64::MAX), i128::from(i64::MIN), 255, 2].map(Value::Int);
    assert_eq!(defaults(integers), expected);
    assert_eq!(defaults("bool a True\nbool b 0\n"), [true, false].map(Value::Bool));
    assert_eq!(defaults("float32 a 1\nfloat64 b -1.5e3\nfloat64 c .5\n"), [1.0, -1500.0, 0.5].map(Value::Real));
    assert_eq!(defaults("float32 a 1_000.2_5\nfloat64 b 1_0e1_0\n"), [1000.25, 1e11].map(Value::Real));
    assert_eq!(defaults("float64 a inf\n"), [Value::Real(f64::INFINITY)]);
    let texts =
        "string a two words\nstring b \"it's\"\nstring c 'a\\'b'\nstring d \"\"\nstring e \"a = b\"\nwstring f ü\n";
    assert_eq!(defaults(texts), ["two words", "it's", "a'b", "", "a = b", "ü"].map(text));
    let arrays = "int8[] a []\nint8[2] b [1, -2]\nstring[<=3] c ['a, b', \"c\", d e]\nbool[] d [true,0]\n";
    let items = |items: &[Value]| Value::List(items.to_vec());
    let expected = [
        items(&[]),
        items(&[1, -2].map(Value::Int)),
        items(&["a, b", "c", "d e"].map(text)),
        items(&[true, false].map(Value::Bool)),
    ];
    assert_eq!(defaults(arrays), expected);
    let constants =
        message("string NAME=with spaces\nchar LETTER = 65\nstring QUOTED=' x '\nstring EMPTY=\n").constants;
    let values: Vec<Value> = constants.into_iter().map(|constant| constant.value).collect();
    assert_eq!(values, [text("with spaces"), Value::Int(65), text(" x "), text("")]);
    // As rosidl_adapter of Jazzy reads them.
    let hashes =
        message("string A=\"a # b\"\nstring B='x#y'  # comment\nstring C=a # b\nstring D=say \"a # b\"\n").constants;
    let values: Vec<Value> = hashes.into_iter().map(|constant| constant.value).collect();
    assert_eq!(values, ["\"a", "'x", "a", "say \"a"].map(text));
}

#[test]
fn services_and_actions_have_their_parts_in_order() {
    let service = Service::parse("S.srv", "int8 a\n---  # the reply\nint8 b\n").unwrap();
    assert_eq!((service.request, service.response), (message("int8 a"), message("int8 b")));
    let action = Action::parse("A.action", "int8 a\n---\nint8 b\n---\nint8 c").unwrap();
    assert_eq!(
        (action.goal, action.result, action.feedback),
        (message("int8 a"), message("int8 b"), message("int8 c"))
    );
    assert_eq!(Service::parse("S.srv", "---").unwrap(), Service::default());
    let problem = |problems: diagnostics::FileProblems| problems.plain();
    assert_eq!(
        problem(Service::parse("S.srv", "int8 a\n").unwrap_err()),
        "S.srv:2:1: a response is missing (the parts are a request, a response, in this order, with a line `---` between \
         them)\n"
    );
    assert_eq!(
        problem(Action::parse("A.action", "---").unwrap_err()),
        "A.action:1:4: a feedback is missing (the parts are a goal, a result, a feedback, in this order, with a line \
         `---` between them)\n"
    );
    assert_eq!(
        problem(Message::parse("M.msg", "---\nint8 a\n---\n").unwrap_err()),
        "M.msg:1:1: nothing follows this separator (a `.msg` file has one part; a `.srv` file has two, an \
         `.action` file three)\n"
    );
}

#[test]
fn all_mistakes_in_a_definition_are_reported_at_once() {
    let text = "\
int8
flaot32 x
float64 X
float64 a__b
float64 b_
int8 x_1
int8 x_1
int8 lower=3
Pose POSE=3
string<=3 S=abc
int8[2] ARRAY=[1, 2]
int8 TOO_BIG=128
uint8 below -1
bool maybe perhaps
float32 number 1,5
string<=3 long abcd
string open \"abc # d\"
string inner \"a\"b\"
int8[2] three [1, 2, 3]
int8[<=2] many [1,2,3]
int8[] list 1, 2
int8[] holes [1,,2]
Pose pose 3
int8[0] none
int8[-1] less
int8[<=] up
string<=0 s
string<=x t
a/b/c/D d
geometry_msgs/pose small
Geometry/Pose large
int8] bracket
int32<=5 bounded
int8 hex 0x
int8 under 1__0
string[] gone [a,]
Pose[] poses []
float32 grouped _1
";
    insta::assert_snapshot!(problems(text));
}

#[test]
fn a_bundle_has_all_types_of_a_message() {
    let rule = "=".repeat(80);
    let text =
        format!("A a\n\n{rule}\nMSG: p/A\nq/B b\n{rule}\n# next\nMSG: q/msg/B\n{rule}\nMSG: q/C\n@key\nint8 x\n");
    let bundle = Bundle::parse("p/msg/Test", &text).unwrap();
    assert_eq!(bundle.message, message("A a"));
    let types: Vec<(String, Message)> =
        bundle.types.iter().map(|(name, message)| (name.to_string(), message.clone())).collect();
    assert_eq!(types[0], ("p/A".to_owned(), message("q/B b")));
    assert_eq!(types[1], ("q/B".to_owned(), Message::default()));
    assert_eq!(types[2], ("q/C".to_owned(), message("@key int8 x")));
    assert_eq!(Bundle::parse("printed", &bundle.to_string()).unwrap(), bundle);
    let text = "A a\n===\nIDL: p/A\nint x\n===\nint8 x\n===\nMSG: B\n===\nMSG: q/B\n@key\n===\nMSG: q/B\n";
    insta::assert_snapshot!(Bundle::parse("p/msg/Test", text).unwrap_err().plain());
}

/// The definition that rosidl generates for a message, combined with hand-written lines.
const IDL: &str = r#"================================================================================
IDL: arm_msgs/msg/Grip
// generated from rosidl_adapter/resource/msg.idl.em
#include "geometry_msgs/msg/Pose.idl"

module arm_msgs {
  module msg {
    typedef double double__36[36];
    module Grip_Constants {
      @verbatim (language="comment", text=
        "how (not) to" "\n" "hold")
      const uint8 SOFT = 1;
      const string NAME = "gr" "ip";
      const double LIMIT = -1.5e3;
    };
    enum Side { LEFT, RIGHT };
    struct Grip {
      @default (value=3)
      @unit (value="N")
      unsigned long force;
      geometry_msgs::msg::Pose pose;
      double__36 covariance;
      sequence<string<8>, 4> names;
      sequence<arm_msgs::msg::Finger> fingers;
      long long a, b[2];
      Side side;
      octet raw; /* one byte */ wstring text;
    };
  };
};
================================================================================
IDL: arm_msgs/msg/Finger
module arm_msgs { module msg { struct Finger { boolean is_bent; }; }; };
"#;

#[test]
fn idl_is_equivalent_to_the_definition_that_it_was_generated_from() {
    let name = |name| TypeName::new(Some("arm_msgs"), name);
    let read = Bundle::parse_idl(&name("Grip"), IDL).unwrap_or_else(|problems| panic!("{}", problems.plain()));
    let same = message(
        "uint8 SOFT=1\nstring NAME=grip\nfloat64 LIMIT=-1500\nuint32 force\ngeometry_msgs/Pose pose\nfloat64[36] covariance\n\
         string<=8[<=4] names\narm_msgs/Finger[] fingers\nint64 a\nint64[2] b\nuint32 side\nbyte raw\nwstring text\n",
    );
    assert_eq!(read.message, same);
    assert_eq!(read.types, [(name("Finger"), message("bool is_bent"))]);
}

#[test]
fn broken_idl_is_refused_with_its_location() {
    let name = TypeName::new(Some("a"), "B");
    let problems = |text: &str| Bundle::parse_idl(&name, text).expect_err("broken IDL").plain();
    let of_fields = |fields: &str| problems(&format!("module a {{ module msg {{\nstruct B {{\n{fields}\n}}; }}; }};"));
    insta::assert_snapshot!(
        [
            problems(""),
            problems("module a { struct C { long x; };"),
            problems("union B switch (long) {};"),
            of_fields("long double x;"),
            of_fields("sequence<sequence<long>> x;"),
            of_fields("long x[many];"),
            of_fields("@default (value=\"x long y;"),
            of_fields("long x"),
        ]
        .concat()
    );
    // However it is cut off, the result is an error or a definition, never a panic.
    for end in (0..IDL.len()).filter(|end| IDL.is_char_boundary(*end)) {
        let _ = Bundle::parse_idl(&TypeName::new(Some("arm_msgs"), "Grip"), &IDL[..end]);
    }
}

#[test]
fn services_and_actions_have_the_messages_that_ros_sends() {
    let service = Service::parse("Set.srv", "bool on\n---\nstring why\n").expect("a service");
    let [request, response, event] = service.messages("Set");
    assert_eq!((request.0.as_str(), request.1.to_string()), ("Set_Request", "bool on\n".to_owned()));
    assert_eq!(response.0, "Set_Response");
    assert_eq!((event.0.as_str(), event.1.fields[1].kind.to_string()), ("Set_Event", "Set_Request[<=1]".to_owned()));
    let action = Action::parse("Go.action", "int8 to\n---\nbool done\n---\nfloat32 left\n").expect("an action");
    let messages = action.messages("Go");
    let names: Vec<&str> = messages.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(
        names.join(" "),
        "Go_Goal Go_Result Go_Feedback Go_FeedbackMessage Go_SendGoal_Request Go_SendGoal_Response Go_SendGoal_Event \
         Go_GetResult_Request Go_GetResult_Response Go_GetResult_Event"
    );
    assert_eq!(messages[3].1.to_string(), "unique_identifier_msgs/UUID goal_id\nGo_Feedback feedback\n");
    assert_eq!(messages[8].1.to_string(), "int8 status\nGo_Result result\n");
}
