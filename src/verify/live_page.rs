//! The live page of a check, which follows a temporary recording.

use std::fs::File;
use std::io;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use campaigns::Error;
use recording::{Follower as _, RunView, Writer};
use tempfile::TempDir;

const NAME: &str = "watched";
/// The maximum delay of the page.
const BEHIND: Duration = Duration::from_millis(100);

/// The recording that the page follows.
pub(crate) struct LivePage {
    writer: Writer<File>,
    flushed: Instant,
    /// The folder of the recording, until the page has opened it.
    folder: TempDir,
}

impl LivePage {
    /// The page of a run at its start.
    pub(crate) fn begin(view: &RunView) -> Result<Self, Error> {
        let folder = tempfile::tempdir().map_err(unwritten)?;
        let file = File::create(folder.path().join(NAME)).map_err(unwritten)?;
        let mut page = Self { writer: Writer::begin(file, view).map_err(unwritten)?, flushed: now(), folder };
        page.writer.flush().map_err(unwritten)?;
        Ok(page)
    }

    /// The path of the recording, which exists as long as this value.
    pub(crate) fn recording(&self) -> PathBuf {
        self.folder.path().join(NAME)
    }

    /// Adds the current step to the recording.
    pub(crate) fn follow(&mut self, view: &RunView) -> Result<(), Error> {
        self.writer.follow(view).map_err(unwritten)?;
        self.show()
    }

    /// Makes the added steps visible, if this is due.
    pub(crate) fn show(&mut self) -> Result<(), Error> {
        if self.flushed.elapsed() < BEHIND {
            return Ok(());
        }
        self.flushed = now();
        self.writer.flush().map_err(unwritten)
    }

    /// Makes the end visible. The page shows it until the program ends.
    pub(crate) fn finish(mut self, view: &RunView) -> Result<(), Error> {
        view.end().map_or(Ok(()), |end| self.writer.end(end)).map_err(unwritten)?;
        self.writer.flush().map_err(unwritten)
    }
}

fn unwritten(source: io::Error) -> Error {
    diagnostics::Error::Write { path: std::env::temp_dir(), source }.into()
}

#[expect(clippy::disallowed_methods, reason = "a live page follows real time")]
fn now() -> Instant {
    Instant::now()
}
