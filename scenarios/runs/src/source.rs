//! The records of a run.

use recording::{Detail, Ended, Next, RecordSource, RunView, fitting};
use scenarios::Error;

use crate::run::Run;

/// The step in which its scenario or its schedule ends the run is the last. A stopped run ends as
/// [interrupted](Ended::Interrupted), without waiting for [partners](crate::Partners).
impl RecordSource for Run {
    type Error = Error;

    fn start(&mut self, wanted: Detail) -> Result<RunView, Error> {
        Ok(fitting(RunView::new(self.header(), self.record(wanted))))
    }

    fn next(&mut self, view: &mut RunView, wanted: Detail, is_stopped: bool) -> Result<Next<Error>, Error> {
        Ok(match self.go_on(view, wanted, is_stopped) {
            Ok(true) => Next::Step,
            Ok(false) => Next::Idle,
            Err(failure) => Next::Failed(failure),
        })
    }
}

impl Run {
    /// Performs a step, and ends the run if its scenario or its schedule ends it there, or if it `is_stopped`. The view
    /// has the step even if it fails. Returns whether it is done: otherwise it still waits for partners; one that
    /// `is_stopped` does not.
    pub(crate) fn go_on(&mut self, view: &mut RunView, wanted: Detail, is_stopped: bool) -> Result<bool, Error> {
        let stepped = self.advance(!is_stopped);
        if let Ok(false) = stepped {
            return Ok(false);
        }
        fitting(view.apply(self.record(wanted)));
        stepped?;
        let over = self.is_over().then_some(Ended::Scheduled);
        let stopped = is_stopped.then_some(Ended::Interrupted);
        if let Some(why) = self.reached(view).or(over).or(stopped) {
            self.end_in(view, why, wanted);
        }
        Ok(true)
    }

    /// Ends the run here.
    pub(crate) fn end_in(&mut self, view: &mut RunView, why: Ended, wanted: Detail) {
        fitting(view.decide(self.verdicts_of_the_end(&why)));
        fitting(view.finish(self.end(why, wanted)));
    }
}
