//! Writing an image to memory.

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::codecs::pnm::{PnmEncoder, PnmSubtype, SampleEncoding};
use image::{ExtendedColorType, ImageEncoder};

/// A raw graymap with one byte per pixel, white at 255.
///
/// # Panics
/// If there are not `width` × `height` pixels, or none.
#[must_use]
pub fn encode_pgm(width: usize, height: usize, pixels: &[u8]) -> Vec<u8> {
    let mut file = Vec::new();
    let encoder = PnmEncoder::new(&mut file).with_subtype(PnmSubtype::Graymap(SampleEncoding::Binary));
    write(encoder, (width, height), ExtendedColorType::L8, pixels);
    file
}

/// A gray PNG with one byte per pixel, white at 255.
///
/// # Panics
/// If there are not `width` × `height` pixels, or none.
#[must_use]
pub fn encode_gray_png(width: usize, height: usize, pixels: &[u8]) -> Vec<u8> {
    encode_png((width, height), ExtendedColorType::L8, pixels)
}

/// A PNG with red, green and blue of each pixel.
///
/// # Panics
/// If there are not `width` × `height` pixels, or none.
#[must_use]
pub fn encode_rgb_png(width: usize, height: usize, pixels: &[[u8; 3]]) -> Vec<u8> {
    encode_png((width, height), ExtendedColorType::Rgb8, pixels.as_flattened())
}

fn encode_png(size: (usize, usize), color: ExtendedColorType, samples: &[u8]) -> Vec<u8> {
    let mut file = Vec::new();
    // Maps and drawings have few colors and large areas of each. Unfiltered, they take two thirds of the bytes that
    // they take with the best filter. The highest level would take three times as long for 1 % less.
    let encoder = PngEncoder::new_with_quality(&mut file, CompressionType::Default, FilterType::NoFilter);
    write(encoder, size, color, samples);
    file
}

fn write(encoder: impl ImageEncoder, (width, height): (usize, usize), color: ExtendedColorType, samples: &[u8]) {
    let side = |length: usize| u32::try_from(length).expect("a side has less than 2^32 pixels");
    encoder.write_image(samples, side(width), side(height), color).expect("an image can be written to memory");
}
