//! Several records at a time, compressed: what all recordings consist of.

use std::io;

use lz4_flex::block;

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
    pub(crate) fn pack(&mut self) -> Option<Vec<u8>> {
        let packed = (!self.0.is_empty()).then(|| block::compress_prepend_size(&self.0));
        self.0.clear();
        packed
    }

    /// How many bytes they take.
    pub(crate) fn len(&self) -> usize {
        self.0.len()
    }
}

/// The records of a compressed chunk, encoded.
pub(crate) fn unpack(packed: &[u8]) -> Result<Vec<u8>, ChunkError> {
    /// No byte of a compressed block stands for more bytes.
    const MOST: usize = 255;
    let (size, block) = block::uncompressed_size(packed).map_err(|_| ChunkError::Damaged)?;
    if size == 0 || size > block.len().saturating_mul(MOST) || size as u64 > MAX_CHUNK_BYTES {
        return Err(ChunkError::Damaged);
    }
    block::decompress(block, size).ok().filter(|records| records.len() == size).ok_or(ChunkError::Damaged)
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
