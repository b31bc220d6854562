//! What is packed by Zstandard.

use std::io::{self, Read};

use ruzstd::decoding::{FrameDecoder, StreamingDecoder};

/// Unpacks Zstandard. The decoder describes damage by the names of its types.
pub(super) struct Zstandard<R: Read>(StreamingDecoder<R, FrameDecoder>);

impl<R: Read> Zstandard<R> {
    const DAMAGED: &'static str = "its Zstandard data is cut off or damaged";

    pub(super) fn new(packed: R) -> io::Result<Self> {
        StreamingDecoder::new(packed).map(Self).map_err(|_| io::Error::other(Self::DAMAGED))
    }
}

impl<R: Read> Read for Zstandard<R> {
    fn read(&mut self, plain: &mut [u8]) -> io::Result<usize> {
        self.0.read(plain).map_err(|_| io::Error::other(Self::DAMAGED))
    }
}
