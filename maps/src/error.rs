//! Errors at the crate's boundary.

/// Why a map could not be saved.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[non_exhaustive]
pub enum Error {
    /// A file could not be written.
    #[error(transparent)]
    #[diagnostic(transparent)]
    File(#[from] diagnostics::Error),
    /// A map has no cells, or more than [`MAX_CELLS`](crate::MAX_CELLS): it could not be loaded again.
    #[error("a map of {width} × {height} cells cannot be saved: it must have from 1 to {} cells", crate::MAX_CELLS)]
    UnsavableSize {
        /// The map's number of columns.
        width: usize,
        /// The map's number of rows.
        height: usize,
    },
}
