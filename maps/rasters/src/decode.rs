//! Reading an image of any kind.

use std::io::Cursor;

use image::codecs::bmp::BmpDecoder;
use image::codecs::png::PngDecoder;
use image::{ImageFormat, Limits};

use super::pnm;
use super::raster::{Raster, RasterError};

/// A PNG decoder holds at most this many bytes besides the samples: a map of 100 million cells takes 100 MB.
const MAX_DECODER_BYTES: u64 = 512 << 20;

impl Raster {
    /// Decodes an image: PGM, PBM or PPM (plain or raw), PNG, or BMP, with at most `max_pixels` pixels.
    ///
    /// Palettes become RGB, and transparency becomes an alpha channel. Samples are taken unchanged, without regard to
    /// gamma or color profiles.
    ///
    /// # Errors
    /// [`RasterError`], before memory is allocated for pixels if there are too many of them.
    pub fn decode(bytes: &[u8], max_pixels: usize) -> Result<Self, RasterError> {
        if let [b'P', b'1'..=b'6', ..] = bytes {
            return pnm::decode(bytes, max_pixels);
        }
        match image::guess_format(bytes) {
            Ok(ImageFormat::Png) => {
                let mut limits = Limits::no_limits();
                limits.max_alloc = Some(MAX_DECODER_BYTES);
                Self::read(PngDecoder::with_limits(Cursor::new(bytes), limits)?, max_pixels)
            }
            Ok(ImageFormat::Bmp) => Self::read(BmpDecoder::new(Cursor::new(bytes))?, max_pixels),
            _ => Err(RasterError::Format),
        }
    }
}

#[cfg(test)]
mod tests {
    use image::ExtendedColorType::{L8, L16, La8, Rgb8, Rgba8};
    use image::codecs::bmp::BmpEncoder;
    use image::codecs::png::PngEncoder;
    use image::{ExtendedColorType, ImageEncoder};
    use proptest::prelude::*;

    use super::*;
    use crate::{encode_gray_png, encode_pgm};

    const MAX_PIXELS: usize = 1_000_000;

    fn png(width: u32, color: ExtendedColorType, samples: &[u8]) -> Vec<u8> {
        let mut file = Vec::new();
        PngEncoder::new(&mut file).write_image(samples, width, 1, color).unwrap();
        file
    }

    fn bmp(width: u32, color: ExtendedColorType, samples: &[u8]) -> Vec<u8> {
        let mut file = Vec::new();
        BmpEncoder::new(&mut file).write_image(samples, width, 1, color).unwrap();
        file
    }

    #[test]
    fn every_color_type_keeps_its_samples() {
        for (color, channels) in [(L8, 1), (La8, 2), (Rgb8, 3), (Rgba8, 4)] {
            let samples: Vec<u8> = (0..2 * channels as u8).collect();
            let raster = Raster::decode(&png(2, color, &samples), MAX_PIXELS).unwrap();
            assert_eq!((raster.width(), raster.height(), raster.white()), (2, 1, 255));
            assert!(raster.pixels().map(<[u16]>::len).eq([channels; 2]));
        }
    }

    #[test]
    fn sixteen_bits_stay_sixteen_bits() {
        let samples: Vec<u8> = [300_u16, 65_535].iter().flat_map(|sample| sample.to_ne_bytes()).collect();
        let raster = Raster::decode(&png(2, L16, &samples), MAX_PIXELS).unwrap();
        assert!(raster.white() == 65_535 && raster.pixels().eq([[300], [65_535]]));
    }

    #[test]
    fn a_bmp_has_colors() {
        let raster = Raster::decode(&bmp(2, Rgb8, &[1, 2, 3, 254, 0, 7]), MAX_PIXELS).unwrap();
        assert!(raster.pixels().eq([[1, 2, 3], [254, 0, 7]]));
        // A gray BMP has a palette.
        let raster = Raster::decode(&bmp(3, L8, &[0, 205, 254]), MAX_PIXELS).unwrap();
        assert!(raster.pixels().eq([[0; 3], [205; 3], [254; 3]]));
    }

    #[test]
    fn a_truncated_png_is_an_error() {
        let whole = encode_gray_png(2, 1, &[1, 2]);
        assert!(Raster::decode(&whole, MAX_PIXELS).is_ok());
        for length in 8..whole.len() - 12 {
            assert_eq!(Raster::decode(&whole[..length], MAX_PIXELS), Err(RasterError::Truncated), "cut after {length}");
        }
    }

    #[test]
    fn a_damaged_file_says_what_is_wrong() {
        let mut file = encode_gray_png(2, 1, &[1, 2]);
        file[20] ^= 1;
        let error = Raster::decode(&file, MAX_PIXELS).unwrap_err().to_string();
        assert!(error.starts_with("it is damaged: CRC error"), "{error}");
    }

    #[test]
    fn other_formats_are_refused() {
        for bytes in [b"\xff\xd8\xff\xe0".as_slice(), b"GIF89a", b"P7\nWIDTH 1", b"P", b""] {
            assert_eq!(Raster::decode(bytes, MAX_PIXELS), Err(RasterError::Format));
        }
    }

    #[test]
    fn a_size_that_is_not_allowed_is_refused_before_memory_is_allocated() {
        let error = RasterError::TooLarge { width: 1 << 31, height: 1 << 30, allowed: 9 };
        assert_eq!(Raster::decode(b"P5 2147483648 1073741824 255 ", 9), Err(error));
        assert_eq!(Raster::decode(b"P5 0 4 255 ", 9), Err(RasterError::Empty { width: 0, height: 4 }));
        let error = RasterError::TooLarge { width: 2, height: 1, allowed: 1 };
        assert_eq!(Raster::decode(&png(2, L8, &[1, 2]), 1), Err(error.clone()));
        assert_eq!(Raster::decode(&bmp(2, L8, &[1, 2]), 1), Err(error));
    }

    proptest! {
        #[test]
        fn no_changed_byte_makes_decoding_panic(
            format in 0..3,
            changes in proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..8),
            cut in any::<prop::sample::Index>(),
        ) {
            let samples: Vec<u8> = (0..40).collect();
            let mut file = match format {
                0 => png(10, Rgba8, &samples),
                1 => bmp(10, Rgba8, &samples),
                _ => encode_pgm(10, 4, &samples),
            };
            for (place, byte) in changes {
                let place = place.index(file.len());
                file[place] = byte;
            }
            let _ = Raster::decode(&file, MAX_PIXELS);
            let _ = Raster::decode(&file[..cut.index(file.len())], MAX_PIXELS);
        }
    }
}
