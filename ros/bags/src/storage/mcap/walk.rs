//! The records of an MCAP file, one after the other.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{self, BufRead, BufReader, Cursor, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use mcap::parse_record;
use mcap::records::{ChunkIndex, MessageHeader, Record, op};

use crate::Error;
use crate::storage::survey::{Definition, Topic, hash};
use crate::storage::zstandard::Zstandard;

/// Larger records are read only if they are messages: no definition is longer.
const LONGEST: u64 = 1 << 26;

/// Chunks of up to this size are read into memory as a whole; larger ones are read twice if they have a checksum.
const LARGEST_WHOLE: u64 = 1 << 24;

/// The name of rosbag2's own metadata.
const METADATA: &str = "rosbag2";

/// The first kind of records that writers may define for themselves.
const PRIVATE: u8 = 0x80;

/// The number of bytes in the records at the end of the data, and of the file.
const DATA_END: u64 = 4;
const FOOTER: u64 = 20;

/// The kinds and lengths of the records with which the data can end.
const ENDS: [(u8, u64); 2] = [(op::DATA_END, DATA_END), (op::FOOTER, FOOTER)];

/// The number of bytes in a record before its content, and of a message's content before its data.
const RECORD_HEAD: usize = 1 + 8;
const MESSAGE_HEAD: u64 = 22;

/// The number of bytes in the record of an index before its entries, and of each of these.
const INDEX_HEAD: u64 = 2 + 4;
const INDEX_ENTRY: u64 = 8 + 8;

/// A time of MCAP; one after the year 2262 becomes the last that there is.
pub(super) fn nanoseconds(time: u64) -> i64 {
    i64::try_from(time).unwrap_or(i64::MAX)
}

/// How much of a message is read.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum ReadDepth {
    Nothing,
    Head,
    /// Its bytes are added to others.
    Body,
}

/// Decides how much of a message is read.
pub(super) trait Chooses: FnMut(&MessageHeader, &BTreeMap<u16, Topic>) -> ReadDepth {}

impl<F: FnMut(&MessageHeader, &BTreeMap<u16, Topic>) -> ReadDepth> Chooses for F {}

/// The summary at the end of a file.
pub(super) struct Summary {
    pub(super) counts: BTreeMap<u16, u64>,
    pub(super) span: Option<(u64, u64)>,
    pub(super) chunks: Vec<ChunkIndex>,
    /// Where the summary begins.
    pub(super) start: u64,
}

/// That chunks are not there, in words.
pub(super) fn absent_chunks(path: &Path) -> String {
    format!("{}: its index names chunks that it does not have", path.display())
}

/// That a channel is declared in different ways, in words.
pub(super) fn redeclared(path: &Path) -> String {
    format!("{} declares a channel in different ways", path.display())
}

/// A walk through the records of a file.
pub(super) struct Walk {
    pub(super) path: PathBuf,
    file: BufReader<File>,
    length: u64,
    /// Whether more records may be written to the file.
    pub(super) grows: bool,
    /// The position of the next record of the file, outside of chunks that are decompressed.
    pub(super) at: u64,
    /// Where the chunk of the last message begins, or the message if it is in none; and the earliest time in that
    /// chunk, as stated there.
    pub(super) origin: (u64, Option<u64>),
    /// The chunk that is being read, unless its records can be read from the file like any others.
    chunk: Option<Chunk>,
    /// The last chunk; memory to reuse for the next.
    pub(super) spare: Vec<u8>,
    /// The position in the file after the last chunk.
    pub(super) after_chunk: u64,
    /// Where the chunks begin that have been read, if more records may be written to the file.
    pub(super) chunks: Vec<u64>,
    pub(super) known: Known,
    /// When the first message of the bag was recorded, unless this is still to be found out.
    pub(super) first_ns: Option<i64>,
    /// When the last message was recorded.
    last: Option<u64>,
    pub(super) is_over: bool,
}

/// The records of a chunk, decompressed.
enum Chunk {
    /// All records, and the error if they end too early.
    Whole(Cursor<Vec<u8>>, Option<io::Error>),
    Stream(BufReader<Box<dyn Read>>),
}

/// The schemas and channels to which messages refer, and what is known of the recording.
#[derive(Default)]
pub(super) struct Known {
    schemas: BTreeMap<u16, (String, Definition)>,
    pub(super) channels: BTreeMap<u16, Topic>,
    /// The distributions of ROS 2 in which it was recorded.
    pub(super) distributions: BTreeSet<String>,
}

