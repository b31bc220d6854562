//! CDR, the encoding of ROS 2's messages: little-endian, each number at a multiple of its own size.
//!
//! Source: OMG's DDS-XTypes 1.3, 7.4.1 (plain CDR, version 1).

/// What precedes every message: the encoding, and two bytes of options.
pub(crate) const HEADER: [u8; 4] = [0, 1, 0, 0];

/// A message on its way to bytes.
#[derive(Debug)]
pub(crate) struct Cdr(Vec<u8>);

impl Cdr {
    pub(crate) fn new() -> Self {
        Self(HEADER.to_vec())
    }

    /// A number's bytes, after padding.
    pub(crate) fn number<const SIZE: usize>(&mut self, bytes: [u8; SIZE]) {
        self.align::<SIZE>();
        self.0.extend(bytes);
    }

    /// The bytes of several numbers: after the first, each is where it belongs.
    pub(crate) fn numbers<const SIZE: usize>(&mut self, numbers: impl ExactSizeIterator<Item = [u8; SIZE]>) {
        if numbers.len() == 0 {
            return;
        }
        self.align::<SIZE>();
        self.0.reserve(SIZE * numbers.len());
        numbers.for_each(|bytes| self.0.extend_from_slice(&bytes));
    }

    fn align<const SIZE: usize>(&mut self) {
        let after_header = (self.0.len() - HEADER.len()).next_multiple_of(SIZE);
        self.0.resize(HEADER.len() + after_header, 0);
    }

    /// The length of a sequence.
    pub(crate) fn length(&mut self, length: usize) {
        self.number(u32::try_from(length).unwrap_or(u32::MAX).to_le_bytes());
    }

    /// Text, with its length and a zero at the end.
    pub(crate) fn text(&mut self, text: &str) {
        self.length(text.len() + 1);
        self.0.extend(text.as_bytes());
        self.0.push(0);
    }

    pub(crate) fn bytes(self) -> Vec<u8> {
        self.0
    }
}
