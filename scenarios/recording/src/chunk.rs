//! Several records at a time, compressed: what all recordings consist of.

use std::io::{self, Read, Write};

use lz4_flex::frame::{FrameDecoder, FrameEncoder, FrameInfo};

use crate::Record;

/// No chunk takes more bytes than this, compressed or not; a step is at most a part of one.
pub(crate) const MAX_CHUNK_BYTES: u64 = 1 << 30;

/// Records on their way to a file, several at a time.
#[derive(Debug, Default)]
pub(crate) struct Chunk(Vec<u8>);

impl Chunk {
    pub(crate) fn push(&mut self, record: &Record) -> io::Result<()> {
        let records = std::mem::take(&mut self.0);
        self.0 = postcard::to_extend(record, records).map_err(io::Error::other)?;
        Ok(())
    }

    /// The records so far, compressed; none if there are none.
    pub(crate) fn pack(&mut self) -> io::Result<Option<Vec<u8>>> {
        if self.0.is_empty() {
            return Ok(None);
        }
        // Damage would show in the checksum.
        let mut packed = FrameEncoder::with_frame_info(FrameInfo::new().content_checksum(true), Vec::new());
        packed.write_all(&self.0)?;
        self.0.clear();
        packed.finish().map(Some).map_err(io::Error::other)
    }

    /// How many bytes they take.
    pub(crate) fn len(&self) -> usize {
        self.0.len()
    }
}

/// The records of a compressed chunk, encoded.
pub(crate) fn unpack(packed: &[u8]) -> Result<Vec<u8>, ChunkError> {
    let mut records = Vec::new();
    let read = FrameDecoder::new(packed).take(MAX_CHUNK_BYTES + 1).read_to_end(&mut records);
    let fits = read.is_ok_and(|size| (1..=MAX_CHUNK_BYTES).contains(&(size as u64)));
    fits.then_some(records).ok_or(ChunkError::Damaged)
}

/// Why there is no next chunk.
#[derive(Debug, thiserror::Error)]
pub(crate) enum ChunkError {
    #[error(transparent)]
    Read(#[from] io::Error),
    #[error("no records of a run")]
    Foreign,
    #[error("damaged")]
    Damaged,
    #[error("compressed with {0}")]
    Compressed(String),
    #[error("version {0}")]
    Version(u32),
}