impl Walk {
    pub(super) fn open(path: &Path) -> Result<Self, Error> {
        let unreadable = |source| Error::Read(diagnostics::Error::Read { path: path.to_owned(), source });
        let file = diagnostics::open_regular(path).map_err(unreadable)?;
        let length = file.metadata().map_err(unreadable)?.len();
        let mut file = BufReader::with_capacity(1 << 16, file);
        let mut magic = [0; 8];
        if file.read_exact(&mut magic).is_err() || magic != mcap::MAGIC {
            return Err(Error::NoBag(path.to_owned()));
        }
        Ok(Self {
            path: path.to_owned(),
            file,
            length,
            grows: false,
            at: magic.len() as u64,
            origin: (0, None),
            chunk: None,
            spare: Vec::new(),
            after_chunk: 0,
            chunks: Vec::new(),
            known: Known::default(),
            first_ns: None,
            last: None,
            is_over: false,
        })
    }

    /// Goes to a record outside of chunks, or to a chunk.
    pub(super) fn go_to(&mut self, at: u64) {
        (self.chunk, self.after_chunk, self.at) = (None, 0, at);
        self.is_over = self.file.seek(SeekFrom::Start(at)).is_err();
    }

    /// Whether the next record is a chunk; then also where it ends.
    pub(super) fn chunk_end(&mut self) -> io::Result<Option<u64>> {
        let head = record_head(&mut self.file)?;
        self.file.seek(SeekFrom::Start(self.at))?;
        Ok(head.filter(|(kind, _)| *kind == op::CHUNK).map(|(_, length)| record_end(self.at, length)))
    }

    /// Whether the records of a chunk are read, after which those of the file follow.
    pub(super) fn is_in_chunk(&self) -> bool {
        self.chunk.is_some()
    }

    /// Where the bytes of the last message are in a chunk that is in memory as a whole.
    pub(super) fn place_in_chunk(&self, length: usize) -> Option<usize> {
        match &self.chunk {
            Some(Chunk::Whole(records, _)) => Some(records.position() as usize - length),
            _ => None,
        }
    }

    /// Whether a chunk is in memory as a whole.
    pub(super) fn is_whole(&self) -> bool {
        matches!(self.chunk, Some(Chunk::Whole(..)))
    }

    /// The summary, after adding all its channels; none if the file was not closed or the summary is incomplete. Goes
    /// back to the first record.
    pub(super) fn summary(&mut self) -> Option<Summary> {
        let summary = self.read_summary();
        self.go_to(mcap::MAGIC.len() as u64);
        if summary.is_none() {
            self.known = Known::default();
        }
        summary
    }

    /// When the first and the last message on a channel were recorded, according to the index.
    pub(super) fn span_of(&mut self, channel: u16, chunks: &[ChunkIndex]) -> Option<(u64, u64)> {
        let of_channel = || chunks.iter().filter(|chunk| chunk.message_index_offsets.contains_key(&channel));
        let first = of_channel().min_by_key(|chunk| chunk.message_start_time)?;
        let last = of_channel().max_by_key(|chunk| chunk.message_end_time)?;
        let mut times = |chunk: &ChunkIndex| {
            let (at, mut body) = (*chunk.message_index_offsets.get(&channel)?, Vec::new());
            self.file.seek(SeekFrom::Start(at)).ok()?;
            let (kind, length) = record_head(&mut self.file).ok()??;
            read_body(&mut self.file, length.min(LONGEST), &mut body).ok()?;
            // The channel, and the number of bytes in what follows: the time and the place of each message.
            let (head, entries) = body.split_first_chunk::<{ INDEX_HEAD as usize }>()?;
            let size = u32::from_le_bytes([head[2], head[3], head[4], head[5]]) as usize;
            let entries = entries.get(..size).filter(|_| kind == op::MESSAGE_INDEX)?.chunks_exact(INDEX_ENTRY as usize);
            let times = || entries.clone().filter_map(|entry| Some(u64::from_le_bytes(*entry.first_chunk()?)));
            times().min().zip(times().max())
        };
        Some((times(first)?.0, times(last)?.1))
    }

