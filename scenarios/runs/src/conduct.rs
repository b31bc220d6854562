//! Conducts a run from start to end.

use std::ops::ControlFlow;
use std::path::Path;

use recording::{Archive, Detail, Ended, Follower, RunView, TrustedView};
use scenarios::Error;

use crate::ending::Ending;
use crate::error::StepError;
use crate::run::Run;

/// Runs a scenario to its end for the follower that `begin` makes from its start. The follower sees at least as much as
/// `detail` requires. `goes_on` is called at the start, after every step and while one waits for
/// [partners](crate::Partners), and may stop the run: one more step then ends it as
/// [interrupted](Ended::Interrupted), without waiting. If there is a `record`, the run is written to it as an
/// [`Archive`].
///
/// # Errors
/// A file that could not be written; the reason why the run cannot continue; an error of the follower.
pub fn conduct<F: Follower, E: From<Error> + From<F::Error>>(
    run: Run,
    detail: Detail,
    record: Option<&Path>,
    begin: impl FnOnce(&RunView) -> Result<F, E>,
    mut goes_on: impl FnMut(&RunView) -> ControlFlow<()>,
) -> Result<(F, RunView), E> {
    let detail = if record.is_some() { detail.max(Detail::Full) } else { detail };
    let mut conducted = Conducted::begin(run, detail);
    let archive = record.map(|path| Archive::begin(path, &conducted.view)).transpose();
    let mut archive = archive.map_err(Error::from)?;
    let mut follower = begin(&conducted.view)?;
    loop {
        let is_stopped = goes_on(&conducted.view).is_break();
        if conducted.view.end().is_some() {
            break;
        }
        let stepped = conducted.step(detail, is_stopped);
        if let Ok(false) = stepped {
            continue;
        }
        // A failed step is also recorded: it may show the reason.
        archive.follow(&conducted.view).map_err(Error::from)?;
        if let Err(failure) = stepped {
            archive.map_or(Ok(()), Archive::finish).map_err(Error::from)?;
            return Err(Error::from(failure).into());
        }
        follower.follow(&conducted.view)?;
    }
    archive.map_or(Ok(()), Archive::finish).map_err(Error::from)?;
    Ok((follower, conducted.view.into_inner()))
}

/// A run with the view that its records add up to.
pub(crate) struct Conducted {
    pub(crate) run: Run,
    pub(crate) view: TrustedView,
    ending: Ending,
}

impl Conducted {
    /// A run at its start.
    pub(crate) fn begin(mut run: Run, detail: Detail) -> Self {
        let view = TrustedView::new(run.header(), run.record(detail));
        Self { run, view, ending: Ending::default() }
    }

    /// Performs a step, and ends the run if its scenario or its schedule ends it there, or if it `is_stopped`. The view
    /// has the step even if it fails. Returns whether it is done: otherwise it still waits for partners; one that
    /// `is_stopped` does not.
    pub(crate) fn step(&mut self, detail: Detail, is_stopped: bool) -> Result<bool, StepError> {
        let stepped = self.run.advance(!is_stopped);
        if let Ok(false) = stepped {
            return Ok(false);
        }
        self.view.apply(self.run.record(detail));
        stepped?;
        let over = self.run.is_over().then_some(Ended::Scheduled);
        let stopped = is_stopped.then_some(Ended::Interrupted);
        if let Some(why) = self.ending.reached(&self.run.scenario().file, &self.view).or(over).or(stopped) {
            self.end(why, detail);
        }
        Ok(true)
    }

    /// Ends the run here.
    pub(crate) fn end(&mut self, why: Ended, detail: Detail) {
        self.view.decide(self.run.verdicts_of_the_end(&why));
        self.view.finish(self.run.end(why, detail));
    }
}
