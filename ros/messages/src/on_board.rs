//! Definitions on board: those of ROS's common packages and of Nav2, in all distributions.
//!
//! Source: the repositories `ros2/common_interfaces`, `ros2/rcl_interfaces`, `ros2/unique_identifier_msgs`,
//! `ros2/geometry2`, `ros2/rosbag2`, `ros2/rmw_dds_common`, `ros-geographic-info/geographic_info` and
//! `ros-navigation/navigation2`; of the types that the `rosbags` package has, its copies.

use std::collections::BTreeSet;
use std::sync::LazyLock;

use crate::definition::{Message, TypeName};

/// The editions of ROS 2 whose definitions are on board, oldest first, which is also their alphabetical order. An
/// edition is a distribution; where Nav2 changed a type within one, also the distribution since that version of Nav2.
pub const EDITIONS: [&str; 11] = [
    "dashing",
    "dashing-nav2-0.2.4",
    "eloquent",
    "foxy",
    "galactic",
    "humble",
    "iron",
    "iron-nav2-1.2.2",
    "jazzy",
    "kilted",
    "lyrical",
];

/// The definitions, each in a line `PACKAGE/NAME@EDITION: FIELD, FIELD, …`: since that edition, or always. Services and
/// actions have their parts, separated by `---`. These are names, types and numbers; of the constants, those that are
/// the values of a field with the same name. `tests/foreign.py` compares them with the `rosbags` package.
static DEFINITIONS: LazyLock<String> = LazyLock::new(|| include_str!("on_board.txt").replace("\n    ", " "));

/// The definition of a message, service or action in one of the [`EDITIONS`], or else in all of them if they agree: as
/// in its `.msg`, `.srv` or `.action` file, without comments and default values. `None` if it is not on board.
#[must_use]
pub fn on_board(name: &TypeName, edition: Option<&str>) -> Option<String> {
    let name = name.to_string();
    let mut forms = DEFINITIONS.lines().filter_map(|line| {
        let (since, fields) = line.strip_prefix(&name)?.split_once(':')?;
        let since = if since.is_empty() { "" } else { since.strip_prefix('@')? };
        edition.is_none_or(|edition| since <= edition).then_some(fields)
    });
    let fields = match edition {
        Some(_) => forms.next_back()?,
        None => forms.next().filter(|_| forms.next().is_none())?,
    };
    Some(text(fields))
}

/// The messages whose definitions are on board, also those that ROS makes for services and actions, by their types in
/// ROS 2: `sensor_msgs/msg/LaserScan`.
#[must_use]
pub fn messages_on_board() -> BTreeSet<String> {
    let of_line = |line: &'static str| {
        let (head, fields) = line.split_once(':')?;
        let (package, name) = head.split('@').next()?.split_once('/')?;
        let kind = kind(fields);
        let messages = Message::of_file(kind, name, "a definition on board", &text(fields)).ok()?;
        Some(messages.into_iter().map(move |(name, _)| format!("{package}/{kind}/{name}")))
    };
    DEFINITIONS.lines().filter_map(of_line).flatten().collect()
}

/// A definition as in its file.
fn text(fields: &str) -> String {
    fields.replace(", ", "\n").replace("---", "\n---\n")
}

/// What it defines: the ending of its file.
fn kind(fields: &str) -> &'static str {
    ["msg", "srv", "action"][fields.matches("---").count()]
}

impl Message {
    /// The definition of a message that is [on board](on_board), also of one that ROS makes for a service or an action.
    ///
    /// ```
    /// use ros_messages::{Message, TypeName};
    ///
    /// let known = |name, edition| Message::known(&TypeName::new(Some("sensor_msgs"), name), edition);
    /// assert_eq!(known("Temperature", None).map(|message| message.fields.len()), Some(3));
    /// assert_eq!(known("Range", Some("humble")).map(|message| message.fields.len()), Some(6));
    /// assert_eq!(known("Range", Some("jazzy")).map(|message| message.fields.len()), Some(7));
    /// assert_eq!(known("Range", None), None, "its distributions differ");
    /// ```
    #[must_use]
    pub fn known(name: &TypeName, edition: Option<&str>) -> Option<Self> {
        let whole = name.whole();
        let text = on_board(&whole, edition)?;
        let messages = Self::of_file(kind(&text), &whole.name, "a definition on board", &text);
        let messages = messages.expect("the tests read all definitions on board");
        messages.into_iter().find_map(|(found, message)| (found == name.name).then_some(message))
    }
}
