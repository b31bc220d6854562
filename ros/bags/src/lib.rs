//! Reads ROS 2 recordings: their messages become events on channels.
//!
//! A [`Bag`] is what rosbag2 writes: an MCAP file with any of its compressions, an SQLite file (with the feature
//! `sqlite`), or a folder of several files. It need not have been closed: everything before the damage is read, and the
//! loss is described in words.
//!
//! A [`Mapping`] is a TOML file that determines which messages of a bag pass on which channel, and which of their
//! fields become the fields of the channel's messages. [`Mapping::compile`] checks it against the bag, whose messages
//! are decoded with the [definitions](Definitions) in the bag itself, in folders, or on board. [`Events`] then yields
//! the ticks and messages one after the other, as an event log does, so the same monitors can judge them. Only mapped
//! topics are decoded, and memory does not grow with the bag.
//!
//! [`Contents`] lists what a bag contains, and proposes a mapping.
//!
//! # Inside
//! `storage` reads the files, one module per format, and puts their messages in order (`merge`); `definitions` finds
//! the definitions of types, by which `ros_messages` decodes the wanted parts of a message; `mapping` is the user's
//! file, and `mapping/compile` what it means for a bag; `events` puts messages in order and makes the ticks. `contents`
//! lists a bag and proposes a mapping.

mod contents;
mod definitions;
mod events;
mod mapping;
mod path;
mod storage;

use std::path::{Path, PathBuf};

use chrono::{DateTime, Utc};

pub use channels::Ground;
pub use contents::{Contents, Listed};
pub use definitions::{Defined, Definitions};
pub use events::{Events, Found};
pub use mapping::{Compiled, Described, Mapping, Remapping, RobotTopics, prefix, resolve};
pub use ros_messages::messages_on_board;
pub use storage::{
    Account, Bag, BagWriter, Definition, Following, Head, Messages, Received, Recorder, Source, Survey, Through, Topic,
    is_bag, parts,
};

/// Why a bag cannot be read at all.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The operating system could not read it.
    #[error(transparent)]
    Read(#[from] diagnostics::Error),
    /// It is neither a file of a known format nor a folder with one.
    #[error("{} is not a bag", .0.display())]
    NoBag(PathBuf),
    /// It is a bag of ROS 1.
    #[error("{} is a bag of ROS 1, which cannot be read", .0.display())]
    Ros1(PathBuf),
    /// It is empty.
    #[error("{} is empty", .0.display())]
    Empty(PathBuf),
    /// A folder contains files that are not one recording.
    #[error("{} contains more than one recording: {} and {} {why}", folder.display(), files[0], files[1])]
    Several {
        /// The folder.
        folder: PathBuf,
        /// Two of the files.
        files: [String; 2],
        /// What shows it.
        why: &'static str,
    },
    /// None of the files that the metadata lists is there, but others are.
    #[error("{} has no {missing}, which its metadata.yaml lists; {other} is there", folder.display())]
    NotListed {
        /// The folder.
        folder: PathBuf,
        /// A listed file.
        missing: String,
        /// Another file.
        other: String,
    },
    /// The whole file is compressed.
    #[error("{} is compressed as a whole", .0.display())]
    Packed(PathBuf),
    /// It is an SQLite file, which this build cannot read.
    #[error("{} is an SQLite file, which this build cannot read", .0.display())]
    NoSqlite(PathBuf),
    /// It is in a format that cannot be read while it is being written.
    #[error("{} cannot be read while it is being written: it is not an MCAP file", .0.display())]
    Followed(PathBuf),
    /// SQLite could not read it.
    #[error("{}: {problem}", path.display())]
    Sqlite {
        /// The file.
        path: PathBuf,
        /// The message of SQLite.
        problem: String,
    },
}

impl Error {
    /// How to fix it.
    #[must_use]
    pub fn help(&self) -> String {
        match self {
            Self::Read(_) => "a bag is a file `.mcap` or `.db3`, or the folder that contains them".to_owned(),
            Self::NoBag(_) => {
                "a bag is a file `.mcap` or `.db3` that rosbag2 wrote, or the folder that contains them".to_owned()
            }
            Self::Ros1(path) => {
                format!(
                    "convert it: `rosbags-convert --src {} --dst {} --dst-storage mcap`",
                    path.display(),
                    path.with_extension("").display()
                )
            }
            Self::Empty(_) => "the recorder was stopped before it wrote anything".to_owned(),
            Self::Several { folder, files, .. } => {
                format!(
                    "name the file: {}; or leave only the files of one recording in the folder",
                    folder.join(&files[0]).display()
                )
            }
            Self::NotListed { folder, other, .. } => {
                format!("name the file: {}; or correct the list", folder.join(other).display())
            }
            Self::Packed(path) => format!("decompress it: `zstd -d {}`", path.display()),
            Self::NoSqlite(path) => {
                let stem = path.with_extension("");
                format!(
                    "build with the feature `sqlite`, which needs a C compiler; or convert it: `rosbags-convert --src {} \
                     --dst {}-mcap --dst-storage mcap`",
                    path.parent().filter(|folder| *folder != Path::new("")).unwrap_or(Path::new(".")).display(),
                    stem.display()
                )
            }
            Self::Followed(_) => "record with `ros2 bag record --storage mcap`".to_owned(),
            Self::Sqlite { .. } => "the file is damaged, or another program is writing it".to_owned(),
        }
    }
}

/// A moment as people write it: a date, or seconds if the clock apparently does not count from 1970.
#[must_use]
pub fn moment(ns: i64) -> String {
    match date(ns) {
        Some(date) => date.format("%Y-%m-%d %H:%M:%S%.3f UTC").to_string(),
        None => format!("{:.3} s", ns as f64 * 1e-9),
    }
}

/// Date and time of nanoseconds since 1970; none before 2000: such a clock counts from something else.
#[must_use]
pub fn date(ns: i64) -> Option<DateTime<Utc>> {
    const YEAR_2000_NS: i64 = 946_684_800_000_000_000;
    (ns >= YEAR_2000_NS).then(|| DateTime::from_timestamp_nanos(ns))
}

/// How long after the first message of a bag something was recorded, in words.
fn after_first(ns: i64, first_ns: i64) -> String {
    format!("{:.3} s after the first message of the bag", ns.saturating_sub(first_ns) as f64 * 1e-9)
}

/// Nanoseconds since 1970 as seconds, without rounding.
#[must_use]
pub fn seconds(ns: i64) -> String {
    let sign = if ns < 0 { "-" } else { "" };
    format!("{sign}{}.{:09}", (ns / 1_000_000_000).unsigned_abs(), (ns % 1_000_000_000).unsigned_abs())
}
