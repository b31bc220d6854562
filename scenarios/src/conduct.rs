//! Conducts a run from start to end.

use std::io;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use diagnostics::Unfinished;
use recording::{Detail, Ended, EventLogWriter, Header, Record, RunView, Step, Writer};

use crate::Error;
use crate::ending::Ending;
use crate::live::Live;

/// Runs a scenario to its end. `follow` is called at the start and after every step, and may stop the run: one more
/// step then ends it as [interrupted](Ended::Interrupted). `follow` sees at least as much as `detail` demands. If there
/// is a `record`, the run is written to it: as an event log if [`is_log`] says so, or else as a recording.
///
/// # Errors
/// A file that could not be written; the reason why the run cannot continue; an error of `follow`.
pub fn conduct<E: From<Error>>(
    mut live: Live,
    detail: Detail,
    record: Option<&Path>,
    mut follow: impl FnMut(&RunView) -> Result<ControlFlow<()>, E>,
) -> Result<RunView, E> {
    let detail = if record.is_some() { detail.max(Detail::Full) } else { detail };
    let scenario = Arc::clone(live.scenario());
    let (header, start) = (live.header(), live.record(detail));
    let mut archive = record.map(|path| Archive::begin(path, &header, &start)).transpose()?;
    let mut view = RunView::new(header, start).expect(FITS);
    let mut ending = Ending::default();
    loop {
        let interrupted = follow(&view)?.is_break().then_some(Ended::Interrupted);
        if view.end().is_some() {
            break;
        }
        let failure = live.step().err();
        let step = live.record(detail);
        // A failed step is recorded, too: it may show the reason.
        if let Some(archive) = &mut archive {
            archive.record(|| Record::Step(step.clone()))?;
        }
        view.apply(step).expect(FITS);
        if let Some(archive) = &mut archive {
            archive.follow(&view)?;
        }
        if let Some(failure) = failure {
            archive.map_or(Ok(()), Archive::finish)?;
            return Err(Error::from(failure).into());
        }
        if let Some(why) = ending.reached(&scenario.file, &view).or(interrupted) {
            let end = live.end(why, detail);
            if let Some(archive) = &mut archive {
                archive.record(|| Record::End(Box::new(end.clone())))?;
            }
            view.finish(end).expect(FITS);
        }
    }
    archive.map_or(Ok(()), Archive::finish)?;
    Ok(view)
}

/// The guarantee about the records of a run in progress.
pub const FITS: &str = "a run's records refer only to what its header contains";

/// Whether a file with this name is an event log.
#[must_use]
pub fn is_log(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("jsonl"))
}

/// The records of a run on their way to a file.
struct Archive {
    path: PathBuf,
    form: Form,
}

enum Form {
    Log(EventLogWriter<Unfinished>),
    Recording(Writer<Unfinished>),
}

impl Archive {
    fn begin(path: &Path, header: &Header, start: &Step) -> Result<Self, Error> {
        let output = Unfinished::create(path)?;
        let form = match is_log(path) {
            true => EventLogWriter::begin(output, header).map(Form::Log),
            false => Writer::begin(output).map(Form::Recording),
        };
        let form = form.map_err(|source| unwritten(path, source))?;
        let mut archive = Self { path: path.to_owned(), form };
        archive.record(|| Record::Header(Box::new(header.clone())))?;
        archive.record(|| Record::Step(start.clone()))?;
        Ok(archive)
    }

    /// Adds a record, if the file consists of records.
    fn record(&mut self, record: impl FnOnce() -> Record) -> Result<(), Error> {
        let Form::Recording(writer) = &mut self.form else { return Ok(()) };
        writer.write(&record()).map_err(|source| unwritten(&self.path, source))
    }

    /// Adds the events of the last step, if the file is an event log.
    fn follow(&mut self, view: &RunView) -> Result<(), Error> {
        let Form::Log(log) = &mut self.form else { return Ok(()) };
        log.follow(view).map_err(|source| unwritten(&self.path, source))
    }

    fn finish(self) -> Result<(), Error> {
        let output = match self.form {
            Form::Log(log) => log.finish(),
            Form::Recording(writer) => writer.finish(),
        };
        Ok(output.map_err(|source: io::Error| unwritten(&self.path, source))?.finish()?)
    }
}

fn unwritten(path: &Path, source: io::Error) -> Error {
    diagnostics::Error::Write { path: path.to_owned(), source }.into()
}