    fn read_summary(&mut self) -> Option<Summary> {
        let end = self.length.checked_sub(9 + FOOTER + mcap::MAGIC.len() as u64)?;
        let mut tail = Vec::new();
        self.file.seek(SeekFrom::Start(end)).ok()?;
        self.file.read_to_end(&mut tail).ok()?;
        if !tail.ends_with(mcap::MAGIC) || tail[0] != op::FOOTER {
            return None;
        }
        let Ok(Record::Footer(footer)) = parse_record(op::FOOTER, &tail[9..29]) else { return None };
        let start = footer.summary_start;
        if start == 0 || start > end {
            return None;
        }
        if footer.summary_crc != 0 {
            // It is that of everything from the start of the summary to this last field of the footer.
            self.file.seek(SeekFrom::Start(start)).ok()?;
            let (_, found) = size_and_checksum(self.file.by_ref().take(end + 9 + FOOTER - 4 - start)).ok()?;
            if found != footer.summary_crc {
                return None;
            }
        }
        let mut at = self.file.seek(SeekFrom::Start(start)).ok()?;
        let (mut statistics, mut chunks, mut body, mut metadata) = (None, Vec::new(), Vec::new(), Vec::new());
        while at < end {
            let (kind, length) = record_head(&mut self.file).ok()??;
            at = at.checked_add(9)?.checked_add(length).filter(|at| *at <= end)?;
            read_body(&mut self.file, length, &mut body).ok()?;
            match parse_record(kind, &body).ok()? {
                Record::Statistics(found) => statistics = Some(found),
                Record::ChunkIndex(index) => chunks.push(index),
                Record::MetadataIndex(index) if index.name == METADATA => metadata.push(index.offset),
                // Some writers leave schemas out of the summary.
                Record::Channel(channel)
                    if channel.schema_id != 0 && !self.known.schemas.contains_key(&channel.schema_id) =>
                {
                    return None;
                }
                record => {
                    if self.known.note(record) {
                        return None;
                    }
                }
            }
        }
        for at in metadata {
            self.file.seek(SeekFrom::Start(at)).ok()?;
            self.known.step(&mut self.file, &mut |_, _: &_| ReadDepth::Nothing, &mut body).ok()?;
        }
        // Some writers leave channels out of the summary, or how many messages they have. Their messages would not be
        // found; the whole file is read then.
        let statistics = statistics.filter(|found| {
            let counted = found.channel_message_counts.values().try_fold(0_u64, |sum, count| sum.checked_add(*count));
            found.channel_count as usize == self.known.channels.len() && counted == Some(found.message_count)
        })?;
        let span = (statistics.message_start_time, statistics.message_end_time);
        Some(Summary {
            counts: statistics.channel_message_counts,
            span: (statistics.message_count > 0).then_some(span),
            chunks,
            start,
        })
    }

    /// What does not fit, in words, if this many messages and chunks at these places have been found in the whole file:
    /// what follows its data contradicts that, or does not belong there. Nothing, if the file was cut off after its
    /// data. To be called at the end of the data.
    pub(super) fn unfit(&mut self, found: u64, chunks: &[u64]) -> Option<String> {
        let (mut at, mut body) = (self.at, Vec::new());
        let (footer, end) = loop {
            let (kind, length) = self.record_at(at)?;
            // Otherwise, it broke off.
            if at == self.at && !ENDS.contains(&(kind, length)) {
                return None;
            }
            let end = at.checked_add(9)?.checked_add(length)?;
            let record = match kind {
                op::FOOTER if length == FOOTER => break (at, end.saturating_add(mcap::MAGIC.len() as u64)),
                op::DATA_END if at == self.at => None,
                op::STATISTICS | op::CHUNK_INDEX if length <= LONGEST => {
                    read_body(&mut self.file, length, &mut body).ok()?;
                    parse_record(kind, &body).ok()
                }
                op::SCHEMA | op::CHANNEL | op::ATTACHMENT_INDEX | op::METADATA_INDEX | op::SUMMARY_OFFSET => None,
                PRIVATE.. => None,
                _ => break (at, at),
            };
            match record {
                Some(Record::Statistics(stated)) if stated.message_count != found => {
                    let stated = stated.message_count;
                    return Some(format!("{} counts {stated} messages, and {found} are there", self.path.display()));
                }
                Some(Record::ChunkIndex(index)) if chunks.binary_search(&index.chunk_start_offset).is_err() => {
                    return Some(absent_chunks(&self.path));
                }
                _ => at = end,
            }
        };
        if let Some(rest) = self.length.checked_sub(end).filter(|rest| *rest > 0) {
            return Some(format!("{} goes on after its end: the last {rest} bytes are not read", self.path.display()));
        }
        self.record_at(footer)?;
        let stated = u64::from_le_bytes(self.bytes().ok()?);
        let actual = self.at + if footer == self.at { 0 } else { 9 + DATA_END };
        let is_elsewhere = stated != 0 && stated != actual;
        is_elsewhere.then(|| format!("{} is not as long as it was when it was written", self.path.display()))
    }

