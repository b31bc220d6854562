//! Recordings as files.

use std::fs::File;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

use flate2::Compression;
use flate2::read::ZlibDecoder;
use flate2::write::ZlibEncoder;
use serde::{Deserialize, Serialize};

use crate::{End, Header, Inconsistent, RunView, Step};

/// The first bytes of every recording.
const MAGIC: [u8; 8] = *b"STEWREC\n";
/// The version of the format. It goes up with every change of the records.
pub const FORMAT: u32 = 5;
/// A chunk is written once its records take this many bytes.
const CHUNK_BYTES: usize = 256 * 1024;
/// No chunk takes more bytes than this, compressed or not; a step is at most a part of one.
const MAX_CHUNK_BYTES: u64 = 1 << 30;

/// One record of a run.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub enum Record {
    /// What does not change during the run; the first record.
    Header(Box<Header>),
    /// A step.
    Step(Step),
    /// The end; the last record.
    End(Box<End>),
}

/// Why a recording cannot be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecordingError {
    /// The file cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The operating system's error.
        source: io::Error,
    },
    /// The file is not a recording.
    #[error("{} is not a recording of a run", .0.display())]
    Foreign(PathBuf),
    /// The file is a recording in another version of the format.
    #[error("{} has version {found} of the format; this program reads version {FORMAT}", path.display())]
    Version {
        /// The file.
        path: PathBuf,
        /// The version of the file.
        found: u32,
    },
    /// The file was changed after it was written.
    #[error("{} is damaged", .0.display())]
    Damaged(PathBuf),
    /// The file ends before its run does.
    #[error("{} ends before its run does, {told}", path.display())]
    Truncated {
        /// The file.
        path: PathBuf,
        /// How much of the run it contains, in words.
        told: String,
    },
}

/// Writes a recording.
///
/// The documentation of the crate describes the file. It is written in chunks: if the program is killed, the chunks
/// already written remain readable.
#[derive(Debug)]
pub struct Writer<W: Write> {
    output: W,
    chunk: Vec<u8>,
}

impl<W: Write> Writer<W> {
    /// Starts a recording.
    ///
    /// # Errors
    /// If writing fails.
    pub fn begin(mut output: W) -> io::Result<Self> {
        output.write_all(&MAGIC)?;
        output.write_all(&FORMAT.to_le_bytes())?;
        Ok(Self { output, chunk: Vec::new() })
    }

    /// Writes a record.
    ///
    /// # Errors
    /// If writing fails.
    pub fn write(&mut self, record: &Record) -> io::Result<()> {
        let chunk = std::mem::take(&mut self.chunk);
        self.chunk = postcard::to_extend(record, chunk).map_err(io::Error::other)?;
        if self.chunk.len() >= CHUNK_BYTES { self.flush() } else { Ok(()) }
    }

