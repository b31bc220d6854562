//! Writes a run to a file, in the format of the file's name.

use std::io;
use std::path::{Path, PathBuf};

use diagnostics::Unfinished;

use crate::mcap_file::McapWriter;
use crate::tree_log_writer::TreeLogWriter;
use crate::{EventLogWriter, Follower, RunView, Writer};

/// Writes a run to a file: `FILE.jsonl` is an event log, `FILE.btlog` a log of BehaviorTree.CPP, `FILE.mcap` a
/// recording that other tools can open, too, and any other file a recording. If it is not finished, nothing remains of
/// it.
pub struct Archive {
    path: PathBuf,
    form: Form,
}

enum Form {
    Log(EventLogWriter<Unfinished>),
    TreeLog(TreeLogWriter<Unfinished>),
    Mcap(Box<McapWriter<Unfinished>>),
    Recording(Writer<Unfinished>),
}

impl Archive {
    /// Starts the file of a run at its start.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn begin(path: &Path, view: &RunView) -> Result<Self, diagnostics::Error> {
        let output = Unfinished::create(path)?;
        let is = |ending: &str| path.extension().is_some_and(|found| found.eq_ignore_ascii_case(ending));
        let form = if is("jsonl") {
            EventLogWriter::begin(output, view).map(Form::Log)
        } else if is("btlog") {
            TreeLogWriter::begin(output, view).map(Form::TreeLog)
        } else if is("mcap") {
            McapWriter::begin(output, view).map(|writer| Form::Mcap(Box::new(writer)))
        } else {
            Writer::begin(output, view).map(Form::Recording)
        };
        Ok(Self { path: path.to_owned(), form: form.map_err(|source| unwritten(path, source))? })
    }

    /// Ends the file.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn finish(self) -> Result<(), diagnostics::Error> {
        let output = match self.form {
            Form::Log(log) => log.finish(),
            Form::TreeLog(log) => log.finish(),
            Form::Mcap(writer) => writer.finish(),
            Form::Recording(writer) => writer.finish(),
        };
        output.map_err(|source| unwritten(&self.path, source))?.finish()
    }
}

impl Follower for Archive {
    type Error = diagnostics::Error;

    fn follow(&mut self, view: &RunView) -> Result<(), diagnostics::Error> {
        let written = match &mut self.form {
            Form::Log(log) => log.follow(view),
            Form::TreeLog(log) => log.follow(view),
            Form::Mcap(writer) => writer.follow(view),
            Form::Recording(writer) => writer.follow(view),
        };
        written.map_err(|source| unwritten(&self.path, source))
    }
}

fn unwritten(path: &Path, source: io::Error) -> diagnostics::Error {
    diagnostics::Error::Write { path: path.to_owned(), source }
}
