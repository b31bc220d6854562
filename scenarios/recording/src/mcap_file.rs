//! Recordings in MCAP: the chunks on a topic, beside topics that other tools show.

use std::fs::File;
use std::io::{self, BufReader, Read, Write};
use std::time::Duration;

use mcap::McapError;
use mcap::records::Record as McapRecord;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use ros_messages::RosType as _;

use crate::chunk::{ChunkError, MAX_CHUNK_BYTES, encode};
use crate::ros;
use crate::topics::Topics;
use crate::topics::output::{LIBRARY, Output, Topic};
use crate::{FORMAT, Follower, RecordRef, RunView};

const TOPIC: &str = "/steward/records";
/// A killed run loses at most this much.
const FLUSH: Duration = Duration::from_secs(1);

pub(crate) struct McapWriter<W: Write> {
    output: Output<W>,
    records: Topic<ros::Records>,
    chunk: Vec<u8>,
    topics: Option<Topics>,
    flushed: Option<Duration>,
}

impl<W: Write> McapWriter<W> {
    pub(crate) fn begin(output: W, view: &RunView) -> io::Result<Self> {
        let mut output = Output::begin(output)?;
        let records = output.topic(TOPIC)?;
        let mut chunk = Vec::new();
        RecordRef::at_start(view).try_for_each(|record| encode(record, &mut chunk))?;
        let mut writer = Self { output, records, chunk, topics: None, flushed: None };
        writer.write(view)?;
        Ok(writer)
    }

    /// Writes the records so far, and the topics for other tools. The first message of the file has records, so that
    /// readers can immediately distinguish it from other files.
    fn write(&mut self, view: &RunView) -> io::Result<()> {
        let time = view.time();
        let is_due = view.end().is_some() || self.flushed.is_none_or(|flushed| time >= flushed + FLUSH);
        if is_due {
            self.write_chunk(time)?;
        } else if view.is_quiet() {
            return Ok(());
        }
        let topics = match &mut self.topics {
            Some(topics) => topics,
            none => none.insert(Topics::begin(view, &mut self.output)?),
        };
        topics.follow(view, is_due, &mut self.output)?;
        if is_due {
            self.flushed = Some(time);
            self.output.flush()?;
        }
        Ok(())
    }

    fn write_chunk(&mut self, time: Duration) -> io::Result<()> {
        if self.chunk.is_empty() {
            return Ok(());
        }
        let (checksum, records) = (crc32fast::hash(&self.chunk), std::mem::take(&mut self.chunk));
        let message = ros::Records { format: FORMAT, checksum, records };
        self.output.write(&self.records, time, &message)?;
        self.chunk = message.records;
        self.chunk.clear();
        Ok(())
    }

    pub(crate) fn finish(mut self) -> io::Result<W> {
        self.write_chunk(self.flushed.unwrap_or_default())?;
        self.output.finish()
    }
}

impl<W: Write> Follower for McapWriter<W> {
    type Error = io::Error;

    fn follow(&mut self, view: &RunView) -> io::Result<()> {
        RecordRef::newest(view).try_for_each(|record| encode(record, &mut self.chunk))?;
        self.write(view)
    }
}

/// Reads the chunks of records from an MCAP file, from start to end, without an index.
pub(crate) struct McapChunks {
    input: BufReader<File>,
    reader: LinearReader,
    /// The channel with the records.
    channel: Option<u16>,
    /// Whether this program wrote the file.
    is_own: bool,
    /// The first chunk.
    ahead: Option<Vec<u8>>,
}

impl std::fmt::Debug for McapChunks {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("McapChunks").field("channel", &self.channel).finish_non_exhaustive()
    }
}

impl McapChunks {
    pub(crate) fn begin(input: BufReader<File>) -> Result<Self, ChunkError> {
        let options = LinearReaderOptions::default()
            .with_prevalidate_chunk_crcs(true)
            .with_record_length_limit(MAX_CHUNK_BYTES as usize);
        let reader = LinearReader::new_with_options(options);
        let mut chunks = Self { input, reader, channel: None, is_own: false, ahead: None };
        chunks.ahead = chunks.message(true)?;
        // A recording that is cut off within its first chunk is still a recording.
        if chunks.ahead.is_none() && !chunks.is_own { Err(ChunkError::Foreign) } else { Ok(chunks) }
    }

    pub(crate) fn next(&mut self) -> Result<Option<Vec<u8>>, ChunkError> {
        match self.ahead.take() {
            Some(first) => Ok(Some(first)),
            None => self.message(false),
        }
    }

