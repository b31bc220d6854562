//! A recording that is read, and perhaps still written.

use std::path::Path;
use std::time::{Duration, Instant};

use diagnostics::Unfinished;
use recording::{Record, Recording, RecordingError, RunView};

use crate::clock::now;
use crate::side::Side;

/// A file that grows is looked at so often.
const LOOK: Duration = Duration::from_millis(100);

/// A recording that is read.
pub(crate) struct Reel {
    recording: Recording,
    state: State,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum State {
    Reading,
    /// All that is in the file has been read, and there is no end yet; when the file was looked at.
    Waiting(Instant),
    Ended,
}

impl Reel {
    /// Opens a recording, with the start of its run. One that is still written has another name, and is waited for
    /// until it has that.
    ///
    /// # Errors
    /// [`RecordingError`].
    pub(crate) fn open(path: &Path) -> Result<(Self, RunView), RecordingError> {
        loop {
            let unfinished = if path.exists() { None } else { Unfinished::of(path) };
            let file = unfinished.as_deref().unwrap_or(path);
            match Self::begin(file) {
                Err(error) if unfinished.is_some() && may_come(&error) => pause(),
                begun => return begun,
            }
        }
    }

    fn begin(path: &Path) -> Result<(Self, RunView), RecordingError> {
        let mut recording = Recording::open(path)?;
        let start = recording.begin()?;
        Ok((Self { recording, state: State::Reading }, start))
    }

    /// Whether the run in it has ended, or the file cannot be read any further.
    pub(crate) fn has_ended(&self) -> bool {
        self.state == State::Ended
    }

    /// Whether all that there is has been read, and there will be more.
    pub(crate) fn grows(&self) -> bool {
        matches!(self.state, State::Waiting(_))
    }

    /// How long there is nothing to read; at most `most`.
    pub(crate) fn wait(&self, most: Duration) -> Duration {
        match self.state {
            State::Reading => Duration::ZERO,
            State::Waiting(since) => LOOK.saturating_sub(since.elapsed()).min(most),
            State::Ended => most,
        }
    }

    /// Reads what is there, until the deadline. Says what keeps it from reading on, if anything does.
    pub(crate) fn read(&mut self, side: &mut Side, deadline: Instant) -> Option<String> {
        if self.has_ended() || !self.wait(LOOK).is_zero() {
            return None;
        }
        while now() < deadline {
            let read = self.recording.next_record().map_err(|error| error.to_string());
            let taken = read.and_then(|record| {
                match record {
                    Some(record) => {
                        let is_end = matches!(record, Record::End(_));
                        side.push(record).map(|()| if is_end { State::Ended } else { State::Reading })
                    }
                    None => Ok(State::Waiting(now())),
                }
                .map_err(|error| error.to_string())
            });
            match taken {
                Ok(state) => self.state = state,
                Err(reason) => {
                    self.state = State::Ended;
                    return Some(reason);
                }
            }
            if self.state != State::Reading {
                break;
            }
        }
        None
    }
}

/// Whether a file that cannot be read yet may be one day.
fn may_come(error: &RecordingError) -> bool {
    matches!(error, RecordingError::Read { .. } | RecordingError::Foreign(_) | RecordingError::Truncated { .. })
}

#[expect(clippy::disallowed_methods, reason = "another program is waited for")]
fn pause() {
    std::thread::sleep(LOOK);
}
