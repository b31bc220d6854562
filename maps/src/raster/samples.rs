//! The samples of an image, within limits.

/// A decoded image, row by row from the top.
#[derive(Debug, PartialEq)]
pub(crate) struct Raster {
    /// Pixels per row.
    pub(crate) width: usize,
    /// Rows.
    pub(crate) height: usize,
    /// 1 gray, 2 gray and alpha, 3 RGB, 4 RGBA.
    pub(crate) channels: usize,
    /// The sample that means white, or opaque.
    pub(crate) white: u16,
    /// `width` × `height` × `channels` samples, each at most `white`.
    pub(crate) samples: Vec<u16>,
}

/// Why bytes are not an image that can serve as a map.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(crate) enum RasterError {
    #[error("it is neither PGM nor PNG")]
    Magic,
    #[error("it is {0}, not a graymap")]
    OtherNetpbm(&'static str),
    #[error("its {0} is missing or not a number")]
    Header(&'static str),
    #[error("its {what} is {value}, outside 1 to {max}")]
    OutOfRange { what: &'static str, value: u64, max: u64 },
    #[error("it has {width} × {height} pixels, more than the {MAX_CELLS} that are allowed")]
    TooLarge { width: u64, height: u64 },
    #[error("it ends early: {found} of {wanted} pixels")]
    Truncated { found: usize, wanted: usize },
    #[error("the pixel in column {column}, row {row} is not a number")]
    NotANumber { column: usize, row: usize },
    #[error("the pixel in column {column}, row {row} is {value}, above the maximum of {white}")]
    TooBright { column: usize, row: usize, value: u64, white: u16 },
    #[error("the PNG cannot be decoded: {0}")]
    Png(String),
}

/// The number of cells of an image of this size, if it is allowed.
pub(super) fn cell_count(width: u64, height: u64) -> Result<usize, RasterError> {
    let count = width.checked_mul(height).and_then(|count| usize::try_from(count).ok());
    count.filter(|count| *count <= MAX_CELLS).ok_or(RasterError::TooLarge { width, height })
}

/// The largest map that is loaded: 500 m × 500 m at 0.05 m.
pub const MAX_CELLS: usize = 100_000_000;
