//! Recordings in their own file format.

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom, Write};

use crate::chunk::{Chunk, ChunkError, MAX_CHUNK_BYTES, unpack};
use crate::{FORMAT, Follower, RecordRef, RunView};

const MAGIC: [u8; 8] = *b"STEWREC\n";

/// Writes a recording.
///
/// The documentation of the crate describes the file. It is written in chunks: if the program is killed, the chunks
/// already written remain readable.
#[derive(Debug)]
pub struct Writer<W: Write> {
    output: W,
    chunk: Chunk,
}

impl<W: Write> Writer<W> {
    /// Starts the recording of a run at its start.
    ///
    /// # Errors
    /// If writing fails.
    pub fn begin(mut output: W, view: &RunView) -> io::Result<Self> {
        output.write_all(&MAGIC)?;
        output.write_all(&FORMAT.to_le_bytes())?;
        let mut writer = Self { output, chunk: Chunk::default() };
        RecordRef::at_start(view).try_for_each(|record| writer.write(record))?;
        Ok(writer)
    }

    pub(crate) fn write(&mut self, record: RecordRef<'_>) -> io::Result<()> {
        self.chunk.push(record)?;
        if self.chunk.is_full() { self.flush() } else { Ok(()) }
    }

    /// Writes what has been collected: from then on, readers see it.
    fn flush(&mut self) -> io::Result<()> {
        let Some(packed) = self.chunk.pack()? else { return Ok(()) };
        let length = u32::try_from(packed.len()).map_err(io::Error::other)?;
        self.output.write_all(&length.to_le_bytes())?;
        self.output.write_all(packed)?;
        self.output.flush()
    }

    /// Ends the recording and returns its file.
    ///
    /// # Errors
    /// If writing fails.
    pub fn finish(mut self) -> io::Result<W> {
        self.flush()?;
        Ok(self.output)
    }
}

impl<W: Write> Follower for Writer<W> {
    type Error = io::Error;

    fn follow(&mut self, view: &RunView) -> io::Result<()> {
        RecordRef::newest(view).try_for_each(|record| self.write(record))
    }
}

#[derive(Debug)]
pub(crate) struct FileChunks(BufReader<File>);

impl FileChunks {
    pub(crate) fn begin(mut input: BufReader<File>) -> Result<Self, ChunkError> {
        let mut head = [0; MAGIC.len() + 4];
        let length = fill(&mut input, &mut head)?;
        if length < head.len() || head[..MAGIC.len()] != MAGIC {
            return Err(ChunkError::Foreign);
        }
        let found = head[MAGIC.len()..].try_into().map_or(0, u32::from_le_bytes);
        if found == FORMAT { Ok(Self(input)) } else { Err(ChunkError::Version(found)) }
    }

    /// The records of the next chunk; none if the file ends first. The chunk may be there later if the file grows.
    pub(crate) fn next(&mut self) -> Result<Option<Vec<u8>>, ChunkError> {
        let begin = self.0.stream_position()?;
        let whole = self.whole()?;
        if whole.is_none() {
            self.0.seek(SeekFrom::Start(begin))?;
        }
        whole.map(|packed| unpack(&packed)).transpose()
    }

    /// The next chunk, compressed.
    fn whole(&mut self) -> Result<Option<Vec<u8>>, ChunkError> {
        let mut length = [0; 4];
        if fill(&mut self.0, &mut length)? < length.len() {
            return Ok(None);
        }
        let length = u64::from(u32::from_le_bytes(length));
        let mut packed = Vec::new();
        (&mut self.0).take(length.min(MAX_CHUNK_BYTES)).read_to_end(&mut packed)?;
        if length > MAX_CHUNK_BYTES {
            return Err(ChunkError::Damaged);
        }
        Ok((packed.len() as u64 == length).then_some(packed))
    }
}

/// Reads until the buffer is full or the file ends. Returns the number of bytes.
fn fill(input: &mut impl Read, buffer: &mut [u8]) -> io::Result<usize> {
    let mut length = 0;
    while length < buffer.len() {
        match input.read(&mut buffer[length..]) {
            Ok(0) => break,
            Ok(more) => length += more,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(length)
}
