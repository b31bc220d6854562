//! What is wanted besides verdicts, and the program that wants it.

use std::convert::Infallible;
use std::ops::ControlFlow;
use std::path::Path;
use std::time::Duration;

use campaigns::{Error, refuse_campaign};
use miette::Diagnostic;
use monitors::Property;
use recording::{Detail, Doubts, Follower, InputFile, RecordSource, RunView, conduct};
use reports::{Outputs, Presentation};

use crate::LogContext;

/// The program that judges: when it is to end, and where it writes what users should see at once.
#[derive(Clone, Copy, Debug)]
pub struct Host {
    /// Whether a user has asked it to end.
    pub is_interrupted: fn() -> bool,
    /// Writes a line.
    pub note: fn(&str),
    /// Writes warnings about a file.
    pub warn: fn(&dyn Diagnostic),
}

impl Host {
    #[cfg(test)]
    pub(crate) const SILENT: Self = Self { is_interrupted: || false, note: |_| {}, warn: |_| {} };

    /// The interval at which what other programs write is looked at again. Chosen, not measured.
    pub const PAUSE: Duration = Duration::from_millis(10);

    /// Stops the work once the program has been asked to end.
    pub fn flow(self) -> ControlFlow<()> {
        if (self.is_interrupted)() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// Waits for other programs, or for the request to end.
    #[expect(clippy::disallowed_methods, reason = "waits for another program")]
    pub fn pause(self) {
        std::thread::sleep(Self::PAUSE);
    }
}

/// Follows verdicts while they are reached, whether there are records or not.
pub trait VerdictObserver {
    /// Takes in what an event, or a loss, until this time has changed.
    ///
    /// # Errors
    /// If it cannot go on.
    fn follow(
        &mut self,
        time: Duration,
        properties: &[Property],
        doubts: &Doubts,
        context: &LogContext,
    ) -> Result<(), Error>;

    /// Nothing more has been written so far.
    fn idle(&mut self, properties: &[Property], context: &LogContext);

    /// Takes a note about the messages that came last.
    fn note(&self, text: &str);
}

/// What shows a run while it is judged.
pub type ShownRun = Box<dyn Follower<Error = Infallible>>;

/// Makes what shows a run, from its start.
pub type ShowRun<'w> = &'w dyn Fn(&RunView) -> Result<ShownRun, Error>;

/// What is wanted besides verdicts.
pub struct Wanted<'w> {
    /// The command that repeats the check.
    pub command: String,
    /// The folder of a report.
    pub folder: Option<&'w Path>,
    /// The stories of violations, even without a report.
    pub stories: bool,
    /// The files with which a log is judged. It is called after they have been read.
    pub inputs: &'w dyn Fn() -> Vec<InputFile>,
    /// Verdicts as they are reached.
    pub observer: Option<Box<dyn VerdictObserver>>,
    /// The file of a recording.
    pub record: Option<&'w Path>,
    /// A page that shows the run from its start.
    pub page: Option<ShowRun<'w>>,
    /// The program.
    pub host: Host,
}

impl Wanted<'_> {
    pub(crate) fn has_records(&self) -> bool {
        self.folder.is_some() || self.stories || self.record.is_some() || self.page.is_some()
    }

    /// Takes a run to its end, and makes of its records what is wanted. Also returns the report, before it is written.
    pub(crate) fn conduct<S: RecordSource>(&self, source: S) -> Result<(Option<Presentation>, RunView), Error>
    where
        Error: From<S::Error>,
    {
        let outputs = Outputs { folder: self.folder.map(Path::to_owned), stories: self.stories, ..Outputs::default() };
        refuse_campaign(&outputs)?;
        let begin = |view: &RunView| {
            let presentation = (!outputs.is_nothing()).then(|| Presentation::begin(view, &outputs)).transpose()?;
            Ok::<_, Error>((presentation, self.page.map(|page| page(view)).transpose()?))
        };
        let ((presentation, _), view) = conduct(source, Detail::Full, self.record, begin, |_| self.host.flow())?;
        Ok((presentation, view))
    }
}
