//! PGM, the portable graymap: plain (P2) and raw (P5).
//!
//! Source: the format's description at <https://netpbm.sourceforge.net/doc/pgm.html>.

use super::samples::{Raster, RasterError, cell_count};

/// The header, which precedes the pixels.
struct Header {
    width: usize,
    height: usize,
    white: u16,
}

/// Decodes a plain graymap: decimal numbers separated by blanks. Comments may be anywhere.
pub(super) fn decode_plain(bytes: &[u8]) -> Result<Raster, RasterError> {
    let mut reader = Reader::new(bytes);
    let Header { width, height, white } = reader.header()?;
    let wanted = width * height;
    // A pixel takes at least a digit and a blank, so a short file cannot demand much memory.
    let mut samples = Vec::with_capacity(wanted.min(bytes.len() / 2 + 1));
    while samples.len() < wanted {
        let (column, row) = (samples.len() % width, samples.len() / width);
        if reader.at_end() {
            return Err(RasterError::Truncated { found: samples.len(), wanted });
        }
        let value = reader.number().ok_or(RasterError::NotANumber { column, row })?;
        samples.push(sample(value, white, column, row)?);
    }
    Ok(Raster { width, height, channels: 1, white, samples })
}

/// Decodes a raw graymap: one byte per pixel, or two, the higher first, if white is above 255. Data after the pixels is
/// ignored, as the format demands.
pub(super) fn decode_raw(bytes: &[u8]) -> Result<Raster, RasterError> {
    let mut reader = Reader::new(bytes);
    let Header { width, height, white } = reader.header()?;
    let size = if white > 255 { 2 } else { 1 };
    let wanted = width * height;
    let rest = reader.rest();
    let Some(pixels) = rest.get(..wanted * size) else {
        return Err(RasterError::Truncated { found: rest.len() / size, wanted });
    };
    let samples = pixels.chunks_exact(size).enumerate().map(|(place, bytes)| {
        let value = bytes.iter().fold(0, |value, byte| value << 8 | u64::from(*byte));
        sample(value, white, place % width, place / width)
    });
    Ok(Raster { width, height, channels: 1, white, samples: samples.collect::<Result<_, _>>()? })
}

/// A raw graymap with one byte per pixel, white at 255.
///
/// # Panics
/// If there are not `width` × `height` pixels.
pub(crate) fn encode(width: usize, height: usize, pixels: &[u8]) -> Vec<u8> {
    assert_eq!(pixels.len(), width * height, "an image must have one pixel per column and row");
    let mut bytes = format!("P5\n{width} {height}\n255\n").into_bytes();
    bytes.extend_from_slice(pixels);
    bytes
}

fn sample(value: u64, white: u16, column: usize, row: usize) -> Result<u16, RasterError> {
    let sample = u16::try_from(value).ok().filter(|sample| *sample <= white);
    sample.ok_or(RasterError::TooBright { column, row, value, white })
}

/// Reads numbers separated by blanks and comments.
struct Reader<'b> {
    bytes: &'b [u8],
    at: usize,
}

impl<'b> Reader<'b> {
    /// Begins after the two bytes of the magic number.
    fn new(bytes: &'b [u8]) -> Self {
        Self { bytes, at: 2 }
    }

    fn header(&mut self) -> Result<Header, RasterError> {
        let width = self.header_number("width", u64::from(u32::MAX))?;
        let height = self.header_number("height", u64::from(u32::MAX))?;
        let white = self.header_number("maximum value", 65_535)?;
        cell_count(width, height)?;
        let white = u16::try_from(white).expect("the maximum value was checked");
        Ok(Header { width: width as usize, height: height as usize, white })
    }

    fn header_number(&mut self, what: &'static str, max: u64) -> Result<u64, RasterError> {
        let value = self.number().ok_or(RasterError::Header(what))?;
        if (1..=max).contains(&value) { Ok(value) } else { Err(RasterError::OutOfRange { what, value, max }) }
    }

