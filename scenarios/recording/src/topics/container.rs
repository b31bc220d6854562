//! The container of a recording: an MCAP file, with one chunk per flush.
//!
//! Source: <https://mcap.dev/spec>. The `mcap` crate's writer passes each number of each message through two checksums
//! and three layers, which would cost more than everything else about a recording. Here a chunk is assembled in memory,
//! and its checksum is computed once.

use std::io::{self, Write};

use mcap::records::op;

use super::cdr::Cdr;

/// An MCAP file that is being written.
pub(crate) struct Container<W: Write> {
    output: W,
    /// The bytes of the file so far.
    written: u64,
    /// The records of the next chunk.
    records: Vec<u8>,
    /// Its messages: channel, time, and offset in the records.
    messages: Vec<(u16, u64, u64)>,
    /// What is written in one call.
    block: Vec<u8>,
    schemas: Vec<(String, String)>,
    /// The number of messages per channel.
    counts: Vec<u64>,
    /// The times of the first and the last message.
    span: Option<(u64, u64)>,
    chunks: u32,
    summary: Summary,
}

/// The records that the end of the file repeats or adds, by their kind.
#[derive(Default)]
struct Summary {
    schemas: Vec<u8>,
    channels: Vec<u8>,
    chunks: Vec<u8>,
    metadata: Vec<u8>,
}

impl<W: Write> Container<W> {
    pub(crate) fn begin(output: W, profile: &str, library: &str) -> io::Result<Self> {
        let mut block = mcap::MAGIC.to_vec();
        record(&mut block, op::HEADER, |block| [profile, library].iter().for_each(|name| text(block, name)));
        let mut container = Self {
            output,
            written: 0,
            records: Vec::new(),
            messages: Vec::new(),
            block,
            schemas: Vec::new(),
            counts: Vec::new(),
            span: None,
            chunks: 0,
            summary: Summary::default(),
        };
        container.write_block()?;
        Ok(container)
    }

    /// Adds a record of metadata; call it before the first message.
    pub(crate) fn metadata(&mut self, name: &str, key: &str, value: &str) -> io::Result<()> {
        record(&mut self.block, op::METADATA, |block| {
            text(block, name);
            sized(block, |block| [key, value].iter().for_each(|part| text(block, part)));
        });
        let (offset, length) = (self.written, self.block.len() as u64);
        record(&mut self.summary.metadata, op::METADATA_INDEX, |summary| {
            summary.extend([offset, length].map(u64::to_le_bytes).as_flattened());
            text(summary, name);
        });
        self.write_block()
    }

    /// Adds a channel, and the type of its messages unless another channel has it.
    pub(crate) fn channel(
        &mut self,
        topic: &str,
        (name, definition): (&str, &str),
        (key, value): (&str, &str),
    ) -> io::Result<u16> {
        let is_it = |known: &(String, String)| (known.0.as_str(), known.1.as_str()) == (name, definition);
        let number = |index: usize| u16::try_from(index).map_err(io::Error::other);
        // The id 0 means "no schema".
        let schema = match self.schemas.iter().position(is_it) {
            Some(index) => number(index + 1)?,
            None => {
                self.schemas.push((name.to_owned(), definition.to_owned()));
                let schema = number(self.schemas.len())?;
                let at = self.summary.schemas.len();
                record(&mut self.summary.schemas, op::SCHEMA, |summary| {
                    summary.extend(schema.to_le_bytes());
                    [name, "ros2msg", definition].iter().for_each(|part| text(summary, part));
                });
                self.records.extend_from_slice(&self.summary.schemas[at..]);
                schema
            }
        };
        let channel = number(self.counts.len())?;
        self.counts.push(0);
        let at = self.summary.channels.len();
        record(&mut self.summary.channels, op::CHANNEL, |summary| {
            summary.extend([channel, schema].map(u16::to_le_bytes).as_flattened());
            [topic, "cdr"].iter().for_each(|part| text(summary, part));
            sized(summary, |summary| [key, value].iter().for_each(|part| text(summary, part)));
        });
        self.records.extend_from_slice(&self.summary.channels[at..]);
        Ok(channel)
    }

