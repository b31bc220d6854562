//! The picture of a map: decoding PGM and PNG within bounds.

mod pgm;
mod png;

pub(crate) use pgm::encode as encode_pgm;
pub(crate) use png::encode as encode_png;

/// The largest map that is loaded: 500 m × 500 m at 0.05 m.
pub const MAX_CELLS: usize = 100_000_000;

/// A decoded picture, row by row from the top.
#[derive(Debug, PartialEq)]
pub(crate) struct Raster {
    /// Pixels a row.
    pub(crate) width: usize,
    /// Rows.
    pub(crate) height: usize,
    /// 1 grey, 2 grey and alpha, 3 RGB, 4 RGBA.
    pub(crate) channels: usize,
    /// The sample that means white, or opaque.
    pub(crate) white: u16,
    /// `width` × `height` × `channels` samples, each at most `white`.
    pub(crate) samples: Vec<u16>,
}

/// Why bytes are no picture that a map can be made of.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(crate) enum RasterError {
    #[error("it is neither PGM nor PNG")]
    Magic,
    #[error("it is {0}, not a greymap")]
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

impl Raster {
    /// Decodes a PGM (plain or raw) or a PNG.
    pub(crate) fn decode(bytes: &[u8]) -> Result<Self, RasterError> {
        match bytes {
            [b'P', b'2', ..] => pgm::decode_plain(bytes),
            [b'P', b'5', ..] => pgm::decode_raw(bytes),
            [b'P', b'1' | b'4', ..] => Err(RasterError::OtherNetpbm("a bitmap (PBM)")),
            [b'P', b'3' | b'6', ..] => Err(RasterError::OtherNetpbm("a colour picture (PPM)")),
            [b'P', b'7', ..] => Err(RasterError::OtherNetpbm("a PAM picture")),
            [0x89, b'P', b'N', b'G', ..] => png::decode(bytes),
            _ => Err(RasterError::Magic),
        }
    }

    /// The samples of each pixel, row by row from the top.
    pub(crate) fn pixels(&self) -> impl DoubleEndedIterator<Item = &[u16]> {
        self.samples.chunks_exact(self.channels)
    }
}

/// The number of cells of a picture of that size, if it is one that is allowed.
fn cell_count(width: u64, height: u64) -> Result<usize, RasterError> {
    let count = width.checked_mul(height).and_then(|count| usize::try_from(count).ok());
    count.filter(|count| *count <= MAX_CELLS).ok_or(RasterError::TooLarge { width, height })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_greymap_is_named() {
        assert_eq!(Raster::decode(b"P6 1 1 255 abc"), Err(RasterError::OtherNetpbm("a colour picture (PPM)")));
        assert_eq!(Raster::decode(b"\xff\xd8\xff\xe0"), Err(RasterError::Magic));
        assert_eq!(Raster::decode(b""), Err(RasterError::Magic));
    }

    #[test]
    fn an_absurd_size_is_refused_before_memory_is_taken() {
        let error = RasterError::TooLarge { width: 4_000_000_000, height: 4_000_000_000 };
        assert_eq!(Raster::decode(b"P5 4000000000 4000000000 255 "), Err(error));
    }
}