    /// The kind and the length of a record outside of chunks, if there is one. Goes to what follows these.
    fn record_at(&mut self, at: u64) -> Option<(u8, u64)> {
        self.file.seek(SeekFrom::Start(at)).ok()?;
        record_head(&mut self.file).ok()?
    }

    /// That the checksum of the whole data is not right, in words; nothing, if the file has none. To be called at the
    /// end of the data.
    pub(super) fn wrong_checksum(&mut self) -> Option<String> {
        let (op::DATA_END, DATA_END) = self.record_at(self.at)? else { return None };
        let stated = u32::from_le_bytes(self.bytes().ok()?);
        if stated == 0 {
            return None;
        }
        self.file.seek(SeekFrom::Start(0)).ok()?;
        let (size, found) = size_and_checksum(self.file.by_ref().take(self.at)).ok()?;
        let is_wrong = size == self.at && found != stated;
        is_wrong.then(|| format!("{}: its checksum is not that of its records", self.path.display()))
    }

    /// The next message that is to be read at least in part; none at the end, or if none has been written yet.
    pub(super) fn next_message(
        &mut self,
        mut chooses: impl Chooses,
        body: &mut Vec<u8>,
        lost: &mut Vec<String>,
    ) -> Option<MessageHeader> {
        body.clear();
        while !self.is_over {
            match self.advance(&mut chooses, body, lost) {
                WalkStep::Message(head, _) => return Some(head),
                WalkStep::Unwritten => return None,
                WalkStep::Other | WalkStep::Index(_) | WalkStep::Odd(_) | WalkStep::Redeclared | WalkStep::End => {}
            }
        }
        None
    }

    /// Reads the next record of the chunk, or of the file itself. Damage ends the chunk, or the file.
    pub(super) fn advance(
        &mut self,
        chooses: &mut impl Chooses,
        body: &mut Vec<u8>,
        lost: &mut Vec<String>,
    ) -> WalkStep {
        match self.step(chooses, body) {
            Ok(step) => {
                let mut lose = |what: String| lost.extend((!lost.contains(&what)).then_some(what));
                match &step {
                    WalkStep::Message(head, _) => self.last = Some(head.log_time),
                    WalkStep::End => self.is_over = true,
                    WalkStep::Odd(kind) => {
                        let odd = format!("{} has records of an unknown kind, {kind:#04x}", self.path.display());
                        lose(odd + ", which may have been messages");
                    }
                    WalkStep::Redeclared => lose(redeclared(&self.path)),
                    WalkStep::Other | WalkStep::Index(_) | WalkStep::Unwritten => {}
                }
                step
            }
            Err(error) => {
                // A chunk states where it ends, so the file can be read from there on, unless it ends before.
                let is_in_chunk = self.file.stream_position().is_ok_and(|at| at < self.after_chunk);
                let goes_on = is_in_chunk && (self.grows || self.after_chunk < self.length);
                lost.push(self.damage(goes_on, &error));
                if let Some(Chunk::Whole(records, _)) = self.chunk.take() {
                    self.spare = records.into_inner();
                }
                self.is_over = !goes_on || self.file.seek(SeekFrom::Start(self.after_chunk)).is_err();
                self.at = self.after_chunk;
                WalkStep::Other
            }
        }
    }

    /// What is lost, in words.
    fn damage(&self, goes_on: bool, error: &io::Error) -> String {
        let since = match (self.last.map(nanoseconds), self.first_ns) {
            (None, _) => "before its first message".to_owned(),
            (Some(last_ns), Some(first_ns)) => crate::after_first(last_ns, first_ns),
            (Some(last_ns), None) => format!("after the message of {}", crate::moment(last_ns)),
        };
        let (what, rest) =
            if goes_on { ("contains a damaged chunk", "the rest of it") } else { ("breaks off", "the rest") };
        let reason = if error.kind() == io::ErrorKind::UnexpectedEof { String::new() } else { format!(" ({error})") };
        format!("{} {what} {since}{reason}: {rest} is lost", self.path.display())
    }