    /// Adds a message.
    pub(crate) fn message(&mut self, channel: u16, time_ns: u64, encode: impl FnOnce(&mut Cdr)) {
        self.messages.push((channel, time_ns, self.records.len() as u64));
        self.counts[usize::from(channel)] += 1;
        record(&mut self.records, op::MESSAGE, |records| {
            const SEQUENCE: u32 = 0;
            records.extend(channel.to_le_bytes());
            records.extend(SEQUENCE.to_le_bytes());
            records.extend([time_ns; 2].map(u64::to_le_bytes).as_flattened());
            let mut cdr = Cdr::after(std::mem::take(records));
            encode(&mut cdr);
            *records = cdr.bytes();
        });
    }

    /// Writes the messages so far as a chunk, so that they can be read whatever happens next.
    pub(crate) fn flush(&mut self) -> io::Result<()> {
        if self.records.is_empty() {
            return Ok(());
        }
        let times = || self.messages.iter().map(|(_, time_ns, _)| *time_ns);
        let (first, last) = times().min().zip(times().max()).unwrap_or_default();
        let all = self.span.unwrap_or((first, last));
        self.span = Some((all.0.min(first), all.1.max(last)));
        let (start, size) = (self.written, self.records.len() as u64);
        record(&mut self.block, op::CHUNK, |block| {
            block.extend([first, last, size].map(u64::to_le_bytes).as_flattened());
            block.extend(crc32fast::hash(&self.records).to_le_bytes());
            text(block, UNCOMPRESSED);
            block.extend(size.to_le_bytes());
            block.extend_from_slice(&self.records);
        });
        let length = self.block.len() as u64;
        // The sort is stable: the messages of a channel stay in order.
        self.messages.sort_by_key(|(channel, ..)| *channel);
        let mut indexes = Vec::new();
        for of_channel in self.messages.chunk_by(|a, b| a.0 == b.0) {
            let channel = of_channel[0].0.to_le_bytes();
            indexes.extend(channel);
            indexes.extend((start + self.block.len() as u64).to_le_bytes());
            record(&mut self.block, op::MESSAGE_INDEX, |block| {
                block.extend(channel);
                let entries = of_channel.iter().map(|(_, time_ns, place)| [*time_ns, *place].map(u64::to_le_bytes));
                sized(block, |block| entries.for_each(|entry| block.extend(entry.as_flattened())));
            });
        }
        let indexes_length = self.block.len() as u64 - length;
        record(&mut self.summary.chunks, op::CHUNK_INDEX, |summary| {
            summary.extend([first, last, start, length].map(u64::to_le_bytes).as_flattened());
            sized(summary, |summary| summary.extend(indexes));
            summary.extend(indexes_length.to_le_bytes());
            text(summary, UNCOMPRESSED);
            summary.extend([size; 2].map(u64::to_le_bytes).as_flattened());
        });
        self.chunks += 1;
        self.records.clear();
        self.messages.clear();
        self.write_block()
    }

    fn write_block(&mut self) -> io::Result<()> {
        self.output.write_all(&self.block)?;
        self.written += self.block.len() as u64;
        self.block.clear();
        self.output.flush()
    }

    /// Ends the file and returns it.
    pub(crate) fn finish(mut self) -> io::Result<W> {
        self.flush()?;
        // Each chunk has its own checksum.
        record(&mut self.block, op::DATA_END, |block| block.extend([0; 4]));
        self.write_block()?;
        let mut statistics = Vec::new();
        let (first, last) = self.span.unwrap_or_default();
        record(&mut statistics, op::STATISTICS, |statistics| {
            statistics.extend(self.counts.iter().sum::<u64>().to_le_bytes());
            statistics.extend((self.schemas.len() as u16).to_le_bytes());
            let (attachments, metadata) = (0, u32::from(!self.summary.metadata.is_empty()));
            let numbers = [self.counts.len() as u32, attachments, metadata, self.chunks];
            statistics.extend(numbers.map(u32::to_le_bytes).as_flattened());
            statistics.extend([first, last].map(u64::to_le_bytes).as_flattened());
            sized(statistics, |statistics| {
                for (channel, count) in (0_u16..).zip(&self.counts) {
                    statistics.extend(channel.to_le_bytes());
                    statistics.extend(count.to_le_bytes());
                }
            });
        });
        let (start, mut offsets) = (self.written, Vec::new());
        for (kind, records) in [
            (op::SCHEMA, &self.summary.schemas),
            (op::CHANNEL, &self.summary.channels),
            (op::STATISTICS, &statistics),
            (op::CHUNK_INDEX, &self.summary.chunks),
            (op::METADATA_INDEX, &self.summary.metadata),
        ] {
            let numbers = [start + self.block.len() as u64, records.len() as u64];
            record(&mut offsets, op::SUMMARY_OFFSET, |offsets| {
                offsets.push(kind);
                offsets.extend(numbers.map(u64::to_le_bytes).as_flattened());
            });
            self.block.extend_from_slice(records);
        }
        let offsets_start = start + self.block.len() as u64;
        self.block.extend(offsets);
        record(&mut self.block, op::FOOTER, |block| {
            block.extend([start, offsets_start].map(u64::to_le_bytes).as_flattened());
            // The checksum covers the length of this record, too.
            const LENGTH: u64 = 8 + 8 + 4;
            let at = block.len() - 16 - 8;
            block[at..at + 8].copy_from_slice(&LENGTH.to_le_bytes());
            block.extend(crc32fast::hash(block).to_le_bytes());
        });
        self.block.extend_from_slice(mcap::MAGIC);
        self.write_block()?;
        Ok(self.output)
    }
}

