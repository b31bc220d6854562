//! Why a log cannot be read.

use std::io;
use std::path::PathBuf;

/// Why a log, or the rest of it, cannot be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LogError {
    /// The operating system could not read it.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The operating system's error.
        source: io::Error,
    },
    /// It is no log of BehaviorTree.CPP.
    #[error("{} is not a log of BehaviorTree.CPP", .0.display())]
    Foreign(PathBuf),
    /// It is an SQLite file, which this build cannot read.
    #[error("{} is an SQLite file, which this build cannot read: build with the feature `sqlite`", .0.display())]
    NoSqlite(PathBuf),
    /// Something in it cannot be so.
    #[error("{}: {problem}", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What, in words.
        problem: String,
    },
    /// It cannot be read as a bag.
    #[error(transparent)]
    Bag(#[from] bags::Error),
    /// A bag does not have what a tree's log needs.
    #[error("{}: {problem}", path.display())]
    Unfit {
        /// The bag.
        path: PathBuf,
        /// Why not, in words.
        problem: String,
        /// How to fix it.
        help: String,
    },
    /// It ends in the middle of something.
    #[error("{} was cut off: {what}", path.display())]
    CutOff {
        /// The file.
        path: PathBuf,
        /// What is not whole, in words.
        what: String,
    },
}