    fn flush(&mut self) -> io::Result<()> {
        if self.chunk.is_empty() {
            return Ok(());
        }
        let mut packed = ZlibEncoder::new(Vec::new(), Compression::default());
        packed.write_all(&self.chunk)?;
        let packed = packed.finish()?;
        let length = u32::try_from(packed.len()).map_err(io::Error::other)?;
        self.output.write_all(&length.to_le_bytes())?;
        self.output.write_all(&packed)?;
        self.output.flush()?;
        self.chunk.clear();
        Ok(())
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

/// Reads a recording, record by record, in bounded memory.
#[derive(Debug)]
pub struct Recording {
    path: PathBuf,
    input: io::BufReader<File>,
    /// The records of a chunk, and how much of it has been read.
    chunk: Vec<u8>,
    read: usize,
    /// The next record, if it has been peeked at.
    ahead: Option<Record>,
}

impl Recording {
    /// Opens a recording.
    ///
    /// # Errors
    /// [`RecordingError`], if the file cannot be read or is not a recording in this version of the format.
    pub fn open(path: &Path) -> Result<Self, RecordingError> {
        let read = |source| RecordingError::Read { path: path.to_owned(), source };
        let file = File::open(path).map_err(read)?;
        let mut recording =
            Self { path: path.to_owned(), input: io::BufReader::new(file), chunk: Vec::new(), read: 0, ahead: None };
        let mut head = [0; MAGIC.len() + 4];
        let length = recording.fill(&mut head)?;
        if length < head.len() || head[..MAGIC.len()] != MAGIC {
            return Err(RecordingError::Foreign(path.to_owned()));
        }
        let found = head[MAGIC.len()..].try_into().map_or(0, u32::from_le_bytes);
        if found != FORMAT {
            return Err(RecordingError::Version { path: path.to_owned(), found });
        }
        Ok(recording)
    }

    /// The next record; none at the end of the file, even in the middle of a chunk.
    ///
    /// # Errors
    /// [`RecordingError`], if the file cannot be read or is damaged.
    pub fn next_record(&mut self) -> Result<Option<Record>, RecordingError> {
        if let Some(record) = self.ahead.take() {
            return Ok(Some(record));
        }
        if self.read == self.chunk.len() && !self.next_chunk()? {
            return Ok(None);
        }
        let rest = &self.chunk[self.read..];
        let (record, after) = postcard::take_from_bytes(rest).map_err(|_| self.damaged())?;
        self.read = self.chunk.len() - after.len();
        Ok(Some(record))
    }

    /// Reads the next chunk; false if the file ends first.
    fn next_chunk(&mut self) -> Result<bool, RecordingError> {
        let mut length = [0; 4];
        if self.fill(&mut length)? < length.len() {
            return Ok(false);
        }
        let length = u64::from(u32::from_le_bytes(length));
        let mut packed = Vec::new();
        let copied = (&mut self.input).take(length.min(MAX_CHUNK_BYTES)).read_to_end(&mut packed);
        copied.map_err(|source| self.unreadable(source))?;
        if length > MAX_CHUNK_BYTES {
            return Err(self.damaged());
        }
        if (packed.len() as u64) < length {
            return Ok(false);
        }
        self.chunk.clear();
        self.read = 0;
        let unpacked = ZlibDecoder::new(&packed[..]).take(MAX_CHUNK_BYTES).read_to_end(&mut self.chunk);
        match unpacked {
            Ok(bytes) if bytes > 0 => Ok(true),
            _ => Err(self.damaged()),
        }
    }

    /// Reads until the buffer is full or the file ends. Returns the number of bytes.
    fn fill(&mut self, buffer: &mut [u8]) -> Result<usize, RecordingError> {
        let mut length = 0;
        while length < buffer.len() {
            match self.input.read(&mut buffer[length..]) {
                Ok(0) => break,
                Ok(more) => length += more,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(source) => return Err(self.unreadable(source)),
            }
        }
        Ok(length)
    }

    fn unreadable(&self, source: io::Error) -> RecordingError {
        RecordingError::Read { path: self.path.clone(), source }
    }

    fn damaged(&self) -> RecordingError {
        RecordingError::Damaged(self.path.clone())
    }

    fn truncated(&self, told: String) -> RecordingError {
        RecordingError::Truncated { path: self.path.clone(), told }
    }

    /// The run at its start, from the first two records.
    ///
    /// # Errors
    /// [`RecordingError`].
    pub fn begin(&mut self) -> Result<RunView, RecordingError> {
        let nothing = || "and tells nothing of it".to_owned();
        let header = match self.next_record()? {
            Some(Record::Header(header)) => header,
            Some(_) => return Err(self.damaged()),
            None => return Err(self.truncated(nothing())),
        };
        match self.next_record()? {
            Some(Record::Step(start)) => RunView::new(*header, start).map_err(|Inconsistent| self.damaged()),
            Some(_) => Err(self.damaged()),
            None => Err(self.truncated(nothing())),
        }
    }

    /// Advances by one step; the last step brings the end with it. Call it until the view has an end.
    ///
    /// # Errors
    /// [`RecordingError`]; [`Truncated`](RecordingError::Truncated) if the file ends before the run does.
    pub fn advance(&mut self, view: &mut RunView) -> Result<(), RecordingError> {
        match self.next_record()? {
            Some(Record::Step(step)) => view.apply(step).map_err(|Inconsistent| self.damaged())?,
            Some(_) => return Err(self.damaged()),
            None => return Err(self.truncated(format!("at {:.2} s", view.time().as_secs_f64()))),
        }
        match self.next_record()? {
            Some(Record::End(end)) => view.finish(*end).map_err(|Inconsistent| self.damaged()),
            next => {
                self.ahead = next;
                Ok(())
            }
        }
    }
}
