//! The contents of a bag, and a mapping to start from.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use ros_messages::{Constant, Layout, Value};

use crate::definitions::Definitions;
use crate::path::{End, ItemsPath, ValueField, leaves};
use crate::storage::{Survey, Topic, is_note};

/// What a bag contains.
#[derive(Clone, Debug)]
pub struct Contents {
    /// The topics, by name.
    pub topics: Vec<Listed>,
    /// When the first message was recorded, in nanoseconds since 1970, if there is any.
    pub start_ns: Option<i64>,
    /// From the first message to the last, in seconds.
    pub duration_s: f64,
    /// Damaged or missing parts, in words.
    pub lost: Vec<String>,
}

/// A topic of a bag.
#[derive(Clone, Debug)]
pub struct Listed {
    /// Its name.
    pub name: String,
    /// The type of its messages.
    pub kind: String,
    /// The number of messages.
    pub messages: u64,
    /// The average number of messages per second, if it is meaningful.
    pub rate_hz: Option<f64>,
    /// The paths of fields that can be values, with the kinds of their values; or why there are none.
    pub fields: Result<Vec<(String, &'static str)>, String>,
    entry: String,
}

/// No more fields than this are proposed: nobody would read them.
const MOST_FIELDS: usize = 16;

/// Types with an array of which every item tells something of its own, so that each becomes a message.
const WITH_ITEMS: [(&str, &str); 2] =
    [("nav2_msgs/msg/BehaviorTreeLog", "event_log"), ("tf2_msgs/msg/TFMessage", "transforms")];

impl Contents {
    /// The contents of a bag or of another source, with the definitions in it and in some folders.
    #[must_use]
    pub fn of(survey: &Survey, definitions: &Definitions<'_>) -> Self {
        let duration_s = survey.span_ns.map_or(0.0, |(first, last)| last.saturating_sub(first) as f64 * 1e-9);
        let mut types: BTreeMap<&str, usize> = BTreeMap::new();
        survey.topics.iter().for_each(|topic| *types.entry(&topic.name).or_default() += 1);
        let mut names = BTreeSet::new();
        let mut topics: Vec<Listed> = survey
            .topics
            .iter()
            .zip(&survey.counts)
            .filter(|(topic, _)| !is_note(topic))
            .map(|(topic, messages)| {
                let defined = definitions.defined(topic);
                let found = defined.as_ref().map(|defined| leaves(&defined.layout)).unwrap_or_default();
                let on_board = defined.as_ref().ok().and_then(|defined| defined.on_board.as_deref());
                let fields = found.iter().map(|leaf| (leaf.path.clone(), what(leaf.end))).collect();
                // In a bag, one name may have several types; an entry of a mapping that names no type is for all.
                let is_first = names.insert(topic.name.clone());
                let has_one_type = types[&*topic.name] == 1;
                let entry = match &defined {
                    Ok(defined) if is_first => entry(topic, has_one_type, on_board, &defined.layout),
                    _ => String::new(),
                };
                Listed {
                    name: topic.name.clone(),
                    kind: topic.kind.clone(),
                    messages: *messages,
                    rate_hz: (*messages > 1 && duration_s > 0.0).then(|| (*messages - 1) as f64 / duration_s),
                    fields: defined.as_ref().map(|_| fields).map_err(|undefined| undefined.to_string()),
                    entry,
                }
            })
            .collect();
        topics.sort_by(|a, b| a.name.cmp(&b.name));
        Self { topics, start_ns: survey.span_ns.map(|(first, _)| first), duration_s, lost: survey.lost.clone() }
    }

    /// A mapping of all topics that can be mapped, as a starting point; none if no topic can.
    #[must_use]
    pub fn proposal(&self) -> Option<String> {
        let entries: String = self.topics.iter().map(|topic| topic.entry.as_str()).collect();
        (!entries.is_empty()).then(|| format!("tick_s = 1.0\ntime = \"log\"\n{}{entries}", self.robot()))
    }

