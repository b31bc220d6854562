//! PGM, the portable graymap, and its relatives PBM and PPM: plain (P1 to P3) and raw (P4 to P6).
//!
//! Source: the format's description at <https://netpbm.sourceforge.net/doc/pgm.html>.

use std::borrow::Cow;

use image::codecs::pnm::{PnmDecoder, PnmHeader, PnmSubtype, SampleEncoding};

use super::raster::{Raster, RasterError, pixel_count};

/// Decodes a portable map, whose maximum is white. Comments may be anywhere in a plain file, and data after the pixels
/// of a raw one is ignored.
pub(super) fn decode(bytes: &[u8], max_pixels: usize) -> Result<Raster, RasterError> {
    let bytes = match bytes {
        [_, b'1'..=b'3', ..] => Cow::Owned(without_comments(bytes)),
        _ => Cow::Borrowed(bytes),
    };
    let (rest, header) = PnmDecoder::new(&*bytes)?.into_inner();
    let wanted = pixel_count(header.width(), header.height(), max_pixels)?;
    if let Some(found) = complete_pixels(&header, rest).filter(|found| *found < wanted) {
        return Err(RasterError::TruncatedPixels { found, wanted });
    }
    if let Some(value) = too_bright(&header, rest) {
        return Err(RasterError::TooBright { value, white: header.maximal_sample() });
    }
    let raster = Raster::read(PnmDecoder::new(&*bytes)?, max_pixels)?;
    // The decoder has scaled the samples to eight or sixteen bits. Below a white of 65,534 it merges none, so they can
    // be scaled back, and a threshold separates the same ones as in the file.
    Ok(match u16::try_from(header.maximal_sample()) {
        Ok(white) if white != raster.white() => raster.scaled_to(white),
        _ => raster,
    })
}

/// How the samples of a graymap or pixmap are written, and how many each pixel has.
fn samples_of(header: &PnmHeader) -> Option<(SampleEncoding, usize)> {
    match header.subtype() {
        PnmSubtype::Graymap(encoding) => Some((encoding, 1)),
        PnmSubtype::Pixmap(encoding) => Some((encoding, 3)),
        _ => None,
    }
}

/// How many pixels of a graymap or pixmap are there. The decoder itself would take each number that a plain file lacks
/// for a zero, and half a map would be a solid wall.
fn complete_pixels(header: &PnmHeader, rest: &[u8]) -> Option<usize> {
    let (encoding, channels) = samples_of(header)?;
    let samples = match encoding {
        SampleEncoding::Ascii => rest.split(u8::is_ascii_whitespace).filter(|number| !number.is_empty()).count(),
        SampleEncoding::Binary if header.maximal_sample() > 255 => rest.len() / 2,
        SampleEncoding::Binary => rest.len(),
    };
    Some(samples / channels)
}

/// The first sample of a graymap or pixmap above its maximum. The decoder itself would take it for white.
fn too_bright(header: &PnmHeader, rest: &[u8]) -> Option<u32> {
    let (encoding, channels) = samples_of(header)?;
    let (white, count) = (header.maximal_sample(), header.width() as usize * header.height() as usize * channels);
    let is_too_bright = |value: &u32| *value > white;
    match (encoding, white) {
        // No byte and no pair of bytes is above these.
        (SampleEncoding::Binary, 255 | 65_535) => None,
        (SampleEncoding::Binary, 256..) => {
            let samples = rest.as_chunks().0.iter().take(count).map(|bytes| u32::from(u16::from_be_bytes(*bytes)));
            samples.into_iter().find(is_too_bright)
        }
        (SampleEncoding::Binary, _) => rest.iter().take(count).map(|byte| u32::from(*byte)).find(is_too_bright),
        (SampleEncoding::Ascii, _) => {
            let numbers = rest.split(u8::is_ascii_whitespace).filter(|number| !number.is_empty()).take(count);
            numbers.filter_map(|number| std::str::from_utf8(number).ok()?.parse().ok()).find(is_too_bright)
        }
    }
}

