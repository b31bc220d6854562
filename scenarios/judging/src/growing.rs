//! Event logs that are still being written.

use std::fs::File;
use std::io::{self, Read, Seek};
use std::path::Path;
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};

use crate::host::Host;

/// The note if the program was interrupted before the end of the log.
pub(crate) const STILL_WRITTEN: &str = "it was still being written: what follows is not judged";

/// The maximum length of a line, in bytes. A longer one is passed on incomplete, and [`EventLog`](monitors::EventLog)
/// refuses it.
const LONGEST_LINE: usize = 1 << 20;

/// The complete lines of an event log that is being written. At the end of the data, reading waits for more: from a
/// pipe until it is closed, from a file until the program is interrupted.
pub(crate) struct GrowingLog {
    input: Input,
    /// Data that has been read but not passed on.
    lines: Vec<u8>,
    is_over: bool,
    host: Host,
}

enum Input {
    File(File),
    /// Standard input or a named pipe.
    Pipe(Receiver<io::Result<Vec<u8>>>),
}

impl GrowingLog {
    pub(crate) fn open(log: &Path, host: Host) -> io::Result<Self> {
        let input = match log {
            log if log == Path::new("-") => Input::Pipe(blocks(|| Ok(io::stdin()))),
            log if std::fs::metadata(log)?.is_file() => {
                diagnostics::reading(log)?;
                Input::File(File::open(log)?)
            }
            log => {
                let log = log.to_owned();
                Input::Pipe(blocks(move || File::open(log)))
            }
        };
        Ok(Self { input, lines: Vec::new(), is_over: false, host })
    }

    /// Reads new data, or pauses if there is none.
    fn more(&mut self) -> io::Result<()> {
        match &mut self.input {
            Input::Pipe(blocks) => match blocks.recv_timeout(Host::PAUSE) {
                Ok(block) => self.lines.extend(block?),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => self.is_over = true,
            },
            Input::File(file) => {
                let read = file.take(1 << 16).read_to_end(&mut self.lines)?;
                if read == 0 {
                    let found = file.metadata()?;
                    if found.is_file() && found.len() < file.stream_position()? {
                        return Err(io::Error::other("it has become shorter"));
                    }
                    self.host.pause();
                }
            }
        }
        Ok(())
    }
}

impl Read for GrowingLog {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        loop {
            let whole = self.lines.iter().rposition(|byte| *byte == b'\n').map_or(0, |last| last + 1);
            let ready = if self.is_over || self.lines.len() > LONGEST_LINE { self.lines.len() } else { whole };
            if ready > 0 || self.is_over {
                let length = ready.min(buffer.len());
                buffer[..length].copy_from_slice(&self.lines[..length]);
                self.lines.drain(..length);
                return Ok(length);
            }
            if (self.host.is_interrupted)() {
                return Ok(0);
            }
            self.more()?;
        }
    }
}

/// The contents of a pipe. A separate thread opens and reads it, since neither operation can be interrupted.
fn blocks<R: Read>(open: impl FnOnce() -> io::Result<R> + Send + 'static) -> Receiver<io::Result<Vec<u8>>> {
    let (sender, receiver) = sync_channel(4);
    std::thread::spawn(move || {
        let mut input = match open() {
            Ok(input) => input,
            Err(error) => return drop(sender.send(Err(error))),
        };
        loop {
            let mut block = vec![0; 1 << 16];
            let read = input.read(&mut block);
            let is_last = !matches!(read, Ok(1..));
            let read = read.map(|length| {
                block.truncate(length);
                block
            });
            if sender.send(read).is_err() || is_last {
                return;
            }
        }
    });
    receiver
}