    /// The next number; `None` if something else comes next. Numbers that are too large saturate.
    fn number(&mut self) -> Option<u64> {
        self.skip_blanks();
        let digits = self.bytes[self.at..].iter().take_while(|byte| byte.is_ascii_digit()).count();
        let number = &self.bytes[self.at..self.at + digits];
        let ends = self.bytes.get(self.at + digits).is_none_or(|byte| byte.is_ascii_whitespace() || *byte == b'#');
        self.at += digits;
        let value =
            number.iter().fold(0, |value: u64, digit| value.saturating_mul(10).saturating_add(u64::from(digit - b'0')));
        (digits > 0 && ends).then_some(value)
    }

    fn at_end(&mut self) -> bool {
        self.skip_blanks();
        self.at == self.bytes.len()
    }

    /// Skips blanks and comments; a comment extends from `#` to the end of the line.
    fn skip_blanks(&mut self) {
        let mut in_comment = false;
        while let Some(byte) = self.bytes.get(self.at) {
            match byte {
                b'\n' | b'\r' => in_comment = false,
                b'#' => in_comment = true,
                byte if !in_comment && !byte.is_ascii_whitespace() => return,
                _ => {}
            }
            self.at += 1;
        }
    }

    /// The bytes after the single blank that ends the header. A comment that begins right there belongs to the header.
    fn rest(&mut self) -> &'b [u8] {
        if self.bytes.get(self.at) == Some(&b'#') {
            let comment = self.bytes[self.at..].iter().take_while(|byte| **byte != b'\n').count();
            self.at += comment;
        }
        self.bytes.get(self.at + 1..).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gray(width: usize, height: usize, white: u16, samples: &[u16]) -> Raster {
        Raster { width, height, channels: 1, white, samples: samples.to_vec() }
    }

    #[test]
    fn plain_and_raw_give_the_same_result() {
        let wanted = Ok(gray(3, 2, 9, &[0, 1, 2, 7, 8, 9]));
        assert_eq!(decode_plain(b"P2\n# drawn by hand\n3 2\n9\n0 1 2 # first row\n7 8 9"), wanted);
        assert_eq!(decode_raw(b"P5 3 # width\n2\n9\n\x00\x01\x02\x07\x08\x09 and more"), wanted);
    }

    #[test]
    fn a_white_above_255_takes_two_bytes_with_the_higher_one_first() {
        assert_eq!(decode_raw(b"P5 2 1 300\n\x01\x2c\x00\x07"), Ok(gray(2, 1, 300, &[300, 7])));
    }

    #[test]
    fn a_pixel_that_looks_like_a_blank_is_a_pixel() {
        assert_eq!(decode_raw(b"P5 2 1 255\n\n#"), Ok(gray(2, 1, 255, &[10, 35])));
    }

    #[test]
    fn errors_say_what_is_wrong_and_where() {
        assert_eq!(decode_raw(b"P5 2 2 255\nabc"), Err(RasterError::Truncated { found: 3, wanted: 4 }));
        assert_eq!(decode_raw(b"P5 2 2 300\nabc"), Err(RasterError::Truncated { found: 1, wanted: 4 }));
        assert_eq!(decode_raw(b"P5 2"), Err(RasterError::Header("height")));
        assert_eq!(decode_plain(b"P2 2 2x 255"), Err(RasterError::Header("height")));
        let out = RasterError::OutOfRange { what: "maximum value", value: 65_536, max: 65_535 };
        assert_eq!(decode_plain(b"P2 1 1 65536 0"), Err(out));
        assert_eq!(decode_plain(b"P2 2 2 9 1 2 x 4"), Err(RasterError::NotANumber { column: 0, row: 1 }));
        let bright = RasterError::TooBright { column: 1, row: 0, value: 10, white: 9 };
        assert_eq!(decode_plain(b"P2 2 1 9 1 10"), Err(bright));
    }
}
