//! A recording that is being read, and perhaps still being written; or the records of a run as they are made.

use std::path::Path;
use std::sync::mpsc::{Receiver, TryRecvError};
use std::time::{Duration, Instant};

use diagnostics::Unfinished;
use recording::{Record, Recording, RecordingError, RunView};

use crate::clock::now;
use crate::shown_run::ShownRun;

/// How often a growing file is checked.
const LOOK: Duration = Duration::from_millis(100);

/// How a recording is opened: [`Recording::open`], or what else makes one of a file.
pub(crate) type Opener = dyn Fn(&Path) -> Result<Recording, RecordingError>;

/// A recording that is being read.
pub(crate) struct OpenRecording {
    /// The name of its file.
    pub(crate) name: String,
    records: Records,
    state: ReadState,
}

/// Where its records come from.
enum Records {
    File(Box<Recording>),
    /// Those of a [feed](crate::Feed).
    Feed(Receiver<Record>),
}

impl Records {
    /// The next record; none if there is none yet.
    fn next(&mut self) -> Result<Option<Record>, String> {
        match self {
            Self::File(recording) => recording.next_record().map_err(|error| error.to_string()),
            Self::Feed(records) => match records.try_recv() {
                Ok(record) => Ok(Some(record)),
                Err(TryRecvError::Empty) => Ok(None),
                Err(TryRecvError::Disconnected) => Err("the program ends".to_owned()),
            },
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum ReadState {
    Reading,
    /// Everything in the file has been read, but the run has not ended. Holds the time of the last check.
    Waiting(Instant),
    Ended,
}

impl OpenRecording {
    /// Opens a recording with that function, with the start of its run. If it is still being written, its file has a
    /// temporary name; this waits until the start of the run is there.
    ///
    /// # Errors
    /// [`RecordingError`].
    pub(crate) fn open(path: &Path, open: &Opener) -> Result<(Self, RunView), RecordingError> {
        loop {
            let unfinished = if path.exists() { None } else { Unfinished::of(path) };
            let file = unfinished.as_deref().unwrap_or(path);
            match begin(file, open) {
                Err(error) if unfinished.is_some() && may_come(&error) => pause(),
                begun => {
                    let (recording, start) = begun?;
                    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
                    return Ok((
                        Self { name, records: Records::File(Box::new(recording)), state: ReadState::Reading },
                        start,
                    ));
                }
            }
        }
    }

    /// The records of a feed, with the start of its first run; none if the feed has ended before that.
    pub(crate) fn of_feed(records: Receiver<Record>) -> Option<(Self, RunView)> {
        let start = start(records.recv().ok()?, &records)?;
        let name = "live".to_owned();
        Some((Self { name, records: Records::Feed(records), state: ReadState::Reading }, start))
    }

    /// The start of the next run of a feed, once the run before has ended.
    pub(crate) fn next_run(&mut self) -> Option<RunView> {
        let Records::Feed(records) = &self.records else { return None };
        let first = self.has_ended().then(|| records.try_recv().ok()).flatten()?;
        // After an error, the rest of a run is left out.
        let start = start(first, records)?;
        self.state = ReadState::Reading;
        Some(start)
    }

    /// Whether its run has ended, or the file cannot be read any further.
    pub(crate) fn has_ended(&self) -> bool {
        self.state == ReadState::Ended
    }

    /// Whether everything in the file has been read, and there may be more.
    pub(crate) fn grows(&self) -> bool {
        matches!(self.state, ReadState::Waiting(_))
    }

    /// The time until there may be something to read, at most `most`.
    pub(crate) fn wait(&self, most: Duration) -> Duration {
        match self.state {
            ReadState::Reading => Duration::ZERO,
            ReadState::Waiting(since) => LOOK.saturating_sub(since.elapsed()).min(most),
            ReadState::Ended => most,
        }
    }

    /// Reads what is there, until the deadline, and shows each step to `note`. Returns the reason if it cannot read on.
    pub(crate) fn read(
        &mut self,
        shown: &mut ShownRun,
        deadline: Instant,
        mut note: impl FnMut(&RunView),
    ) -> Option<String> {
        if self.has_ended() || !self.wait(LOOK).is_zero() {
            return None;
        }
        while now() < deadline {
            let read = self.records.next();
            // A record that cannot be read or stored ends the recording, and what has been read so far remains.
            let taken = read.and_then(|record| {
                match record {
                    Some(record) => {
                        let is_end = matches!(record, Record::End(_));
                        shown.push(record).map(|()| match is_end {
                            true => ReadState::Ended,
                            false => {
                                note(shown.newest());
                                ReadState::Reading
                            }
                        })
                    }
                    None => Ok(ReadState::Waiting(now())),
                }
                .map_err(|error| error.to_string())
            });
            match taken {
                Ok(state) => self.state = state,
                Err(reason) => {
                    self.state = ReadState::Ended;
                    return Some(reason);
                }
            }
            if self.state != ReadState::Reading {
                break;
            }
        }
        None
    }
}

/// The start of a run, from its first two records.
fn start(first: Record, records: &Receiver<Record>) -> Option<RunView> {
    let Record::Header(header) = first else { return None };
    let Record::Step(start) = records.recv().ok()? else { return None };
    RunView::new(*header, start).ok()
}

fn begin(path: &Path, open: &Opener) -> Result<(Recording, RunView), RecordingError> {
    let mut recording = open(path)?;
    let start = recording.begin()?;
    Ok((recording, start))
}

/// Whether a file that cannot be read yet may become readable.
fn may_come(error: &RecordingError) -> bool {
    matches!(error, RecordingError::Read { .. } | RecordingError::Foreign(_) | RecordingError::Truncated { .. })
}

#[expect(clippy::disallowed_methods, reason = "waits for another program")]
fn pause() {
    std::thread::sleep(LOOK);
}
