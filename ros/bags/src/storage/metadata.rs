//! What rosbag2's metadata file contains about a bag.
//!
//! It is read line by line: rosbag2 writes one fact per line.

use std::collections::BTreeMap;
use std::fs;
use std::io::Read;
use std::path::Path;

use super::survey::Survey;

/// The name of the metadata file that rosbag2 writes beside the files with messages.
pub(super) const METADATA: &str = "metadata.yaml";

/// The contents of the metadata file of a folder.
#[derive(Debug, Default)]
pub(super) struct Metadata {
    /// The names of the files, in the order in which they were recorded. Early versions wrote the folder before them;
    /// one that was compressed as a whole has been decompressed.
    pub(super) listed: Vec<String>,
    /// The distribution of ROS 2 that it names. Jazzy was the first to write it.
    pub(super) distribution: Option<String>,
    /// How many messages there are: on topics, in files, and altogether.
    topics: BTreeMap<String, u64>,
    files: BTreeMap<String, u64>,
    all: Option<u64>,
    /// That it is there and lists no files, in words.
    pub(super) lost: Option<String>,
}

impl Metadata {
    /// That of a folder; if it has none, nothing is known.
    pub(super) fn of(folder: &Path) -> Self {
        let path = folder.join(METADATA);
        if fs::symlink_metadata(&path).is_err() {
            return Self::default();
        }
        let mut text = String::new();
        let read = diagnostics::open_regular(&path).and_then(|mut file| file.read_to_string(&mut text));
        let listed = read.ok().and_then(|_| listed(&text));
        let lost = format!("{METADATA} cannot be read, so files that it lists may be missing");
        match listed {
            Some(listed) => Self { listed, ..Self::parse(&text) },
            None => Self { lost: Some(lost), ..Self::parse(&text) },
        }
    }

    fn parse(text: &str) -> Self {
        let (mut found, mut item) = (Self::default(), Item::default());
        let indent = |line: &str| line.len() - line.trim_start().len();
        let top = text.lines().find(|line| line.trim_start().starts_with(LIST)).map(indent);
        for line in text.lines() {
            let (at, begins) = (indent(line), line.trim_start().starts_with("- "));
            // The keys of an item may be in any order: rosbags sorts them. Lists inside an item are part of it.
            if item.at.is_none_or(|of| at <= of) && !line.trim().is_empty() {
                found.count(std::mem::take(&mut item));
                item.at = begins.then_some(at);
            }
            let Some((key, value)) = line.split_once(':') else { continue };
            let value = plain(value);
            match (key.trim_start_matches([' ', '-']), item.at) {
                ("ros_distro", None) if !value.is_empty() => found.distribution = Some(value.to_owned()),
                ("message_count", None) if Some(at) == top => found.all = value.parse().ok(),
                ("name", Some(_)) => item.topic = Some(value.to_owned()),
                ("path", Some(_)) => item.file = Some(file_name(value)),
                ("message_count", Some(_)) => item.count = value.parse().ok(),
                _ => {}
            }
        }
        found.count(item);
        found
    }

    /// Adds what an item of a list counts.
    fn count(&mut self, Item { topic, file, count, .. }: Item) {
        match (count, topic, file) {
            (Some(count), Some(topic), _) => {
                let all = self.topics.entry(topic).or_default();
                *all = all.saturating_add(count);
            }
            (Some(count), None, Some(file)) => drop(self.files.insert(file, count)),
            _ => {}
        }
    }

    /// Compares what it counts with what there is on topics.
    pub(super) fn compare_topics(&self, survey: &mut Survey) {
        for (name, stated) in &self.topics {
            let of_name = |(index, topic): (usize, &super::Topic)| (topic.name == *name).then_some(index);
            let of_name: Vec<usize> = survey.topics.iter().enumerate().filter_map(of_name).collect();
            let found = of_name.iter().fold(0_u64, |sum, index| sum.saturating_add(survey.counts[*index]));
            if found != *stated {
                let what = format!("{METADATA} counts {stated} messages on {name}, and {found} are there");
                survey.missing.extend(of_name.iter().map(|index| (*index, what.clone())));
            }
        }
    }

    /// Compares what it counts with what there is in all files, by their names.
    pub(super) fn compare(&self, files: &BTreeMap<String, u64>, survey: &mut Survey) {
        self.compare_topics(survey);
        // The counts of topics concern only these.
        if !survey.missing.is_empty() {
            return;
        }
        let others = files.iter().filter_map(|(name, found)| {
            let stated = self.files.get(name).filter(|stated| *stated != found)?;
            Some(format!("{METADATA} counts {stated} messages in {name}, and {found} are there"))
        });
        let others: Vec<String> = others.collect();
        let found = files.values().fold(0_u64, |sum, count| sum.saturating_add(*count));
        let all = self.all.filter(|stated| *stated != found && others.is_empty());
        let all = all.map(|stated| format!("{METADATA} counts {stated} messages, and {found} are there"));
        survey.lost.extend(others.into_iter().chain(all));
    }
}

/// An item of a list: a topic or a file, and how many messages it has.
#[derive(Default)]
struct Item {
    /// How far its `-` is indented.
    at: Option<usize>,
    topic: Option<String>,
    file: Option<String>,
    count: Option<u64>,
}

const LIST: &str = "relative_file_paths:";

/// The names of the listed files; none if there is no list, or if its end may be missing: in what rosbag2 writes, other
/// keys always follow it.
fn listed(metadata: &str) -> Option<Vec<String>> {
    let lines = metadata.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#'));
    let mut lines = lines.skip_while(|line| !line.starts_with(LIST)).peekable();
    let first = lines.next()?.strip_prefix(LIST)?.trim();
    let names: Vec<String> = if let Some(list) = first.strip_prefix('[') {
        let list = std::iter::once(list).chain(lines).collect::<String>();
        list.split_once(']')?.0.split(',').map(file_name).collect()
    } else {
        let names = std::iter::from_fn(|| lines.next_if(|line| line.starts_with("- "))).collect::<Vec<_>>();
        lines.peek()?;
        names.into_iter().map(|name| file_name(&name[2..])).collect()
    };
    let names: Vec<String> = names.into_iter().filter(|name| !name.is_empty()).collect();
    (!names.is_empty()).then_some(names)
}

/// The name of a file without its folder, once it is decompressed.
fn file_name(path: &str) -> String {
    let name = plain(path).rsplit('/').next().unwrap_or_default();
    name.strip_suffix(".zstd").unwrap_or(name).to_owned()
}

/// A value without quotation marks.
fn plain(value: &str) -> &str {
    value.trim().trim_matches(['"', '\''])
}
