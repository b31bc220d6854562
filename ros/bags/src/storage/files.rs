//! Which files a bag consists of.

use std::collections::BTreeMap;
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

use super::survey::Survey;
use crate::Error;

/// The format of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Format {
    Mcap,
    Sqlite,
}

impl Format {
    /// The format of a file, by its first bytes or else by its name.
    fn of(path: &Path) -> Option<Self> {
        let mut first = Vec::new();
        let _ = diagnostics::open_regular(path).and_then(|file| file.take(16).read_to_end(&mut first));
        if first.starts_with(b"\x89MCAP") {
            return Some(Self::Mcap);
        }
        if first.starts_with(b"SQLite format 3\0") {
            return Some(Self::Sqlite);
        }
        match path.extension()?.to_str()? {
            "mcap" => Some(Self::Mcap),
            "db3" => Some(Self::Sqlite),
            _ => None,
        }
    }
}

/// Whether a file is a bag of ROS 1.
fn is_of_ros_1(path: &Path) -> bool {
    let mut first = Vec::new();
    let _ = diagnostics::open_regular(path).and_then(|file| file.take(9).read_to_end(&mut first));
    first == b"#ROSBAG V"
}

/// Whether a path names a bag: a folder, or a file in one of the formats.
#[must_use]
pub fn is_bag(path: &Path) -> bool {
    path.is_dir() || path.is_file() && Format::of(path).is_some()
}

/// The name of the metadata file that rosbag2 writes beside the files with messages.
pub(super) const METADATA: &str = "metadata.yaml";

/// The files of a bag.
#[derive(Debug, Default)]
pub(super) struct Files {
    /// Their paths, in the order in which they were recorded.
    pub(super) found: Vec<(PathBuf, Format)>,
    /// Whether the metadata lists them. If not, they are what the folder contains.
    pub(super) are_listed: bool,
}

/// The files of a bag. Notes what the metadata says.
pub(super) fn of(path: &Path, survey: &mut Survey) -> Result<Files, Error> {
    let unreadable = |source| Error::Read(diagnostics::Error::Read { path: path.to_owned(), source });
    if !fs::metadata(path).map_err(unreadable)?.is_dir() {
        let no_bag = || if is_of_ros_1(path) { Error::Ros1(path.to_owned()) } else { Error::NoBag(path.to_owned()) };
        let format = Format::of(path).ok_or_else(no_bag)?;
        return Ok(Files { found: vec![(path.to_owned(), format)], are_listed: true });
    }
    let mut names = names(path)?;
    diagnostics::reading(&path.join(METADATA)).map_err(unreadable)?;
    let metadata = fs::read_to_string(path.join(METADATA)).unwrap_or_default();
    survey.distributions.extend(distribution(&metadata));
    let listed = listed(&metadata);
    let of_bags = |names: &[String]| -> Vec<(PathBuf, Format)> {
        let files = names.iter().map(|name| path.join(name)).filter(|path| path.is_file());
        files.filter_map(|path| Some((path.clone(), Format::of(&path)?))).collect()
    };
    if listed.is_empty() {
        let found = of_bags(&names);
        if found.is_empty() {
            return Err(Error::NoBag(path.to_owned()));
        }
        refuse_formats(path, &found)?;
        survey.lost.extend(skipped(&names_of(&found)));
        return Ok(Files { found, are_listed: false });
    }
    let (found, missing): (Vec<String>, Vec<String>) = listed.into_iter().partition(|name| names.contains(name));
    names.retain(|name| !found.contains(name));
    let others = of_bags(&names);
    let found = of_bags(&found);
    match (missing.first(), others.first()) {
        (Some(missing), Some((other, _))) if found.is_empty() => {
            let (missing, other) = (missing.clone(), name_of(other));
            return Err(Error::NotListed { folder: path.to_owned(), missing, other });
        }
        _ if found.is_empty() => return Err(Error::NoBag(path.to_owned())),
        _ => {}
    }
    survey.lost.extend(missing.iter().map(|name| is_missing(name)));
    survey.notes.extend(others.iter().map(|(other, _)| is_not_listed(&name_of(other))));
    Ok(Files { found, are_listed: true })
}

/// That a listed file is missing, in words.
pub(super) fn is_missing(name: &str) -> String {
    format!("{name} is missing, although {METADATA} lists it")
}

fn is_not_listed(name: &str) -> String {
    format!("{name} is not read: {METADATA} does not list it")
}

fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

fn names_of(files: &[(PathBuf, Format)]) -> Vec<String> {
    files.iter().map(|(path, _)| name_of(path)).collect()
}

