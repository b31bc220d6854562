//! What can go wrong at the crate's boundary.

use std::io;
use std::path::PathBuf;

use crate::FileProblems;

/// Why a map or places file could not be read or written.
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
    /// A map has no cells, or more than [`MAX_CELLS`](crate::MAX_CELLS): it could not be loaded again.
    #[error("a map of {width} × {height} cells cannot be saved: it must have from 1 to {} cells", crate::MAX_CELLS)]
    UnsavableSize {
        /// The map's number of columns.
        width: usize,
        /// The map's number of rows.
        height: usize,
    },
    /// A file was read and is wrong.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Problems(#[from] FileProblems),
}