    /// The next chunk of records; none if the file ends first, even in the middle of something. With `first`, no other
    /// message may precede it.
    fn message(&mut self, first: bool) -> Result<Option<Vec<u8>>, ChunkError> {
        while let Some(event) = self.reader.next_event() {
            let (opcode, data) = match event {
                Ok(LinearReadEvent::ReadRequest(bytes)) => {
                    match self.input.read(self.reader.insert(bytes))? {
                        // The rest may come later.
                        0 => break,
                        read => self.reader.notify_read(read),
                    }
                    continue;
                }
                Ok(LinearReadEvent::Record { opcode, data }) => (opcode, data),
                Err(McapError::UnsupportedCompression(by)) => return Err(ChunkError::Compressed(by)),
                Err(_) => return Err(ChunkError::Damaged),
            };
            match mcap::parse_record(opcode, data).map_err(|_| ChunkError::Damaged)? {
                McapRecord::Header(header) => self.is_own = header.library.starts_with(LIBRARY),
                McapRecord::Channel(channel) if channel.topic == TOPIC => self.channel = Some(channel.id),
                McapRecord::Message { header, data } if Some(header.channel_id) == self.channel => {
                    return chunk(&data).map(Some);
                }
                McapRecord::Message { .. } if first => return Err(ChunkError::Foreign),
                _ => {}
            }
        }
        Ok(None)
    }
}