/// The name that means "no compression".
const UNCOMPRESSED: &str = "";

/// Adds a record.
fn record(bytes: &mut Vec<u8>, kind: u8, content: impl FnOnce(&mut Vec<u8>)) {
    let at = bytes.len();
    bytes.push(kind);
    bytes.extend([0; 8]);
    content(bytes);
    let length = (bytes.len() - at - 9) as u64;
    bytes[at + 1..at + 9].copy_from_slice(&length.to_le_bytes());
}

/// Adds something, preceded by its length.
fn sized(bytes: &mut Vec<u8>, content: impl FnOnce(&mut Vec<u8>)) {
    let at = bytes.len();
    bytes.extend([0; 4]);
    content(bytes);
    let length = (bytes.len() - at - 4) as u32;
    bytes[at..at + 4].copy_from_slice(&length.to_le_bytes());
}

fn text(bytes: &mut Vec<u8>, text: &str) {
    sized(bytes, |bytes| bytes.extend_from_slice(text.as_bytes()));
}

#[cfg(test)]
mod tests {
    use mcap::records::MessageIndexEntry;

    use super::*;

    #[test]
    fn the_mcap_crate_finds_each_message_with_and_without_the_index() {
        let mut file = Container::begin(Vec::new(), "ros2", "test").unwrap();
        file.metadata("rosbag2", "ROS_DISTRO", "humble").unwrap();
        let [b, a] = ["/b", "/a"].map(|topic| file.channel(topic, ("t/msg/T", "uint8 x\n"), ("key", "value")).unwrap());
        let written = [(a, 5, 1_u8), (b, 7, 2), (a, 6, 3), (b, 8, 4), (a, 9, 5)];
        for (channel, time_ns, x) in written {
            file.message(channel, time_ns, |cdr| cdr.number([x]));
            if time_ns == 6 {
                file.flush().unwrap();
            }
        }
        let bytes = file.finish().unwrap();
        let told = |message: mcap::Message<'_>| {
            let schema = message.channel.schema.as_ref().unwrap();
            assert_eq!((schema.name.as_str(), schema.data.as_ref()), ("t/msg/T", b"uint8 x\n".as_slice()));
            assert_eq!(message.channel.metadata["key"], "value");
            (message.channel.id, message.log_time, message.data[4])
        };
        let read: Vec<_> = mcap::MessageStream::new(&bytes).unwrap().map(|message| told(message.unwrap())).collect();
        assert_eq!(read, written);
        let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
        let mut indexed = Vec::new();
        for chunk in &summary.chunk_indexes {
            let find = |entry: &MessageIndexEntry| told(summary.seek_message(&bytes, chunk, entry).unwrap());
            indexed.extend(summary.read_message_indexes(&bytes, chunk).unwrap().values().flatten().map(find));
        }
        indexed.sort_by_key(|(.., x)| *x);
        assert_eq!(indexed, written);
        let statistics = summary.stats.unwrap();
        assert_eq!((statistics.message_count, statistics.chunk_count, statistics.metadata_count), (5, 2, 1));
        assert_eq!((statistics.message_start_time, statistics.message_end_time), (5, 9));
        assert_eq!(statistics.channel_message_counts.into_iter().collect::<Vec<_>>(), [(b, 2), (a, 3)]);
        let metadata = mcap::read::metadata(&bytes, &summary.metadata_indexes[0]).unwrap();
        assert_eq!(metadata.metadata["ROS_DISTRO"], "humble");
    }
}
