//! A recording that can be read while it is being written.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};

use crate::chunk::{Chunk, unpack};
use crate::{Record, RecordRef};

/// The records of a run so far, in a file, so that memory does not grow. They are read chunk by chunk, starting
/// anywhere.
#[derive(Debug)]
pub struct RecordStore {
    file: File,
    /// Where each chunk of the file ends.
    ends: Vec<u64>,
    /// The records that are not in the file yet.
    chunk: Chunk,
}

impl RecordStore {
    /// A store in an empty file that can be written and read.
    #[must_use]
    pub fn new(file: File) -> Self {
        Self { file, ends: Vec::new(), chunk: Chunk::default() }
    }

    /// Adds a record.
    ///
    /// # Errors
    /// If writing fails.
    pub fn push(&mut self, record: RecordRef<'_>) -> io::Result<()> {
        self.chunk.push(record)?;
        if self.chunk.is_full() { self.complete() } else { Ok(()) }
    }

    /// Completes the current chunk, if it has records.
    fn complete(&mut self) -> io::Result<()> {
        let begin = self.length();
        let Some(packed) = self.chunk.pack()? else { return Ok(()) };
        self.file.seek(SeekFrom::Start(begin))?;
        self.file.write_all(packed)?;
        self.ends.push(begin + packed.len() as u64);
        Ok(())
    }

    fn length(&self) -> u64 {
        self.ends.last().copied().unwrap_or(0)
    }

    /// The number of complete chunks: the next record will be in none of them.
    #[must_use]
    pub fn chunks(&self) -> usize {
        self.ends.len()
    }

    /// The records of a chunk; none if there are no more. Reading the current one completes it.
    ///
    /// # Errors
    /// If the file cannot be read or written.
    pub fn read(&mut self, chunk: usize) -> io::Result<Vec<Record>> {
        if chunk == self.ends.len() {
            self.complete()?;
        }
        let Some(end) = self.ends.get(chunk) else { return Ok(Vec::new()) };
        let begin = chunk.checked_sub(1).map_or(0, |before| self.ends[before]);
        let mut packed = Vec::new();
        self.file.seek(SeekFrom::Start(begin))?;
        (&mut self.file).take(end - begin).read_to_end(&mut packed)?;
        let encoded = unpack(&packed).map_err(io::Error::other)?;
        let (mut rest, mut records) = (encoded.as_slice(), Vec::new());
        while !rest.is_empty() {
            let (record, after) = postcard::take_from_bytes(rest).map_err(io::Error::other)?;
            records.push(record);
            rest = after;
        }
        Ok(records)
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;
    use crate::Step;

    fn step(number: u64) -> Step {
        Step { time: Duration::from_millis(20 * number), ticks: number, ..Step::default() }
    }

    fn ticks(records: &[Record]) -> Vec<u64> {
        let ticks = |record: &Record| if let Record::Step(step) = record { step.ticks } else { panic!("{record:?}") };
        records.iter().map(ticks).collect()
    }

    #[test]
    fn a_store_can_be_read_while_it_grows() {
        let mut store = RecordStore::new(tempfile::tempfile().unwrap());
        assert!(store.read(0).unwrap().is_empty());
        for number in 0..100_000 {
            store.push(RecordRef::Step(&step(number))).unwrap();
        }
        let complete = store.chunks();
        assert!(complete > 2, "{complete} chunks");
        // Backward, including the current chunk.
        let mut parts: Vec<Vec<u64>> = (0..=complete).rev().map(|chunk| ticks(&store.read(chunk).unwrap())).collect();
        parts.reverse();
        assert_eq!(parts.concat(), (0..100_000).collect::<Vec<_>>());
        store.push(RecordRef::Step(&step(100_000))).unwrap();
        assert_eq!(ticks(&store.read(complete + 1).unwrap()), [100_000]);
        assert!(store.read(complete + 2).unwrap().is_empty());
    }
}
