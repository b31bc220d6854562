//! Reading recordings.

use std::io::{self, BufRead, BufReader};
use std::path::{Path, PathBuf};

use tree_logs::{BagTree, LogError};

use crate::chunk::ChunkError;
use crate::file::FileChunks;
use crate::mcap_file::McapChunks;
use crate::tree_log::TreeLog;
use crate::{End, FORMAT, Header, Inconsistent, Record, RunView, Step};

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
    /// The file is in MCAP, and its chunks are compressed.
    #[error("the chunks of {} are compressed with {by}", path.display())]
    Compressed {
        /// The file.
        path: PathBuf,
        /// The name of the compression.
        by: String,
    },
    /// The file was changed after it was written.
    #[error("{} is damaged", .0.display())]
    Damaged(PathBuf),
    /// The file is a log of a tree that cannot be read.
    #[error(transparent)]
    TreeLog(LogError),
    /// The file ends before its run does.
    #[error("{} ends before its run does, {extent}", path.display())]
    Truncated {
        /// The file.
        path: PathBuf,
        /// How much of the run it contains, in words.
        extent: String,
    },
}

/// Reads a recording, record by record, in bounded memory.
#[derive(Debug)]
pub struct Recording {
    path: PathBuf,
    source: Records,
    /// The next record, if it has been peeked at.
    ahead: Option<Record>,
}

#[derive(Debug)]
enum Records {
    /// A recording: the records of a chunk, and how many of their bytes have been read.
    Chunks { chunks: Chunks, chunk: Vec<u8>, read: usize },
    /// A log of BehaviorTree.CPP.
    Tree(Box<TreeLog>),
}

#[derive(Debug)]
enum Chunks {
    File(FileChunks),
    Mcap(Box<McapChunks>),
}

impl Chunks {
    fn begin(path: &Path) -> Result<Self, ChunkError> {
        let mut input = BufReader::new(diagnostics::open_regular(path)?);
        if input.fill_buf()?.starts_with(mcap::MAGIC) {
            return McapChunks::begin(input).map(|chunks| Self::Mcap(Box::new(chunks)));
        }
        FileChunks::begin(input).map(Self::File)
    }

    fn next(&mut self) -> Result<Option<Vec<u8>>, ChunkError> {
        match self {
            Self::File(chunks) => chunks.next(),
            Self::Mcap(chunks) => chunks.next(),
        }
    }
}

impl Recording {
    /// Opens a recording, in its own format or in MCAP, or a [log](tree_logs::Log) of BehaviorTree.CPP.
    ///
    /// # Errors
    /// [`RecordingError`], if the file cannot be read or is not a recording in this version of the format.
    pub fn open(path: &Path) -> Result<Self, RecordingError> {
        let source = match TreeLog::open(path) {
            Ok(log) => Records::Tree(Box::new(log)),
            Err(LogError::Foreign(_) | LogError::Read { .. }) => {
                let chunks = Chunks::begin(path).map_err(|error| RecordingError::new(error, path))?;
                Records::Chunks { chunks, chunk: Vec::new(), read: 0 }
            }
            Err(error) => return Err(RecordingError::TreeLog(error)),
        };
        Ok(Self { path: path.to_owned(), source, ahead: None })
    }

    /// Opens a bag, of which a topic of `nav2_msgs/msg/BehaviorTreeLog` has the statuses of this tree, as a
    /// [log](tree_logs::Log::of_bag).
    ///
    /// # Errors
    /// [`RecordingError::TreeLog`].
    pub fn of_bag(path: &Path, tree: &BagTree) -> Result<Self, RecordingError> {
        let log = TreeLog::of_bag(path, tree).map_err(RecordingError::TreeLog)?;
        Ok(Self { path: path.to_owned(), source: Records::Tree(Box::new(log)), ahead: None })
    }

