//! PNG: gray, RGB and palette, with and without alpha, 8 or 16 bits per sample.

use std::io::Cursor;

use png::{BitDepth, ColorType, Decoder, DecodingError, Encoder, Limits, Transformations};

use super::samples::{Raster, RasterError, cell_count};

/// The decoder holds at most this many bytes besides the samples: the largest map takes 100 MB.
const MAX_DECODER_BYTES: usize = 512 << 20;

/// Decodes a PNG. A palette becomes RGB, any transparency an alpha channel. Samples are taken unchanged, without regard
/// to gamma.
pub(super) fn decode(bytes: &[u8]) -> Result<Raster, RasterError> {
    let broken = |error: DecodingError| RasterError::Png(error.to_string());
    let mut decoder = Decoder::new_with_limits(Cursor::new(bytes), Limits { bytes: MAX_DECODER_BYTES });
    decoder.set_transformations(Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(broken)?;
    let (width, height) = reader.info().size();
    let cells = cell_count(width.into(), height.into())?;
    let (color, depth) = reader.output_color_type();
    let channels = color.samples();
    let wide = depth == BitDepth::Sixteen;
    let mut buffer = vec![0; cells * channels * if wide { 2 } else { 1 }];
    reader.next_frame(&mut buffer).map_err(broken)?;
    let samples = if wide {
        buffer.as_chunks().0.iter().map(|bytes| u16::from_be_bytes(*bytes)).collect()
    } else {
        buffer.into_iter().map(u16::from).collect()
    };
    let white = if wide { u16::MAX } else { 255 };
    Ok(Raster { width: width as usize, height: height as usize, channels, white, samples })
}

/// A gray PNG with one byte per pixel, white at 255.
///
/// # Panics
/// If there are not `width` × `height` pixels, or not from 1 to [`MAX_CELLS`](super::MAX_CELLS).
pub(crate) fn encode(width: usize, height: usize, pixels: &[u8]) -> Vec<u8> {
    let side = |length: usize| u32::try_from(length).expect("a side has no more pixels than a map has cells");
    encode_as((side(width), side(height)), ColorType::Grayscale, BitDepth::Eight, pixels)
}

fn encode_as((width, height): (u32, u32), color: ColorType, depth: BitDepth, samples: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, width, height);
    encoder.set_color(color);
    encoder.set_depth(depth);
    let written = encoder.write_header().and_then(|mut writer| {
        writer.write_image_data(samples)?;
        writer.finish()
    });
    written.expect("an image of that size can be written to memory");
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_color_type_keeps_its_samples() {
        for (color, channels) in
            [(ColorType::Grayscale, 1), (ColorType::GrayscaleAlpha, 2), (ColorType::Rgb, 3), (ColorType::Rgba, 4)]
        {
            let pixels: Vec<u8> = (0..2 * channels as u8).collect();
            let raster = decode(&encode_as((2, 1), color, BitDepth::Eight, &pixels)).unwrap();
            assert_eq!((raster.channels, raster.white), (channels, 255));
            assert_eq!(raster.samples, pixels.iter().map(|sample| u16::from(*sample)).collect::<Vec<_>>());
        }
    }

    #[test]
    fn sixteen_bits_stay_sixteen_bits() {
        let pixels: Vec<u8> = [300_u16, 65_535].iter().flat_map(|sample| sample.to_be_bytes()).collect();
        let raster = decode(&encode_as((2, 1), ColorType::Grayscale, BitDepth::Sixteen, &pixels)).unwrap();
        assert_eq!((raster.white, raster.samples), (65_535, vec![300, 65_535]));
    }

    #[test]
    fn a_truncated_png_is_an_error() {
        let whole = encode(2, 1, &[1, 2]);
        assert!(decode(&whole).is_ok());
        for length in 8..whole.len() - 12 {
            assert!(matches!(decode(&whole[..length]), Err(RasterError::Png(_))), "cut after {length}");
        }
    }
}
