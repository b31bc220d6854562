//! Conducts a run from its start to its end, or goes through a recorded one, for what is to be left of it.

use std::io;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use channels::Verdict;
use diagnostics::Unfinished;
use recording::{Detail, EventLogWriter, Header, Record, Recording, RecordingError, RunView, Step, Writer};

use crate::ending::Ending;
use crate::live::Live;
use crate::presentation::{Outputs, Presentation};
use crate::report::Report;
use crate::scenario::Scenario;
use crate::{Error, campaign};

/// Runs a scenario to its end, with monitors, and leaves nothing behind but the report.
///
/// # Errors
/// What is wrong with the scenario.
pub fn report_of(scenario: Arc<Scenario>, seed: u64) -> Result<Report, Error> {
    let live = Live::new(scenario, seed, true)?;
    conduct(live, Detail::Verdicts, &Outputs::default(), None, |_| ControlFlow::Continue(()))
}

/// Runs a scenario to its end. `follow` is called at the start and then after every step, and may break the run off; it
/// sees as much as `detail` says, or more. All that can be told of the run goes to `record`, if there is one: a file that
/// ends in `.jsonl` is the event log, any other a recording.
///
/// # Errors
/// What could not be written; why the run cannot go on; [`Error::Interrupted`] if `follow` broke it off.
pub fn conduct(
    mut live: Live,
    detail: Detail,
    outputs: &Outputs,
    record: Option<&Path>,
    mut follow: impl FnMut(&RunView) -> ControlFlow<()>,
) -> Result<Report, Error> {
    refuse_campaign(outputs)?;
    let shown = record.is_some() || !outputs.is_nothing();
    let detail = if shown { detail.max(Detail::Full) } else { detail };
    let scenario = Arc::clone(live.scenario());
    let (header, start) = (live.header(), live.record(detail));
    let mut archive = record.map(|path| Archive::begin(path, &header, &start)).transpose()?;
    let mut view = RunView::new(header, start).expect(FITS);
    let mut presentation = Presentation::begin(&view, outputs)?;
    let mut ending = Ending::default();
    let mut go_on = follow(&view);
    while view.end().is_none() {
        if go_on.is_break() {
            archive.map_or(Ok(()), Archive::finish)?;
            presentation.break_off()?;
            return Err(interrupted(&view, outputs, record));
        }
        let failure = live.step().err();
        let step = live.record(detail);
        // A step that failed is told, too: it may say why.
        if let Some(archive) = &mut archive {
            archive.record(|| Record::Step(step.clone()))?;
        }
        view.apply(step).expect(FITS);
        if let Some(archive) = &mut archive {
            archive.follow(&view)?;
        }
        if let Some(failure) = failure {
            archive.map_or(Ok(()), Archive::finish)?;
            return Err(failure.into());
        }
        if let Some(why) = ending.reached(&scenario.file, &view) {
            let end = live.end(why, detail);
            if let Some(archive) = &mut archive {
                archive.record(|| Record::End(Box::new(end.clone())))?;
            }
            view.finish(end).expect(FITS);
        }
        presentation.follow(&view)?;
        go_on = follow(&view);
    }
    archive.map_or(Ok(()), Archive::finish)?;
    presentation.finish(&view)
}

/// What holds of the records of a run that is going on.
pub(crate) const FITS: &str = "a run tells of nothing that its header does not have";

/// Makes the report of a recorded run, with its page and pictures, as the run itself did.
///
/// # Errors
/// What is wrong with the recording; what could not be written.
pub fn report_recording(path: &Path, outputs: &Outputs) -> Result<Report, Error> {
    refuse_campaign(outputs)?;
    let mut recording = Recording::open(path).map_err(unreadable)?;
    let mut view = recording.begin().map_err(unreadable)?;
    let mut presentation = Presentation::begin(&view, outputs)?;
    while view.end().is_none() {
        recording.advance(&mut view).map_err(unreadable)?;
        presentation.follow(&view)?;
    }
    presentation.finish(&view)
}

fn unreadable(error: RecordingError) -> Error {
    let help = match &error {
        RecordingError::Foreign(_) => "a recording is what `steward --scenario … --record FILE.rec` writes",
        RecordingError::Version { .. } => {
            "run the scenario again with this version, or report with that of the recording"
        }
        RecordingError::Truncated { .. } => "a run that was broken off has no report: run it again to its end",
        _ => "record the run again",
    };
    Error::refused(error.to_string(), help)
}

fn refuse_campaign(outputs: &Outputs) -> Result<(), Error> {
    match outputs.folder.as_deref().filter(|folder| campaign::has_journal(folder)) {
        Some(folder) => {
            let message = format!("{} has the results of a campaign", folder.display());
            Err(Error::refused(message, "a run does not write over them: name another folder with `--out`"))
        }
        None => Ok(()),
    }
}

/// That a run was broken off, and what there is of it.
fn interrupted(view: &RunView, outputs: &Outputs, record: Option<&Path>) -> Error {
    let mut text = format!("interrupted after {:.1} s of simulated time", view.time().as_secs_f64());
    let verdicts = view.monitors().map(|monitor| {
        let verdict = match monitor.state.verdict {
            Verdict::True => "satisfied",
            Verdict::False => "violated",
            Verdict::Inconclusive => "undecided",
        };
        format!("{} {verdict}", monitor.name())
    });
    let verdicts: Vec<String> = verdicts.collect();
    if !verdicts.is_empty() {
        text += &format!(" ({})", verdicts.join(", "));
    }
    text += "; report and pictures were not written";
    let what = if record.is_some_and(is_log) { "event log" } else { "recording" };
    for (what, path) in [(what, record), ("animation", outputs.gif.as_deref())] {
        if let Some(path) = path {
            text += &format!(", the {what} until then is {}", path.display());
        }
    }
    Error::Interrupted(text)
}

/// Whether a file of that name is to be an event log.
fn is_log(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("jsonl"))
}

/// What is told of a run on its way to a file.
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
        let form = form.map_err(|source| Error::Write { path: path.to_owned(), source })?;
        let mut archive = Self { path: path.to_owned(), form };
        archive.record(|| Record::Header(Box::new(header.clone())))?;
        archive.record(|| Record::Step(start.clone()))?;
        Ok(archive)
    }

    /// Adds a record, if that is what it is made of.
    fn record(&mut self, record: impl FnOnce() -> Record) -> Result<(), Error> {
        let Form::Recording(writer) = &mut self.form else { return Ok(()) };
        writer.write(&record()).map_err(|source| Error::Write { path: self.path.clone(), source })
    }

    /// Adds what the last step says, if it is the event log.
    fn follow(&mut self, view: &RunView) -> Result<(), Error> {
        let Form::Log(log) = &mut self.form else { return Ok(()) };
        log.follow(view).map_err(|source| Error::Write { path: self.path.clone(), source })
    }

    fn finish(self) -> Result<(), Error> {
        let output = match self.form {
            Form::Log(log) => log.finish(),
            Form::Recording(writer) => writer.finish(),
        };
        Ok(output.map_err(|source: io::Error| Error::Write { path: self.path, source })?.finish()?)
    }
}