    fn step(&mut self, chooses: &mut impl Chooses, body: &mut Vec<u8>) -> io::Result<WalkStep> {
        if let Some(chunk) = &mut self.chunk {
            let (step, _) = match chunk {
                Chunk::Whole(records, _) => self.known.step(records, chooses, body)?,
                Chunk::Stream(records) => self.known.step(records, chooses, body)?,
            };
            if !matches!(step, WalkStep::End) {
                return Ok(step);
            }
            // Only now does damage matter: the records before it have been returned.
            if let Some(Chunk::Whole(records, damage)) = self.chunk.take() {
                self.spare = records.into_inner();
                damage.map_or(Ok(()), Err)?;
            }
            self.at = self.file.seek(SeekFrom::Start(self.after_chunk))?;
            return Ok(WalkStep::Other);
        }
        if self.grows && !self.is_written()? {
            return Ok(WalkStep::Unwritten);
        }
        match self.file.fill_buf()?.first().copied() {
            None => Err(io::ErrorKind::UnexpectedEof.into()),
            Some(op::DATA_END | op::FOOTER) if self.is_end()? => Ok(WalkStep::End),
            Some(op::CHUNK) => {
                let (_, length) = record_head(&mut self.file)?.ok_or(io::ErrorKind::UnexpectedEof)?;
                self.after_chunk = record_end(self.at, length);
                self.origin = (self.at, None);
                self.chunks.extend(self.grows.then_some(self.at));
                self.enter()?;
                self.at = self.file.stream_position()?;
                Ok(WalkStep::Other)
            }
            Some(_) => {
                if self.at >= self.after_chunk {
                    self.origin = (self.at, None);
                }
                let (step, length) = self.known.step(&mut self.file, chooses, body)?;
                self.at = record_end(self.at, length);
                Ok(step)
            }
        }
    }

    /// Whether the next record, which has the kind of an end, is one: the file may be cut off in it. Another length
    /// shows that it has been something else.
    fn is_end(&mut self) -> io::Result<bool> {
        let head = record_head(&mut self.file);
        self.file.seek(SeekFrom::Start(self.at))?;
        match head {
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => Ok(true),
            head => Ok(head?.is_some_and(|head| ENDS.contains(&head))),
        }
    }

    /// That the file breaks off, in words, if only a part of the next record is in it, and no more of it is awaited.
    pub(super) fn breaks_off(&mut self) -> Option<String> {
        if self.is_over || self.is_in_chunk() {
            return None;
        }
        let at = self.file.stream_position().ok()?;
        let is_begun = self.file.get_ref().metadata().ok()?.len() > at;
        let is_part = is_begun && !self.is_written().ok()?;
        is_part.then(|| self.damage(false, &io::Error::from(io::ErrorKind::UnexpectedEof)))
    }

    /// Whether the whole of the next record is in the file. Only then does it count: its writer may be in the middle of
    /// it.
    fn is_written(&mut self) -> io::Result<bool> {
        const HEAD: u64 = RECORD_HEAD as u64;
        if let Some([_, length @ ..]) = self.file.buffer().first_chunk::<RECORD_HEAD>() {
            let whole = record_end(0, u64::from_le_bytes(*length));
            if self.file.buffer().len() as u64 >= whole {
                return Ok(true);
            }
        }
        let at = self.file.stream_position()?;
        let written = self.file.get_ref().metadata()?.len();
        let rest = written.checked_sub(at).ok_or_else(|| io::Error::other("it has become shorter"))?;
        if rest < HEAD {
            return Ok(false);
        }
        // Some writers correct the length of a chunk when it is complete, so what was read before does not count.
        self.file.seek(SeekFrom::Start(at))?;
        let (_, length) = record_head(&mut self.file)?.ok_or(io::ErrorKind::UnexpectedEof)?;
        self.file.seek_relative(-(HEAD as i64))?;
        Ok(rest - HEAD >= length)
    }

