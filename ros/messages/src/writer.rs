//! Writes CDR, little-endian: each number at a multiple of its own size.
//!
//! Source: OMG's DDS-XTypes 1.3, 7.4.1 (plain CDR, version 1).

/// What precedes every message: the encoding, and two bytes of options.
const ENCODING: [u8; 4] = [0, 1, 0, 0];

/// A message while it is encoded.
#[derive(Debug)]
pub struct CdrWriter {
    bytes: Vec<u8>,
}

impl CdrWriter {
    /// Begins a message in the memory of another.
    #[must_use]
    pub fn reusing(mut bytes: Vec<u8>) -> Self {
        bytes.clear();
        bytes.extend(ENCODING);
        Self { bytes }
    }

    /// Writes a number's bytes, the least significant first, after padding.
    pub fn number<const SIZE: usize>(&mut self, bytes: [u8; SIZE]) {
        self.align::<SIZE>();
        self.bytes.extend(bytes);
    }

    /// Writes several numbers of one size: only the first needs padding.
    pub fn numbers<const SIZE: usize>(&mut self, numbers: impl ExactSizeIterator<Item = [u8; SIZE]>) {
        if numbers.len() == 0 {
            return;
        }
        self.align::<SIZE>();
        let at = self.bytes.len();
        self.bytes.resize(at + SIZE * numbers.len(), 0);
        let (places, _) = self.bytes[at..].as_chunks_mut::<SIZE>();
        places.iter_mut().zip(numbers).for_each(|(place, bytes)| *place = bytes);
    }

    fn align<const SIZE: usize>(&mut self) {
        let length = (self.bytes.len() - ENCODING.len()).next_multiple_of(SIZE);
        self.bytes.resize(ENCODING.len() + length, 0);
    }

    /// Writes the length of a sequence.
    pub fn length(&mut self, length: usize) {
        self.number(u32::try_from(length).unwrap_or(u32::MAX).to_le_bytes());
    }

    /// Writes text, with its length and a zero at the end.
    pub fn text(&mut self, text: &str) {
        self.length(text.len() + 1);
        self.bytes.extend(text.as_bytes());
        self.bytes.push(0);
    }

    /// The whole message.
    #[must_use]
    pub fn bytes(self) -> Vec<u8> {
        self.bytes
    }
}