    /// Opens a recording as [`open`](Self::open) does; or, if there is a tree, a bag as [`of_bag`](Self::of_bag) does.
    ///
    /// # Errors
    /// [`RecordingError`].
    pub fn open_with(path: &Path, tree: Option<&BagTree>) -> Result<Self, RecordingError> {
        match (Self::open(path), tree) {
            (Err(RecordingError::Foreign(_) | RecordingError::Read { .. }), Some(tree)) => Self::of_bag(path, tree),
            (opened, _) => opened,
        }
    }

    /// The next record; none at the end of the file, even in the middle of a chunk. If the file is still being written,
    /// the record may come later.
    ///
    /// # Errors
    /// [`RecordingError`], if the file cannot be read or is damaged.
    pub fn next_record(&mut self) -> Result<Option<Record>, RecordingError> {
        if let Some(record) = self.ahead.take() {
            return Ok(Some(record));
        }
        match &mut self.source {
            Records::Chunks { chunks, chunk, read } => {
                if *read == chunk.len() {
                    let failed = |error| RecordingError::new(error, &self.path);
                    let Some(next) = chunks.next().map_err(failed)? else { return Ok(None) };
                    (*chunk, *read) = (next, 0);
                }
                let taken = postcard::take_from_bytes(&chunk[*read..]);
                let (record, after): (Record, _) = taken.map_err(|_| RecordingError::Damaged(self.path.clone()))?;
                *read = chunk.len() - after.len();
                Ok(Some(record))
            }
            Records::Tree(log) => log.next_record().map_err(RecordingError::TreeLog),
        }
    }

    fn damaged(&self) -> RecordingError {
        RecordingError::Damaged(self.path.clone())
    }

    /// The error that the file ends before its run does, with how much of the run it contains, in words.
    #[must_use]
    pub fn truncated(&self, extent: String) -> RecordingError {
        RecordingError::Truncated { path: self.path.clone(), extent }
    }

    /// The first two records.
    fn start(&mut self) -> Result<(Header, Step), RecordingError> {
        match (self.next_record()?, self.next_record()?) {
            (Some(Record::Header(header)), Some(Record::Step(start))) => Ok((*header, start)),
            (None | Some(Record::Header(_)), None) => Err(self.truncated("and contains no step of it".to_owned())),
            _ => Err(self.damaged()),
        }
    }

    /// The next step, with the end if it is the last one.
    fn step(&mut self, view: &RunView) -> Result<(Step, Option<Box<End>>), RecordingError> {
        let step = match self.next_record()? {
            Some(Record::Step(step)) => step,
            Some(_) => return Err(self.damaged()),
            None => return Err(self.truncated(format!("at {:.2} s", view.time().as_secs_f64()))),
        };
        match self.next_record()? {
            Some(Record::End(end)) => Ok((step, Some(end))),
            next => {
                self.ahead = next;
                Ok((step, None))
            }
        }
    }

    /// The run at its start, from the first two records.
    ///
    /// # Errors
    /// [`RecordingError`].
    pub fn begin(&mut self) -> Result<RunView, RecordingError> {
        let (header, start) = self.start()?;
        RunView::new(header, start).map_err(|Inconsistent| self.damaged())
    }

    /// Advances by one step; the last step brings the end with it. Call it until the view has an end.
    ///
    /// # Errors
    /// [`RecordingError`]; [`Truncated`](RecordingError::Truncated) if the file ends before the run does.
    pub fn advance(&mut self, view: &mut RunView) -> Result<(), RecordingError> {
        let (step, end) = self.step(view)?;
        let applied = view.apply(step).and_then(|()| end.map_or(Ok(()), |end| view.finish(*end)));
        applied.map_err(|Inconsistent| self.damaged())
    }
}

impl RecordingError {
    fn new(error: ChunkError, path: &Path) -> Self {
        let path = path.to_owned();
        match error {
            ChunkError::Read(source) => Self::Read { path, source },
            ChunkError::Foreign => Self::Foreign(path),
            ChunkError::Damaged => Self::Damaged(path),
            ChunkError::Compressed(by) => Self::Compressed { path, by },
            ChunkError::Version(found) => Self::Version { path, found },
        }
    }
}