    /// The fields of a chunk before its records.
    fn chunk_head(&mut self) -> io::Result<ChunkHead> {
        let earliest = u64::from_le_bytes(self.bytes()?);
        let _latest: [u8; 8] = self.bytes()?;
        self.origin.1 = (earliest > 0).then_some(earliest);
        let size = u64::from_le_bytes(self.bytes()?);
        let checksum = u32::from_le_bytes(self.bytes()?);
        let name_length = u32::from_le_bytes(self.bytes()?);
        let mut compression = Vec::new();
        read_body(&mut self.file, name_length.into(), &mut compression)?;
        Ok(ChunkHead { size, checksum, compression, length: u64::from_le_bytes(self.bytes()?) })
    }

    fn bytes<const N: usize>(&mut self) -> io::Result<[u8; N]> {
        let mut bytes = [0; N];
        self.file.read_exact(&mut bytes)?;
        Ok(bytes)
    }

    /// Enters a chunk. Without compression and checksum, its records follow like any others, and unwanted messages can
    /// be skipped without reading them. Otherwise it is decompressed into memory, if it is small enough. Records must
    /// not be returned before a checksum over all of them is known to be right, so a large chunk is decompressed twice.
    fn enter(&mut self) -> io::Result<()> {
        let ChunkHead { size, checksum, compression, length } = self.chunk_head()?;
        if compression.is_empty() && checksum == 0 {
            return Ok(());
        }
        let at = self.file.stream_position()?;
        let wrong = || Err(io::Error::other("its checksum is not that of its messages"));
        let plain = decompressed(&self.path, at, length, &compression)?;
        if size > LARGEST_WHOLE {
            let is_other = |(read, found)| read == size && found != checksum;
            if checksum != 0 && size_and_checksum(BufReader::with_capacity(1 << 16, plain)).is_ok_and(is_other) {
                return wrong();
            }
            let input = decompressed(&self.path, at, length, &compression)?;
            let plain: Box<dyn Read> = Box::new(Exactly { input, left: size });
            self.chunk = Some(Chunk::Stream(BufReader::with_capacity(1 << 16, plain)));
            return Ok(());
        }
        // If the chunk is damaged, the records before the damage are returned first.
        let mut whole = std::mem::take(&mut self.spare);
        whole.clear();
        let read = plain.take(size + 1).read_to_end(&mut whole);
        let is_other = whole.len() as u64 != size;
        let damage = read.err().or_else(|| is_other.then(|| io::ErrorKind::UnexpectedEof.into()));
        if damage.is_none() && checksum != 0 && crc32fast::hash(&whole) != checksum {
            return wrong();
        }
        self.chunk = Some(Chunk::Whole(Cursor::new(whole), damage));
        Ok(())
    }
}

/// The records of a chunk, whose bytes are at that position of a file.
fn decompressed(path: &Path, at: u64, length: u64, compression: &[u8]) -> io::Result<Box<dyn Read>> {
    let mut file = diagnostics::open_regular(path)?;
    file.seek(SeekFrom::Start(at))?;
    let packed = BufReader::with_capacity(1 << 16, file.take(length));
    match compression {
        b"" => Ok(Box::new(packed)),
        b"zstd" => Ok(Box::new(Zstandard::new(packed)?)),
        b"lz4" => Ok(Box::new(lz4_flex::frame::FrameDecoder::new(packed))),
        other => {
            let other = String::from_utf8_lossy(other);
            Err(io::Error::other(format!("the compression `{other}` is not supported")))
        }
    }
}

/// Bytes of which so many are to come: if there are fewer or more, reading them ends with an error.
struct Exactly<R> {
    input: R,
    left: u64,
}

impl<R: Read> Read for Exactly<R> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let read = self.input.read(bytes)?;
        let left = self.left.checked_sub(read as u64).filter(|left| read > 0 || *left == 0 || bytes.is_empty());
        self.left = left.ok_or(io::ErrorKind::UnexpectedEof)?;
        Ok(read)
    }
}

fn size_and_checksum(mut input: impl BufRead) -> io::Result<(u64, u32)> {
    let (mut size, mut hasher) = (0, crc32fast::Hasher::new());
    loop {
        let bytes = input.fill_buf()?;
        if bytes.is_empty() {
            return Ok((size, hasher.finalize()));
        }
        hasher.update(bytes);
        let read = bytes.len();
        size += read as u64;
        input.consume(read);
    }
}

