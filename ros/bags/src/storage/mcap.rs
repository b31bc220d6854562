//! MCAP files.
//!
//! A file is read from start to end, record by record, and large chunks as a stream, so memory does not depend on the
//! size of either. If the file has an index of its chunks, chunks without wanted topics are skipped. Unwanted messages
//! are skipped, too, where there is neither compression nor a checksum.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{self, BufRead, BufReader, Cursor, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use mcap::parse_record;
use mcap::records::{ChunkIndex, MessageHeader, Record, op};

use super::source::{Received, Wanted};
use super::survey::{Definition, Head, Survey, Topic, hash};
use super::zstandard::Zstandard;
use crate::Error;

/// Larger records are read only if they are messages: no definition is longer.
const LONGEST: u64 = 1 << 26;

/// Chunks of up to this size are read into memory as a whole; larger ones are read twice if they have a checksum.
const LARGEST_WHOLE: u64 = 1 << 24;

/// The name of rosbag2's own metadata.
const METADATA: &str = "rosbag2";

/// The number of bytes in a message's record before its data.
const MESSAGE_HEAD: u64 = 22;

/// Adds the contents of a file.
pub(super) fn survey(path: &Path, survey: &mut Survey) -> Result<(), Error> {
    let mut walk = Walk::open(path)?;
    let summary = walk.summary();
    survey.distributions.append(&mut walk.known.distributions);
    if let Some(summary) = summary {
        let topics: BTreeMap<u16, usize> =
            walk.known.channels.iter().map(|(id, topic)| (*id, survey.add(topic.clone()))).collect();
        for (channel, count) in &summary.counts {
            if let Some(topic) = topics.get(channel) {
                survey.counts[*topic] += count;
            }
        }
        if let Some((first, last)) = summary.span {
            survey.note_times(nanoseconds(first), nanoseconds(last));
        }
        return Ok(());
    }
    let mut none = Vec::new();
    let mut lost = Vec::new();
    let (mut counts, mut seen) = (BTreeMap::<u16, u64>::new(), None::<(u64, u64)>);
    while let Some(head) = walk.next_message(|_, _| ReadDepth::Head, &mut none, &mut lost) {
        *counts.entry(head.channel_id).or_default() += 1;
        let (first, last) = seen.unwrap_or((head.log_time, head.log_time));
        seen = Some((first.min(head.log_time), last.max(head.log_time)));
    }
    survey.distributions.append(&mut walk.known.distributions);
    // What is lost will be reported when the messages are read.
    for (channel, topic) in &walk.known.channels {
        let topic = survey.add(topic.clone());
        survey.counts[topic] += counts.get(channel).copied().unwrap_or(0);
    }
    if let Some((first, last)) = seen {
        survey.note_times(nanoseconds(first), nanoseconds(last));
    }
    Ok(())
}

/// A time of MCAP; one after the year 2262 becomes the last that there is.
fn nanoseconds(time: u64) -> i64 {
    i64::try_from(time).unwrap_or(i64::MAX)
}

/// The wanted messages of a file.
pub(super) struct McapReader {
    walk: Walk,
    /// The wanted channels that have been seen, with their topics; none for others.
    seen: BTreeMap<u16, Option<usize>>,
}

impl McapReader {
    pub(super) fn open(path: &Path, wanted: &Wanted, survey: &mut Survey) -> Result<Self, Error> {
        let mut walk = Walk::open(path)?;
        if let Some(summary) = walk.summary() {
            let mut is_wanted = |channel: &u16| {
                walk.known.channels.get(channel).is_none_or(|topic| wanted.index(topic, survey).is_some())
            };
            // An index without channels comes from a writer that indexes no messages: the chunk may have any.
            let needless = summary.chunks.iter().filter(|chunk| {
                let channels = &chunk.message_index_offsets;
                !channels.is_empty() && !channels.keys().any(&mut is_wanted)
            });
            walk.needless = needless.map(|chunk| chunk.chunk_start_offset).collect();
        }
        Ok(Self { walk, seen: BTreeMap::new() })
    }

    /// Opens a file that is still being written.
    pub(super) fn follow(path: &Path) -> Result<Self, Error> {
        let walk = Walk { grows: true, ..Walk::open(path)? };
        Ok(Self { walk, seen: BTreeMap::new() })
    }

