//! Chunks: several records at a time. All recordings consist of them, and compress them except in MCAP.

use std::io::{self, Read, Write};

use lz4_flex::frame::{BlockSize, FrameDecoder, FrameEncoder, FrameInfo};

use crate::RecordRef;

/// No chunk has more bytes than this, compressed or not; a step is never larger than a chunk.
pub(crate) const MAX_CHUNK_BYTES: u64 = 1 << 30;

/// A chunk is full once its records take this many bytes.
const CHUNK_BYTES: usize = 256 * 1024;

pub(crate) struct Chunk {
    records: Vec<u8>,
    /// Compresses each chunk in the same memory.
    packer: FrameEncoder<Vec<u8>>,
}

impl Default for Chunk {
    fn default() -> Self {
        // The checksum reveals damage.
        let info = FrameInfo::new().content_checksum(true).block_size(BlockSize::Max256KB);
        Self { records: Vec::new(), packer: FrameEncoder::with_frame_info(info, Vec::new()) }
    }
}

impl std::fmt::Debug for Chunk {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Chunk").field("records", &self.records).finish_non_exhaustive()
    }
}

impl Chunk {
    pub(crate) fn push(&mut self, record: RecordRef<'_>) -> io::Result<()> {
        encode(record, &mut self.records)
    }

    /// The records so far, compressed; none if there are none.
    pub(crate) fn pack(&mut self) -> io::Result<Option<&[u8]>> {
        if self.records.is_empty() {
            return Ok(None);
        }
        self.packer.get_mut().clear();
        self.packer.write_all(&self.records)?;
        self.packer.try_finish().map_err(io::Error::other)?;
        self.records.clear();
        Ok(Some(self.packer.get_ref()))
    }

    pub(crate) fn is_full(&self) -> bool {
        self.records.len() >= CHUNK_BYTES
    }
}

pub(crate) fn encode(record: RecordRef<'_>, records: &mut Vec<u8>) -> io::Result<()> {
    *records = postcard::to_extend(&record, std::mem::take(records)).map_err(io::Error::other)?;
    Ok(())
}

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