impl Known {
    /// Adds a schema, a channel or metadata. Returns whether it is a channel that has been declared in another way,
    /// which still counts.
    fn note(&mut self, record: Record<'_>) -> bool {
        match record {
            Record::Schema { header, data } => {
                let text = String::from_utf8_lossy(&data).into_owned();
                self.schemas.insert(header.id, (header.name, Definition { language: header.encoding, text }));
            }
            Record::Channel(channel) => {
                let known = self.channels.get(&channel.id);
                let (kind, definition) = match (self.schemas.get(&channel.schema_id), known) {
                    (Some((kind, definition)), _) => (kind.clone(), Some(definition.clone())),
                    // Its schema is in a part of the file that has been passed over.
                    (None, Some(known)) => (known.kind.clone(), known.definition.clone()),
                    (None, None) => (String::new(), None),
                };
                let topic = Topic {
                    name: channel.topic,
                    kind,
                    encoding: channel.message_encoding,
                    definition: definition.filter(|definition| !definition.language.is_empty()),
                    hash: channel.metadata.get("topic_type_hash").and_then(|text| hash(text)),
                };
                if let Some(known) = known {
                    return *known != topic;
                }
                self.channels.insert(channel.id, topic);
            }
            // In Humble and Iron. Later versions write the distribution into the metadata file.
            Record::Metadata(metadata) if metadata.name == METADATA => {
                let distribution = metadata.metadata.get("ROS_DISTRO").filter(|name| !name.is_empty());
                self.distributions.extend(distribution.cloned());
            }
            _ => {}
        }
        false
    }

    /// Reads the next record of a chunk, or of the file. Returns the number of bytes after its kind and its length,
    /// too.
    fn step(
        &mut self,
        input: &mut (impl BufRead + Pass),
        chooses: &mut impl Chooses,
        body: &mut Vec<u8>,
    ) -> io::Result<(WalkStep, u64)> {
        // Nearly every record is a message, and its head is in the buffer.
        let (length, head) = match message_in(input.fill_buf()?) {
            Some(found) => {
                input.consume(RECORD_HEAD + MESSAGE_HEAD as usize);
                found
            }
            None => match record_head(input)? {
                Some((op::MESSAGE, length @ MESSAGE_HEAD..)) => {
                    let mut head = [0; MESSAGE_HEAD as usize];
                    input.read_exact(&mut head)?;
                    (length, message_head(&head))
                }
                Some((kind, length)) => return Ok((self.other(kind, length, input)?, length)),
                None => return Ok((WalkStep::End, 0)),
            },
        };
        let rest = length - MESSAGE_HEAD;
        let depth = chooses(&head, &self.channels);
        match depth {
            ReadDepth::Body => read_more(input, rest, body)?,
            ReadDepth::Nothing | ReadDepth::Head => input.pass(rest)?,
        }
        let is_wanted = depth != ReadDepth::Nothing;
        Ok((if is_wanted { WalkStep::Message(head, rest as usize) } else { WalkStep::Other }, length))
    }

    /// Reads a record that is no message, after its kind and its length.
    fn other(&mut self, kind: u8, length: u64, input: &mut (impl BufRead + Pass)) -> io::Result<WalkStep> {
        match kind {
            op::SCHEMA | op::CHANNEL | op::METADATA if length <= LONGEST => {
                let mut body = Vec::new();
                read_body(input, length, &mut body)?;
                let is_redeclared = match parse_record(kind, &body) {
                    // Messages can be read without it.
                    Err(_) if kind == op::METADATA => false,
                    record => self.note(record.map_err(io::Error::other)?),
                };
                Ok(if is_redeclared { WalkStep::Redeclared } else { WalkStep::Other })
            }
            // A part of a file that was never written reads as zeros.
            0 => Err(io::Error::other("there are zeros in place of records")),
            kind => {
                input.pass(length)?;
                Ok(match kind {
                    op::MESSAGE_INDEX => WalkStep::Index(length.saturating_sub(INDEX_HEAD) / INDEX_ENTRY),
                    op::HEADER | op::ATTACHMENT | op::METADATA | PRIVATE.. => WalkStep::Other,
                    // Also what is too short for a message or too long for a definition.
                    kind => WalkStep::Odd(kind),
                })
            }
        }
    }
}