    pub(super) fn receive(
        &mut self,
        wanted: &Wanted,
        survey: &mut Survey,
        body: &mut Vec<u8>,
        lost: &mut Vec<String>,
    ) -> Received {
        let Self { walk, seen } = self;
        walk.first_ns = survey.first_ns();
        let mut topic = None;
        let chooses = |channel: u16, channels: &BTreeMap<u16, Topic>| {
            let index = || channels.get(&channel).and_then(|topic| wanted.index(topic, survey));
            topic = *seen.entry(channel).or_insert_with(index);
            if topic.is_some() { ReadDepth::Body } else { ReadDepth::Nothing }
        };
        let head = walk.next_message(chooses, body, lost);
        match head.zip(topic) {
            Some((head, topic)) => Received::Message(Head {
                topic,
                log_ns: nanoseconds(head.log_time),
                publish_ns: nanoseconds(head.publish_time),
            }),
            None if walk.is_over => Received::Over,
            None => Received::Idle,
        }
    }
}

/// The summary at the end of a file.
struct Summary {
    counts: BTreeMap<u16, u64>,
    span: Option<(u64, u64)>,
    chunks: Vec<ChunkIndex>,
}

/// How much of a message is read.
#[derive(Clone, Copy, PartialEq, Eq)]
enum ReadDepth {
    Nothing,
    Head,
    Body,
}

/// Decides how much of a message on a channel is read.
trait Chooses: FnMut(u16, &BTreeMap<u16, Topic>) -> ReadDepth {}

impl<F: FnMut(u16, &BTreeMap<u16, Topic>) -> ReadDepth> Chooses for F {}

/// A walk through the records of a file.
struct Walk {
    path: PathBuf,
    file: BufReader<File>,
    length: u64,
    /// Whether more records may be written to the file.
    grows: bool,
    /// The chunk that is being read, unless its records can be read from the file like any others.
    chunk: Option<Chunk>,
    /// Memory to reuse for the next chunk.
    spare: Vec<u8>,
    /// The position in the file after the last chunk.
    after_chunk: u64,
    /// The positions of chunks without wanted messages.
    needless: BTreeSet<u64>,
    known: Known,
    /// When the first message of the bag was recorded.
    first_ns: i64,
    /// When the last message was recorded.
    last: Option<u64>,
    is_over: bool,
}

/// The records of a chunk, decompressed.
enum Chunk {
    /// All records, and the error if they end too early.
    Whole(Cursor<Vec<u8>>, Option<io::Error>),
    Stream(BufReader<Box<dyn Read>>),
}

/// The schemas and channels to which messages refer, and what is known of the recording.
#[derive(Default)]
struct Known {
    schemas: BTreeMap<u16, (String, Definition)>,
    channels: BTreeMap<u16, Topic>,
    /// The distributions of ROS 2 in which it was recorded.
    distributions: BTreeSet<String>,
}