/// A plain file with a blank in place of each comment, which extends from `#` to the end of the line. The decoder
/// expects comments only in the header.
fn without_comments(bytes: &[u8]) -> Vec<u8> {
    let mut in_comment = false;
    let blanked = bytes.iter().map(|byte| {
        in_comment = (in_comment || *byte == b'#') && !matches!(byte, b'\n' | b'\r');
        if in_comment { b' ' } else { *byte }
    });
    blanked.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples(bytes: &[u8]) -> Result<(usize, u16, Vec<u16>), RasterError> {
        let raster = decode(bytes, 1_000_000)?;
        Ok((raster.width(), raster.white(), raster.pixels().flatten().copied().collect()))
    }

    #[test]
    fn plain_and_raw_give_the_same_result() {
        let wanted = Ok((3, 9, vec![0, 1, 2, 7, 8, 9]));
        assert_eq!(samples(b"P2\n# drawn by hand\n3 2\n9\n0 1 2 # first row\n7 8 9"), wanted);
        assert_eq!(samples(b"P5 3 # width\n2\n9\n\x00\x01\x02\x07\x08\x09 and more"), wanted);
    }

    #[test]
    fn a_white_above_255_takes_two_bytes_with_the_higher_one_first() {
        assert_eq!(samples(b"P5 2 1 300\n\x01\x2c\x00\x07"), Ok((2, 300, vec![300, 7])));
    }

    #[test]
    fn every_sample_is_that_of_the_file_whatever_its_white() {
        for white in [1, 2, 99, 100, 254, 256, 1_000, 32_767, 65_000] {
            let file: String = (0..=white).map(|sample| format!("{sample}\n")).collect();
            let file = format!("P2 1 {} {white}\n{file}", u32::from(white) + 1);
            assert!(samples(file.as_bytes()) == Ok((1, white, (0..=white).collect())), "{white}");
        }
    }

    #[test]
    fn a_sample_above_white_is_refused() {
        let bright = |value, white| Err(RasterError::TooBright { value, white });
        assert_eq!(samples(b"P5 2 1 9\n\x08\x0a"), bright(10, 9));
        assert_eq!(samples(b"P2 2 1 9\n10 8"), bright(10, 9));
        assert_eq!(samples(b"P5 2 1 300\n\x01\x2d\x00\x07"), bright(301, 300));
        assert_eq!(samples(b"P6 1 1 9\n\x01\x02\x0b"), bright(11, 9));
        // What follows the pixels is none.
        assert_eq!(samples(b"P5 2 1 9\n\x08\x09\xff"), Ok((2, 9, vec![8, 9])));
    }

    #[test]
    fn a_pixel_that_looks_like_a_blank_is_a_pixel() {
        assert_eq!(samples(b"P5 2 1 255\n\n#"), Ok((2, 255, vec![10, 35])));
    }

    #[test]
    fn bitmaps_and_pixmaps_are_read() {
        assert_eq!(samples(b"P1 3 1 1 0 1"), Ok((3, 1, vec![0, 1, 0])));
        assert_eq!(samples(b"P4 3 1\n\xa0"), Ok((3, 1, vec![0, 1, 0])));
        assert_eq!(samples(b"P3 1 1 255 1 2 3"), Ok((1, 255, vec![1, 2, 3])));
        assert_eq!(samples(b"P6 1 1 255\n\x01\x02\x03"), Ok((1, 255, vec![1, 2, 3])));
    }

    #[test]
    fn a_truncated_file_says_how_much_is_there() {
        let truncated = |found, wanted| Err(RasterError::TruncatedPixels { found, wanted });
        assert_eq!(samples(b"P5 2 2 255\nabc"), truncated(3, 4));
        assert_eq!(samples(b"P5 2 2 300\nabc"), truncated(1, 4));
        assert_eq!(samples(b"P6 2 2 255\nabcdefgh"), truncated(2, 4));
        assert_eq!(samples(b"P2 2 2 9 1 2 3 # 4"), truncated(3, 4));
        assert_eq!(samples(b"P3 2 2 9 1 2 3 4"), truncated(1, 4));
        assert_eq!(samples(b"P5 2"), Err(RasterError::Truncated));
        assert!(matches!(samples(b"P1 2 2 0 1"), Err(RasterError::Damaged(_))));
    }

    #[test]
    fn a_wrong_header_or_number_is_named() {
        let problem = |bytes: &[u8]| samples(bytes).unwrap_err().to_string();
        let number = problem(b"P2 2 2x 255 0 0 0 0");
        assert_eq!(number, "it is damaged: Error parsing \"2x\" as number in preamble: invalid digit found in string");
        assert_eq!(problem(b"P2 1 1 65536 0"), "it is damaged: Image MAXVAL exceeds 65535: 65536");
        assert_eq!(problem(b"P2 1 1 0 0"), "it is damaged: Image MAXVAL is zero");
        let sample = "it is damaged: Non-ASCII-digit character when parsing number in sample";
        assert_eq!(problem(b"P2 2 2 9 1 2 x 4"), sample);
        assert_eq!(problem(b"P2 2 2 9 1 2 999 4"), "it has a sample of 999, above its maximum of 9");
    }
}