/// What precedes the records of a chunk.
struct ChunkHead {
    /// Their number of bytes without compression.
    size: u64,
    /// Their CRC-32 without compression; 0 if there is none.
    checksum: u32,
    /// The name of the compression; empty if there is none.
    compression: Vec<u8>,
    /// The number of bytes that follow.
    length: u64,
}

pub(super) enum WalkStep {
    /// A message that is to be read at least in part, and the number of its bytes.
    Message(MessageHeader, usize),
    /// The index of a chunk's messages on one channel, and how many it has.
    Index(u64),
    /// A record of a kind that is not to be there.
    Odd(u8),
    /// A channel that has been declared in another way.
    Redeclared,
    Other,
    /// The next record has not been written as a whole yet.
    Unwritten,
    End,
}

/// An input that can skip bytes.
trait Pass {
    fn pass(&mut self, length: u64) -> io::Result<()>;
}

impl Pass for Cursor<Vec<u8>> {
    fn pass(&mut self, length: u64) -> io::Result<()> {
        let end = self.position().checked_add(length).filter(|end| *end <= self.get_ref().len() as u64);
        self.set_position(end.ok_or(io::ErrorKind::UnexpectedEof)?);
        Ok(())
    }
}

impl Pass for BufReader<Box<dyn Read>> {
    fn pass(&mut self, length: u64) -> io::Result<()> {
        let passed = io::copy(&mut self.take(length), &mut io::sink())?;
        if passed == length { Ok(()) } else { Err(io::ErrorKind::UnexpectedEof.into()) }
    }
}

/// Skipping beyond the end of the file shows at the next read.
impl Pass for BufReader<File> {
    fn pass(&mut self, length: u64) -> io::Result<()> {
        self.seek_relative(i64::try_from(length).map_err(io::Error::other)?)
    }
}

/// The kind and the length of the next record; none at the end.
fn record_head(input: &mut impl BufRead) -> io::Result<Option<(u8, u64)>> {
    if input.fill_buf()?.is_empty() {
        return Ok(None);
    }
    let mut head = [0; RECORD_HEAD];
    input.read_exact(&mut head)?;
    let [kind, length @ ..] = head;
    Ok(Some((kind, u64::from_le_bytes(length))))
}

/// Where a record ends that begins here, with a content of this length.
fn record_end(at: u64, length: u64) -> u64 {
    at.saturating_add(RECORD_HEAD as u64).saturating_add(length)
}

fn read_body(input: &mut impl BufRead, length: u64, body: &mut Vec<u8>) -> io::Result<()> {
    body.clear();
    read_more(input, length, body)
}

/// Adds bytes; if they end too early, none.
fn read_more(input: &mut impl BufRead, length: u64, bytes: &mut Vec<u8>) -> io::Result<()> {
    // Most records are completely in the buffer.
    if let Some(whole) = input.fill_buf()?.get(..usize::try_from(length).unwrap_or(usize::MAX)) {
        bytes.extend_from_slice(whole);
        input.consume(length as usize);
        return Ok(());
    }
    let before = bytes.len();
    input.take(length).read_to_end(bytes)?;
    if (bytes.len() - before) as u64 == length {
        return Ok(());
    }
    bytes.truncate(before);
    Err(io::ErrorKind::UnexpectedEof.into())
}

/// The length of the record that begins here, and the head of its message, if it is one.
fn message_in(bytes: &[u8]) -> Option<(u64, MessageHeader)> {
    let [kind, length @ ..] = bytes.first_chunk::<RECORD_HEAD>()?;
    let length = u64::from_le_bytes(*length);
    let head = bytes[RECORD_HEAD..].first_chunk()?;
    (*kind == op::MESSAGE && length >= MESSAGE_HEAD).then(|| (length, message_head(head)))
}

fn message_head(bytes: &[u8; MESSAGE_HEAD as usize]) -> MessageHeader {
    // An array that is made byte by byte takes a hundred instructions more.
    let number = |from: usize| bytes[from..].first_chunk().map_or(0, |number| u64::from_le_bytes(*number));
    MessageHeader {
        channel_id: u16::from_le_bytes([bytes[0], bytes[1]]),
        sequence: u32::from_le_bytes([bytes[2], bytes[3], bytes[4], bytes[5]]),
        log_time: number(6),
        publish_time: number(14),
    }
}