impl Walk {
    fn open(path: &Path) -> Result<Self, Error> {
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
            chunk: None,
            spare: Vec::new(),
            after_chunk: 0,
            needless: BTreeSet::new(),
            known: Known::default(),
            first_ns: 0,
            last: None,
            is_over: false,
        })
    }

    /// The summary, after adding all its channels; none if the file was not closed or the summary is incomplete. Goes
    /// back to the first record.
    fn summary(&mut self) -> Option<Summary> {
        let summary = self.read_summary();
        if self.file.seek(SeekFrom::Start(mcap::MAGIC.len() as u64)).is_err() {
            self.is_over = true;
        }
        if summary.is_none() {
            self.known = Known::default();
        }
        summary
    }

    fn read_summary(&mut self) -> Option<Summary> {
        const FOOTER: u64 = 9 + 20;
        let end = self.length.checked_sub(FOOTER + mcap::MAGIC.len() as u64)?;
        let mut tail = Vec::new();
        self.file.seek(SeekFrom::Start(end)).ok()?;
        self.file.read_to_end(&mut tail).ok()?;
        if !tail.ends_with(mcap::MAGIC) || tail[0] != op::FOOTER {
            return None;
        }
        let Ok(Record::Footer(footer)) = parse_record(op::FOOTER, &tail[9..29]) else { return None };
        if footer.summary_start == 0 || footer.summary_start > end {
            return None;
        }
        let mut at = self.file.seek(SeekFrom::Start(footer.summary_start)).ok()?;
        let (mut statistics, mut chunks, mut body, mut metadata) = (None, Vec::new(), Vec::new(), Vec::new());
        while at < end {
            let (kind, length) = record_head(&mut self.file).ok()??;
            at = at.checked_add(9)?.checked_add(length).filter(|at| *at <= end)?;
            read_body(&mut self.file, length, &mut body).ok()?;
            match parse_record(kind, &body).ok()? {
                Record::Statistics(found) => statistics = Some(found),
                Record::ChunkIndex(index) => chunks.push(index),
                Record::MetadataIndex(index) if index.name == METADATA => metadata.push(index.offset),
                record => self.known.note(record),
            }
        }
        for at in metadata {
            self.file.seek(SeekFrom::Start(at)).ok()?;
            self.known.step(&mut self.file, &mut |_, _: &_| ReadDepth::Nothing, &mut body).ok()?;
        }
        // Some writers leave channels out of the summary. Their messages would not be found; the whole file is read
        // then.
        let statistics = statistics.filter(|found| found.channel_count as usize == self.known.channels.len())?;
        let span = (statistics.message_start_time, statistics.message_end_time);
        Some(Summary {
            counts: statistics.channel_message_counts,
            span: (statistics.message_count > 0).then_some(span),
            chunks,
        })
    }

    /// The next message that is to be read at least in part; none at the end, or if none has been written yet. Damage
    /// ends the chunk, or the file.
    fn next_message(
        &mut self,
        mut chooses: impl Chooses,
        body: &mut Vec<u8>,
        lost: &mut Vec<String>,
    ) -> Option<MessageHeader> {
        while !self.is_over {
            match self.step(&mut chooses, body) {
                Ok(WalkStep::Message(head)) => {
                    self.last = Some(head.log_time);
                    return Some(head);
                }
                Ok(WalkStep::Other) => {}
                Ok(WalkStep::Unwritten) => return None,
                Ok(WalkStep::End) => self.is_over = true,
                Err(error) => {
                    // A chunk says where it ends, so the file can be read from there on, unless it ends before.
                    let is_in_chunk = self.file.stream_position().is_ok_and(|at| at < self.after_chunk);
                    let goes_on = is_in_chunk && (self.grows || self.after_chunk < self.length);
                    lost.push(self.damage(goes_on, &error));
                    self.chunk = None;
                    self.is_over = !goes_on || self.file.seek(SeekFrom::Start(self.after_chunk)).is_err();
                }
            }
        }
        None
    }

    /// What is lost, in words.
    fn damage(&self, goes_on: bool, error: &io::Error) -> String {
        let since = self.last.map_or_else(
            || "before its first message".to_owned(),
            |last| crate::after_first(nanoseconds(last), self.first_ns),
        );
        let (what, rest) =
            if goes_on { ("contains a damaged chunk", "the rest of it") } else { ("breaks off", "the rest") };
        let reason = if error.kind() == io::ErrorKind::UnexpectedEof { String::new() } else { format!(" ({error})") };
        format!("{} {what} {since}{reason}: {rest} is lost", self.path.display())
    }

    /// Reads the next record of the chunk, or of the file itself.
    fn step(&mut self, chooses: &mut impl Chooses, body: &mut Vec<u8>) -> io::Result<WalkStep> {
        if let Some(chunk) = &mut self.chunk {
            let step = match chunk {
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
            self.file.seek(SeekFrom::Start(self.after_chunk))?;
            return Ok(WalkStep::Other);
        }
        if self.grows && !self.is_written()? {
            return Ok(WalkStep::Unwritten);
        }
        match self.file.fill_buf()?.first() {
            None => Err(io::ErrorKind::UnexpectedEof.into()),
            Some(&(op::DATA_END | op::FOOTER)) => Ok(WalkStep::End),
            Some(&op::CHUNK) => {
                let at = self.file.stream_position()?;
                let (_, length) = record_head(&mut self.file)?.ok_or(io::ErrorKind::UnexpectedEof)?;
                self.after_chunk = at.saturating_add(9).saturating_add(length);
                if self.needless.contains(&at) {
                    self.file.pass(length)?
                } else {
                    self.enter()?
                }
                Ok(WalkStep::Other)
            }
            Some(_) => self.known.step(&mut self.file, chooses, body),
        }
    }

    /// Whether the whole of the next record is in the file. Only then does it count: its writer may be in the middle of
    /// it.
    fn is_written(&mut self) -> io::Result<bool> {
        const HEAD: u64 = 1 + 8;
        if let Some([_, length @ ..]) = self.file.buffer().first_chunk::<{ HEAD as usize }>() {
            let whole = u64::from_le_bytes(*length).saturating_add(HEAD);
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
        let _times: [u8; 16] = self.bytes()?;
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
        let mut plain = decompressed(&self.path, at, length, &compression)?;
        if size > LARGEST_WHOLE {
            let is_other = |(read, found)| read == size && found != checksum;
            if checksum != 0 && size_and_checksum(&mut plain).is_ok_and(is_other) {
                return wrong();
            }
            let plain = decompressed(&self.path, at, length, &compression)?;
            self.chunk = Some(Chunk::Stream(BufReader::with_capacity(1 << 16, plain)));
            return Ok(());
        }
        // If the chunk is damaged, the records before the damage are returned first.
        let mut whole = std::mem::take(&mut self.spare);
        whole.clear();
        let read = plain.take(LARGEST_WHOLE).read_to_end(&mut whole);
        let is_short = whole.len() as u64 != size;
        let damage = read.err().or_else(|| is_short.then(|| io::ErrorKind::UnexpectedEof.into()));
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

fn size_and_checksum(input: &mut impl Read) -> io::Result<(u64, u32)> {
    let (mut size, mut hasher, mut buffer) = (0, crc32fast::Hasher::new(), [0; 1 << 13]);
    loop {
        match input.read(&mut buffer)? {
            0 => return Ok((size, hasher.finalize())),
            read => {
                size += read as u64;
                hasher.update(&buffer[..read]);
            }
        }
    }
}

impl Known {
    /// Adds a schema, a channel or metadata.
    fn note(&mut self, record: Record<'_>) {
        match record {
            Record::Schema { header, data } => {
                let text = String::from_utf8_lossy(&data).into_owned();
                self.schemas.insert(header.id, (header.name, Definition { language: header.encoding, text }));
            }
            Record::Channel(channel) => {
                let (kind, definition) = self.schemas.get(&channel.schema_id).cloned().unzip();
                let topic = Topic {
                    name: channel.topic,
                    kind: kind.unwrap_or_default(),
                    encoding: channel.message_encoding,
                    definition: definition.filter(|definition| !definition.language.is_empty()),
                    hash: channel.metadata.get("topic_type_hash").and_then(|text| hash(text)),
                };
                self.channels.insert(channel.id, topic);
            }
            // In Humble and Iron. Later versions write the distribution into the metadata file.
            Record::Metadata(metadata) if metadata.name == METADATA => {
                let distribution = metadata.metadata.get("ROS_DISTRO").filter(|name| !name.is_empty());
                self.distributions.extend(distribution.cloned());
            }
            _ => {}
        }
    }

    /// Reads the next record of a chunk, or of the file.
    fn step(
        &mut self,
        input: &mut (impl BufRead + Pass),
        chooses: &mut impl Chooses,
        body: &mut Vec<u8>,
    ) -> io::Result<WalkStep> {
        let Some((kind, length)) = record_head(input)? else { return Ok(WalkStep::End) };
        match kind {
            op::MESSAGE if length >= MESSAGE_HEAD => {
                let mut head = [0; MESSAGE_HEAD as usize];
                input.read_exact(&mut head)?;
                let head = message_head(&head);
                let (reading, rest) = (chooses(head.channel_id, &self.channels), length - MESSAGE_HEAD);
                if reading == ReadDepth::Body {
                    read_body(input, rest, body)?
                } else {
                    input.pass(rest)?
                }
                Ok(if reading == ReadDepth::Nothing { WalkStep::Other } else { WalkStep::Message(head) })
            }
            op::SCHEMA | op::CHANNEL | op::METADATA if length <= LONGEST => {
                let mut body = Vec::new();
                read_body(input, length, &mut body)?;
                match parse_record(kind, &body) {
                    // Messages can be read without it.
                    Err(_) if kind == op::METADATA => {}
                    record => self.note(record.map_err(io::Error::other)?),
                }
                Ok(WalkStep::Other)
            }
            // Indexes and attachments; also what is too short for a message or too long for a definition.
            _ => input.pass(length).map(|()| WalkStep::Other),
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

enum WalkStep {
    Message(MessageHeader),
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
    let mut head = [0; 1 + 8];
    input.read_exact(&mut head)?;
    let [kind, length @ ..] = head;
    Ok(Some((kind, u64::from_le_bytes(length))))
}

fn read_body(input: &mut impl BufRead, length: u64, body: &mut Vec<u8>) -> io::Result<()> {
    body.clear();
    // Most records are completely in the buffer.
    if let Some(whole) = input.fill_buf()?.get(..usize::try_from(length).unwrap_or(usize::MAX)) {
        body.extend_from_slice(whole);
        input.consume(body.len());
        return Ok(());
    }
    input.take(length).read_to_end(body)?;
    if body.len() as u64 == length { Ok(()) } else { Err(io::ErrorKind::UnexpectedEof.into()) }
}

fn message_head(bytes: &[u8; MESSAGE_HEAD as usize]) -> MessageHeader {
    let number = |from: usize| u64::from_le_bytes(std::array::from_fn(|place| bytes[from + place]));
    MessageHeader {
        channel_id: u16::from_le_bytes([bytes[0], bytes[1]]),
        sequence: u32::from_le_bytes([bytes[2], bytes[3], bytes[4], bytes[5]]),
        log_time: number(6),
        publish_time: number(14),
    }
}
