//! Which files a bag consists of.

use std::collections::BTreeMap;
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

use super::metadata::{METADATA, Metadata};
use super::survey::Survey;
use crate::Error;

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

/// How many files the recording has that this file is a part of, according to the metadata beside it; none if it has no
/// others.
#[must_use]
pub fn parts(file: &Path) -> Option<usize> {
    let listed = Metadata::of(file.parent()?).listed;
    (listed.len() > 1 && listed.contains(&name_of(file))).then_some(listed.len())
}

#[derive(Debug, Default)]
pub(super) struct Files {
    /// Their paths, in the order in which they were recorded.
    pub(super) found: Vec<(PathBuf, Format)>,
    /// Whether the metadata lists them. If not, they are what the folder contains.
    pub(super) are_listed: bool,
    pub(super) metadata: Metadata,
}

/// The files of a bag. Notes what the metadata reports.
pub(super) fn of(path: &Path, survey: &mut Survey) -> Result<Files, Error> {
    let unreadable = |source| Error::Read(diagnostics::Error::Read { path: path.to_owned(), source });
    if !fs::metadata(path).map_err(unreadable)?.is_dir() {
        let no_bag = || if is_of_ros_1(path) { Error::Ros1(path.to_owned()) } else { Error::NoBag(path.to_owned()) };
        let format = Format::of(path).ok_or_else(no_bag)?;
        let found = vec![(path.to_owned(), format)];
        return Ok(Files { found, are_listed: true, metadata: Metadata::default() });
    }
    let mut names = names(path)?;
    diagnostics::reading(&path.join(METADATA)).map_err(unreadable)?;
    let metadata = Metadata::of(path);
    survey.distributions.extend(metadata.distribution.clone());
    survey.lost.extend(metadata.lost.clone());
    let of_bags = |names: &[String]| -> Vec<(PathBuf, Format)> {
        let files = names.iter().map(|name| path.join(name)).filter(|path| path.is_file());
        files.filter_map(|path| Some((path.clone(), Format::of(&path)?))).collect()
    };
    if metadata.listed.is_empty() {
        let found = of_bags(&names);
        if found.is_empty() {
            return Err(Error::NoBag(path.to_owned()));
        }
        refuse_formats(path, &found)?;
        survey.lost.extend(skipped(&names_of(&found)));
        // A folder may be another bag; a link that leads nowhere, or a pipe, stands for a part of this one.
        let is_unreadable = |name: &&String| {
            let path = path.join(name);
            !path.is_file() && !path.is_dir() && Format::of(&path).is_some()
        };
        survey.lost.extend(names.iter().filter(is_unreadable).map(|name| format!("{name} is not a file")));
        return Ok(Files { found, are_listed: false, metadata });
    }
    let is_there = |name: &String| names.contains(name) && path.join(name).is_file();
    let (found, missing): (Vec<String>, Vec<String>) = metadata.listed.iter().cloned().partition(is_there);
    if let Some(other) = found.iter().map(|name| path.join(name)).find(|path| Format::of(path).is_none()) {
        return Err(Error::NoBag(other));
    }
    names.retain(|name| !found.contains(name));
    let others = of_bags(&names);
    let found = once(of_bags(&found), survey);
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
    Ok(Files { found, are_listed: true, metadata })
}

/// The files without those that are the same as one before them, which are noted.
fn once(files: Vec<(PathBuf, Format)>, survey: &mut Survey) -> Vec<(PathBuf, Format)> {
    let mut all: Vec<(PathBuf, Format)> = Vec::new();
    for (path, format) in files {
        match all.iter().find(|(other, _)| is_same(other, &path)) {
            Some((other, _)) => survey.notes.push(is_read_once(&name_of(&path), &name_of(other))),
            None => all.push((path, format)),
        }
    }
    all
}

/// Whether two names are those of one file.
pub(super) fn is_same(a: &Path, b: &Path) -> bool {
    #[cfg(unix)]
    let id = |path: &Path| {
        let found = fs::metadata(path).ok()?;
        Some((std::os::unix::fs::MetadataExt::dev(&found), std::os::unix::fs::MetadataExt::ino(&found)))
    };
    #[cfg(not(unix))]
    let id = |path: &Path| fs::canonicalize(path).ok();
    a == b || id(a).is_some_and(|of_a| Some(of_a) == id(b))
}

/// That a file is listed twice, in words.
pub(super) fn is_read_once(name: &str, other: &str) -> String {
    match name == other {
        true => format!("{name} is read once, although {METADATA} lists it twice"),
        false => format!("{name} is not read: it is the same file as {other}"),
    }
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