    /// The topics that show the robot on its map, where there is one of a kind; empty without a map.
    fn robot(&self) -> String {
        let line = |(key, kind): (&str, &str)| {
            let mut found = self.topics.iter().filter(|topic| topic.kind == kind);
            let only = found.next().filter(|_| found.next().is_none())?;
            Some(format!("{key} = {:?}\n", only.name))
        };
        let map = line(("map", "nav_msgs/msg/OccupancyGrid"));
        let others = [
            ("pose", "geometry_msgs/msg/PoseWithCovarianceStamped"),
            ("odometry", "nav_msgs/msg/Odometry"),
            ("scan", "sensor_msgs/msg/LaserScan"),
            ("path", "nav_msgs/msg/Path"),
        ];
        map.map_or_else(String::new, |map| {
            format!("\n[robot]\n{map}{}", others.into_iter().filter_map(line).collect::<String>())
        })
    }
}

fn what(end: End) -> &'static str {
    match end {
        End::Bool => "true or false",
        End::Int => "an integer",
        End::Real => "a number",
        End::Text => "a string",
        End::Bytes => "bytes",
        End::Time => "a stamp",
    }
}

/// The entry of a topic in a mapping; empty if no field can be mapped. It names the type, if it is the only one, so
/// that properties can be checked without the topic; if the type is defined on board, it says so.
fn entry(topic: &Topic, has_one_type: bool, on_board: Option<&str>, layout: &Layout) -> String {
    let Topic { name, kind, .. } = topic;
    let with_items = WITH_ITEMS.iter().find(|(with_items, _)| with_items == kind);
    let items = with_items.and_then(|(_, each)| Some((each, ItemsPath::resolve(each, layout).ok()?)));
    let mut leaves = leaves(items.as_ref().map_or(layout, |(_, items)| &items.layout));
    leaves.retain(|leaf| !leaf.path.starts_with("header.") && leaf.end != End::Time);
    if leaves.is_empty() {
        return String::new();
    }
    let on_board = on_board.map_or_else(String::new, |how| format!(" # defined on board, {how}"));
    let each = items.as_ref().map_or_else(String::new, |(each, _)| format!("each = {each:?}\n"));
    let named = if has_one_type {
        format!("type = {kind:?}{on_board}\n")
    } else {
        format!("# of several types, such as {kind}{}\n", on_board.replace(" #", ","))
    };
    let mut text = format!(
        "\n[[messages]]\ntopic = {name:?}\n{named}from = \"{}\"\nto = \"monitor\"\n{each}[messages.fields]\n",
        process(name)
    );
    let mut names = BTreeSet::new();
    for leaf in leaves.iter().take(MOST_FIELDS) {
        let mut name = leaf.path.replace("[-1]", "").replace('.', "_");
        while !names.insert(name.clone()) {
            name.push('_');
        }
        // Writing to a string cannot fail.
        let _ = match symbols(leaf) {
            Some(symbols) => writeln!(text, "{name} = {{ path = \"{}\", symbols = {{ {symbols} }} }}", leaf.path),
            None => writeln!(text, "{name} = \"{}\"", leaf.path),
        };
    }
    if leaves.len() > MOST_FIELDS {
        let _ = writeln!(text, "# {} more", leaves.len() - MOST_FIELDS);
    }
    text
}

/// The name of a process for a topic.
fn process(topic: &str) -> String {
    let letters = topic.trim_matches('/').chars();
    let name: String = letters.map(|letter| if letter.is_ascii_alphanumeric() { letter } else { '_' }).collect();
    match name.chars().next() {
        Some(first) if first.is_ascii_alphabetic() && name != "monitor" => name,
        _ => format!("topic_{name}"),
    }
}

/// The symbols of an integer whose message has constants for it: `STATUS_ABORTED` for `status`.
fn symbols(leaf: &ValueField<'_>) -> Option<String> {
    let field = leaf.path.rsplit('.').next().filter(|_| leaf.end == End::Int)?;
    let prefix = format!("{}_", field.to_ascii_uppercase());
    let mut seen = BTreeSet::new();
    let named = leaf.constants.iter().filter_map(|Constant { name, value, .. }| match value {
        Value::Int(number) => {
            let name = name.strip_prefix(&prefix)?;
            seen.insert(*number).then(|| format!("{number} = {name:?}"))
        }
        _ => None,
    });
    let named: Vec<String> = named.collect();
    (!named.is_empty()).then(|| named.join(", "))
}
