//! What can go wrong with a file.

use std::io;
use std::path::PathBuf;

use crate::FileProblems;

/// Why a file could not be read or written.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[non_exhaustive]
pub enum Error {
    /// A file that the caller named could not be read at all.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A file could not be written.
    #[error("cannot write {}: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A file was read and is wrong.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Problems(#[from] FileProblems),
}
