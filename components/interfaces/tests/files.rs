//! Interface files: their meaning, and the messages about their mistakes.

use std::collections::BTreeMap;
use std::io;
use std::path::Path;

use channels::{FieldKind, Symbol};
use diagnostics::Error;
use interfaces::{Field, Interface, Operation};

/// Loads `robot/arm.toml` from these files.
fn load<const N: usize>(files: [(&str, &str); N]) -> Result<Interface, Error> {
    let files = BTreeMap::from(files);
    let read = |path: &Path| {
        let text = files.get(path.to_str().expect("a path in letters"));
        text.map(|text| text.as_bytes().to_vec()).ok_or_else(|| io::ErrorKind::NotFound.into())
    };
    Interface::load(Path::new("robot/arm.toml"), &["Dock", "Kitchen"].map(Symbol::new), &read)
}

fn alone(text: &str) -> Result<Interface, Error> {
    load([("robot/arm.toml", text)])
}

/// All problems, one line each.
fn problems<const N: usize>(files: [(&str, &str); N]) -> String {
    match load(files) {
        Err(Error::Problems(problems)) => problems.plain(),
        other => panic!("{other:?}"),
    }
}

fn shapes(interface: &Interface) -> String {
    let to = interface.requests();
    let from = interface.replies().expect("replies that can be distinguished");
    let line = |arrow: &str, shape: &channels::Shape| format!("{arrow} {shape}\n");
    to.iter().map(|shape| line("→", shape)).chain(from.iter().map(|shape| line("←", shape))).collect()
}

fn fields(fields: &[Field]) -> Vec<String> {
    fields.iter().map(|field| format!("{}: {}", field.name, field.kind)).collect()
}

#[test]
fn each_operation_has_its_messages() {
    let interface = alone(
        r#"
        [services.say]
        request = { text = "text" }
        reply = { seconds = "real" }
        [services.hush]
        [topics.spoken]
        fields = { text = "text" }
        [actions.pick]
        goal = { object = ["cup", "box"], at = "place?" }
        feedback = { height_m = "real" }
        result = { weight_kg = "real" }
        "#,
    )
    .unwrap();
    insta::assert_snapshot!(shapes(&interface));
}

#[test]
fn fields_and_operations_keep_the_order_of_the_file() {
    let interface =
        alone("services.b.request = { z = 'int', a = 'bool', m = ['x', '?'] }\nservices.a.reply = { one = 'real?' }\n")
            .unwrap();
    let names: Vec<&str> = interface.services.iter().map(|service| service.name.as_str()).collect();
    assert_eq!(names, ["b", "a"]);
    assert_eq!(fields(&interface.services[0].request), ["z: int", "a: bool", "m: <x> | <none>"]);
    assert_eq!(interface.services[1].reply[0].kind, FieldKind::Optional(Box::new(FieldKind::Real)));
}

