//! Reads a recording as an event log.

use std::io::{self, BufRead, Cursor, Read};

use crate::{Ended, EventLogWriter, Follower, Recording, RecordingError, RunView};

/// The event log that the run of a recording would have written.
pub struct LoggedRecording<F> {
    recording: Recording,
    view: RunView,
    log: EventLogWriter<Vec<u8>>,
    lines: Cursor<Vec<u8>>,
    /// Called once if the recording ends before its run does.
    truncated: Option<F>,
}

impl<F: FnOnce(&RecordingError)> LoggedRecording<F> {
    /// Reads a recording from its start. If it ends before its run does, so does the log, and `truncated` is called.
    ///
    /// # Errors
    /// [`RecordingError`].
    pub fn begin(mut recording: Recording, truncated: F) -> Result<Self, RecordingError> {
        let view = recording.begin()?;
        // Whoever reads it asks for the messages.
        let log = EventLogWriter::of_messages(Vec::new(), &view).map_err(|source| recording.unreadable(source))?;
        Ok(Self { recording, view, log, lines: Cursor::default(), truncated: Some(truncated) })
    }
}

impl<F: FnOnce(&RecordingError)> BufRead for LoggedRecording<F> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        while self.lines.position() == self.lines.get_ref().len() as u64 {
            self.lines = Cursor::new(self.log.lines()?);
            if !self.lines.get_ref().is_empty() {
                break;
            }
            if let Some(end) = self.view.end() {
                if let (Ended::CutOff(what), Some(truncated)) = (&end.ended, self.truncated.take()) {
                    let extent = format!("at {:.2} s: {what}", self.view.time().as_secs_f64());
                    truncated(&self.recording.truncated(extent));
                }
                return Ok(&[]);
            }
            if self.truncated.is_none() {
                return Ok(&[]);
            }
            match self.recording.advance(&mut self.view) {
                Ok(()) => self.log.follow(&self.view)?,
                Err(error @ RecordingError::Truncated { .. }) => {
                    if let Some(truncated) = self.truncated.take() {
                        truncated(&error);
                    }
                }
                Err(error) => return Err(io::Error::other(error)),
            }
        }
        self.lines.fill_buf()
    }

    fn consume(&mut self, bytes: usize) {
        self.lines.consume(bytes);
    }
}

impl<F: FnOnce(&RecordingError)> Read for LoggedRecording<F> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.fill_buf()?.read(buffer)?;
        self.consume(read);
        Ok(read)
    }
}