/// The chunk in a message, which must have this version.
fn chunk(message: &[u8]) -> Result<Vec<u8>, ChunkError> {
    let damaged = |_| ChunkError::Damaged;
    // In another version, what follows the format may be different.
    let format = u32::decode(message).map_err(damaged)?;
    if format != FORMAT {
        return Err(ChunkError::Version(format));
    }
    let ros::Records { checksum, records, .. } = ros::Records::decode(message).map_err(damaged)?;
    if crc32fast::hash(&records) == checksum { Ok(records) } else { Err(ChunkError::Damaged) }
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;
    use std::rc::Rc;

    use super::*;
    use crate::{End, Ended, Header, MonitorEnd, Recording, RecordingError, Step};

    /// What has reached the disk.
    #[derive(Clone, Default)]
    struct Disk(Rc<RefCell<Vec<u8>>>);

    impl Write for Disk {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.0.borrow_mut().extend(bytes);
            Ok(bytes.len())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    fn header() -> Header {
        Header { scenario: "test".to_owned(), ..Header::default() }
    }

    fn step(time: Duration) -> Step {
        Step { time, ..Step::default() }
    }

    /// How much of its run a file contains.
    fn read(bytes: &[u8]) -> Result<Duration, RecordingError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.mcap");
        std::fs::write(&path, bytes).unwrap();
        let mut recording = Recording::open(&path)?;
        let mut view = recording.begin()?;
        loop {
            match recording.advance(&mut view) {
                Ok(()) if view.end().is_some() => return Ok(view.time()),
                Ok(()) => {}
                Err(RecordingError::Truncated { .. }) => return Ok(view.time()),
                Err(error) => return Err(error),
            }
        }
    }

    #[test]
    fn the_file_on_disk_lags_behind_by_at_most_a_second() {
        let disk = Disk::default();
        let mut view = RunView::new(header(), step(Duration::ZERO)).unwrap();
        let mut writer = McapWriter::begin(disk.clone(), &view).unwrap();
        let mut lengths = Vec::new();
        for number in 1..=150 {
            view.apply(step(Duration::from_millis(20 * number))).unwrap();
            writer.follow(&view).unwrap();
            let on_disk = disk.0.borrow().clone();
            let until = read(&on_disk).unwrap();
            assert!(view.time() - until < FLUSH, "at {:?}, the file ends at {until:?}", view.time());
            lengths.push(until);
        }
        lengths.dedup();
        assert_eq!(lengths, [0, 1, 2, 3].map(Duration::from_secs));
        let ended = Ended::TimeLimit(view.time());
        let end = End {
            ended,
            trace_hash: String::new(),
            monitors: Vec::<MonitorEnd>::new(),
            skill_errors: vec![],
            messages_hit: vec![],
            scene: None,
        };
        view.apply(step(view.time())).unwrap();
        view.finish(end).unwrap();
        writer.follow(&view).unwrap();
        writer.finish().unwrap();
        let whole = disk.0.borrow().clone();
        // Wherever it is cut off, it can be read up to there, or is not a recording yet.
        for length in (0..whole.len()).step_by(97) {
            let cut = read(&whole[..length]);
            let fits = matches!(cut, Ok(_) | Err(RecordingError::Foreign(_) | RecordingError::Truncated { .. }));
            assert!(fits, "{length}: {cut:?}");
        }
        assert_eq!(read(&whole).unwrap(), Duration::from_secs(3));
        let cut = read(&whole[..200]);
        assert!(matches!(cut, Err(RecordingError::Truncated { .. })), "within the first chunk: {cut:?}");
    }

    #[test]
    fn compressed_chunks_are_named() {
        let chunk = [&[0_u8; 28][..], &4_u32.to_le_bytes(), b"zstd", &1_u64.to_le_bytes(), &[0]].concat();
        let header = [0_u8; 8];
        let record = |op: u8, body: &[u8]| [&[op][..], &(body.len() as u64).to_le_bytes(), body].concat();
        let file = [mcap::MAGIC, &record(1, &header), &record(6, &chunk)].concat();
        let error = read(&file).unwrap_err();
        assert!(matches!(&error, RecordingError::Compressed { by, .. } if by == "zstd"), "{error:?}");
    }

    /// Why a recording is not played.
    #[derive(Debug)]
    enum Unplayed {
        Read(RecordingError),
        Write(diagnostics::Error),
    }

    impl From<RecordingError> for Unplayed {
        fn from(error: RecordingError) -> Self {
            Self::Read(error)
        }
    }

    impl From<diagnostics::Error> for Unplayed {
        fn from(error: diagnostics::Error) -> Self {
            Self::Write(error)
        }
    }

    impl From<std::convert::Infallible> for Unplayed {
        fn from(never: std::convert::Infallible) -> Self {
            match never {}
        }
    }

    /// Plays a start followed by these records with and without recording them again.
    fn plays(records: &[crate::Record], folder: &std::path::Path) -> [Result<(), Unplayed>; 2] {
        let start = RunView::new(header(), step(Duration::ZERO)).unwrap();
        let mut writer = crate::Writer::begin(Vec::new(), &start).unwrap();
        records.iter().for_each(|record| writer.write(record.borrowed()).unwrap());
        let path = folder.join("run.rec");
        std::fs::write(&path, writer.finish().unwrap()).unwrap();
        let again = folder.join("again.mcap");
        [None, Some(again.as_path())].map(|again| {
            let recording = Recording::open(&path)?;
            let goes_on = |_: &RunView| std::ops::ControlFlow::Continue(());
            crate::conduct(recording, crate::Detail::Full, again, |_| Ok::<(), Unplayed>(()), goes_on).map(drop)
        })
    }

    fn records() -> Vec<crate::Record> {
        let end = End {
            ended: Ended::Recorded,
            trace_hash: String::new(),
            monitors: vec![],
            skill_errors: vec![],
            messages_hit: vec![],
            scene: None,
        };
        let steps = (1..5).map(|number| crate::Record::Step(step(Duration::from_millis(700 * number))));
        steps.chain([crate::Record::End(Box::new(end))]).collect()
    }

    #[test]
    fn a_damaged_recording_is_refused_alike_whether_it_is_recorded_again_or_not() {
        let folder = tempfile::tempdir().unwrap();
        assert!(plays(&records(), folder.path()).iter().all(Result::is_ok));
        for time in [Duration::MAX, Duration::from_nanos(u64::MAX) + Duration::from_nanos(1), Duration::ZERO] {
            let mut records = records();
            records[1] = crate::Record::Step(step(time));
            for played in plays(&records, folder.path()) {
                assert!(matches!(played, Err(Unplayed::Read(RecordingError::Damaged(_)))), "{time:?}: {played:?}");
            }
        }
        // Any byte of any record: both ways give the same answer, and neither blames the file that is written.
        let mut random = 1_u64;
        let mut below = |bound: usize| {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (random >> 33) as usize % bound
        };
        let (mut changed, mut refused) = (0, 0);
        for _ in 0..2_000 {
            let mut records = records();
            let place = below(records.len());
            let mut bytes = postcard::to_allocvec(&records[place]).unwrap();
            let at = below(bytes.len());
            bytes[at] = below(256) as u8;
            let Ok(record) = postcard::from_bytes(&bytes) else { continue };
            records[place] = record;
            let [plain, again] = plays(&records, folder.path());
            if let Err(Unplayed::Write(error)) = &again {
                panic!("{error}");
            }
            assert_eq!(plain.is_ok(), again.is_ok(), "{plain:?}, {again:?}");
            (changed, refused) = (changed + 1, refused + u32::from(plain.is_err()));
        }
        assert!(changed > 100 && refused > 50, "{changed}, {refused}");
    }
}
