//! The live page of what is being judged: it follows a recording that is written for it.

use std::fs::File;
use std::io;
use std::time::{Duration, Instant};

use campaigns::Error;
use recording::{Follower as _, RunView, Writer};
use tempfile::TempDir;

use crate::live::BoardArgs;

/// How long the page may be behind.
const BEHIND: Duration = Duration::from_millis(100);

/// The page, and the recording that it follows.
pub(super) struct LivePage {
    writer: Writer<File>,
    flushed: Instant,
    /// Where the recording is. The page has opened it, and needs no name.
    _folder: TempDir,
}

impl LivePage {
    /// The page of a run at its start.
    pub(super) fn begin(view: &RunView, board: &BoardArgs) -> Result<Self, Error> {
        let folder = tempfile::tempdir().map_err(unwritten)?;
        let path = folder.path().join("watched");
        let file = File::create(&path).map_err(unwritten)?;
        let mut page = Self { writer: Writer::begin(file, view).map_err(unwritten)?, flushed: now(), _folder: folder };
        page.writer.flush().map_err(unwritten)?;
        board.follow(&path)?;
        Ok(page)
    }

    /// Adds what is new.
    pub(super) fn follow(&mut self, view: &RunView) -> Result<(), Error> {
        self.writer.follow(view).map_err(unwritten)?;
        self.show()
    }

    /// Shows what has been added, if that is due.
    pub(super) fn show(&mut self) -> Result<(), Error> {
        if self.flushed.elapsed() < BEHIND {
            return Ok(());
        }
        self.flushed = now();
        self.writer.flush().map_err(unwritten)
    }

    /// Shows the end, for as long as the program goes on.
    pub(super) fn finish(mut self, view: &RunView) -> Result<(), Error> {
        view.end().map_or(Ok(()), |end| self.writer.end(end)).map_err(unwritten)?;
        self.writer.flush().map_err(unwritten)
    }
}

fn unwritten(source: io::Error) -> Error {
    diagnostics::Error::Write { path: std::env::temp_dir(), source }.into()
}

#[expect(clippy::disallowed_methods, reason = "what is shown to a person keeps pace with the clock")]
fn now() -> Instant {
    Instant::now()
}
