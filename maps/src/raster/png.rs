//! PNG: grey, RGB and palette, with and without alpha, 8 or 16 bits a sample.

use std::io::Cursor;

use image::codecs::png::{PngDecoder, PngEncoder};
use image::{ExtendedColorType, ImageDecoder, ImageEncoder, Limits};

use super::samples::{Raster, RasterError, cell_count};

/// Decodes a PNG. A palette becomes RGB, transparency of any kind an alpha channel; samples are taken as they are,
/// without regard to gamma.
pub(super) fn decode(bytes: &[u8]) -> Result<Raster, RasterError> {
    let broken = |error: image::ImageError| RasterError::Png(error.to_string());
    let decoder = PngDecoder::with_limits(Cursor::new(bytes), Limits::default()).map_err(broken)?;
    let (width, height) = decoder.dimensions();
    let cells = cell_count(width.into(), height.into())?;
    let color = decoder.color_type();
    let channels = usize::from(color.channel_count());
    let wide = color.bytes_per_pixel() > color.channel_count();
    let mut buffer = vec![0; cells * usize::from(color.bytes_per_pixel())];
    decoder.read_image(&mut buffer).map_err(broken)?;
    let samples = if wide {
        buffer.as_chunks().0.iter().map(|bytes| u16::from_ne_bytes(*bytes)).collect()
    } else {
        buffer.into_iter().map(u16::from).collect()
    };
    let white = if wide { u16::MAX } else { 255 };
    Ok(Raster { width: width as usize, height: height as usize, channels, white, samples })
}

/// A grey PNG of one byte a pixel, white at 255.
///
/// # Panics
/// If there are not `width` × `height` pixels, or not from 1 to [`MAX_CELLS`](super::MAX_CELLS).
pub(crate) fn encode(width: usize, height: usize, pixels: &[u8]) -> Vec<u8> {
    let side = |length: usize| u32::try_from(length).expect("a side has no more pixels than a map has cells");
    let (width, height) = (side(width), side(height));
    let mut bytes = Vec::new();
    let written = PngEncoder::new(&mut bytes).write_image(pixels, width, height, ExtendedColorType::L8);
    written.expect("a picture of that size can be written to memory");
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn png(pixels: &[u8], color: ExtendedColorType) -> Vec<u8> {
        let mut bytes = Vec::new();
        PngEncoder::new(&mut bytes).write_image(pixels, 2, 1, color).unwrap();
        bytes
    }

    #[test]
    fn every_colour_type_keeps_its_samples() {
        for (color, channels) in [
            (ExtendedColorType::L8, 1),
            (ExtendedColorType::La8, 2),
            (ExtendedColorType::Rgb8, 3),
            (ExtendedColorType::Rgba8, 4),
        ] {
            let pixels: Vec<u8> = (0..2 * channels as u8).collect();
            let raster = decode(&png(&pixels, color)).unwrap();
            assert_eq!((raster.channels, raster.white), (channels, 255));
            assert_eq!(raster.samples, pixels.iter().map(|sample| u16::from(*sample)).collect::<Vec<_>>());
        }
    }

    #[test]
    fn sixteen_bits_stay_sixteen_bits() {
        let pixels: Vec<u8> = [300_u16, 65_535].iter().flat_map(|sample| sample.to_ne_bytes()).collect();
        let raster = decode(&png(&pixels, ExtendedColorType::L16)).unwrap();
        assert_eq!((raster.white, raster.samples), (65_535, vec![300, 65_535]));
    }

    #[test]
    fn a_cut_png_is_an_error() {
        let whole = encode(2, 1, &[1, 2]);
        assert!(decode(&whole).is_ok());
        for length in 8..whole.len() - 12 {
            assert!(matches!(decode(&whole[..length]), Err(RasterError::Png(_))), "cut after {length}");
        }
    }
}
