//! Which files a bag consists of.

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

/// Whether a path names a bag: a folder, or a file in one of the formats.
#[must_use]
pub fn is_bag(path: &Path) -> bool {
    path.is_dir() || path.is_file() && Format::of(path).is_some()
}

/// The name of the metadata file that rosbag2 writes beside the files with messages.
pub(super) const METADATA: &str = "metadata.yaml";

/// The files of a bag, in the order in which they were recorded. Notes what the metadata says.
pub(super) fn of(path: &Path, survey: &mut Survey) -> Result<Vec<(PathBuf, Format)>, Error> {
    let unreadable = |source| Error::Read(diagnostics::Error::Read { path: path.to_owned(), source });
    if !fs::metadata(path).map_err(unreadable)?.is_dir() {
        let format = Format::of(path).ok_or_else(|| Error::NoBag(path.to_owned()))?;
        return Ok(vec![(path.to_owned(), format)]);
    }
    let mut names = names(path)?;
    // The files that rosbag2 lists come first, in its order.
    let metadata = fs::read_to_string(path.join(METADATA)).unwrap_or_default();
    survey.distributions.extend(distribution(&metadata));
    let listed = listed(&metadata);
    let (found, missing): (Vec<String>, Vec<String>) = listed.into_iter().partition(|name| names.contains(name));
    survey.lost.extend(missing.into_iter().map(|name| format!("{name} is missing, although {METADATA} lists it")));
    names.retain(|name| !found.contains(name));
    let files = found.into_iter().chain(names).map(|name| path.join(name));
    let files: Vec<_> =
        files.filter(|path| path.is_file()).filter_map(|path| Some((path.clone(), Format::of(&path)?))).collect();
    if files.is_empty() { Err(Error::NoBag(path.to_owned())) } else { Ok(files) }
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
    if let Some(packed) = names.iter().find(|name| name.ends_with(".mcap.zstd") || name.ends_with(".db3.zstd")) {
        return Err(Error::Packed(folder.join(packed)));
    }
    names.sort_by_key(|name| in_order(name));
    Ok(names)
}

/// A sort key in which the last number of a name is separate, so that `bag_10.mcap` comes after `bag_9.mcap`.
fn in_order(name: &str) -> (String, u64, String) {
    let stem = name.split_once('.').map_or(name, |(stem, _)| stem);
    let digits = stem.len() - stem.trim_end_matches(|letter: char| letter.is_ascii_digit()).len();
    let (text, number) = stem.split_at(stem.len() - digits);
    (text.to_owned(), number.parse().unwrap_or(0), name.to_owned())
}

/// The files that rosbag2's metadata lists.
pub(super) fn listed(metadata: &str) -> Vec<String> {
    let lines = metadata.lines().skip_while(|line| line.trim() != "relative_file_paths:").skip(1);
    let names = lines.map_while(|line| line.trim().strip_prefix("- "));
    names.map(|name| name.trim().trim_matches(['"', '\'']).to_owned()).collect()
}

/// The distribution of ROS 2 that rosbag2's metadata names. Jazzy was the first to write it.
fn distribution(metadata: &str) -> Option<String> {
    let name = metadata.lines().find_map(|line| line.trim().strip_prefix("ros_distro:"))?;
    let name = name.trim().trim_matches(['"', '\'']);
    (!name.is_empty()).then(|| name.to_owned())
}
