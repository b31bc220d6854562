//! Errors with pictures.

use resvg::usvg;

/// Why a picture could not be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The text is not an SVG picture.
    #[error("cannot read the picture")]
    Read(#[source] usvg::Error),
    /// The picture is too large to be held in memory, or empty.
    #[error("the picture has no size that can be rendered")]
    Size,
    /// The writer of an animation failed.
    #[error("cannot write the animation")]
    Write(#[from] std::io::Error),
}
