//! The keys of an interface file.

/// A key of an interface file.
#[derive(Clone, Copy, Debug)]
pub struct Key {
    /// Its path: `services.NAME.reply`. The file chooses `NAME`.
    pub path: &'static str,
    /// What it means.
    pub about: &'static str,
    /// What it takes.
    pub takes: &'static str,
}

const FIELDS: &str = "a table: the name of each field with its kind; with `ros`, a selection";

const fn key(path: &'static str, about: &'static str, takes: &'static str) -> Key {
    Key { path, about, takes }
}

/// All keys of an interface file.
pub const KEYS: [Key; 10] = [
    key(
        "packages",
        "Folders with ROS packages, such as `/opt/ros/jazzy/share`. They are searched last.",
        "an array of strings, relative to this file",
    ),
    key("services.NAME.request", "The fields of the request.", FIELDS),
    key("services.NAME.reply", "The fields of the reply if the service did what it was asked to do.", FIELDS),
    key("services.NAME.ros", "The definition with the fields.", "a `.srv` file, relative to this file"),
    key("topics.NAME.fields", "The fields of the message.", FIELDS),
    key("topics.NAME.ros", "The definition with the fields.", "a `.msg` file, relative to this file"),
    key("actions.NAME.goal", "The fields of a goal.", FIELDS),
    key("actions.NAME.feedback", "The fields of feedback.", FIELDS),
    key("actions.NAME.result", "The fields of the result if the goal was reached.", FIELDS),
    key("actions.NAME.ros", "The definition with the fields.", "an `.action` file, relative to this file"),
];
