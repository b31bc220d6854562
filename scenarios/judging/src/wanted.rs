//! What is wanted besides verdicts.

use std::convert::Infallible;
use std::path::Path;
use std::time::Duration;

use campaigns::{Error, refuse_campaign};
use monitors::Property;
use recording::{Detail, Doubts, Follower, InputFile, RecordSource, RunView, conduct};
use reports::{Outputs, Presentation};

use crate::host::Host;
use crate::log_context::LogContext;

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
