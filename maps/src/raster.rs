//! The image of a map: decoding PGM and PNG within bounds.

mod pgm;
mod png;
mod samples;

pub(crate) use pgm::encode as encode_pgm;
pub(crate) use png::encode as encode_png;
pub use samples::MAX_CELLS;
pub(crate) use samples::{Raster, RasterError};

impl Raster {
    /// Decodes a PGM (plain or raw) or a PNG.
    pub(crate) fn decode(bytes: &[u8]) -> Result<Self, RasterError> {
        match bytes {
            [b'P', b'2', ..] => pgm::decode_plain(bytes),
            [b'P', b'5', ..] => pgm::decode_raw(bytes),
            [b'P', b'1' | b'4', ..] => Err(RasterError::OtherNetpbm("a bitmap (PBM)")),
            [b'P', b'3' | b'6', ..] => Err(RasterError::OtherNetpbm("a color image (PPM)")),
            [b'P', b'7', ..] => Err(RasterError::OtherNetpbm("a PAM image")),
            [0x89, b'P', b'N', b'G', ..] => png::decode(bytes),
            _ => Err(RasterError::Magic),
        }
    }

    /// The samples of each pixel, row by row from the top.
    pub(crate) fn pixels(&self) -> impl DoubleEndedIterator<Item = &[u16]> {
        self.samples.chunks_exact(self.channels)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_that_are_not_graymaps_are_named() {
        assert_eq!(Raster::decode(b"P6 1 1 255 abc"), Err(RasterError::OtherNetpbm("a color image (PPM)")));
        assert_eq!(Raster::decode(b"\xff\xd8\xff\xe0"), Err(RasterError::Magic));
        assert_eq!(Raster::decode(b""), Err(RasterError::Magic));
    }

    #[test]
    fn an_absurd_size_is_refused_before_memory_is_allocated() {
        let error = RasterError::TooLarge { width: 4_000_000_000, height: 4_000_000_000 };
        assert_eq!(Raster::decode(b"P5 4000000000 4000000000 255 "), Err(error));
    }
}
