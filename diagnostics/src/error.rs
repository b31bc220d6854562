//! Errors when reading and writing files.

use std::io;
use std::path::PathBuf;

use crate::FileProblems;

/// Why a file could not be read or written.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[non_exhaustive]
pub enum Error {
    /// A file could not be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// A file could not be written.
    #[error("cannot write {}: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// A file would be overwritten that the command needs.
    #[error("{} would be overwritten: {why}", path.display())]
    #[diagnostic(help("name another file or folder to be written"))]
    Overwrites {
        /// The file.
        path: PathBuf,
        /// What it is needed for, in words.
        why: String,
    },
    /// A file was read, but it has problems.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Problems(#[from] FileProblems),
}