/// A recording has one format: a file in the other is a copy.
fn refuse_formats(folder: &Path, files: &[(PathBuf, Format)]) -> Result<(), Error> {
    let Some(((first, format), rest)) = files.split_first() else { return Ok(()) };
    match rest.iter().find(|(_, other)| other != format) {
        Some((other, _)) => Err(Error::Several {
            folder: folder.to_owned(),
            files: [name_of(first), name_of(other)],
            why: "have different formats",
        }),
        None => Ok(()),
    }
}

/// Which files are missing before or among those whose names end with numbers, in words: rosbag2 counts from 0.
pub(super) fn skipped(names: &[String]) -> Vec<String> {
    let mut numbered: BTreeMap<(String, &str), Vec<u64>> = BTreeMap::new();
    for name in names {
        let (stem, number) = stem_and_number(name);
        let ending = name.split_once('.').map_or("", |(_, ending)| ending);
        numbered.entry((stem.to_owned(), ending)).or_default().extend(number);
    }
    let mut all = Vec::new();
    for ((stem, ending), numbers) in numbered.into_iter().filter(|((stem, _), _)| stem.ends_with('_')) {
        let mut next = 0;
        for number in numbers {
            if number > next {
                let name = |number| format!("{stem}{number}.{ending}");
                all.push(match number - next {
                    1 => format!("{} is missing: {} is there", name(next), name(number)),
                    _ => format!("{} to {} are missing: {} is there", name(next), name(number - 1), name(number)),
                });
            }
            next = number.saturating_add(1);
        }
    }
    all
}

/// What a name without its ending begins with, and the number at its end, if it has one.
pub(super) fn stem_and_number(name: &str) -> (&str, Option<u64>) {
    let stem = name.split_once('.').map_or(name, |(stem, _)| stem);
    let digits = stem.len() - stem.trim_end_matches(|letter: char| letter.is_ascii_digit()).len();
    let (text, number) = stem.split_at(stem.len() - digits);
    (text, number.parse().ok())
}

/// The names of the files in the folder of a bag, in the order in which they were recorded.
///
/// # Errors
/// If the folder cannot be read, or its files are compressed as a whole.
pub(super) fn names(folder: &Path) -> Result<Vec<String>, Error> {
    let unreadable = |source| Error::Read(diagnostics::Error::Read { path: folder.to_owned(), source });
    let mut names = Vec::new();
    for entry in fs::read_dir(folder).map_err(unreadable)? {
        names.push(entry.map_err(unreadable)?.file_name().to_string_lossy().into_owned());
    }
    let is_packed = |name: &&String| {
        let plain = name.strip_suffix(".zstd").filter(|plain| plain.ends_with(".mcap") || plain.ends_with(".db3"));
        plain.is_some_and(|plain| names.iter().all(|name| name != plain))
    };
    if let Some(packed) = names.iter().find(is_packed) {
        return Err(Error::Packed(folder.join(packed)));
    }
    names.sort_by_key(|name| in_order(name));
    Ok(names)
}

/// A sort key in which the last number of a name is separate, so that `bag_10.mcap` comes after `bag_9.mcap`.
fn in_order(name: &str) -> (String, u64, String) {
    let (text, number) = stem_and_number(name);
    (text.to_owned(), number.unwrap_or(0), name.to_owned())
}

/// The names of the files that rosbag2's metadata lists. Early versions wrote the folder before them; one that was
/// compressed as a whole has been decompressed.
pub(super) fn listed(metadata: &str) -> Vec<String> {
    const KEY: &str = "relative_file_paths:";
    let mut lines = metadata.lines().map(str::trim).skip_while(|line| !line.starts_with(KEY));
    let first = lines.next().and_then(|line| line.strip_prefix(KEY)).unwrap_or_default().trim();
    let in_brackets = first.strip_prefix('[').and_then(|list| list.strip_suffix(']'));
    let names: Vec<&str> = match in_brackets {
        Some(list) => list.split(',').collect(),
        None => lines.map_while(|line| line.strip_prefix("- ")).collect(),
    };
    let names = names.into_iter().map(|name| name.trim().trim_matches(['"', '\'']));
    let names = names.map(|name| name.rsplit('/').next().unwrap_or(name)).filter(|name| !name.is_empty());
    names.map(|name| name.strip_suffix(".zstd").unwrap_or(name).to_owned()).collect()
}

/// The distribution of ROS 2 that rosbag2's metadata names. Jazzy was the first to write it.
fn distribution(metadata: &str) -> Option<String> {
    let name = metadata.lines().find_map(|line| line.trim().strip_prefix("ros_distro:"))?;
    let name = name.trim().trim_matches(['"', '\'']);
    (!name.is_empty()).then(|| name.to_owned())
}
