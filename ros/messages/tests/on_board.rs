//! The definitions on board; `foreign.py` compares them with those of `rosbags`.

use std::collections::BTreeSet;
use std::path::Path;

use ros_messages::{EDITIONS, Folders, Layout, Message, TypeName, Undefined, on_board};

/// The names on board.
fn names() -> BTreeSet<TypeName> {
    let heads = include_str!("../src/on_board.txt").lines().filter(|line| !line.starts_with(' '));
    let names = heads.map(|line| line.split(['@', ':']).next().and_then(TypeName::parse));
    names.map(|name| name.expect("a name")).collect()
}

/// The hash of a type in an edition, if it has the type.
fn hash(name: &str, edition: &str) -> Option<String> {
    let name = TypeName::parse(name).expect("a name");
    let mut find = |name: &TypeName| {
        Message::known(name, Some(edition)).ok_or_else(|| Undefined::new(format!("no {name} in {edition}"), ""))
    };
    find(&name).ok()?;
    let layout = Layout::resolve(&name, &mut find).unwrap_or_else(|undefined| panic!("{name}: {undefined}"));
    Some(layout.type_hash())
}

#[test]
fn every_definition_on_board_is_complete_in_every_edition_that_has_it() {
    assert!(EDITIONS.is_sorted());
    for name in names() {
        let ends: [&[&str]; 3] = [&[""], &["_Request", "_Response"], &["_Goal", "_Result", "_FeedbackMessage"]];
        let newest = on_board(&name, Some("lyrical")).expect("every definition is in the newest edition");
        for end in ends[newest.matches("---").count()] {
            let found = EDITIONS.map(|edition| hash(&format!("{name}{end}"), edition));
            assert!(found.is_sorted_by_key(Option::is_some) && found[10].is_some(), "{name}{end}: {found:?}");
            // What is written about editions names the first and the last one of each form.
            let forms = found.chunk_by(|a, b| a == b).count();
            assert_eq!(forms, found.iter().collect::<BTreeSet<_>>().len(), "{name}{end}: {found:?}");
        }
    }
}

#[test]
fn editions_are_those_that_are_known() {
    let lines = include_str!("../src/on_board.txt").lines().filter_map(|line| line.split_once(':')?.0.split_once('@'));
    lines.for_each(|(name, edition)| assert!(EDITIONS.contains(&edition), "{name}@{edition}"));
}

/// The hashes are those of `rosbags` 0.11.
#[test]
fn types_that_distributions_changed_have_the_hashes_of_each() {
    let cases = [
        ("sensor_msgs/Range", "humble", "RIHS01_9430b1915b94d4268ff903679e8ecd09b6a67d331bd028738ec1eeb592891ebd"),
        ("sensor_msgs/Range", "iron", "RIHS01_b42b62562e93cbfe9d42b82fe5994dfa3d63d7d5c90a317981703f7388adff3a"),
        (
            "visualization_msgs/MarkerArray",
            "galactic",
            "RIHS01_5c558796cd4f02d359577f920f5436cb73a64056b1bac422876f3cb2814e6b0d",
        ),
        (
            "visualization_msgs/MarkerArray",
            "jazzy",
            "RIHS01_86cb8800b6fb05b5eff1abd7a56f62a5641d3ae9a1c29e78e67e704f1d067dcf",
        ),
        ("nav_msgs/Odometry", "foxy", "RIHS01_3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0"),
        ("tf2_msgs/TFMessage", "kilted", "RIHS01_e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087"),
        (
            "lifecycle_msgs/TransitionEvent",
            "lyrical",
            "RIHS01_78b19e2be41a797fc009c96bda68944182edabec7852cccd928a40bc06f6f9d7",
        ),
    ];
    for (name, edition, expected) in cases {
        assert_eq!(hash(name, edition).as_deref(), Some(expected), "{name} in {edition}");
    }
}

#[test]
fn a_folder_has_precedence_over_what_is_on_board() {
    let read = |path: &Path| match path.to_str() {
        Some("share/geometry_msgs/msg/Point.msg") => Ok(b"int8 x\n".to_vec()),
        _ => Err(std::io::ErrorKind::NotFound.into()),
    };
    let folders = Folders { paths: &["share".into()], read: &read };
    let fields = |name: &str| folders.layout(&TypeName::parse(name).expect("a name")).map(|layout| layout.fields.len());
    assert_eq!(fields("geometry_msgs/Point").ok(), Some(1));
    assert_eq!(fields("geometry_msgs/Vector3").ok(), Some(3));
    let undefined = fields("sensor_msgs/Range").expect_err("distributions differ");
    assert_eq!(undefined.to_string(), "there is no definition of sensor_msgs/Range");
}
