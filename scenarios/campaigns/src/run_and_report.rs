//! Runs a scenario from its start to its report.

use std::convert::Infallible;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;

use recording::{Detail, Follower, RunView, conduct};
use reports::report::Report;
use reports::{Outputs, Presentation};
use runs::Run;
use scenarios::scenario::Scenario;

use crate::Error;
use crate::journal::has_journal;

/// Runs a scenario to its end, with monitors, and keeps only the report.
///
/// # Errors
/// [`Error`] if something is wrong with the scenario.
pub fn report_of(scenario: Arc<Scenario>, seed: u64) -> Result<Report, Error> {
    let run = Run::new(scenario, seed, true)?;
    run_and_report(run, Detail::Verdicts, &Outputs::default(), None, |_| {}, |_| ControlFlow::Continue(()))
}

/// Runs a scenario to its end, like [`conduct`], and makes its outputs. A run that `goes_on` stops is reported as
/// interrupted. `observe` gets the run at its start and after each step.
///
/// # Errors
/// [`Error`] if something cannot be written, or the run cannot continue.
pub fn run_and_report(
    run: Run,
    detail: Detail,
    outputs: &Outputs,
    record: Option<&Path>,
    observe: impl FnMut(&RunView),
    goes_on: impl FnMut(&RunView) -> ControlFlow<()>,
) -> Result<Report, Error> {
    refuse_campaign(outputs)?;
    let detail = if outputs.is_nothing() { detail } else { detail.max(Detail::Full) };
    let begin = |view: &RunView| {
        let (presentation, mut listener) = (Presentation::begin(view, outputs)?, Listener(observe));
        let Ok(()) = listener.follow(view);
        Ok::<_, Error>((presentation, listener))
    };
    let ((presentation, _), view) = conduct(run, detail, record, begin, goes_on)?;
    Ok(presentation.finish(&view)?)
}

/// A function that gets a run while it goes on.
struct Listener<F>(F);

impl<F: FnMut(&RunView)> Follower for Listener<F> {
    type Error = Infallible;

    fn follow(&mut self, view: &RunView) -> Result<(), Infallible> {
        (self.0)(view);
        Ok(())
    }
}

/// Rejects a folder with the results of a campaign: a run does not overwrite them.
///
/// # Errors
/// If the folder has such results.
pub fn refuse_campaign(outputs: &Outputs) -> Result<(), Error> {
    match outputs.folder.as_deref().filter(|folder| has_journal(folder)) {
        Some(folder) => {
            let message = format!("{} contains the results of a campaign", folder.display());
            Err(Error::refused(message, "a run does not overwrite them: choose another folder with `--out`"))
        }
        None => Ok(()),
    }
}
