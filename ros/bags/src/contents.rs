//! The contents of a bag, and a mapping to start from.

use std::collections::{BTreeMap, BTreeSet};

use ros_messages::{Constant, Layout, Value};

use crate::definitions::Definitions;
use crate::path::{End, ValueField, arrays, leaves};
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
    /// What else is to be known of its files, in words.
    pub notes: Vec<String>,
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

/// No more fields than this are proposed: a proposal is to be read by people.
const MOST_FIELDS: usize = 16;

/// Nor entries for more arrays of a topic.
const MOST_ARRAYS: usize = 8;

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
            .enumerate()
            .filter(|(_, (topic, _))| !is_note(topic))
            .map(|(index, (topic, messages))| {
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
                    rate_hz: rate_hz(survey, index, *messages),
                    fields: defined.as_ref().map(|_| fields).map_err(|undefined| undefined.to_string()),
                    entry,
                }
            })
            .collect();
        topics.sort_by(|a, b| a.name.cmp(&b.name));
        let missing: BTreeSet<&String> = survey.missing.iter().map(|(_, what)| what).collect();
        let lost = survey.lost.iter().chain(missing).cloned().collect();
        let start_ns = survey.span_ns.map(|(first, _)| first);
        Self { topics, start_ns, duration_s, lost, notes: survey.notes.clone() }
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

/// How many messages come in a second: between the first and the last on the topic or, if these are not known, in the
/// whole time. None if that is no time.
fn rate_hz(survey: &Survey, topic: usize, messages: u64) -> Option<f64> {
    let s = |(first, last): (i64, i64)| last.saturating_sub(first) as f64 * 1e-9;
    let (count, duration_s) = match survey.spans_ns.get(&topic) {
        Some(span) => (messages.saturating_sub(1), s(*span)),
        None => (messages, s(survey.span_ns?)),
    };
    (messages > 1 && duration_s > 0.0).then(|| count as f64 / duration_s)
}

/// The entries of a topic in a mapping: one for the message, and one for the items of each array of messages, so that
/// all of them are judged. Empty if no field can be mapped. They name the type, if it is the only one, so that
/// properties can be checked without the topic; if the type is defined on board, a comment states it.
fn entry(topic: &Topic, has_one_type: bool, on_board: Option<&str>, layout: &Layout) -> String {
    let Topic { name, kind, .. } = topic;
    let on_board = on_board.map_or_else(String::new, |how| format!(" # defined on board, {how}"));
    let named = if has_one_type {
        format!("type = {kind:?}{on_board}\n")
    } else {
        format!("# of several types, such as {kind}{}\n", on_board.replace(" #", ","))
    };
    let of = |items: Option<&str>, from: &str, fields: &str| {
        let each = items.map_or_else(String::new, |each| format!("each = {each:?}\n"));
        format!(
            "\n[[messages]]\ntopic = {name:?}\n{named}from = \"{from}\"\nto = \"monitor\"\n{each}[messages.fields]\n{fields}"
        )
    };
    let (whole, arrays) = (fields(layout, false), arrays(layout));
    let own = process(name);
    let mut text = whole.as_ref().map_or_else(String::new, |fields| of(None, &own, fields));
    let has_one = whole.is_none() && arrays.len() == 1;
    for (array, items) in arrays.iter().take(MOST_ARRAYS) {
        // Messages of another kind come from a process of their own: a property is then about one of them.
        let from = if has_one { own.clone() } else { format!("{own}_{}", array.replace('.', "_")) };
        if let Some(fields) = fields(items, true) {
            text += &of(Some(array), &from, &fields);
        }
    }
    if arrays.len() > MOST_ARRAYS {
        text += &format!("# {} more arrays\n", arrays.len() - MOST_ARRAYS);
    }
    text
}

/// The fields of a message in a mapping, or of the items of an array; none if there are none. Of an array in an item,
/// there is a list of all its items.
fn fields(layout: &Layout, is_item: bool) -> Option<String> {
    let mut leaves = leaves(layout);
    let is_list = |leaf: &ValueField<'_>| leaf.path.contains("[-1]");
    leaves.retain(|leaf| !leaf.path.starts_with("header.") && leaf.end != End::Time);
    // Of an array in an item of an array in an item, a mapping can have no list.
    let is_deep = |leaf: &ValueField<'_>| is_item && leaf.path.matches("[-1]").count() > 1;
    let deep = leaves.iter().filter(|leaf| is_deep(leaf)).count();
    leaves.retain(|leaf| !is_list(leaf) || is_item && !is_deep(leaf));
    let (mut text, mut names) = (String::new(), BTreeSet::new());
    for leaf in leaves.iter().take(MOST_FIELDS) {
        let mut name = leaf.path.replace("[-1]", "").replace('.', "_");
        while !names.insert(name.clone()) {
            name.push('_');
        }
        let path = leaf.path.replace("[-1]", "[]");
        text += &match symbols(leaf) {
            Some(symbols) => format!("{name} = {{ path = {path:?}, symbols = {{ {symbols} }} }}\n"),
            None => format!("{name} = {path:?}\n"),
        };
    }
    if leaves.len() > MOST_FIELDS {
        text += &format!("# {} more\n", leaves.len() - MOST_FIELDS);
    }
    if deep > 0 {
        text += &format!("# {deep} more in arrays of arrays, of which a path names one item: `a[-1].b[-1].c`\n");
    }
    leaves.first().map(|_| text)
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