#[test]
fn a_client_sees_only_what_it_uses() {
    let text = "services.level.reply = { pct = 'real' }\nservices.current.reply = { amperes = 'real' }\n\
                topics.full = {}\nactions.charge = {}\n";
    let interface = alone(text).unwrap();
    let part = interface.restricted_to(|operation| match operation {
        Operation::Service(service) => service.name == "current",
        Operation::Topic(_) => true,
        Operation::Action(_) => false,
    });
    insta::assert_snapshot!(shapes(&part), @r"
    → [request: <current>]
    ← [status: <ok>, amperes: real]
    ← [status: <error>, reason: text]
    ← [topic: <full>]
    ");
    let problem = interface.replies().unwrap_err();
    assert_eq!(
        problem.one_line(),
        "a reply of `level`, with `pct`, looks like one of `current`, with `amperes` (give the fields the same names in \
         both, such as `value`, or let no client use both services)"
    );
}

#[test]
fn replies_with_different_names_are_distinguished_by_their_kinds() {
    let are_distinct = |one: &str, other: &str| {
        let text = format!("services.a.reply = {{ one = {one} }}\nservices.b.reply = {{ other = {other} }}\n");
        alone(&text).unwrap().replies().is_ok()
    };
    assert!(are_distinct("'int'", "'real'"));
    assert!(are_distinct("['x', 'y']", "['z']"));
    assert!(!are_distinct("['x', 'y']", "['y', 'z']"));
    assert!(!are_distinct("'int?'", "'real?'"));
    assert!(!are_distinct("'int?'", "'int'"));
    assert!(!are_distinct("'int?'", "['none']"));
    assert!(!are_distinct("['x', '?']", "['z', 'none']"));
    assert!(are_distinct("'int?'", "['some']"));
    let one = alone("services.a.reply = { one = 'real', x = 'int' }\nservices.b.reply = { other = 'real' }\n").unwrap();
    assert!(one.replies().is_ok());
}

#[test]
fn the_components_of_the_program_have_interfaces_too() {
    let at_place = |name: &str| {
        let state = r#"["running", "success", "failure", "stopped", "idle"]"#;
        format!("[services.{name}]\nrequest = {{ place = 'place' }}\nreply = {{ state = {state} }}\n")
    };
    let navigation = alone(&["start_navigation", "get_status", "stop_navigation"].map(at_place).concat()).unwrap();
    let battery =
        "services.get_level.reply = { level = 'real' }\nservices.get_charging.reply = { charging = 'bool' }\n";
    insta::assert_snapshot!(shapes(&navigation) + &shapes(&alone(battery).unwrap()));
}

#[test]
fn all_mistakes_in_a_file_are_reported_at_once() {
    let text = r#"
        [services.goal]
        request = { text = "texxt", request = "int", 2nd = "int", flag = [], list = ["a", "a", "b c", 3], last = 4 }
        reply = ["a"]
        replay = {}
        [services."big talk"]
        reply = { status = "text?" }
        [topics.ok]
        fields = { none = ["none", "?"], where = "Place" }
        [actions.ok]
        goal = { request = "text" }
        [action.pick]
    "#;
    insta::assert_snapshot!(problems([("robot/arm.toml", text)]));
}

#[test]
fn the_kind_place_requires_places() {
    let read = |_: &Path| Ok(b"services.go.request = { to = 'place' }".to_vec());
    let error = Interface::load(Path::new("go.toml"), &[], &read).unwrap_err();
    let Error::Problems(problems) = error else { panic!("{error}") };
    assert_eq!(
        problems.plain(),
        "go.toml:1:30: `place` is one of the scenario's places, but the scenario has none (give the scenario a file of `places`, or \
         list the symbols: `[\"Kitchen\", \"Dock\"]`)\n"
    );
}

const POSE: &str = "Point position\nfloat64[4] orientation\n";
const POINT: &str = "float64 x\nfloat64 y\n";

#[test]
fn definitions_of_ros_become_flat_fields() {
    let text = r#"
        [services.set_mode]
        ros = "my_msgs/srv/SetMode.srv"
        [topics.where]
        ros = "geometry_msgs/msg/Pose.msg"
        [actions.go]
        ros = "my_msgs/action/Go.action"
    "#;
    let interface = load([
        ("robot/arm.toml", text),
        ("robot/my_msgs/srv/SetMode.srv", "uint8 AUTO=1\nuint8 mode\nstring<=5[<=2] why\n---\nbool success\n"),
        (
            "robot/my_msgs/action/Go.action",
            "geometry_msgs/Pose to\nwstring how\n---\n---\nbuiltin_interfaces/Duration left\n",
        ),
        ("robot/geometry_msgs/msg/Pose.msg", POSE),
        ("robot/geometry_msgs/msg/Point.msg", POINT),
    ]);
    insta::assert_snapshot!(shapes(&interface.unwrap()));
}

#[test]
fn common_types_need_no_files_unless_distributions_differ() {
    let text = "[topics.where]\nros = 'geometry_msgs/msg/PoseStamped.msg'\nfields = ['pose.position', 'header.stamp']\n\
                [services.stop]\nros = 'std_srvs/srv/SetBool.srv'\n[topics.own]\nros = 'x/msg/Own.msg'\n";
    let own = ("robot/x/msg/Own.msg", "geometry_msgs/Twist twist\n");
    let interface = load([("robot/arm.toml", text), own]).unwrap();
    assert_eq!(fields(&interface.services[0].request), ["data: bool"]);
    let stamped = ["pose_position_x: real", "pose_position_y: real", "pose_position_z: real"];
    assert_eq!(fields(&interface.topics[0].fields)[..3], stamped);
    assert_eq!(interface.topics[1].fields.len(), 6);
    // A file has precedence, also over a type in a type on board.
    let overridden = load([("robot/arm.toml", text), own, ("robot/geometry_msgs/msg/Point.msg", "int8 x\n")]).unwrap();
    assert_eq!(fields(&overridden.topics[0].fields)[..2], ["pose_position_x: int", "header_stamp_sec: int"]);
    let text = "[topics.ahead]\nros = 'sensor_msgs/msg/Range.msg'\n";
    assert!(problems([("robot/arm.toml", text)]).contains("there is no such definition"));
}

#[test]
fn a_file_selects_and_renames_fields_of_a_definition() {
    let text = r#"
        [topics.scan]
        ros = "sensor_msgs/msg/Scan.msg"
        fields = ["range_max", "ranges[3]", "at.position", "at.orientation[2]"]
        [topics.pose]
        ros = "sensor_msgs/msg/Scan.msg"
        fields = { max_m = "range_max", spot = "at.position", turn = "at.orientation[3]", state = "status" }
    "#;
    let scan = "std_msgs/Header header\nfloat32 range_max\nfloat32[] ranges\ngeometry_msgs/Pose at\nint8 status\n";
    let interface = load([
        ("robot/arm.toml", text),
        ("robot/sensor_msgs/msg/Scan.msg", scan),
        ("robot/geometry_msgs/msg/Pose.msg", POSE),
        ("robot/geometry_msgs/msg/Point.msg", POINT),
    ]);
    let interface = interface.unwrap();
    let names = ["range_max: real", "ranges_3: real | <none>", "at_position_x: real", "at_position_y: real"];
    assert_eq!(fields(&interface.topics[0].fields)[..4], names);
    assert_eq!(fields(&interface.topics[0].fields)[4], "at_orientation_2: real");
    let names = ["max_m: real", "spot_x: real", "spot_y: real", "turn: real", "state: int"];
    assert_eq!(fields(&interface.topics[1].fields), names);
}

#[test]
fn a_text_of_a_definition_can_be_one_of_several_symbols() {
    let text = r#"
        [services.get_state]
        ros = "std_srvs/srv/Trigger.srv"
        reply = { state = { path = "message", symbols = ["open", "closed"] }, done = "success" }
        [topics.states]
        ros = "x/msg/States.msg"
        fields = { last = { path = "names[0]", symbols = ["open", "closed"] } }
    "#;
    let interface = load([("robot/arm.toml", text), ("robot/x/msg/States.msg", "string[] names")]).unwrap();
    assert_eq!(fields(&interface.services[0].reply), ["state: <open> | <closed>", "done: bool"]);
    assert_eq!(fields(&interface.topics[0].fields), ["last: <open> | <closed> | <none>"]);
    let wrong = r#"
        [topics.told]
        ros = "x/msg/Told.msg"
        [topics.told.fields]
        c = { path = "text", symbols = [] }
        d = { path = "text", symbols = ["one", "?"] }
        e = { path = "text", symbols = "one" }
        f = { path = "text" }
        g = { symbols = ["one"] }
        h = { path = "text", symbol = ["one"], symbols = ["one"] }
    "#;
    let elsewhere = r#"
        [topics.told]
        ros = "x/msg/Told.msg"
        [topics.told.fields]
        a = { path = "number", symbols = ["one"] }
        b = { path = "texts[]", symbols = ["one"] }
        c = { path = "both", symbols = ["one"] }
    "#;
    let told = "int8 number\nstring text\nstring[] texts\nBoth both\n";
    let both = "string one\nstring other\n";
    let both = [wrong, elsewhere].map(|text| {
        problems([("robot/arm.toml", text), ("robot/x/msg/Told.msg", told), ("robot/x/msg/Both.msg", both)])
    });
    insta::assert_snapshot!(both.concat());
}

#[test]
fn arrays_become_lists() {
    let text = r#"
        [topics.scan]
        ros = "x/msg/Scan.msg"
        [topics.some]
        ros = "x/msg/Scan.msg"
        fields = { six = "six[]", deep = "inner[0].deep[]", first = "inner[].point[0]" }
        [topics.own]
        fields = { ranges = "real[]" }
    "#;
    let interface = load([
        ("robot/arm.toml", text),
        ("robot/x/msg/Scan.msg", "float32[] ranges\nint8[6] six\nInner[] inner\n"),
        ("robot/x/msg/Inner.msg", "string name\nint8[2] point\nbool[<=9] deep"),
    ]);
    let interface = interface.unwrap();
    let names = ["ranges: list of real", "six_0: int", "six_1: int"];
    assert_eq!(fields(&interface.topics[0].fields)[..3], names);
    let inner = ["inner_name: list of text", "inner_point_0: list of int", "inner_point_1: list of int"];
    assert_eq!(fields(&interface.topics[0].fields)[7..10], inner);
    let some = ["six: list of int", "deep: list of bool", "first: list of int"];
    assert_eq!(fields(&interface.topics[1].fields), some);
    assert_eq!(fields(&interface.topics[2].fields), ["ranges: list of real"]);
}

#[test]
fn packages_are_searched_beside_above_and_where_the_file_says() {
    let text = "packages = ['/opt/ros/share']\n[topics.a]\nros = 'ros/nav/nav_msgs/msg/A.msg'\n\
                [topics.b]\nros = 'std_msgs/msg/B.msg'\n[topics.alone]\nros = 'Alone.msg'\n";
    let interface = load([
        ("robot/arm.toml", text),
        ("robot/ros/nav/nav_msgs/msg/A.msg", "beside_msgs/X a\nabove_msgs/X b\ntop_msgs/X c\nfar_msgs/X d\nX own\n"),
        ("robot/ros/nav/nav_msgs/msg/X.msg", "int8 own"),
        ("robot/ros/nav/beside_msgs/msg/X.msg", "int8 beside"),
        ("robot/ros/above_msgs/msg/X.msg", "int8 above"),
        ("robot/top_msgs/msg/X.msg", "int8 top"),
        ("/opt/ros/share/far_msgs/msg/X.msg", "Y y"),
        ("/opt/ros/share/far_msgs/msg/Y.msg", "int8 far"),
        ("/opt/ros/share/std_msgs/msg/B.msg", "int8 b"),
        ("robot/Alone.msg", "Neighbor n"),
        ("robot/Neighbor.msg", "int8 x"),
    ]);
    let interface = interface.unwrap();
    let names = ["a_beside: int", "b_above: int", "c_top: int", "d_y_far: int", "own_own: int"];
    assert_eq!(fields(&interface.topics[0].fields), names);
    assert_eq!(fields(&interface.topics[1].fields), ["b: int"]);
    assert_eq!(fields(&interface.topics[2].fields), ["n_x: int"]);
}

#[test]
fn what_cannot_be_flattened_is_refused_with_a_remedy() {
    let text = r#"
        [topics.scan]
        ros = "x/msg/Scan.msg"
        [topics.picked]
        ros = "x/msg/Scan.msg"
        fields = ["angel", "angle.x", "angle[0]", "six[6]", "inner[].deep", "nested[]", "a..b", "six[one]"]
        [topics.large]
        ros = "x/msg/Large.msg"
        [topics.endless]
        ros = "x/msg/Endless.msg"
        [topics.headed]
        ros = "x/msg/Headed.msg"
        [topics.twice]
        ros = "x/msg/Twice.msg"
        [topics.status]
        ros = "x/msg/Status.msg"
        [topics.none]
        ros = "x/msg/None.msg"
        [topics.wrong]
        ros = "x/srv/Wrong.srv"
        [services.broken]
        ros = "x/srv/Broken.srv"
        [services.again]
        ros = "x/srv/Broken.srv"
        [services.typed]
        ros = 3
        request = 5
        [services.chosen]
        ros = "x/srv/Sound.srv"
        request = 5
        reply = { other = 3 }
    "#;
    let problems = problems([
        ("robot/arm.toml", text),
        ("robot/x/msg/Scan.msg", "float32 angle\nfloat32[] ranges\nint8[6] six\nInner[] inner\nNested[] nested\n"),
        ("robot/x/msg/Nested.msg", "int8[] deep\nInner[] inner\n"),
        ("robot/x/msg/Inner.msg", "int8 shallow"),
        ("robot/x/msg/Large.msg", "float64[4294967295] matrix"),
        ("robot/x/msg/Endless.msg", "Loop loop"),
        ("robot/x/msg/Loop.msg", "Endless again"),
        ("robot/x/msg/Headed.msg", "Header header\nsensor_msgs/Range other\nmy_msgs/Thing thing\n"),
        ("robot/x/msg/Twice.msg", "A a\nint8 a_b\n"),
        ("robot/x/msg/A.msg", "int8 b"),
        ("robot/x/msg/Status.msg", "int8 topic"),
        ("robot/x/srv/Broken.srv", "int x\nfloat64 y 1,5\n"),
        ("robot/x/srv/Sound.srv", "---\nint8 x\n"),
    ]);
    insta::assert_snapshot!(problems);
}

#[test]
fn nested_messages_without_fields_terminate() {
    let files = [
        ("robot/arm.toml", "[topics.t]\nros = 'x/msg/A.msg'\n"),
        ("robot/x/msg/A.msg", "B[4000000000] b"),
        ("robot/x/msg/B.msg", "C[4000000000] c"),
        ("robot/x/msg/C.msg", ""),
    ];
    assert!(problems(files).contains("more than the 64 fields"));
    let few = [files[0], ("robot/x/msg/A.msg", "B[3] b"), ("robot/x/msg/B.msg", "C[3] c"), files[3]];
    assert_eq!(load(few).unwrap().topics[0].fields, []);
}
