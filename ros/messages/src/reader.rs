//! Reads CDR, the encoding of ROS 2's messages: each number at a multiple of its own size, big- or little-endian.
//!
//! Source: OMG's DDS-XTypes 1.3, 7.4.1 (plain CDR, version 1).

use crate::value::{Mismatch, WideWidth};

/// A message while it is decoded.
#[derive(Clone, Debug)]
pub struct CdrReader<'b> {
    /// What follows the encoding: numbers are aligned from here.
    bytes: &'b [u8],
    at: usize,
    is_big: bool,
    /// Whether a wide string had a zero. In ROS, none has.
    pub(crate) has_wide_zero: bool,
}

impl<'b> CdrReader<'b> {
    /// Begins with the four bytes that precede every message: the encoding, and two bytes of options.
    ///
    /// # Errors
    /// [`Mismatch::Encoding`] if they are not those of plain CDR.
    pub fn new(message: &'b [u8]) -> Result<Self, Mismatch> {
        match message {
            [0, order @ (0 | 1), _, _, bytes @ ..] => {
                Ok(Self { bytes, at: 0, is_big: *order == 0, has_wide_zero: false })
            }
            _ => Err(Mismatch::Encoding),
        }
    }

    /// How many bytes are left.
    #[must_use]
    pub fn left(&self) -> usize {
        self.bytes.len().saturating_sub(self.at)
    }

    /// The next bytes, without padding before them.
    ///
    /// # Errors
    /// [`Mismatch::Short`] if fewer are left.
    pub fn take(&mut self, count: usize) -> Result<&'b [u8], Mismatch> {
        let taken = self.at.checked_add(count).and_then(|end| self.bytes.get(self.at..end)).ok_or(Mismatch::Short)?;
        self.at += count;
        Ok(taken)
    }

    /// Moves on to the next multiple of a power of two.
    fn align(&mut self, size: usize) {
        self.at = self.at.saturating_add(size - 1) & !(size - 1);
    }

    /// The bytes of a number, the least significant first.
    ///
    /// # Errors
    /// [`Mismatch::Short`] if fewer are left.
    pub fn number<const SIZE: usize>(&mut self) -> Result<[u8; SIZE], Mismatch> {
        self.align(SIZE);
        let mut bytes: [u8; SIZE] = self.take(SIZE)?.try_into().map_err(|_| Mismatch::Short)?;
        if self.is_big {
            bytes.reverse();
        }
        Ok(bytes)
    }

    /// Several numbers of one size, each as [`number`](Self::number): only the first has padding before it.
    ///
    /// # Errors
    /// [`Mismatch::Short`] if fewer are left.
    pub fn numbers<const SIZE: usize>(
        &mut self,
        count: usize,
    ) -> Result<impl Iterator<Item = [u8; SIZE]> + use<'b, SIZE>, Mismatch> {
        let (numbers, _) = self.run(SIZE, count)?.as_chunks::<SIZE>();
        let is_big = self.is_big;
        Ok(numbers.iter().map(move |number| {
            let mut bytes = *number;
            if is_big {
                bytes.reverse();
            }
            bytes
        }))
    }

    /// Skips numbers of one size: only the first has padding before it, and none if there are no numbers.
    ///
    /// # Errors
    /// [`Mismatch::Short`] if fewer are left.
    pub fn skip(&mut self, size: usize, count: usize) -> Result<(), Mismatch> {
        self.run(size, count).map(drop)
    }

    fn run(&mut self, size: usize, count: usize) -> Result<&'b [u8], Mismatch> {
        if count == 0 {
            return Ok(&[]);
        }
        self.align(size);
        self.take(count.saturating_mul(size))
    }

    /// The length of a sequence. Each item has at least one byte, so a length that is greater than what is left is
    /// wrong, and is detected before anything is allocated.
    ///
    /// # Errors
    /// [`Mismatch::Bound`] or [`Mismatch::Short`] if it is greater than the bound or than what is left.
    pub fn length(&mut self, bound: usize) -> Result<usize, Mismatch> {
        let length = u32::from_le_bytes(self.number()?) as usize;
        match length {
            _ if length > bound => Err(Mismatch::Bound),
            _ if length > self.left() => Err(Mismatch::Short),
            _ => Ok(length),
        }
    }

    /// The bytes of a string. Its length includes a terminating zero; for an empty string, some writers leave out the
    /// zero and write the length 0.
    ///
    /// # Errors
    /// As [`length`](Self::length).
    pub fn string(&mut self, bound: Option<usize>) -> Result<&'b [u8], Mismatch> {
        let length = self.length(bound.map_or(usize::MAX, |bound| bound.saturating_add(1)))?;
        let text = self.take(length)?;
        Ok(text.strip_suffix(&[0]).unwrap_or(text))
    }

    /// A wide string in UTF-16. ROS writes its units, in four bytes each; other programs that write four bytes write
    /// characters, each of which may become two units.
    ///
    /// # Errors
    /// As [`length`](Self::length); [`Mismatch::Wide`] if four bytes are neither a unit of UTF-16 nor a character.
    pub fn wide_string(&mut self, bound: Option<usize>, width: WideWidth) -> Result<Vec<u16>, Mismatch> {
        let length = self.length(bound.unwrap_or(usize::MAX))?;
        let mut units: Vec<u16> = Vec::new();
        for _ in 0..length {
            let unit = match width {
                WideWidth::Two => u32::from(u16::from_le_bytes(self.number()?)),
                WideWidth::Four => u32::from_le_bytes(self.number()?),
            };
            if let Ok(unit) = u16::try_from(unit) {
                units.push(unit);
            } else {
                let character = char::from_u32(unit).ok_or(Mismatch::Wide)?;
                units.extend_from_slice(character.encode_utf16(&mut [0; 2]));
            }
        }
        self.has_wide_zero |= units.contains(&0);
        Ok(units)
    }
}
